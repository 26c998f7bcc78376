"""Motor names as written on casings, in ledgers and in short: `F24-4W`, `aerotech f24`, `H128W-14A`."""

import re
from collections.abc import Collection
from dataclasses import dataclass

from fieldkit.flight.makers import MAKERS
from fieldkit.motors.motor import PLUGGED_DELAY

MAX_NAME = 1000
"""Largest length of the name of a motor or a cluster. [characters]"""

_MAKER_OF = {alias: maker for maker, aliases in MAKERS.items() for alias in (*aliases, maker.upper())}
_MAKER = re.compile(
    r"(?<![\w-])("
    + "|".join(re.escape(a) for aliases in MAKERS.values() for a in sorted(aliases, key=len, reverse=True))
    + r")(?!\w)[\s:,-]*"
)
_CASE = re.compile(
    r"(?<![\w./-])(?:(?P<pro>P(?:RO)?)[- ]?(?P<a>24|29|38|54|75|98)(?:[-/ ]?\d+GX?L?)?"
    r"|RMS[- ]?(?P<b>18|24|29|38|54|75|98)(?:[-/]\w+)*"
    r"|(?P<c>18|24|29|38|54|75|98)/\d+(?:-\d+)*)(?![\w./])[\s,:]*"
)
"""Cases: `Pro38-3G`, `P38`, `RMS-29/40-120`, `38/360`."""
_SORT = re.compile(
    r"\(?(?<![\w-])(?:SINGLE[- ]USE|RELOADABLE|RELOAD|ECONOJET|CONSUMER|PRO SERIES(?: II)?|PRO II|PS ?II"
    r"|BLACK POWDER|BP|RMS|SU|LMS|DMS(?=\s+[\dA-O]))(?![\w-])\)?\s*"
)
"""Words for a sort of motor, which name none. `H100W DMS` is a designation."""
_PROPELLANTS = {
    "BLUE THUNDER": "T",
    "MOJAVE GREEN": "G",
    "BLACK ?JACK": "J",
    "BLACK MAX|FAST ?JACK": "FJ",
    "DARK MATTER": "DM",
    "METAL ?STORM": "M",
    "WARP[- ]?(?:9|NINE)": "N",
}
"""AeroTech's propellants that do not begin with their letters, as White Lightning and Redline do."""
_DIAMETER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)\s*MM\b[\s,]*")
_HALVES = str.maketrans(
    {"½": "1/2", "¼": "1/4", "⅛": "1/8", "–": "-", "—": "-", "−": "-", "\N{NON-BREAKING HYPHEN}": "-"}
)

_CORE = re.compile(
    r"(?:(?P<hp>HP)[- ]?|(?P<impulse>\d+)-?)?"
    r"(?P<letter>(?:1/[248])?[A-O])[- ]?(?P<thrust>\d+(?:\.\d+)?)(?P<rest>.*)"
)
_DELAY = re.compile(r"(\d+(?:\.\d+)?|P)([A-Z]{0,2})")
_DELAY_WORD = re.compile(r"-(?:S|M|L|SHORT|MEDIUM|LONG)(?![\w.])")
_OWN_DELAY = re.compile(r"-(?:\d+(?:\.\d+)?|P)([A-Z]{0,2})(?![\w.-])", re.IGNORECASE)
_ONE_MOTOR = r"(?:1/[248])?[A-O]\d+(?:\.\d+)?(?:[A-Z]{1,3})?(?:-(?:\d+|P)[A-Z]{0,2})?"
_SEVERAL_MOTORS = re.compile(rf"(?<![\w./-])\d*{_ONE_MOTOR}(?![\w.]).*?(?<![\w.])\d*{_ONE_MOTOR}(?![\w.])")
_CLUSTER = re.compile(
    rf"(?:(?:[2-9]|1[0-2])(?:\s+|\s*[X×*]\s*)|[A-Z][^\d/@+]*\s(?:[2-9]|1[0-2])\s*[X×*]\s*)(?:HP-)?\d*{_ONE_MOTOR}(?!\w)",
    re.IGNORECASE,
)
_COUNT_LAST = re.compile(rf"(?<![\w./-])(\d*{_ONE_MOTOR})\s*\(?[X×*]\s*([2-9]|1[0-2])\)?$", re.IGNORECASE)


_WORD = re.compile(r"(?<!\S)(?<!lot )\S+", re.IGNORECASE)
"""A word that is not the number of a lot."""
_MAKER_IN_WORDS = re.compile(
    rf"(?<![\w-])(?:{'|'.join(sorted((re.escape(maker) for maker in MAKERS), key=len, reverse=True))})(?![\w-])",
    re.IGNORECASE,
)
_NEW_PROPELLANTS = ("NT", "NW")
"""AeroTech's New Blue Thunder and new White Lightning."""


@dataclass(frozen=True, slots=True)
class Name:
    """A parsed motor name: `F24`, propellant letters, delay, maker, diameter [m].

    `prefix` is the text before the class: `216` of `216H118-12A`, `HP` of `HP-I205W`. `core` is empty if the text is
    not a class and a thrust, such as `MICRO_MAXX_II`; `squeezed` is the whole text reduced to letters and digits.
    `adjustable` marks a delay followed by an A, the longest of those that can be drilled.
    """

    core: str
    letters: str
    delay: float | None
    prefix: str
    maker: str
    diameter: float | None
    squeezed: str
    adjustable: bool = False


def tidy(text: str) -> str:
    """A name in capitals, with plain hyphens and fractions and single spaces."""
    return " ".join(text.translate(_HALVES).upper().replace("_", "-").split())


def squeeze(text: str) -> str:
    """The letters, in capitals, and digits of a text."""
    return re.sub(r"[^A-Z0-9]", "", text.upper())


def maker_of(text: str) -> str:
    """The maker that a text names, in the catalog's spelling; an unknown name is returned unchanged."""
    return _MAKER_OF.get(tidy(text), text.strip())


def in_capitals(text: str) -> str:
    """A motor's name with class, thrust and propellant in capitals and its maker as in the catalog.

    `AeroTech F24W-4` for `aerotech f24w-4`. Other words, such as the name of a propellant or a lot, are unchanged.
    """
    if len(text) > MAX_NAME:
        return text
    named = _MAKER_IN_WORDS.sub(lambda maker: _MAKER_OF[maker[0].upper()], text)
    return _WORD.sub(lambda word: word[0].upper() if parse(word[0]).core else word[0], named)


def is_cluster(text: str) -> bool:
    """Whether a text names several motors: a cluster (`3 B6-4`, `Estes 3 x B6-4`), stages (`D12-0/A8-5`) or both."""
    if len(text) > MAX_NAME:
        return False
    tidied = count_first(tidy(text))
    return bool(_CLUSTER.match(tidied) or _SEVERAL_MOTORS.search(tidied))


def count_first(text: str) -> str:
    """The name of a cluster with its count before the motor: `Estes 2 x D12-5` for `Estes D12-5 x2`."""
    return _COUNT_LAST.sub(r"\2 x \1", text.strip()) if len(text) <= MAX_NAME else text


def parse(text: str, makers: Collection[str] = ()) -> Name:
    """Parse a motor name; see `Name`. `makers` are those of the user's own motors, in addition to the known ones.
    A text longer than `MAX_NAME` has an empty name."""
    if len(text) > MAX_NAME:
        return Name("", "", None, "", "", None, "")
    rest = tidy(text)
    maker, rest = _own_maker(rest, makers)
    diameter = None
    if case := _CASE.search(rest):
        maker = "Cesaroni" if case["pro"] else "AeroTech" if case["b"] else ""
        diameter, rest = float(case["a"] or case["b"] or case["c"]) / 1e3, rest.replace(case[0], "")
    rest = _SORT.sub("", rest)
    while (found := _MAKER.search(rest)) and maker in ("", _MAKER_OF[found[1]]):  # `Quest Q-Jet`, `Cesaroni Pro29`
        maker, rest = _MAKER_OF[found[1]], rest.replace(found[0], "", 1)
    if millimetres := _DIAMETER.search(rest):
        diameter, rest = float(millimetres[1]) / 1e3, rest.replace(millimetres[0], "", 1)
    rest = re.sub(r"^1[ X]+(?=[A-O1])", "", rest.strip(" -,;()*?.\"'"))
    rest = re.sub(r"^(1/[248])[ -](?=[A-O]\d)", r"\1", rest)
    for words, short in _PROPELLANTS.items():
        rest = re.sub(rf"(?<![A-Z])(?:{words})(?![A-Z])", short, rest)
    core = _CORE.fullmatch(rest)
    if not core:
        return Name("", "", None, "", maker, diameter, squeeze(rest))
    letters, delay, adjustable = _tail(core["rest"])
    return Name(
        core["letter"] + core["thrust"],
        letters,
        delay,
        core["hp"] or core["impulse"] or "",
        maker,
        diameter,
        squeeze(rest),
        adjustable,
    )


def _own_maker(rest: str, makers: Collection[str]) -> tuple[str, str]:
    """The user's own maker at the start or end of a tidy text, in full or by its first word, and the rest."""
    for maker in sorted((one for one in makers if tidy(one) not in _MAKER_OF), key=len, reverse=True):
        words = [word for word in re.split(r"[\s-]+", tidy(maker)) if word]
        short = [word for word in words[:1] if word not in _MAKER_OF]
        for written in (words, short):
            name = r"[\s-]*".join(map(re.escape, written))
            for place in (rf"^\(?{name}\)?(?!\w)[\s:,-]*", rf"[\s:,(-]+{name}\)?$"):
                if name and (found := re.search(place, rest)):
                    return maker, rest.replace(found[0], "", 1)
    return "", rest


def _tail(rest: str) -> tuple[str, float | None, bool]:
    """Propellant letters and delay from the text after class and thrust: `W-4`, `-4W`, `T-14A`, `-PT`.

    The A of an adjustable delay, the s of seconds, the S of `PS`, plugged, and a short, medium or long delay (`-M`) are
    not propellants.
    """
    letters, delay, adjustable = "", None, False
    rest = _DELAY_WORD.sub("", rest)
    for position, part in enumerate(re.split(r"[-/\s()]+", rest)):
        match = _DELAY.fullmatch(part) if position and delay is None else None
        if match:
            delay = PLUGGED_DELAY if match[1] == "P" else float(match[1])
            adjustable = match[1] != "P" and match[2] == "A"
            letters += "" if adjustable or match[2] == "S" else match[2]
        else:
            letters += squeeze(part)
    return letters, delay, adjustable


def with_delay(text: str, delay: float) -> str:
    """A motor's name with this delay [s], in place of its own if it has one: `F24W-4`; `53F32-5` for `53F32-12A`."""
    written = "P" if delay == PLUGGED_DELAY else f"{delay:g}"
    if parse(text).delay is None:
        return f"{text}-{written}"
    return _OWN_DELAY.sub(lambda own: f"-{written}{'' if own[1] in ('A', 'S') else own[1]}", text, count=1)


def compatible(wanted: str, has: str) -> bool:
    """Whether propellant letters may mean the same: equal, one missing, or one short for the other.

    The N of `NT` and `NW` means new, so T and W may stand for them, and they for T and W; `BT` is Blue Thunder. Letters
    with a digit are a typing error (`F24-W4`) and not short for anything.
    """
    if any(letter.isdigit() for letter in wanted) and not has.startswith(wanted):
        return False
    if wanted.startswith(has) or has.startswith(wanted):
        return True
    new = (wanted, has) if has in _NEW_PROPELLANTS else (has, {"BT": "NT", "NBT": "NT"}.get(wanted, wanted))
    return new[1] in _NEW_PROPELLANTS and new[0] in (new[1], new[1][1:])


_OTHER_SPELLINGS = {"PK": "PINK", "MY": "MELLOW", "SMOKEYSAM": "SMOKYSAM"}
"""Letters and words for a propellant that are neither its initials nor its beginning."""


def burns(letters: str, propellant: str) -> bool:
    """Whether the letters of a name mean a propellant, as in `I285-CL` (Classic), `J357BS`, `G106 Skidmark`.

    Cesaroni's designations have none of these letters, but flyers and shops write them.
    """
    words = squeeze(propellant)
    initials = "".join(word[:1] for word in tidy(propellant).split())
    meant = _OTHER_SPELLINGS.get(letters, letters)
    return meant != "" and (meant == initials or (len(meant) > 1 and words.startswith(meant)))

"""Find a motor by its written name: the text narrows the choice, and any ambiguity is reported."""

import difflib
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache

from fieldkit.errors import AmbiguousMotor, UnknownMotor
from fieldkit.flight import BY_NAME
from fieldkit.motors.listing import Listing, Listings
from fieldkit.motors.motor import PLUGGED_DELAY, Motor, delays_text
from fieldkit.motors.names import Name, burns, compatible, is_cluster, parse, squeeze, tidy
from fieldkit.quantities import rounded

MASS_ERROR = 0.18
"""Nine in ten estimated masses of motors are off by less; `python -m tools.motor_masses` prints it. [1]"""
CURVE_ERROR = 0.02
"""Nine in ten flights change by less with the estimated shape of a thrust curve in place of the listed curve; a test
flies both. [1]"""
_UNKNOWN_CLASS = re.compile(r"(?:^|\s)[P-Z]\d")
"""Motor classes that nobody sells: `P4935`, `Q99`."""
_SWAPPED_SUFFIX = re.compile(r"([A-Z]{1,3})(\d{1,2})")
"""Propellant letters and delay in the wrong order, as in `F24-W4`."""
_ENDING = re.compile(r"\d[A-Z]*-([A-Z]+)$")
"""Letters after the hyphen of a name, which is where its delay belongs: `C6-R`."""
LETTER_DELAYS = {"S": "4 or 6", "M": "4 to 10", "L": "6 to 14", "X": "10 to 18"}
"""Delays that AeroTech's letters stand for: short, medium, long, extra long. [s]

Source: lists by others, not by the maker; the package states the seconds.
"""
_WORD = 3
"""Minimum number of letters for a word to be a maker and not a propellant."""
ONE_DIGIT_OFF = 0.75
"""Minimum similarity of a name with one character more or less: C66 and C6 have 0.8. [1]"""
_SMALL_MOTOR_MAKERS = ("Estes", "AeroTech", "Quest", "Klima", "Apogee")
_LARGE_MOTOR_MAKERS = ("AeroTech", "Cesaroni", "Loki", "Estes", "AMW", "Quest")
"""Makers by popularity: up to class E, and above it."""


@dataclass(frozen=True, slots=True)
class Found:
    """A motor, the delay in its name [s], and notes for the user about the choice.

    `delay` is None if the name has none, and `PLUGGED_DELAY` if it ends in P. `doubt` is the note on a delay that
    cannot be read, empty if there is none.
    """

    motor: Motor
    delay: float | None
    notes: tuple[str, ...] = ()
    doubt: str = ""


def find(listings: Listings, text: str, maker: str = "") -> Found:
    """The only motor that matches a text.

    Raises UnknownMotor with the nearest names, and AmbiguousMotor with one line for each match.
    """
    name, candidates = _candidates(listings, text, maker)
    if len(candidates) > 1:
        raise AmbiguousMotor(f"{text.strip()}: found {len(candidates)} motors, expected one of\n{_table(candidates)}")
    return _found(name, candidates[0], text)


def resolve(listings: Listings, text: str, maker: str = "") -> Found:
    """The motor that a text most probably means, with a note on the others. Raises UnknownMotor.

    If several match, one in production is preferred, then the most popular maker in that class, then the oldest entry
    in the catalog. If only the delay indicates a motor that is no longer made, the note names those that are.
    """
    name, candidates = _candidates(listings, text, maker)
    best, *others = sorted(candidates, key=_likelihood)
    if not best.own and not best.available:
        any_delay = sorted(_fitting(listings, replace(name, delay=None), name.maker), key=_likelihood)
        others += [one for one in any_delay if one.available and one not in others]
    note = f"read as {best.label}; it could also be {', '.join(other.label for other in others)}" if others else ""
    return _found(name, best, text, note)


def search(listings: Listings, text: str) -> list[Motor]:
    """Every motor that a text could mean, best first: names, makers, `24mm`, cases, propellants, or parts.

    An empty text returns all motors; a text without matches returns the motors with the nearest names, none for a class
    that nobody sells.
    """
    found = matches(listings, text)
    if not found and not _UNKNOWN_CLASS.search(tidy(text)):
        found = nearest(listings, _parsed(listings, text))
    return [listing.motor() for listing in found]


def matches(listings: Listings, text: str) -> list[Listing]:
    """The listings that a text could mean, best first; without those whose names are merely near."""
    name = _parsed(listings, text)
    meant = _fitting(listings, name, name.maker)
    words = tidy(text).replace(" MM", "MM").split()
    fitting = [listing for listing in _all(listings) if all(map(listing.mentions, words))]
    ranked = [*sorted(meant, key=_likelihood), *sorted(fitting, key=_in_order)]
    return list({id(listing): listing for listing in ranked}.values())


def nearest(listings: Listings, name: Name, limit: int = 5) -> list[Listing]:
    """The listings whose names are closest to a name: in its class those with its digits in another order, those with a
    digit more or less, then the nearest thrusts; or similar letters."""
    same = [key for key in listings if name.core and _class(key) == _class(name.core)]
    swapped = [key for key in same if key != name.core and sorted(key) == sorted(name.core)]
    mistyped = difflib.get_close_matches(name.core, same, n=2, cutoff=ONE_DIGIT_OFF)
    keys = [*swapped, *mistyped, *sorted(same, key=lambda key: abs(_thrust(key) - _thrust(name.core)))[:limit]]
    if not keys:
        squeezed = {
            squeeze(text): listing.name for listing in _all(listings) for text in (listing.name, listing.designation)
        }
        keys = [squeezed[key] for key in difflib.get_close_matches(name.squeezed, squeezed, n=limit, cutoff=0.5)]
    near = [listing for key in dict.fromkeys(keys) for listing in sorted(listings[key], key=_likelihood)]
    return near[:limit]


def _candidates(listings: Listings, text: str, maker: str) -> tuple[Name, list[Listing]]:
    if is_cluster(text):
        raise UnknownMotor(
            f"{text.strip()}: found several motors, expected a single one such as C6-5: flights on clusters and stages "
            "are not used in any fit"
        )
    name = _parsed(listings, f"{maker} {text}" if maker else text)
    candidates = _fitting(listings, name, name.maker)
    if not candidates:
        raise UnknownMotor(_unknown(listings, text, name))
    return name, candidates


def _fitting(listings: Listings, name: Name, maker: str) -> list[Listing]:
    """The listings that match everything a name specifies, narrowed by optional parts if some match them."""
    fitting = [listing for listing in listings.get(name.core, ()) if _fits(listing, name)]
    if not fitting and len(name.squeezed) > 2:
        ways = (name.squeezed, name.squeezed.removesuffix("P"))
        fitting = [listing for listing in _all(listings) if squeeze(listing.designation) in ways]
    if not fitting and name.core:
        fitting = [listing for listing in _all(listings) if listing.former and _formerly(listing, name)]
    fitting = [
        listing
        for listing in fitting
        if maker in ("", listing.maker) and (name.diameter is None or abs(listing.diameter - name.diameter) < 1e-3)
    ]
    fitting = _narrow(fitting, lambda listing: listing.own)
    fitting = _narrow(fitting, lambda listing: bool(maker) and squeeze(listing.designation) == name.squeezed)
    fitting = _narrow(fitting, lambda listing: name.letters != "" != listing.letters)
    if name.letters:
        fitting = _narrow(fitting, lambda one: one.letters != "" or burns(name.letters, one.propellant))
        fitting = _narrow(
            fitting, lambda one: one.letters != "" or not one.propellant or burns(name.letters, one.propellant)
        )
    exact = _narrow(fitting, lambda listing: listing.letters == name.letters != "")
    sold = [listing for listing in fitting if name.delay in listing.delays]
    return [listing for listing in exact if listing in sold] or sold or exact


def _fits(listing: Listing, name: Name) -> bool:
    return compatible(name.letters, listing.letters) and name.prefix in ("", parse(listing.designation).prefix)


def _formerly(listing: Listing, name: Name) -> bool:
    """Whether a name matches the previous designation of a motor."""
    former = parse(listing.former)
    return former.core == name.core and compatible(name.letters, former.letters) and name.prefix in ("", former.prefix)


def _narrow(listings: list[Listing], keep: Callable[[Listing], bool]) -> list[Listing]:
    return [listing for listing in listings if keep(listing)] or listings


def _found(name: Name, listing: Listing, text: str, note: str = "") -> Found:
    motor, doubt = as_printed(listing.motor(), name), _doubtful_delay(name, listing, text)
    notes = [one for one in (note, doubt) if one]
    if name.letters and not doubt and not (listing.letters or burns(name.letters, listing.propellant)):
        notes.append(f"{listing.label} does not have the letters {name.letters} in its name")
    if name.delay is not None and motor.delays and name.delay not in motor.delays:
        asked = "plugged" if name.delay == PLUGGED_DELAY else f"with a delay of {name.delay:g} s"
        notes.append(f"{listing.label} is not sold {asked}, only with {delays_text(motor.delays)}")
        if any(one.field == "delays" and not one.applied for one in motor.corrections):
            notes.append(
                f"that delay list is outdated; give the longest delay on the package, as in {listing.designation}-14A"
            )
    if motor.estimated:
        masses = all("mass" in one for one in motor.estimated)
        off = f"off by up to {MASS_ERROR:.0%}" if masses else f"which moves apogees by up to {CURVE_ERROR:.0%}"
        notes.append(f"{listing.label}: {' and '.join(motor.estimated)} not listed, estimated, {off} either way")
    if motor.curve.startswith("recorded"):
        notes.append(f"{listing.label}: {motor.curve}")
    return Found(motor, name.delay, tuple(notes), doubt)


@cache
def with_delays(motor: Motor, *delays: float) -> Motor:
    """The motor with only these delays [s], such as that printed on its bag; cached, so each is a single object."""
    return replace(motor, delays=delays)


def as_printed(motor: Motor, name: Name) -> Motor:
    """The motor with only the longest delay that a name states, as in `H128W-14A`, if the catalog lacks that delay."""
    if not name.adjustable or name.delay is None or name.delay in motor.delays:
        return motor
    return with_delays(motor, name.delay)


def _likelihood(listing: Listing) -> tuple[bool, bool, int]:
    makers = _SMALL_MOTOR_MAKERS if _class(listing.name) <= "E" else _LARGE_MOTOR_MAKERS
    place = makers.index(listing.maker) if listing.maker in makers else len(makers)
    return not listing.own, not listing.available, place


def _in_order(listing: Listing) -> tuple[bool, bool, str, float]:
    return not listing.own, not listing.available, _class(listing.name), _thrust(listing.name)


def _class(name: str) -> str:
    return name.rstrip("0123456789.")


def _thrust(name: str) -> float:
    digits = name[len(_class(name)) :]
    return float(digits) if digits and digits.count(".") < 2 and digits != "." else 0.0


def _parsed(listings: Listings, text: str) -> Name:
    """Parse a text, including the makers of own motors; these are searched only if words are left over."""
    name = parse(text)
    if name.core and len(name.letters) < _WORD:
        return name
    return parse(text, {listing.maker for listing in _all(listings) if listing.own and listing.maker})


def _all(listings: Listings) -> Iterable[Listing]:
    return (listing for group in listings.values() for listing in group)


def _unknown(listings: Listings, text: str, name: Name) -> str:
    if _UNKNOWN_CLASS.search(tidy(text)):
        return (
            f"{text.strip()!r}: found a class above O, which the catalog does not have; expected the motor's own file"
        )
    elsewhere = listings.get(name.core, ())
    if elsewhere and (swapped := _SWAPPED_SUFFIX.fullmatch(name.letters)):
        meant = f"{name.core}-{swapped[2]}{swapped[1]}"
        labels = ", ".join(listing.label for listing in _fitting(listings, parse(meant), name.maker))
        return (
            f"{text.strip()!r}: found letters before a delay; did you mean {meant}{f' ({labels})' if labels else ''}?"
        )
    if not elsewhere and name.delay is None and (meant := _with_hyphen(listings, name)):
        return f"no motor {text.strip()!r}; did you mean {meant}?"
    last = name if name.core else parse(text.split()[-1]) if text.split() else name
    near = sorted(elsewhere, key=_likelihood) if elsewhere else nearest(listings, last if last.core else name)
    offer = ", ".join(listing.label for listing in near[:5]) or "a name such as F24-4W"
    return f"no motor {text.strip()!r}" + (f"; did you mean {offer}?" if near else f", expected {offer}")


def _with_hyphen(listings: Listings, name: Name) -> str:
    """The motors that a name without its hyphen may be: `F24-4W (AeroTech F24W)` for F244W; empty if there are none."""
    found = []
    for digits in (1, 2):
        core, delay = name.core[:-digits], name.core[-digits:]
        meant = f"{core}-{delay}{name.letters}"
        usual = listings.get(core) and "." not in delay and float(delay) <= BY_NAME["delay"].high
        if usual and (fitting := _fitting(listings, parse(meant), name.maker)):
            found.append(f"{meant} ({', '.join(listing.label for listing in fitting)})")
    return " or ".join(found)


def _doubtful_delay(name: Name, listing: Listing, text: str) -> str:
    """The error in what follows the hyphen of a name if it is neither a delay nor part of the motor's designation."""
    ending = _ENDING.search(tidy(text))
    if ending is None or name.delay is not None or squeeze(listing.designation).endswith(ending[1]):
        return ""
    if burns(ending[1], listing.propellant):
        return ""
    seconds = LETTER_DELAYS.get(ending[1]) if listing.maker == "AeroTech" else None
    meaning = f" ({seconds} s by the maker's letters)" if seconds else ""
    return f"{text.strip()!r}: found {ending[1]!r} as the delay{meaning}, expected seconds, or P for plugged"


def _table(listings: Sequence[Listing]) -> str:
    motors = [listing.motor() for listing in listings]
    return "\n".join(
        f"  {motor.maker} {motor.designation}: class {motor.impulse_class}, {motor.diameter * 1e3:g} mm, "
        f"{rounded(motor.total_impulse)} N s, delays {delays_text(motor.delays)}"
        for motor in motors
    )

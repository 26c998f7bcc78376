"""A check of a planned flight: its verdict, its value, the limit, and the source of the limit."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from fieldkit.messages import amount, message
from fieldkit.quantities import in_system

ADVICE_NOTE = "These checks are advice; the range safety officer decides."
OFF_APOGEE = "2 s early or late shortens the way down by 4 to 24%"
"""By how much a charge near apogee changes the duration: flights of F24 (322 g, 66 mm), A8 (40 g, 25 mm) and C6 (60 g,
25 mm), with a Cd of 0.6 and a delay that fires at apogee and 2 s sooner and later."""
SAFE_RISK, UNSAFE_RISK = 0.05, 0.5
"""Probability of missing a limit up to which a check passes, and from which it fails. [1]"""

Verdict = Literal["ok", "caution", "unsafe", "unknown"]
MARKS: dict[Verdict, str] = {"ok": "✓", "caution": "!", "unsafe": "⊘", "unknown": "?"}
"""A symbol for each verdict, printed next to its word."""
SEVERITY: tuple[Verdict, ...] = ("ok", "unknown", "caution", "unsafe")
"""Verdicts from mildest to worst."""
BY_EYE = "check it yourself: "
"""Start of the finding of a check that only the flyer can make."""
HIGHER_IF_LIGHT = ("ceiling", "field size")
"""Checks that a lighter flight of the same rocket meets less easily."""


@dataclass(frozen=True, slots=True)
class SafetyCheck:
    """One check: its name, its verdict, the value found, the limit, and the source of the limit.

    The amounts in `finding` are marked, as in `fieldkit.messages`. `rule` is the rule's own wording
    if a rule set has the limit, `mark` the reliability of its text (`O`, `T`, `U`).
    """

    name: str
    verdict: Verdict
    finding: str
    source: str
    rule: str = ""
    mark: str = ""

    @property
    def failed(self) -> bool:
        """Whether the verdict is neither ok nor unknown."""
        return self.verdict in ("caution", "unsafe")

    @property
    def by_eye(self) -> bool:
        """Whether only the flyer can check it."""
        return self.verdict == "unknown" and self.finding.startswith(BY_EYE)

    @property
    def suffix(self) -> str:
        """A mark for a rule whose text is unverified."""
        return " (unverified)" if self.mark == "U" else ""

    @property
    def text(self) -> str:
        """The value found and the limit, in SI."""
        return str(message(self.finding))

    def words(self, system: str = "SI", *, source: bool = True, rule: bool = True) -> str:
        """The check in a line: `⊘ ground wind: unsafe: 10.0 m/s ...`, with the `rule` unless it is ok, and with
        `source` if it failed."""
        stated = f". The rule: {self.rule}" if rule and self.rule and self.verdict != "ok" else ""
        origin = f" [{self.source}]" if source and self.failed and self.source else ""
        found = in_system(message(self.finding), system)
        return f"{MARKS[self.verdict]} {self.name}: {self.verdict}: {found}{self.suffix}{stated}{origin}"

    def json(self) -> dict[str, str]:
        """Ready for JSON."""
        document = {"check": self.name, "verdict": self.verdict, "text": self.text, "source": self.source}
        return document | ({"rule": self.rule, "mark": self.mark} if self.mark else {})


def worst(checks: Sequence[SafetyCheck]) -> SafetyCheck:
    """The worst of several checks; the first of equally bad ones."""
    return max(checks, key=lambda check: SEVERITY.index(check.verdict))


def worst_first(checks: Iterable[SafetyCheck]) -> list[SafetyCheck]:
    """Checks from the worst verdict to the mildest, otherwise in their order."""
    return sorted(checks, key=lambda check: -SEVERITY.index(check.verdict))


def strictest(light: Sequence[SafetyCheck], heavy: Sequence[SafetyCheck]) -> list[SafetyCheck]:
    """The worse of each check of the same rocket flown light and heavy: if equal, that of the light one on height and
    landing, else of the heavy one. Checks that share a name are compared in their order."""
    found: dict[tuple[str, int], list[SafetyCheck]] = {}
    for lines in (light, heavy):
        seen: Counter[str] = Counter()
        for line in lines:
            found.setdefault((line.name, seen[line.name]), []).append(line)
            seen[line.name] += 1
    return [worst(both if name in HIGHER_IF_LIGHT else both[::-1]) for (name, _), both in found.items()]


def by_chance(chance: float) -> Verdict:
    """Verdict of a check whose limit is missed with this probability [1]."""
    return "ok" if chance < SAFE_RISK else "caution" if chance < UNSAFE_RISK else "unsafe"


figure = amount
"""A value [SI] within a finding, displayed in the reader's units; it has a number of decimals in its unit of SI."""


def length(metres: float) -> str:
    """A length [m] within a finding: `284 m` or `932 ft`."""
    return figure(metres, "m")


def lengths(*metres: float) -> list[str]:
    """Lengths to be compared within a finding: with one decimal if they look the same without."""
    digits = int(len({round(one) for one in metres}) < len(set(metres)))
    return [figure(one, "m", digits) for one in metres]


MOST_DECIMALS = 3
"""Decimals at which a value and its limit are shown as equal. [1]"""


def compared(value: float, limit: float, unit: str) -> tuple[str, str]:
    """A value and its limit [SI] within a finding, with decimals if they look the same without: `1500.3 g` and
    `1500.0 g`."""
    scale = 1e3 if unit == "g" else 1.0
    distinct = (
        digits for digits in range(MOST_DECIMALS) if round(value * scale, digits) != round(limit * scale, digits)
    )
    digits = next(distinct, 0)
    return figure(value, unit, digits), figure(limit, unit, digits)


def ratio(value: float, *bounds: float) -> str:
    """A ratio with one decimal; with two, rounded down, if it would look like a bound that it does not reach.
    [1]"""
    text = f"{value:.1f}"
    short = any(value < bound <= float(text) for bound in bounds)
    return f"{math.floor(value * 100) / 100:.2f}" if short else text


def speed(value: float, digits: int = 1) -> str:
    """A speed [m/s] within a finding: `13.4 m/s` or `30.0 mph`."""
    return figure(value, "m/s", digits)

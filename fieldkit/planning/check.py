"""A check of a planned flight: how it ended, what was found, what would be right, and whose rule that is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from fieldkit.units import FOOT, MILE

ADVICE_NOTE = "These checks are advice; the range safety officer decides."
MPH = MILE / 3600
SAFE_RISK, UNSAFE_RISK = 0.05, 0.5
"""Probability of missing a limit up to which a check passes, and from which on it fails. [1]"""

Verdict = Literal["ok", "caution", "unsafe", "unknown"]
MARKS: dict[Verdict, str] = {"ok": "✓", "caution": "!", "unsafe": "⊘", "unknown": "?"}
"""A sign for each verdict, next to its word."""
SEVERITY: tuple[Verdict, ...] = ("ok", "unknown", "caution", "unsafe")
"""Verdicts from the mildest to the worst."""


@dataclass(frozen=True, slots=True)
class SafetyCheck:
    """One check: its name, how it ended, what was found and what would be right, and where the limit is from.

    `rule` is the rule's own words where a rule set has the limit, `mark` how sure its text is (`O`, `T`, `U`).
    """

    name: str
    verdict: Verdict
    text: str
    source: str
    rule: str = ""
    mark: str = ""

    @property
    def failed(self) -> bool:
        """Whether it is not well, and known."""
        return self.verdict in ("caution", "unsafe")

    def words(self) -> str:
        """The check in a line: `⊘ ground wind: unsafe: 10.0 m/s ...`, with rule and source if it is not well."""
        rule = f" {self.rule}" if self.rule and self.failed else ""
        source = f" [{self.source}]" if self.failed else ""
        doubt = " (unverified)" if self.mark == "U" else ""
        return f"{MARKS[self.verdict]} {self.name}: {self.verdict}: {self.text}{doubt}{rule}{source}"

    def json(self) -> dict[str, str]:
        """Ready for JSON."""
        document = {"check": self.name, "verdict": self.verdict, "text": self.text, "source": self.source}
        return document | ({"rule": self.rule, "mark": self.mark} if self.mark else {})


def worst(checks: Sequence[SafetyCheck]) -> SafetyCheck:
    """The worst of some checks, the first of equally bad ones."""
    return max(checks, key=lambda check: SEVERITY.index(check.verdict))


def by_chance(chance: float) -> Verdict:
    """How a check ends that is missed with this chance."""
    return "ok" if chance < SAFE_RISK else "caution" if chance < UNSAFE_RISK else "unsafe"


def safety_text(lines: Sequence[SafetyCheck]) -> Iterator[str]:
    """All lines as text, and who decides."""
    yield from (line.words() for line in lines)
    yield ADVICE_NOTE


def length(metres: float) -> str:
    """In both units, as every line has it: `284 m (932 ft)`."""
    return f"{metres:.0f} m ({metres / FOOT:.0f} ft)"


def speed(value: float, digits: int = 1) -> str:
    """Of a rocket, in both units: `13.4 m/s (44 ft/s)`."""
    return f"{value:.{digits}f} m/s ({value / FOOT:.0f} ft/s)"

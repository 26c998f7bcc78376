"""What the product said of a set of flights, beside what was put into it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

WORTH_IT = 0.2
"""Part of the error that knowing the effect must take away for a set to count as decidable."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Of predicted apogees on the future flights."""

    mae: float
    bias: float
    covered: int
    flights: int
    interval: float = float("nan")
    """Mean score of the 90% interval: its width plus 20 times what a flight lies outside (Gneiting and Raftery, 2007).
    [m]"""


@dataclass(frozen=True, slots=True)
class Result:
    """What the product said of one set, beside its label; `error` if it said nothing."""

    name: str
    scenario: str
    label: str
    reach: float
    """Part of the error that knowing the truth takes away, as the bench's own simulator has it. [1]"""
    ideal: float
    """Error on the future flights that the bench's own simulator leaves with the truth known. [m]"""
    verdict: str = ""
    also: tuple[str, ...] = ()
    confidence: float = float("nan")
    before: Errors | None = None
    after: Errors | None = None
    given: Errors | None = None
    """With the true effect given to the product, whatever it made of the flights."""
    seconds: float = float("nan")
    error: str = ""
    level: int = 0
    top: tuple[str, ...] = field(default=())
    """The best candidates, best first."""
    probabilities: Mapping[str, float] = field(default_factory=dict)
    """Posterior probability of each effect and of `unexplained`, as far as they were given. [1]"""

    @property
    def gain(self) -> float:
        """Part of the error on the future flights that the fit of the true effect takes away. [1]"""
        return 1 - self.given.mae / self.before.mae if self.given and self.before else 0.0

    @property
    def decidable(self) -> bool:
        """Whether what is missing matters: to the product's fit of it, or in truth if nothing known is it."""
        return (self.reach if self.label == "unexplained" else self.gain) >= WORTH_IT

    @property
    def named(self) -> bool:
        """Whether the verdict is the label."""
        return effects(self.verdict) == effects(self.label)

    @property
    def right(self) -> bool:
        """Whether the verdict is the label, or names it as one that these flights cannot distinguish."""
        return effects(self.label) in {effects(name) for name in (self.verdict, *self.also)}


def effects(name: str) -> frozenset[str]:
    """The effects that a verdict names, in no order."""
    return frozenset(name.split("+"))

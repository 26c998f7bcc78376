"""The product's result for a set of flights, with the truth."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

WORTH_IT = 0.2
"""A set is decidable if knowing the effect removes at least this fraction of the error. [1]"""


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of predicted apogees on the later flights."""

    mae: float
    bias: float
    covered: int
    flights: int
    interval: float = float("nan")
    """Mean score of the 90% interval: its width plus 20 times the distance of a flight outside it (Gneiting and
    Raftery, 2007). [m]"""


@dataclass(frozen=True, slots=True)
class Result:
    """The product's result for one set, with its label; `error` if there is no result."""

    name: str
    scenario: str
    label: str
    reach: float
    """Fraction of the error that knowing the truth removes, according to the bench's simulator. [1]"""
    ideal: float
    """Error of the bench's simulator on the later flights with the truth known. [m]"""
    verdict: str = ""
    also: tuple[str, ...] = ()
    confidence: float = float("nan")
    before: Errors | None = None
    after: Errors | None = None
    given: Errors | None = None
    """Errors with the true effect given to the product, whatever its verdict."""
    without: Mapping[str, float] = field(default_factory=dict)
    """Error with the other effects of a pair given to the product, by the effect that is withheld. [m]"""
    seconds: float = float("nan")
    error: str = ""
    level: int = 0
    top: tuple[str, ...] = field(default=())
    """The best candidates, best first."""
    false: tuple[str, ...] = ()
    """The effects of the verdict that are not there at half their stated size (`false_names`)."""
    probabilities: Mapping[str, float] = field(default_factory=dict)
    """Posterior probability of each effect and of `unexplained`, if the product reports them. [1]"""

    @property
    def gain(self) -> float:
        """Fraction of the error on the later flights that the fit with the true effect removes. [1]"""
        return 1 - self.given.mae / self.before.mae if self.given and self.before else 0.0

    @property
    def decidable(self) -> bool:
        """Whether the effect matters: to the product's fit with it, or in truth if it is an unknown effect."""
        return (self.reach if self.label == "unexplained" else self.gain) >= WORTH_IT

    @property
    def needed(self) -> frozenset[str]:
        """The effects of the label that matter although the others are known: the fit with all of them removes at least
        `WORTH_IT` of the error of the fit without this one."""
        if not self.given or not self.before:
            return frozenset()
        without = self.without or {self.label: self.before.mae}
        return frozenset(name for name, error in without.items() if 1 - self.given.mae / error >= WORTH_IT)

    @property
    def found(self) -> frozenset[str]:
        """The effects of the label in the verdict, or in a set that it lists as indistinguishable."""
        return frozenset.union(*(effects(name) for name in (self.verdict, *self.also))) & effects(self.label)

    @property
    def named(self) -> bool:
        """Whether the verdict is the label."""
        return effects(self.verdict) == effects(self.label)

    @property
    def right(self) -> bool:
        """Whether the verdict is the label, or lists it among effects that these flights do not distinguish."""
        return effects(self.label) in {effects(name) for name in (self.verdict, *self.also)}


def effects(name: str) -> frozenset[str]:
    """The set of effects in a verdict."""
    return frozenset(name.split("+"))


NOT_NAMES = frozenset({"none", "unexplained"})
HALF = 0.5
"""Part of its stated size that must be there for a name to be true. [1]"""


def false_names(answer: Mapping[str, Any], label: Mapping[str, Any]) -> tuple[str, ...]:
    """The effects of a verdict that are neither planted nor among a history's own deviations at half the stated size.

    `answer` is the JSON of `loop`, `label` that of a set. A deviation is that of the motor or configuration that the
    verdict states, or the mean of all if it states none; of motors also relative to the rocket's others, because the
    drag coefficient absorbs what they share.
    """
    stated = {one["effect"]: one.get("parameters", {}) for one in answer["candidates"]}
    verdict = effects(answer["verdict"]["effect"]) - NOT_NAMES - effects(label["label"])
    return tuple(sorted(name for name in verdict if not _there(stated.get(name, {}), _deviations(label, name))))


def _deviations(label: Mapping[str, Any], effect: str) -> Mapping[str, float]:
    own: Mapping[str, float] = label.get("deviations", {}).get(effect, {})
    return own


def _there(parameters: Mapping[str, Mapping[str, Any]], own: Mapping[str, float]) -> bool:
    """Whether one of the stated parameters is among deviations at half its size."""
    return any(_at_half(name.partition(" of ")[2], float(one["mean"]), own) for name, one in parameters.items())


def _at_half(group: str, size: float, own: Mapping[str, float]) -> bool:
    if not own:
        return False
    mean = sum(own.values()) / len(own)
    some = [value for name, value in own.items() if name in group.split()] or [mean]
    found = [value for one in some for value in (one, one - mean)]
    return any(value * size > 0 and abs(value) >= HALF * abs(size) for value in found)

"""Calibration of probabilities: how often effects with a given probability were present.

In every set each effect and `unexplained` is a case: its posterior probability, and whether it is in the label. The
expected calibration error is the mean difference of the two over bins of probability, weighted by their cases (Naeini,
Cooper and Hauskrecht, AAAI 2015).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bench.result import Result, effects

BINS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)
"""Edges of the bins of probability. [1]"""
WORTH_SAYING = 0.05
"""Minimum probability of the cases in the second calibration error: most effects are absent and have a low probability.
[1]"""
PRIOR_EFFECTS = 0.67
"""Prior expected number of effects, and of unexplained patterns, in the product: ten families, each with a probability
of 1 - 0.5^(1/10). [1]"""


@dataclass(frozen=True, slots=True)
class Bin:
    """Cases with probabilities in an interval: their number, mean probability, and the fraction present."""

    low: float
    high: float
    cases: int
    expected: float
    found: float


def cases(results: Sequence[Result]) -> list[tuple[float, bool]]:
    """Every probability, and whether its effect was present."""
    return [
        (chance, name in effects(result.label)) for result in results for name, chance in result.probabilities.items()
    ]


def reliability(results: Sequence[Result]) -> list[Bin]:
    """The bins that have cases."""
    chance, there = (np.array(column, float) for column in zip(*cases(results), strict=True))
    found = []
    for low, high in pairwise(BINS):
        inside = (chance >= low) & ((chance < high) | (high == BINS[-1]))
        if inside.any():
            found.append(Bin(low, high, int(inside.sum()), float(chance[inside].mean()), float(there[inside].mean())))
    return found


def calibration_error(bins: Sequence[Bin]) -> float:
    """Expected calibration error. [1]"""
    return sum(one.cases * abs(one.expected - one.found) for one in bins) / sum(one.cases for one in bins)


def at_their_frequency(results: Sequence[Result]) -> list[Result]:
    """Results with the odds of every effect multiplied by one factor, the ratio of the mean number of effects in these
    histories to `PRIOR_EFFECTS`.

    By Bayes' theorem this is to first order what the probabilities would be if the product had known how common effects
    are here.
    """
    present = [len(effects(one.label) - {"none"}) for one in results]
    factor = float(np.mean(present)) / PRIOR_EFFECTS

    def moved(chance: float) -> float:
        return factor * chance / (1 - chance + factor * chance)

    return [
        replace(one, probabilities={name: moved(chance) for name, chance in one.probabilities.items()})
        for one in results
    ]


def calibration_lines(results: Sequence[Result]) -> Iterator[str]:
    """The reliability diagram as a table in Markdown, and the errors, as given and at the frequency of effects in these
    histories; nothing if no probabilities were given."""
    if not cases(results):
        return
    yield from _lines(results)
    yield ""
    yield "With the odds of every effect at its mean frequency in these histories:"
    yield ""
    yield from _lines(at_their_frequency(results))


def _lines(results: Sequence[Result]) -> Iterator[str]:
    bins = reliability(results)
    yield "| probability | cases | mean | present |"
    yield "|---|---|---|---|"
    for one in bins:
        yield f"| {one.low:.0%} to {one.high:.0%} | {one.cases} | {one.expected:.0%} | {one.found:.0%} |"
    yield ""
    filled = [one for one in bins if one.low >= WORTH_SAYING]
    beyond = f", {calibration_error(filled):.1%} from {WORTH_SAYING:.0%} on" if filled else ""
    yield f"expected calibration error: {calibration_error(bins):.1%} of all cases{beyond}"

"""Proper scores and calibration of forecasts given as draws.

The continuous ranked probability score is E|X - y| - E|X - X'| / 2 for a forecast X and a flight y, in meters. For a
single number it is the absolute error; a well-calibrated spread makes it smaller (Gneiting and Raftery, Strictly Proper
Scoring Rules, Prediction, and Estimation, 2007). The fraction of draws below the flight, its probability integral
transform (PIT), is uniform over flights if forecasts are calibrated (Dawid, 1984). Coverage and PITs are compared with
what chance allows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fieldkit.shapes import Array, Float

LEVELS = (0.5, 0.8, 0.9)
"""Central intervals whose coverage is reported. [1]"""
BINS = 10
"""Number of bins in the histogram of PITs. [1]"""


def crps(draws: Float[Array, "draw"], flown: float) -> float:
    """The continuous ranked probability score of one forecast; for a single draw, its absolute error. [m]"""
    ordered = np.sort(draws)
    count = len(ordered)
    between = 2 * (ordered * (2 * np.arange(1, count + 1) - count - 1)).sum() / count**2
    return float(np.abs(ordered - flown).mean() - between / 2)


def interval_score(low: float, high: float, flown: float, level: float = 0.9) -> float:
    """The score of a central interval: its width plus 2 / (1 - level) times the distance of the flight outside it. [m]

    Its expectation is smallest at the true quantiles (Gneiting and Raftery, 2007, section 6.2).
    """
    return (high - low) + 2 / (1 - level) * (max(low - flown, 0.0) + max(flown - high, 0.0))


def pit(draws: Float[Array, "draw"], flown: float) -> float:
    """The fraction of a forecast's draws below the flight, plus half of the draws equal to it. [1]

    Between two draws it is interpolated, because a saved forecast has only a few dozen: each stands for the quantile in
    the middle of its part of the distribution (Hazen, 1914).
    """
    ordered, count = np.sort(draws), len(draws)
    below, upto = (int(np.searchsorted(ordered, flown, side)) for side in ("left", "right"))
    if upto > below or below in (0, count):
        return (below + upto) / 2 / count
    part = (flown - ordered[below - 1]) / (ordered[below] - ordered[below - 1])
    return float((below - 0.5 + part) / count)


@dataclass(frozen=True, slots=True)
class Reliability:
    """A central interval: its nominal coverage, its observed coverage, and the 90% range of coverage by chance."""

    level: float
    held: float
    expected: tuple[float, float]

    @property
    def honest(self) -> bool:
        """Whether chance explains the difference."""
        return self.expected[0] <= self.held <= self.expected[1]


@dataclass(frozen=True, slots=True)
class Calibration:
    """Counts of PITs by bin, the 90% range of counts by chance, and intervals by level."""

    counts: tuple[int, ...]
    expected: tuple[float, float]
    intervals: tuple[Reliability, ...]


def calibration(
    pits: Sequence[float],
    levels: Sequence[float] = LEVELS,
    inside: Mapping[float, Sequence[bool]] = MappingProxyType({}),
) -> Calibration:
    """How uniform the PITs of flights are: each count and fraction with its binomial 90% range.

    `inside` is whether each flight was in the interval of a level whose ends were issued; other intervals follow from
    the PITs.
    """
    from scipy.stats import binom  # takes 0.6 s to import

    values = np.asarray(pits, float)
    count = len(values)
    counts, _ = np.histogram(values, bins=BINS, range=(0.0, 1.0))
    low, high = (float(binom.ppf(end, count, 1 / BINS)) for end in (0.05, 0.95))
    found = []
    for level in levels:
        held = float(np.mean(inside.get(level, np.abs(values - 0.5) <= level / 2))) if count else float("nan")
        ends = [float(binom.ppf(end, count, level)) / max(count, 1) for end in (0.05, 0.95)]
        found.append(Reliability(level, held, (ends[0], ends[1])))
    return Calibration(tuple(int(one) for one in counts), (low, high), tuple(found))

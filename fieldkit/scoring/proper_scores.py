"""Proper scores and calibration of forecasts that are known as draws.

The continuous ranked probability score is E|X - y| - E|X - X'| / 2 for a forecast X and a flight y, in meters: the
absolute error of a forecast that is one number, less the more honest its spread (Gneiting and Raftery, Strictly
Proper Scoring Rules, Prediction, and Estimation, 2007). The fraction of draws below the flight, its PIT, is uniform
over flights if forecasts are calibrated (Dawid, 1984); both are judged against what chance alone would do.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.shapes import Array, Float

LEVELS = (0.5, 0.8, 0.9)
"""Central intervals whose coverage is reported. [1]"""
BINS = 10
"""Of the histogram of PITs. [1]"""


def crps(draws: Float[Array, "draw"], flown: float) -> float:
    """The continuous ranked probability score of one forecast; of a single draw its absolute error. [m]"""
    ordered = np.sort(draws)
    count = len(ordered)
    between = 2 * (ordered * (2 * np.arange(1, count + 1) - count - 1)).sum() / count**2
    return float(np.abs(ordered - flown).mean() - between / 2)


def interval_score(low: float, high: float, flown: float, level: float = 0.9) -> float:
    """The score of a central interval: its width, and 2 / (1 - level) times what a flight lies outside of it. [m]

    Its expectation is smallest at the true quantiles (Gneiting and Raftery, 2007, section 6.2).
    """
    return (high - low) + 2 / (1 - level) * (max(low - flown, 0.0) + max(flown - high, 0.0))


def pit(draws: Float[Array, "draw"], flown: float) -> float:
    """The fraction of a forecast below what was flown, half of what equals it. [1]"""
    return float((draws < flown).mean() + (draws == flown).mean() / 2)


@dataclass(frozen=True, slots=True)
class Reliability:
    """A central interval: its nominal coverage, its observed coverage, and the range of coverage in nine of ten such
    seasons."""

    level: float
    held: float
    expected: tuple[float, float]

    @property
    def honest(self) -> bool:
        """Whether chance alone explains the difference."""
        return self.expected[0] <= self.held <= self.expected[1]


@dataclass(frozen=True, slots=True)
class Calibration:
    """PITs of flights in bins, the counts that chance leaves in nine of ten, and intervals by level."""

    counts: tuple[int, ...]
    expected: tuple[float, float]
    intervals: tuple[Reliability, ...]


def calibration(pits: Sequence[float], levels: Sequence[float] = LEVELS) -> Calibration:
    """How uniform the PITs of flights are, each count and share beside its binomial 90 % range."""
    from scipy.stats import binom

    values = np.asarray(pits, float)
    count = len(values)
    counts, _ = np.histogram(values, bins=BINS, range=(0.0, 1.0))
    low, high = (float(binom.ppf(end, count, 1 / BINS)) for end in (0.05, 0.95))
    found = []
    for level in levels:
        held = float((np.abs(values - 0.5) <= level / 2).mean()) if count else float("nan")
        ends = [float(binom.ppf(end, count, level)) / max(count, 1) for end in (0.05, 0.95)]
        found.append(Reliability(level, held, (ends[0], ends[1])))
    return Calibration(tuple(int(one) for one in counts), (low, high), tuple(found))

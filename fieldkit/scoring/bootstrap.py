"""Errors of forecasts with bootstrap intervals over the flights.

Source: the percentile bootstrap (Efron, Bootstrap Methods: Another Look at the Jackknife, 1979).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.scoring.score import Forecasts, Score, score
from fieldkit.shapes import Array, Flags, Float

RESAMPLED = 2000
"""Number of bootstrap resamples of the flights."""
SEED = 5
LEVELS = (0.05, 0.95)
MIN_FLIGHTS_FOR_VERDICT = 5
"""Minimum number of flights for a verdict on a difference. [1]"""

Interval = tuple[float, float]
"""The ends of a central 90% bootstrap interval of a figure, in its unit."""


@dataclass(frozen=True, slots=True)
class Judged:
    """A score with the 90% bootstrap interval of each of its figures, and the number of flights."""

    score: Score
    flights: int
    mae: Interval
    rmse: Interval
    bias: Interval
    coverage90: Interval

    def json(self) -> dict[str, Any]:
        """The contract's keys, and the intervals under `interval90`."""
        intervals = {"mae_m": self.mae, "rmse_m": self.rmse, "bias_m": self.bias, "coverage90": self.coverage90}
        return {**self.score.json(), "interval90": {name: list(ends) for name, ends in intervals.items()}}


def misses(forecasts: Forecasts, truth: Float[Array, "flight"], seen: Flags) -> Float[Array, "seen"]:
    """Predicted minus flown apogee of the flights with an apogee. [m]"""
    return np.asarray((forecasts.apogee - np.exp(truth))[seen])


def resampled(count: int) -> Any:
    """Resamples of `count` flights, drawn with replacement, identical at every call. [resample flight]"""
    return np.random.default_rng(SEED).integers(0, max(count, 1), (RESAMPLED, count))


def judge(forecasts: Forecasts, truth: Float[Array, "flight"], seen: Flags) -> Judged:
    """Score forecasts of log apogee on the flights with an apogee. Flights are resampled; nothing is refitted.

    Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), percentile intervals. `truth` has the flown
    apogees. [log m]
    """
    found, count = score(forecasts, truth, seen), int(seen.sum())
    if not count:
        nowhere = (float("nan"), float("nan"))
        return Judged(found, 0, nowhere, nowhere, nowhere, nowhere)
    rows = resampled(count)
    error = misses(forecasts, truth, seen)[rows]
    below = forecasts.below(truth)[seen]
    inside = ((below > 0.05) & (below < 0.95))[rows]
    return Judged(
        found,
        count,
        ends_of(np.abs(error).mean(axis=1)),
        ends_of(np.sqrt((error**2).mean(axis=1))),
        ends_of(error.mean(axis=1)),
        ends_of(inside.mean(axis=1)),
    )


def gain(before: Forecasts, after: Forecasts, truth: Float[Array, "flight"], seen: Flags) -> tuple[float, Interval]:
    """The reduction of the mean absolute error and its interval; both forecasts are resampled together. [m]"""
    fell = np.abs(misses(before, truth, seen)) - np.abs(misses(after, truth, seen))
    if not len(fell):
        return float("nan"), (float("nan"), float("nan"))
    return float(fell.mean()), ends_of(fell[resampled(len(fell))].mean(axis=1))


@dataclass(frozen=True, slots=True)
class ScoreDifference:
    """The mean score of our forecast and a rival's on the same flights. `less` is how much smaller ours is, with its
    90% bootstrap interval from paired resampling."""

    flights: int
    ours: float
    theirs: float
    less: float
    interval: Interval

    @property
    def verdict(self) -> str:
        """`better` or `worse` on these flights, or `unclear` if the interval contains zero or there are fewer than
        `MIN_FLIGHTS_FOR_VERDICT`."""
        low, high = self.interval
        if self.flights < MIN_FLIGHTS_FOR_VERDICT or not low * high > 0:
            return "unclear"
        return "better" if low > 0 else "worse"

    def json(self) -> dict[str, Any]:
        """Every figure except the count, and the verdict."""
        figures = {"ours": self.ours, "theirs": self.theirs, "less": self.less, "interval": list(self.interval)}
        return figures | {"verdict": self.verdict}


def paired(ours: Float[Array, "flight"], theirs: Float[Array, "flight"]) -> ScoreDifference:
    """The difference of two scores of the same flights, in their unit; smaller scores are better."""
    if not len(ours):
        nan = float("nan")
        return ScoreDifference(0, nan, nan, nan, (nan, nan))
    less = theirs - ours
    interval = ends_of(less[resampled(len(less))].mean(axis=1))
    return ScoreDifference(len(less), float(ours.mean()), float(theirs.mean()), float(less.mean()), interval)


def ends_of(values: Float[Array, "resample"]) -> Interval:
    """The central 90% interval of the resampled figures, in their unit."""
    low, high = np.quantile(values, LEVELS)
    return float(low), float(high)

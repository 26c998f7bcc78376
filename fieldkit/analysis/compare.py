"""Compare two recordings of one flight: align the clocks, then compare figures and heights."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.analysis.records import Figure, MeasuredClimb, Recorded
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    import pandas

_REACH = 3.0
"""Largest difference between lift-off times that may belong to the same flight. [s]"""


@dataclass(frozen=True, slots=True)
class FigureDifference:
    """The second figure minus the first, with the `sd` of both combined; `in_sd` is the difference divided by `sd`.

    `in_sd` is None if neither has an uncertainty. [SI], [1]
    """

    value: float
    sd: float
    in_sd: float | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """The second of two recordings compared with the first.

    `shift` is what to add to the second's clock to match the first's [s]; `rms` is the root mean square difference of
    heights over the `seconds` of ascent that both cover [m]. None if either has no samples.
    """

    differences: Mapping[str, FigureDifference]
    shift: float | None = None
    rms: float | None = None
    seconds: float | None = None


def compare(first: Recorded, second: Recorded) -> Comparison:
    """Compare the second recording of a flight with the first.

    The clocks are aligned at lift-off, or at apogee if either has no lift-off, and then refined by least squares on the
    heights of the ascent.
    """
    shared = [name for name in first.figures if name in second.figures]
    differences = {name: _difference(first.figures[name], second.figures[name]) for name in shared}
    if first.climb is None or second.climb is None:
        return Comparison(differences)
    return Comparison(differences, *_aligned(first, first.climb, second, second.climb))


def _difference(first: Figure, second: Figure) -> FigureDifference:
    value, sd = second.value - first.value, float(np.hypot(first.sd, second.sd))
    return FigureDifference(value, sd, value / sd if sd > 0 else None)


def _aligned(
    first: Recorded, one: MeasuredClimb, second: Recorded, other: MeasuredClimb
) -> tuple[float, float, float] | tuple[None, None, None]:
    """Shift [s], rms difference of heights [m] and duration compared [s]."""
    from scipy.optimize import minimize_scalar  # takes 0.3 s to import

    mark = next((name for name in ("liftoff", "apogee") if name in first.events and name in second.events), None)
    start = first.events[mark].time - second.events[mark].time if mark else float(one.time[-1] - other.time[-1])

    def mean_square(shift: float) -> float:
        gaps = _gaps(one, other, shift)
        return float(np.mean(gaps**2)) if gaps.size > 4 else np.inf

    tries = start + np.linspace(-_REACH, _REACH, 61)
    best = float(tries[np.argmin([mean_square(shift) for shift in tries])])
    found = minimize_scalar(mean_square, bounds=(best - 0.15, best + 0.15), method="bounded")
    gaps = _gaps(one, other, float(found.x))
    if gaps.size <= 4:
        return None, None, None
    step = float(np.median(np.diff(one.time)))
    return float(found.x), float(np.sqrt(np.mean(gaps**2))), gaps.size * step


def _gaps(one: MeasuredClimb, other: MeasuredClimb, shift: float) -> Float[Array, "time"]:
    """Differences of height at the first's times while both climb, over at least most of the shorter one. [m]"""
    shorter = min(np.ptp(one.time), np.ptp(other.time))
    both = _joined(one, other, shift)
    if len(both) * np.median(np.diff(one.time)) < 0.6 * shorter:
        return np.empty(0)
    return np.asarray(both["second"] - both["first"], float)


def _joined(one: MeasuredClimb, other: MeasuredClimb, shift: float) -> "pandas.DataFrame":
    """Heights of both at the first's times, with the second's clock shifted and its heights interpolated. [m]

    Of rows with the same time, as a simulation writes them around an event, the first counts.
    """
    import pandas  # takes 0.17 s to import

    heights = pandas.Series(one.height, one.time), pandas.Series(other.height, other.time + shift)
    first, second = (series[~series.index.duplicated()] for series in heights)
    whole = pandas.concat({"first": first, "second": second}, axis=1).sort_index()
    return whole.interpolate("index", limit_area="inside").loc[first.index].dropna()

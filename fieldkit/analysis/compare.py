"""Two recordings of one flight beside each other: clocks aligned, figures and heights compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.analysis.records import Figure, MeasuredClimb, Recorded
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    import pandas

_REACH = 3.0
"""How far lift-offs may be found apart that are one. [s]"""


@dataclass(frozen=True, slots=True)
class FigureDifference:
    """How much more the second says than the first; `sd` is of both together, `apart` the difference in it.

    `apart` is None if neither has an uncertainty. [SI], [1]
    """

    value: float
    sd: float
    apart: float | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """The second of two recordings against the first.

    `shift` is what the second's clock must be put forward by to agree with the first's [s], `rms` how far their
    heights are apart from then on, over the `seconds` of ascent that both have [m]; None if either has no samples.
    """

    differences: Mapping[str, FigureDifference]
    shift: float | None = None
    rms: float | None = None
    seconds: float | None = None


def compare(first: Recorded, second: Recorded) -> Comparison:
    """What the second recording of a flight says against the first.

    The clocks are set by lift-off, or apogee if one has no lift-off, and then so that the heights of the ascent
    agree best by least squares.
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
    """Shift [s], rms difference of heights [m] and the length of what was compared [s]."""
    from scipy.optimize import minimize_scalar

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
    """Differences of height where both climb, at the first's times, most of the shorter one at least. [m]"""
    shorter = min(np.ptp(one.time), np.ptp(other.time))
    both = _joined(one, other, shift)
    if len(both) * np.median(np.diff(one.time)) < 0.6 * shorter:
        return np.empty(0)
    return np.asarray(both["second"] - both["first"], float)


def _joined(one: MeasuredClimb, other: MeasuredClimb, shift: float) -> "pandas.DataFrame":
    """The heights of both at the first's times, the second's clock put forward and between its samples by lines. [m]"""
    import pandas

    first, second = pandas.Series(one.height, one.time), pandas.Series(other.height, other.time + shift)
    whole = pandas.concat({"first": first, "second": second}, axis=1).sort_index()
    return whole.interpolate("index", limit_area="inside").loc[first.index].dropna()

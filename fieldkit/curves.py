"""Curves through computed points, and the lowest point of a cost. `scipy.interpolate` and `scipy.optimize` would take
27 MB of memory."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fieldkit.shapes import Array, Float

GOLDEN_RATIO = 0.5 * (5**0.5 - 1)
"""Ratio of the longer part to the whole if the whole is divided in the same ratio. [1]"""


@dataclass(frozen=True)
class MonotoneCurve:
    """Cubic curves through `values` at increasing places `at`, without extremes between them.

    Source: Fritsch and Butland, A method for constructing local monotone piecewise cubic interpolants, SIAM J. Sci.
    Stat. Comput. 5 (1984).
    """

    at: Float[Array, "point"]
    values: Float[Array, "*curve point"]
    slopes: Float[Array, "*curve point"] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "slopes", _slopes(np.diff(self.at), np.diff(self.values) / np.diff(self.at)))

    def __call__(self, places: Any) -> Any:
        """The curves at a place, or at several in the last axis."""
        step, start, (first, second, third) = self._cubic(places)
        return self.values[..., start] + step * (first + step * (second + step * third))

    def slope(self, place: Any) -> Any:
        """The derivatives of the curves at a place, or at several in the last axis."""
        step, _, (first, second, third) = self._cubic(place)
        return first + step * (2 * second + 3 * step * third)

    def _cubic(self, places: Any) -> tuple[Any, Any, tuple[Any, Any, Any]]:
        """The distance of places from the point before them, its number, and the coefficients of the cubic there."""
        start = np.clip(np.searchsorted(self.at, places, side="right") - 1, 0, len(self.at) - 2)
        width = self.at[start + 1] - self.at[start]
        rise = (self.values[..., start + 1] - self.values[..., start]) / width
        first, last = self.slopes[..., start], self.slopes[..., start + 1]
        return (
            places - self.at[start],
            start,
            (first, (3 * rise - 2 * first - last) / width, (first + last - 2 * rise) / width**2),
        )


def _slopes(width: Float[Array, "interval"], rise: Float[Array, "*curve interval"]) -> Float[Array, "*curve point"]:
    """The slopes at the points: within the curve the weighted harmonic mean of the slopes on both sides, 0 at an
    extreme."""
    if len(width) == 1:
        return np.repeat(rise, 2, axis=-1)
    before, after = rise[..., :-1], rise[..., 1:]
    near, far = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    monotone = before * after > 0
    ones = np.ones_like(rise[..., 1:])
    mean = (near + far) / (near / np.where(monotone, before, ones) + far / np.where(monotone, after, ones))
    first = _end_slope(width[0], width[1], rise[..., 0], rise[..., 1])
    last = _end_slope(width[-1], width[-2], rise[..., -1], rise[..., -2])
    return np.concatenate([first[..., None], np.where(monotone, mean, 0.0), last[..., None]], axis=-1)


def _end_slope(width: float, next_width: float, rise: Array, next_rise: Array) -> Array:
    """The slope at an end of a parabola through three points, as far as the curve stays monotone."""
    slope = ((2 * width + next_width) * rise - width * next_rise) / (width + next_width)
    slope = np.where(slope * rise > 0, slope, 0.0)
    return np.where((rise * next_rise <= 0) & (np.abs(slope) > 3 * np.abs(rise)), 3 * rise, slope)


def lowest(cost: Callable[[float], float], low: float, high: float, tolerance: float) -> tuple[float, float]:
    """The place between two bounds where a cost with one minimum is lowest, within a tolerance, and that cost, by
    golden-section search."""
    inner = [high - GOLDEN_RATIO * (high - low), low + GOLDEN_RATIO * (high - low)]
    costs = [cost(place) for place in inner]
    while high - low > tolerance:
        if costs[0] <= costs[1]:
            high, inner[1], costs[1] = inner[1], inner[0], costs[0]
            inner[0] = high - GOLDEN_RATIO * (high - low)
            costs[0] = cost(inner[0])
        else:
            low, inner[0], costs[0] = inner[0], inner[1], costs[1]
            inner[1] = low + GOLDEN_RATIO * (high - low)
            costs[1] = cost(inner[1])
    return min(zip(inner, costs, strict=True), key=lambda pair: pair[1])

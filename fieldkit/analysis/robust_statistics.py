"""Small robust statistics shared by the measurements.

Two of them are also in `scipy.signal` and `scipy.stats` (a test compares them). Importing those takes longer than
measuring a log, and a third of the memory.

Source: the median absolute deviation as a scale (Hampel, The Influence Curve and Its Role in Robust Estimation, 1974).
"""

from itertools import pairwise

import numpy as np

from fieldkit.shapes import Array, Float

_LONG_FILTER = 500_000
"""Samples times window above which scipy's filter is used. [1]"""
_STUDENT_DOF = 4.0
"""Degrees of freedom of the errors of samples. [1]"""
_LINE_ROUNDS = 4
"""Rounds of a robust fit of a line. [1]"""
_RATE_WINDOW, _MOST_STRETCHES = 25, 20
"""Number of samples that show a sampling rate, and largest number of changes of it; beyond that it is irregular. [1]"""


def mad_sd(values: Float[Array, "_"]) -> float:
    """Robust standard deviation from the median absolute deviation, in the unit of the values; 0 without values."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else 0.0


def student_weights(residuals: Float[Array, "_"], fitted: int, smallest: float) -> Float[Array, "_"]:
    """Weights of samples in a fit of `fitted` values, from their residuals: the inverse variance of an error with a
    Student t distribution, so that outliers count less, in 1/unit². The scale is at least `smallest`, in the unit.

    Errors with lag-1 autocorrelation r are worth (1 - r) / (1 + r) independent ones.
    """
    scale = max(mad_sd(residuals) * np.sqrt(residuals.size / (residuals.size - fitted)), smallest)
    lag1 = lag_one(residuals)
    independent = (1 - lag1) / (1 + lag1)
    weight = (_STUDENT_DOF + 1) / (_STUDENT_DOF + (residuals / scale) ** 2)
    return np.asarray(independent * weight / scale**2, np.float64)


def running_median(values: Float[Array, "_"], size: int) -> Float[Array, "_"]:
    """Running median over an odd number of samples, in their unit; samples are mirrored at the ends.

    Long channels use scipy: its filter is faster, but importing it takes longer than filtering a short channel.
    """
    size = min(size, values.size)
    if values.size * size > _LONG_FILTER:
        from scipy.ndimage import median_filter  # takes 0.2 s to import

        return np.asarray(median_filter(values, size=size, mode="reflect"), float)
    padded = np.pad(np.asarray(values, float), (size // 2, size - 1 - size // 2), mode="symmetric")
    windows = np.lib.stride_tricks.sliding_window_view(padded, size)
    return np.asarray(np.partition(windows, size // 2, axis=1)[:, size // 2])


def running_median_over(
    time: Float[Array, "_"], values: Float[Array, "_"], window: float, least: int, most: int
) -> Float[Array, "_"]:
    """Running median over a time [s], of at least and at most so many samples, in the unit of the values.

    A log may be sampled faster in the climb than on the way down; each stretch has its own number of samples.
    """
    found = np.empty(values.size)
    for part, step in stretches(time):
        size = int(np.clip(window / step, least, most)) | 1
        first, last = max(part.start - size, 0), min(part.stop + size, values.size)
        found[part] = running_median(values[first:last], size)[part.start - first : part.stop - first]
    return found


def stretches(time: Float[Array, "_"]) -> list[tuple[slice, float]]:
    """The parts of a log between changes of its sampling rate by a factor of two, and the time step of each. [s]"""
    usual = median_step(time)
    steps = running_median(np.diff(time), _RATE_WINDOW)
    rates = np.round(np.log2(np.maximum(steps, 1e-6) / usual))
    edges = np.flatnonzero(np.diff(rates)) + 1
    edges = edges[np.diff(edges, prepend=0) >= _RATE_WINDOW] if edges.size else edges
    if not 0 < edges.size <= _MOST_STRETCHES:
        return [(slice(0, time.size), usual)]
    bounds = [0, *edges.tolist(), time.size]
    return [(slice(a, b), median_step(time[a : b + 1])) for a, b in pairwise(bounds)]


def local_slopes(values: Float[Array, "_"], width: int, step: float) -> Float[Array, "_"]:
    """Slope at the center of a parabola through each window of an odd number of evenly spaced samples, per unit of
    time.

    Half a window is lost at either end (Savitzky and Golay, Analytical Chemistry 36, 1964).
    """
    place = np.arange(width) - width // 2
    return np.correlate(values, place / (step * (place**2).sum()), mode="valid")


def student_line(x: Float[Array, "_"], y: Float[Array, "_"], smallest: float) -> tuple[float, float]:
    """Slope and intercept of a line through samples whose errors have a Student t distribution and a scale of at least
    `smallest`, in the units of `y` and `x`."""
    middle, weight = x.mean(), np.ones(x.size)
    design = np.stack([x - middle, np.ones(x.size)], axis=1)
    slope, level = 0.0, 0.0
    for _ in range(_LINE_ROUNDS):
        counted = design.T * weight
        slope, level = np.linalg.solve(counted @ design, counted @ y).tolist()
        weight = student_weights(y - design @ np.array([slope, level]), 2, smallest)
    return slope, level - slope * float(middle)


def median_step(time: Float[Array, "_"]) -> float:
    """Median time between samples at different times; infinite if there are none. [s]"""
    steps = np.diff(time)
    later = steps[steps > 0]
    return float(np.median(later)) if later.size else np.inf


def hole_at(time: Float[Array, "_"], moment: float) -> float:
    """Length of the gap in the samples around a moment: from the last sample before it to the first after it. [s]"""
    after = int(np.clip(np.searchsorted(time, moment, side="right"), 1, time.size - 1))
    return float(time[after] - time[after - 1])


def lag_one(values: Float[Array, "_"]) -> float:
    """Robust lag-1 autocorrelation of residuals, from 0 to 0.95. [1]"""
    if values.size < 8:
        return 0.0
    bound = 3 * max(mad_sd(values), 1e-12)
    calm = np.clip(values - np.median(values), -bound, bound)
    return float(np.clip((calm[1:] * calm[:-1]).mean() / max((calm**2).mean(), 1e-24), 0, 0.95))

"""Small robust statistics that the measuring shares."""

import numpy as np

from fieldkit.shapes import Array, Float


def mad_sd(values: Float[Array, "_"]) -> float:
    """Standard deviation of the bulk of values, by the median absolute deviation; 0 for none."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else 0.0


def running_median(values: Float[Array, "_"], size: int) -> Float[Array, "_"]:
    """Median over a window of an odd number of samples, shorter towards the ends."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(values, size=min(size, values.size), mode="reflect"), float)


def median_step(time: Float[Array, "_"]) -> float:
    """The usual time from one sample to the next. [s]"""
    return float(np.median(np.diff(time)))


def hole_at(time: Float[Array, "_"], moment: float) -> float:
    """How long no sample was taken about a moment: from the last one before it to the first after it. [s]"""
    after = int(np.clip(np.searchsorted(time, moment, side="right"), 1, time.size - 1))
    return float(time[after] - time[after - 1])


def lag_one(values: Float[Array, "_"]) -> float:
    """Autocorrelation of residuals from one sample to the next, robustly, from 0 to 0.95. [1]"""
    if values.size < 8:
        return 0.0
    bound = 3 * max(mad_sd(values), 1e-12)
    calm = np.clip(values - np.median(values), -bound, bound)
    return float(np.clip((calm[1:] * calm[:-1]).mean() / max((calm**2).mean(), 1e-24), 0, 0.95))

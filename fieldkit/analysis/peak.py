"""Peak acceleration of a boost: from an accelerometer, or from a curve through heights combined with motor data.

Derivation: the maximum of a running mean; what a curve through heights smooths away is estimated from motors in the
catalog.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Push
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.records import Figure
from fieldkit.analysis.robust_statistics import median_step, running_median
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

BEYOND_WINDOW = (
    (0.05, 0.02, 0.06),
    (0.1, 0.06, 0.11),
    (0.2, 0.12, 0.20),
    (0.4, 0.20, 0.28),
    (0.6, 0.27, 0.32),
    (1.0, 0.47, 0.34),
    (1.5, 0.87, 0.34),
)
"""Peak thrust divided by the highest mean over a window, for window lengths as fractions of the burn: mean and standard
deviation of its logarithm over the motors of the catalog, with each impulse class weighted equally (a test recomputes
it). [1]"""
BEYOND_MEAN = (0.47, 0.34)
"""The same for the mean of the burn. [1]"""
_MAX_LATE_START = 0.05
"""How long after lift-off an accelerometer may start and still have recorded the peak, which ignition may cause. [s]"""
_WINDOW = 0.05
"""Averaging window of the peak acceleration. In a log too sparse for it, the peak lies between the mean of three
samples and a single sample. [s]"""
_SCALE = 0.02
"""Relative error of an accelerometer. [1]"""


def peak_push(push: Push | None, ascent: Ascent, begin: float, burnout: float, mean: Figure) -> Figure | None:
    """Peak acceleration from lift-off to top speed, net of gravity, over a twentieth of a second.

    `mean` is the mean acceleration of the boost, with its source.
    """
    inside = (ascent.time >= begin) & (ascent.time <= burnout)
    if push is not None:
        there = (push.time >= begin - 0.05) & (push.time <= burnout + 0.05)
        level = levelled(push, begin)
        if there.sum() >= 8 and level is not None:
            if push.full is None or not push.full[there].any():
                if push.time[0] > begin + _MAX_LATE_START:
                    return None  # it may have come at ignition, before the first sample
                return _felt_peak(push.time[there], level[there], push)
            hidden = inside & (np.interp(ascent.time, push.time, push.full) > 0)
            floor = float(level[there & push.full].min()) - push.missed
            lasts = float(push.full[there].sum()) * median_step(push.time)
            filled = float(level[there & push.full].mean())
            return _above(_smoothed_peak(ascent, inside, mean, hidden, (filled, lasts)), max(floor, GRAVITY))
    return _smoothed_peak(ascent, inside, mean) if inside.any() else None


def _above(peak: Figure, floor: float) -> Figure:
    """A peak known to be at least the end of the range: the normal distribution of its logarithm, truncated there."""
    spread = peak.sd / peak.value
    logs = np.log(peak.value) + spread * np.linspace(-5, 5, 2001)
    logs = logs[logs >= np.log(floor)]
    if logs.size < 2:
        return Figure(floor, spread * floor, peak.source)
    weight = np.exp(-(((logs - np.log(peak.value)) / spread) ** 2) / 2)
    mean = float(weight @ logs / weight.sum())
    sd = float(np.sqrt(weight @ (logs - mean) ** 2 / weight.sum()))
    value = float(np.exp(mean))
    return Figure(value, sd * value, peak.source)


def _usual_peak(mean: Figure) -> Figure:
    """Peak from the mean acceleration alone, by the motors of the catalog."""
    spread = float(np.hypot(mean.sd / mean.value, BEYOND_MEAN[1]))
    usual = mean.value * float(np.exp(BEYOND_MEAN[0]))
    return Figure(usual, spread * usual, mean.source)


def _felt_peak(time: Float[Array, "time"], net: Float[Array, "time"], push: Push) -> Figure | None:
    """Peak of an accelerometer's readings in the boost; None if it is not above their error.

    Its scale error is about as large as the difference between its climb and that of the heights, which have errors of
    their own. A filter lowers the peak by about as large a fraction as its delay is of the boost.
    """
    width = max(3, round(_WINDOW / median_step(time)))
    smooth = running_median(net, width | 1)
    value = float(smooth.max())
    coarse = 0.0
    if 3 * median_step(time) > _WINDOW:  # between the mean of three samples, which is too long, and one of them
        coarse = (float(net.max()) - value) / 2
        value += coarse
    if median_step(time) > 1.5 * _WINDOW:  # between samples that differ there may be more than at either
        coarse = max(coarse, float(np.abs(np.diff(net)).max()) / 4)
    scale = np.hypot(_SCALE, (push.scale - 1) / 2)
    blurred = push.blur / max(float(np.ptp(time)), _WINDOW)
    sd = np.sqrt((scale * value) ** 2 + (blurred * value) ** 2 + 0.5**2 + coarse**2)
    return Figure(value, float(sd), push.source) if value > 2 * sd else None


def _smoothed_peak(
    ascent: Ascent, inside: Flags, mean: Figure, hidden: Flags | None = None, filled: tuple[float, float] = (0.0, 0.0)
) -> Figure:
    """Peak from heights only: that of the curve, times what motors have beyond a window as long as the curve resolves.

    If an accelerometer was saturated in the samples `hidden`, `filled` is the mean there [m/s^2] and how long it lasted
    [s]. Disturbed pressure at high speed creates peaks that no motor has. If the curve's peak differs from what motors
    have at this mean by more than the uncertainty of both, only the mean is used.
    """
    burn = max(float(np.ptp(ascent.time[inside])), 1e-3)
    by_mean = _usual_peak(mean)
    if hidden is not None and hidden.any():
        curve, window = filled
        draws = ascent.accelerations[:, hidden].mean(axis=1)
    else:
        place = int(np.argmax(ascent.acceleration[inside]))
        curve, draws = ascent.acceleration[inside][place], ascent.accelerations[:, inside][:, place]
        window = ascent.resolution
    if curve <= 0:
        return by_mean
    parts, logs, sds = np.array(BEYOND_WINDOW).T
    peak = float(curve * np.exp(np.interp(window / burn, parts, logs)))
    shared = mean.sd / mean.value  # an error of the mean is also an error of the peak
    sd = float(np.linalg.norm([draws.std() / curve, np.interp(window / burn, parts, sds), shared]))
    if abs(np.log(peak / by_mean.value)) > 2 * np.hypot(sd, by_mean.sd / by_mean.value):
        return by_mean
    return Figure(peak, sd * peak, mean.source)

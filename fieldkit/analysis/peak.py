"""The strongest acceleration of a boost: as an accelerometer felt it, or as a curve through heights and motors say.

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
"""Peak thrust over the greatest mean of a window, by the window's part of the burn: mean and standard deviation of its
logarithm over the motors of the catalog, each impulse class weighted equally (a test computes it again). [1]"""
BEYOND_MEAN = (0.47, 0.34)
"""The same for the mean of the burn. [1]"""
_MAX_LATE_START = 0.05
"""How long after lift-off an accelerometer may begin and still have felt all. [s]"""
_WINDOW = 0.05
"""Of the peak acceleration; a log that is too thin for it has a peak between its mean of three samples and one. [s]"""
_SCALE = 0.02
"""Of an accelerometer's error, to the acceleration. [1]"""


def peak_push(push: Push | None, ascent: Ascent, begin: float, burnout: float, mean: Figure) -> Figure | None:
    """Strongest acceleration from lift-off to top speed, net of gravity, over a twentieth of a second.

    `mean` is the mean acceleration of the boost, with its source.
    """
    inside = (ascent.time >= begin) & (ascent.time <= burnout)
    if push is not None:
        there = (push.time >= begin - 0.05) & (push.time <= burnout + 0.05)
        level = levelled(push, begin)
        if there.sum() >= 8 and level is not None:
            if push.full is None or not push.full[there].any():
                return _felt_peak(push.time[there], level[there], begin, push)
            hidden = inside & (np.interp(ascent.time, push.time, push.full) > 0)
            floor = float(level[there & push.full].min()) - push.missed
            lasts = float(push.full[there].sum()) * median_step(push.time)
            filled = float(level[there & push.full].mean())
            return _above(_smoothed_peak(ascent, inside, mean, hidden, (filled, lasts)), max(floor, GRAVITY))
    return _smoothed_peak(ascent, inside, mean) if inside.any() else None


def _above(peak: Figure, floor: float) -> Figure:
    """A peak that is known to be no less than the end of a range: its logarithm's normal distribution, cut there."""
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


def _felt_peak(time: Float[Array, "time"], net: Float[Array, "time"], begin: float, push: Push) -> Figure | None:
    """The peak of what an accelerometer felt in the boost; None if it may have come before the first sample.

    Its scale is off by about as much as its climb differs from that by the heights, which have errors of their own.
    """
    width = max(3, round(_WINDOW / median_step(time)))
    smooth = running_median(net, width | 1)
    value = float(smooth.max())
    if time[0] > begin + _MAX_LATE_START and smooth[:2].max() == smooth.max():
        return None
    coarse = 0.0
    if 3 * median_step(time) > _WINDOW:  # between the mean of three samples, which is too long, and one of them
        coarse = (float(net.max()) - value) / 2
        value += coarse
    if median_step(time) > 1.5 * _WINDOW:  # between samples that differ there may be more than at either
        coarse = max(coarse, float(np.abs(np.diff(net)).max()) / 4)
    scale = np.hypot(_SCALE, (push.scale - 1) / 2)
    sd = np.sqrt((scale * value) ** 2 + 0.5**2 + coarse**2)
    return Figure(value, float(sd), push.source) if value > 2 * sd else None


def _smoothed_peak(
    ascent: Ascent, inside: Flags, mean: Figure, hidden: Flags | None = None, filled: tuple[float, float] = (0.0, 0.0)
) -> Figure:
    """The peak by heights alone: that of the curve, and what motors have beyond it in a window as long as it resolves.

    If an accelerometer was at the end of its range, `hidden`, the mean there [m/s^2] and how long it was [s] are
    known, `filled`.
    Disturbed pressure at high speed makes peaks that no motor has: if the curve's peak is further from what motors
    have for such a mean than the uncertainty of both, only the mean is used.
    """
    burn = max(float(np.ptp(ascent.time[inside])), 1e-3)
    usual, spread = mean.value * np.exp(BEYOND_MEAN[0]), float(np.hypot(mean.sd / mean.value, BEYOND_MEAN[1]))
    if hidden is not None and hidden.any():
        curve, window = filled
        draws = ascent.accelerations[:, hidden].mean(axis=1)
    else:
        place = int(np.argmax(ascent.acceleration[inside]))
        curve, draws = ascent.acceleration[inside][place], ascent.accelerations[:, inside][:, place]
        window = ascent.resolution
    if curve <= 0:
        return Figure(usual, spread * usual, mean.source)
    parts, logs, sds = np.array(BEYOND_WINDOW).T
    peak = float(curve * np.exp(np.interp(window / burn, parts, logs)))
    shared = mean.sd / mean.value  # what is off with the mean is off with the peak
    sd = float(np.linalg.norm([draws.std() / curve, np.interp(window / burn, parts, sds), shared]))
    if abs(np.log(peak / usual)) > 2 * np.hypot(sd, spread):
        peak, sd = usual, spread
    return Figure(peak, sd * peak, mean.source)

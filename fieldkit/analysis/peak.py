"""Peak acceleration of a boost: from an accelerometer, or from a curve through heights combined with motor data.

Derivation: the maximum of a running mean; what a curve through heights smooths away is estimated from motors in the
catalog, whose thrust is the acceleration plus gravity and drag.
"""

from statistics import NormalDist

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Push
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.records import Figure
from fieldkit.analysis.robust_statistics import mad_sd, median_step, running_median
from fieldkit.flight.readout import PEAK_WINDOW
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float, Int, Integers

BEYOND_WINDOW = (
    (0.05, 1.02, 0.06),
    (0.1, 1.07, 0.14),
    (0.2, 1.16, 0.29),
    (0.4, 1.29, 0.48),
    (0.6, 1.39, 0.59),
    (1.0, 1.71, 0.73),
    (1.5, 2.56, 1.09),
)
"""Peak thrust divided by the highest mean over a window, for window lengths as fractions of the burn: mean and standard
deviation over the motors of the catalog, with each impulse class weighted equally (a test recomputes it). A few motors
have peaks far above their means, so the logarithms would have too small a spread. [1]"""
BEYOND_MEAN = (1.71, 0.73)
"""The same for the mean of the burn. [1]"""
BEYOND_SAMPLES = (
    (0.04, -0.01, 0.08),
    (0.05, 0.0, 0.08),
    (0.06, 0.01, 0.11),
    (0.1, 0.05, 0.17),
    (0.15, 0.1, 0.33),
    (0.2, 0.15, 0.51),
    (0.3, 0.23, 0.7),
    (0.4, 0.31, 0.87),
)
"""How far the peak is above the highest of samples taken at an interval [s], as a fraction of the largest difference
between neighboring samples: mean and standard deviation over the motors of the catalog and the phase of the samples,
with each impulse class weighted equally (a test recomputes it). [1]"""
_MAX_LATE_START = 0.05
"""How long after lift-off a log may start and still have recorded the peak, which ignition may cause. [s]"""
_SPARSE_INTERVAL = 0.7
"""In a log too sparse for three samples in the averaging window, the peak lies between their mean and a single sample;
at intervals above this fraction of it, not even there. [1]"""
_MEANS = float(np.sqrt(12))
"""Length of the mean that spreads a change as widely as a first-order filter of a time constant. [1]"""
_SCALE = 0.02
"""Relative error of an accelerometer. [1]"""
_FAST_FRACTION = 0.5
"""Fraction of the top speed above which drag is measured in the coast. [1]"""


def peak_push(push: Push | None, ascent: Ascent, begin: float, burnout: float, mean: Figure) -> Figure | None:
    """Peak acceleration from lift-off to top speed, net of gravity, over a twentieth of a second.

    Lift-off and burnout are times [s]; `mean` is the mean acceleration of the boost, with its source.
    """
    inside = (ascent.time >= begin) & (ascent.time <= burnout)
    if push is not None:
        beside = max(PEAK_WINDOW, median_step(push.time))
        there = (push.time >= begin - beside) & (push.time <= burnout + beside)
        level = levelled(push, begin)
        if there.sum() >= 8 and level is not None:
            if push.full is None or not push.full[there].any():
                if push.time[0] > begin + _MAX_LATE_START:
                    return None  # it may have come at ignition, before the first sample
                return _felt_peak(push.time[there], level[there], push)
            hidden = inside & (np.interp(ascent.time, push.time, push.full) > 0)
            floor = push.range_end - GRAVITY
            lasts = float(push.full[there].sum()) * median_step(push.time)
            filled = float(level[there & push.full].mean())
            return _above(_smoothed_peak(ascent, inside, mean, hidden, (filled, lasts)), max(floor, GRAVITY))
    if not inside.any():
        return None
    return _smoothed_peak(ascent, inside, mean, starts_late=bool(ascent.time[0] > begin + _MAX_LATE_START))


def _above(peak: Figure, floor: float) -> Figure:
    """A peak known to be at least the end of the range: the lognormal distribution, truncated there."""
    spread = float(np.sqrt(np.log1p((peak.sd / peak.value) ** 2)))
    middle = np.log(peak.value) - spread**2 / 2
    logs = middle + spread * np.linspace(-5, 5, 2001)
    logs = logs[logs >= np.log(floor)]
    if logs.size < 2:
        return Figure(floor, spread * floor, peak.source)
    weight = np.exp(-(((logs - middle) / spread) ** 2) / 2)
    mean = float(weight @ logs / weight.sum())
    sd = float(np.sqrt(weight @ (logs - mean) ** 2 / weight.sum()))
    value = float(np.exp(mean))
    return Figure(value, sd * value, peak.source)


def _felt_peak(time: Float[Array, "time"], net: Float[Array, "time"], push: Push) -> Figure | None:
    """Peak of an accelerometer's readings in the boost; None if it is not above their error.

    Its scale error is about as large as the difference between its climb and that of the heights, which have errors of
    their own. A filter shows means, beyond which the peak is as far as that of motors in the catalog.
    """
    value, coarse = _highest(net, median_step(time))
    by_noise, noise = _raised_by_noise(net, median_step(time))
    value -= by_noise if noise > coarse else 0.0  # a smaller one is within that error
    ratio, spread = _beyond_window(_MEANS * push.blur / max(float(np.ptp(time)), PEAK_WINDOW))
    value, blurred = value + (ratio - 1) * (value + GRAVITY), spread * (value + GRAVITY)
    scale = np.hypot(_SCALE, (push.scale - 1) / 2)
    sd = np.sqrt((scale * value) ** 2 + blurred**2 + 0.5**2 + coarse**2 + noise**2)
    return Figure(value, float(sd), push.source) if value > 2 * sd else None


def _raised_by_noise(net: Float[Array, "time"], step: float) -> tuple[float, float]:
    """How much the vibration of a boost raises the highest of its means, of samples at an interval [s], and the error
    of that. [m/s^2]

    Derivation: noise n, which third differences show where thrust changes smoothly, leaves n / sqrt(k) in a mean of k
    samples. The highest of m means of one thrust is high by the expected maximum of m normal numbers (Blom 1958), and
    that of a thrust with a peak by less, down to nothing.
    """
    count = max(PEAK_WINDOW / step, 1.0)
    left = mad_sd(np.diff(net, 3)) / float(np.sqrt(20 * count))
    means = max(net.size / count, 1.0)
    raised = left * NormalDist().inv_cdf((means - 0.375) / (means + 0.25))
    return max(raised, 0.0) / 2, float(np.hypot(left, raised / np.sqrt(12)))


def _highest(net: Float[Array, "time"], step: float) -> tuple[float, float]:
    """The highest mean over the window of samples at an interval [s], and its error from the interval. [m/s^2]"""
    highest = float(net.max())
    if step > _SPARSE_INTERVAL * PEAK_WINDOW:
        steps, means, sds = np.array(BEYOND_SAMPLES).T
        mean, sd = (float(np.interp(step, steps, one)) * float(np.abs(np.diff(net)).max()) for one in (means, sds))
        return highest + mean, sd
    middle = float(running_median(net, max(3, round(PEAK_WINDOW / step)) | 1).max())
    if 3 * step <= PEAK_WINDOW:
        return middle, 0.0
    return (middle + highest) / 2, (highest - middle) / 2  # three samples are too long, and one may be noise


def _smoothed_peak(
    ascent: Ascent,
    inside: Flags,
    mean: Figure,
    hidden: Flags | None = None,
    filled: tuple[float, float] = (0.0, 0.0),
    *,
    starts_late: bool = False,
) -> Figure:
    """Peak from heights only: the highest mean of the curve over as long as it resolves, with what motors have beyond
    that.

    If an accelerometer was saturated in the samples `hidden`, `filled` is the mean there [m/s^2] and how long it lasted
    [s]. Disturbed pressure at high speed creates peaks that no motor has. If the curve's peak differs from what motors
    have at this mean by more than the uncertainty of both, only the mean is used, and so it is if the curve
    `starts_late`, because the peak may have come at ignition.
    """
    time, speed = ascent.time[inside], ascent.speed[inside]
    burn = max(float(np.ptp(time)), 1e-3)
    drag = _drag(ascent, float(time[-1]), float(speed[-1]))
    by_mean = _beyond(mean, BEYOND_MEAN, float(np.mean(drag * speed**2)))
    if hidden is not None and hidden.any():
        curve, window = filled
        hardest = np.flatnonzero(hidden[inside])
    else:
        window = ascent.resolution
        hardest = _hardest(ascent.acceleration[inside], round(window / median_step(ascent.time)))
        curve = float(ascent.acceleration[inside][hardest].mean())
    draws = ascent.accelerations[:, inside][:, hardest].mean(axis=1)
    if curve <= 0 or starts_late:
        return by_mean
    beyond = _beyond_window(window / burn)
    shared = mean.sd / mean.value  # an error of the mean is also an error of the peak
    error = float(np.hypot(draws.std(), shared * curve))
    peak = _beyond(Figure(curve, error, mean.source), beyond, float(drag * np.mean(speed[hardest] ** 2)))
    if abs(np.log(peak.value / by_mean.value)) > 2 * np.hypot(peak.sd / peak.value, by_mean.sd / by_mean.value):
        return by_mean
    return peak


def _beyond_window(part: float) -> tuple[float, float]:
    """Peak thrust divided by the highest mean over a part of the burn, and the standard deviation. [1]"""
    parts, ratios, sds = np.array(((0.0, 1.0, 0.0), *BEYOND_WINDOW)).T
    return float(np.interp(part, parts, ratios)), float(np.interp(part, parts, sds))


def _hardest(net: Float[Array, "time"], count: int) -> Int[Integers, "_"]:
    """Which of evenly spaced accelerations are the `count` in a row with the highest mean, or all if they are fewer."""
    count = int(np.clip(count, 1, net.size))
    return int(np.argmax(np.convolve(net, np.full(count, 1.0), "valid"))) + np.arange(count)


def _beyond(mean: Figure, ratio: tuple[float, ...], drag: float) -> Figure:
    """Peak from the mean over a window and a `ratio` of peak and mean thrust, with its standard deviation.

    Thrust per mass is the net acceleration plus gravity and drag [m/s^2].
    """
    thrust = mean.value + GRAVITY + drag
    sd = np.hypot(ratio[0] * mean.sd, ratio[1] * thrust)
    return Figure(mean.value + (ratio[0] - 1) * thrust, float(sd), mean.source)


def _drag(ascent: Ascent, burnout: float, fastest: float) -> float:
    """Drag per mass and speed squared in the fast part of the coast, 0 if there is none. [1/m]"""
    fast = (ascent.time > burnout) & (ascent.speed > _FAST_FRACTION * fastest)
    if not fast.any():
        return 0.0
    return max(float(np.median((-ascent.acceleration[fast] - GRAVITY) / ascent.speed[fast] ** 2)), 0.0)

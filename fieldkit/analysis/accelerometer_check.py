"""Check whether an accelerometer recorded the same flight as the height samples, by its scale and its clock.

The acceleration, integrated twice, gives a climb. If that climb differs from the barometer's in quiet air, in size or
in time, the column is not the axial acceleration on this clock: it is another axis, has another scale, or was derived
from pressure, which a filter delays. In a tilted flight the climb along the axis is slightly longer than the vertical
one.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.channels import Heights, Push, lag_density
from fieldkit.analysis.initial_guess import THRUST_DECREASE, lagged, levelled
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event
from fieldkit.analysis.robust_statistics import mad_sd, median_step
from fieldkit.integrals import running_integral
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

SCALES = (0.75, 1.35)
"""Allowed ratio of the climb from heights to the climb from a trusted accelerometer. A calibration error of 10% and a
flight tilted by 30 degrees stay inside. [1]"""
_FILLED_SCALE, _MISSED = 0.03, 300.0
"""Scale error of a saturated accelerometer [1], and how much it may have missed while saturated [m/s^2]. The scale must
be known well, because a missed peak and a scale error produce nearly the same climb."""
_MOST_FADING = 2.0
"""Decrease of what was missed, relative to its average, with which its last sample is at the end of the range. [1]"""
_FILL_ROUNDS = 3
"""Rounds in which what was missed and the dynamic pressure of the speed with it are found in turn. [1]"""
_MAX_MISFIT = 3.0
"""Largest misfit of a climb with its saturated samples filled in, or of one with another scale, in standard deviations
of the heights. [1]"""
MAX_DELAY, MAX_LEAD = 0.22, 0.5
"""Largest delay and lead of a trusted accelerometer relative to the heights. Vents and filters delay pressure; nothing
delays what a mass feels. [s]"""
MAX_DERIVED_DELAY = 0.05
"""Largest delay of an acceleration that shows no gravity on the way down. It was derived from heights or from several
sensors rather than measured in the airframe, and is trusted only if it is on time. [s]"""
_MAX_BLUR = 0.05
"""Such a delay as a fraction of the boost, if that is longer: a filter blurs thrust by about as much as it delays it,
which a long boost shows as well as before. [1]"""
_HANGING_TIME, _LEVEL, _MAX_SPREAD = 3.0, 0.7, 3.0
"""How long after apogee the rocket hangs or lies, with its axis anywhere but upright [s]. If an acceleration has
gravity removed, its median from then on is near zero and its spread is small [m/s^2]."""
_PAD = 0.1
"""Time on the pad that an accelerometer must have recorded for its climb to be known from the start. [s]"""
_COAST = 0.6
"""Fraction of the coast in which the climbs are compared: tilt matters later, and filtered heights lag earlier. [1]"""
_MIN_SAMPLES, _MIN_CLIMB = 8, 15.0
"""Fewest samples [1] and smallest climb [m] that can be compared."""
_CORRELATION_TIME = 0.5
"""Correlation time of the errors of heights. [s]"""
MAX_FILLED_DELAY = 0.1
"""Above this delay, what a saturated accelerometer missed cannot be distinguished from the delay. If its climb agrees
with the heights at a shorter one, it is on time, as sensors of one logger are. [s]"""
_MAX_SAMPLE_INTERVAL = 0.2
"""Longest sample interval at which an accelerometer still captures the whole boost. [s]"""
_FILTERS = (0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6)
"""Time constants of filters to try if no delay explains the heights. [s]"""
_LAGS = (*np.arange(0.0, 0.2, 0.02).tolist(), *np.arange(0.2, 0.8, 0.04).tolist())
"""Lags of heights behind a filter or small vents to try. [s]"""
_ANOTHER_CLOCK, _DELAYS = 0.1, np.arange(-0.12, 0.13, 0.04)
"""Probability that heights and acceleration have different clocks [1], and delays to try around the best one [s]."""
_MIN_LAG = 0.04
"""Smallest lag that is removed; less is an error of times. [s]"""
_LEAST_BLUR = 0.015
"""Least delay of an accelerometer that a filter explains; less is an error of times. [s]"""
_ONE_STEP = float(np.log(4))
"""Time from 20% to 80% of a step behind a first-order filter, in its time constants. [1]"""
_MAX_SHIFT, _STEP = 1.5, 0.02
"""Range of clock shifts to try, and the step. [s]"""
_SCALE, _RAM, _HEIGHT_ERROR = 0.3, 0.05, 0.01
"""Standard deviations: of the scale; of the airframe's pressure error, relative to dynamic pressure; of heights,
relative to themselves. [1]
"""
_ZERO = 0.3
"""Standard deviation of an accelerometer's zero since the pad and of what gravity loses along an axis tilted by ten
degrees, which bends a climb as a lag does. [m/s^2]"""
_TRANSONIC_SPEEDS = (260.0, 430.0)
"""Range of speeds in which the pressure is not trusted. [m/s]"""


@dataclass(frozen=True, slots=True)
class Agreement:
    """Ratio of the climb from heights to the climb from the accelerometer [1], and the accelerometer's delay [s].

    `missed` is the mean acceleration beyond the end of the range, with its standard deviation [m/s^2], and `decrease`
    that of the thrust meanwhile, as a fraction of its mean [1]; `misfit` is what
    remains after both, in standard deviations of the heights [1]. `derived` if the channel was computed rather than
    measured by a sensor. `boost` is the duration of the boost according to the heights, `onset` the time constant with
    which the channel rises at lift-off [s]. `filtered` is the time constant of the filter that the heights are behind,
    if that explains them and no delay does [s]. `lag` is that of heights behind a short filter or small vents, to be
    removed, and `lag_sd` its standard deviation [s], `scale_sd` that of the scale [1].
    """

    scale: float
    late: float
    step: float
    missed: float = 0.0
    misfit: float = 0.0
    missed_sd: float = 0.0
    derived: bool = False
    boost: float = 0.0
    onset: float = 0.0
    filtered: float = 0.0
    decrease: float = 0.0
    lag: float = 0.0
    lag_sd: float = 0.0
    scale_sd: float = 0.0

    @property
    def is_consistent(self) -> bool:
        """Whether both recorded the same flight. Widely spaced samples constrain the clock less."""
        same_scale = SCALES[0] <= self.scale <= SCALES[1] and not self.is_off and not self.is_smoothed
        return same_scale and self.missed >= 0 and (not self.missed_sd or self.misfit < _MAX_MISFIT)

    @property
    def keeps_time(self) -> bool:
        """Whether only the scale differs: the climb has the right shape at the right time, so that its clock shows
        lift-off and burnout."""
        return self.scale > 0 and self.misfit < _MAX_MISFIT and not (self.is_off or self.derived or self.is_smoothed)

    @property
    def is_off(self) -> bool:
        """Whether the clocks differ by more than sensor delays explain."""
        latest = MAX_DELAY + self.step
        if self.derived:
            latest = min(latest, self._most_blur + self.step / 2)
        return not -MAX_LEAD - self.step <= self.late <= latest

    @property
    def is_smoothed(self) -> bool:
        """Whether a channel rises at lift-off more slowly than its boost allows. A filter that looks ahead, as programs
        that export have, smooths without delay; an accelerometer that is slow and on time felt a slow thrust."""
        return (self.onset - self.step if self.derived else self.blur) > self._most_blur

    @property
    def _most_blur(self) -> float:
        return max(MAX_DERIVED_DELAY, _MAX_BLUR * self.boost)

    @property
    def blur(self) -> float:
        """Time over which the filter of a channel spreads a change of thrust: its delay or its rise at lift-off, and
        the shorter of them if both may be errors of an accelerometer's times or a slow thrust. A delay is known to half
        a step of those that are tried. [s]"""
        if self.derived:
            return max(self.late - self.step / 2, self.onset - self.step, 0.0)
        delays = self.late, self.onset - self.step / _ONE_STEP
        if min(delays) > _LEAST_BLUR + self.step / 4:
            return max(delays)
        return max(min(max(self.late, _STEP / 2), delays[1]), 0.0)

    @property
    def why(self) -> str:
        """The reason if they do not agree."""
        if self.is_off:
            return f"is {abs(self.late):.1f} s {'late' if self.late > 0 else 'early'}"
        if self.is_smoothed:
            slow = f"was computed and smoothed over about {self.onset:.1f} s"
            return slow if self.derived else f"is behind a filter of about {self.blur:.2f} s"
        return f"gives {100 / self.scale:.0f}% of the climb that the heights show"


def agreement(track: Heights, push: Push, seen: Outline, lift: Event, full: Flags | None = None) -> Agreement | None:
    """Compare an accelerometer with the heights, from the lift-off found in the heights into the coast.

    What it missed while saturated (samples marked in `full`) is fitted together with its scale. None if too few samples
    in quiet air remain to decide.
    """
    net = levelled(push, lift.time)
    end = seen.fastest + _COAST * (seen.top - seen.fastest)
    inside = (track.time > lift.time) & (track.time < end)
    if net is None or push.time[0] > lift.time - _PAD or push.time[-1] < end:
        return None
    felt = (push.time > lift.time - _MAX_SHIFT) & (push.time < end + _MAX_SHIFT)
    time, net = push.time[felt], net[felt]
    if time.size < _MIN_SAMPLES or inside.sum() < _MIN_SAMPLES or np.diff(time).max() > _MAX_SAMPLE_INTERVAL:
        return None
    speed = running_integral(net, time)
    climb = running_integral(speed, time)
    when, height = track.time[inside], track.height[inside] - seen.pad
    fast = np.abs(np.interp(when, time, speed))
    quiet = (fast < _TRANSONIC_SPEEDS[0]) | (fast > _TRANSONIC_SPEEDS[1])
    when, height = when[quiet], height[quiet]
    if when.size < _MIN_SAMPLES or np.ptp(height) < max(_MIN_CLIMB, 10 * track.noise):
        return None
    shifts = np.arange(-_MAX_SHIFT, _MAX_SHIFT + _STEP / 2, _STEP)
    step = median_step(track.time[inside])
    spread = np.hypot(track.noise, _HEIGHT_ERROR * height)
    correlated = max(1.0, _CORRELATION_TIME / step)
    decrease, flown = THRUST_DECREASE, speed

    def tried(beyond: Array | None) -> list[tuple[float, float, float, float, float]]:
        return [_fit(when + shift, height, time, climb, flown, beyond, spread, correlated) for shift in shifts]

    if full is None:
        found = tried(None)
        best = int(np.argmin([one[0] for one in found]))
    else:
        on_time = np.abs(shifts) < MAX_FILLED_DELAY + step
        for decrease in (THRUST_DECREASE, 0.0):
            missed = 0.0
            for _ in range(_FILL_ROUNDS):  # what was missed is also missing in the dynamic pressure
                gained = running_integral(shape_of_missed(push, full, missed, decrease)[felt], time)
                flown = speed + max(missed, 0.0) * gained
                found = tried(running_integral(gained, time))
                costs = np.array([one[0] for one in found])
                best = int(np.argmin(np.where(on_time, costs, np.inf)))
                missed = found[best][3]
            if found[best][1] < _MAX_MISFIT:
                break
        else:
            best = int(np.argmin(costs))
    late, (_, misfit, scale, missed, sd) = float(shifts[best]), found[best]
    derived, boost = _is_derived(push, seen), seen.fastest - lift.time
    onset = _onset(time, net, lift.time, seen.fastest) if full is None or derived else 0.0
    filtered, lag, lag_sd, scale_sd = 0.0, 0.0, 0.0, 0.0
    if full is None:
        even = np.arange(time[0], time[-1], _STEP)
        zero = np.maximum(even - lift.time, 0.0) ** 2 / 2
        fast, high = np.interp(even, time, speed), np.interp(even, time, climb)

        def behind(lag: float, delay: float = 0.0) -> tuple[float, float, float, float, float]:
            shown, rams, drifts = (lagged(one, float(one[0]), _STEP, lag) for one in (high, fast**2, zero))
            flown = np.sqrt(np.maximum(rams, 0.0))
            return _fit(when - delay, height, even, shown, flown, None, spread, correlated, drifts)

        scale_sd, sd = sd, 0.0
        delays = _DELAYS - late
        by_lag, by_delay = [behind(one)[0] for one in _LAGS], [behind(0.0, one)[0] for one in delays.tolist()]
        lag, lag_sd = _lag_of(np.array(by_lag), delays, np.array(by_delay))
        if misfit > _MAX_MISFIT:
            misfits = [behind(one)[1] for one in _FILTERS]
            least = int(np.argmin(misfits))
            filtered = _FILTERS[least] if misfits[least] < _MAX_MISFIT else 0.0
    beyond_sd = sd * max(1.0, misfit)
    known = {"filtered": filtered, "decrease": decrease, "lag": lag, "lag_sd": lag_sd, "scale_sd": scale_sd}
    return Agreement(scale, late, step, missed, misfit, beyond_sd, derived, boost, onset, **known)


def _lag_of(
    by_lag: Float[Array, "lag"], delays: Float[Array, "delay"], by_delay: Float[Array, "delay"]
) -> tuple[float, float]:
    """The lag of heights behind those of an accelerometer, and its standard deviation, from the cost of each of `_LAGS`
    and of each of some delays [s] on another clock. [s]

    Derivation: heights behind a first-order filter T are late by T in a coast, but by less of it in the boost before.
    A lag too small to be removed is part of the error.
    """
    lags, least = np.array(_LAGS), min(by_lag.min(), by_delay.min())
    spans = lag_density(lags) * np.gradient(lags)
    weights = np.append(
        (1 - _ANOTHER_CLOCK) * np.exp((least - by_lag) / 2) * spans / spans.sum(),
        _ANOTHER_CLOCK * np.exp((least - by_delay) / 2) * np.gradient(delays) / (2 * _MAX_SHIFT),
    )
    weights, late = weights / weights.sum(), np.append(lags, delays)
    mean = float(weights @ late)
    variance = float(weights @ (late - mean) ** 2)
    return (mean, variance**0.5) if mean > _MIN_LAG else (0.0, (mean**2 + variance) ** 0.5)


def shape_of_missed(push: Push, full: Flags, missed: float, decrease: float) -> Float[Array, "time"]:
    """What a saturated accelerometer missed in each sample, relative to its average `missed` [m/s^2]: thrust decreases
    by a fraction of its mean, and is never within the range. [1]

    Derivation: a straight line with that average and that slope."""
    place = np.cumsum(full) / max(int(full.sum()), 1)
    thrust = float(push.felt[full].min()) + missed if full.any() else 0.0
    fades = min(decrease * thrust / missed, _MOST_FADING) if missed > 0 else decrease
    return np.asarray(full * (1 + fades * (0.5 - place)))


def _onset(time: Float[Array, "time"], net: Float[Array, "time"], lift: float, fastest: float) -> float:
    """Time constant of the rise of an acceleration at lift-off, where thrust rises within hundredths of a second. [s]

    Infinite if it does not begin with a rest. Derivation: a first-order filter rises from 20% to 80% of a step in ln 4
    time constants.
    """
    boost = net[(time > lift) & (time < fastest)]
    if boost.size < 3:
        return 0.0
    strong = float(np.quantile(boost, 0.6))
    risen = int(np.argmax((net >= 0.8 * strong) & (time > lift - _MAX_SHIFT)))
    low = np.flatnonzero(net[:risen] < 0.2 * strong)
    return float(time[risen] - time[low[-1]]) / _ONE_STEP if low.size else np.inf


def unchecked(push: Push, seen: Outline, lift: Event | None) -> bool:
    """Whether an acceleration that cannot be compared with the heights was computed, and does not rise like thrust.

    One that includes gravity was measured.
    """
    if push.weighs or not _is_derived(push, seen):
        return False
    begin = lift.time if lift is not None else float(push.time[0])
    inside = push.time > begin - _MAX_SHIFT
    time = push.time[inside]
    if time.size < 2:
        return True
    onset = _onset(time, push.felt[inside] - GRAVITY, begin, seen.fastest)
    return onset > max(MAX_DERIVED_DELAY, _MAX_BLUR * (seen.fastest - begin)) + median_step(time)


def _is_derived(push: Push, seen: Outline) -> bool:
    """Whether an acceleration lacks the gravity that a sensor along the axis measures on the way down."""
    after_apogee = push.felt[push.time > seen.top + _HANGING_TIME] - GRAVITY
    return bool(
        after_apogee.size >= _MIN_SAMPLES
        and abs(np.median(after_apogee)) < _LEVEL
        and mad_sd(after_apogee) < _MAX_SPREAD
    )


def _fit(
    when: Float[Array, "sample"],
    height: Float[Array, "sample"],
    time: Float[Array, "time"],
    climb: Float[Array, "time"],
    speed: Float[Array, "time"],
    beyond: Float[Array, "time"] | None,
    spread: Float[Array, "sample"],
    correlated: float,
    zero: Float[Array, "time"] | None = None,
) -> tuple[float, float, float, float, float]:
    """Cost of a climb through heights, its misfit in standard deviations of these, the best scale, how much of `beyond`
    was missed, and its standard deviation, or without `beyond` that of the scale.

    `spread` is the standard deviation of each height [m], `correlated` the number of neighbors that share its error.
    `zero` is the climb by an error of the accelerometer's zero of one unit, if that is fitted.
    The airframe's pressure error, a fraction of the dynamic pressure, is fitted together with the scale.
    """
    felt = np.interp(when, time, climb)
    ram = np.interp(when, time, speed) ** 2 / (2 * GRAVITY)
    columns, sds = [felt, ram], [_SCALE if beyond is None else _FILLED_SCALE, _RAM]
    if zero is not None:
        columns, sds = [*columns, np.interp(when, time, zero)], [*sds, _ZERO]
    if beyond is not None:
        columns, sds = [*columns, np.interp(when, time, beyond)], [*sds, _MISSED]
    prior = np.diag(1 / np.array(sds))
    wide = spread * np.sqrt(correlated)
    design = np.concatenate([np.stack(columns, axis=1) / wide[:, None], prior])
    target = np.concatenate([height / wide, prior[0]])
    values, *_ = np.linalg.lstsq(design, target, rcond=None)
    left = target - design @ values
    cost, misfit = float(left @ left), float(np.sqrt(correlated * np.mean(left[: when.size] ** 2)))
    errors = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))
    if beyond is None:
        return cost, misfit, float(values[0]), 0.0, float(errors[0])
    return cost, misfit, float(values[0]), float(values[2]), float(errors[2])

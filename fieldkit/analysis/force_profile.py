"""Drag along the coast of one log: drag area over mass as a function of time, by a linear-Gaussian smoother.

A coast at an upward speed v and a height h follows

    dv/dt = -g - b(t) s(h) v |v|,    dh/dt = v,    b = rho Cd A / (2 m),

with rho the air density at the pad and s(h) the density ratio above it. b is constant in each of up to `_MAX_INTERVALS`
intervals. Heights and accelerations, averaged over the intervals, are compared with that path; the equations are
linearized about it and the fit is repeated (iterated extended Kalman smoother, in its batch form: Särkkä, Bayesian
Filtering and Smoothing, 2013, chapter 10). What a healthy rocket's b does is a Gaussian process: a slow change with the
logarithm of the speed (Reynolds number, angle of attack), and a fast one. The errors of sensors have priors of their
own: bias, gain and lag; static ports, which are off by a fraction of the dynamic pressure; correlated noise; and the
angle of the path, which lengthens it by a fraction that grows as 1/v².

The result is the likelihood of any b(t), with everything else integrated out, so that hypotheses about b(t), such as a
step, cost two products of small matrices (`fieldkit.selection.drag_steps`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import exp, sqrt

import numpy as np

from fieldkit.analysis.accelerometer_check import SCALES
from fieldkit.analysis.ballistic import SCALE_HEIGHT
from fieldkit.analysis.channels import BAROMETRIC, Push, pushes
from fieldkit.analysis.drag_and_impulse import PORT_ERROR, PORTS_SD
from fieldkit.analysis.records import HeightTrack, Recorded
from fieldkit.analysis.robust_statistics import mad_sd, median_step
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

_MAX_INTERVALS, _SHORTEST_INTERVAL = 80, 0.06
"""Most intervals of a coast [1], and the shortest one [s]."""
_MIN_TIME, _MIN_INTERVALS, _MIN_SPEED_RATIO = 1.0, 8, 1.5
"""Shortest coast [s], fewest intervals [1] and smallest ratio of its first speed to its last that show drag. [1]"""
_MAX_SPEED = 0.7 * 335.0
"""Mach 0.7, above which Cd grows with the Mach number. [m/s]"""
_BEGIN_MARGIN, _END_MARGIN = 0.12, 0.15
"""How long after burnout a coast begins, in addition to twice the standard deviation of burnout, and how long before
apogee or ejection it ends. [s]"""
_DRAGS = (2e-4, 1e-2)
"""Range of b in which a fit starts: rockets from 40 kg and 150 mm to 0.05 kg and 40 mm. [1/m]"""
_MIN_SPEED, _MIN_SPEED_FRACTION = 5.0, 0.2
"""Speed at which a coast ends [m/s], also as a fraction of its first speed [1]: drag is then a sixteenth of what it was
at first, below the errors of every sensor, and the direction of the path is unknown."""
_SLOW_SD, _SLOW_LENGTH = 0.15, 0.7
"""Slow change of b in a healthy coast: standard deviation [1] and length in the logarithm of the speed [1]. Cd of a
smooth body changes with Re^-0.2 at most (Hoerner, Fluid-Dynamic Drag, 1965, chapter 2), by 8% from 60 to 25 m/s."""
_FAST_TIME = 0.3
"""Correlation time of the fast change of b and of the noise of an accelerometer: about a period of a rocket's pitch.
[s]"""
_FAST_SDS, _PUSH_SDS, _PITCH_SDS = (0.03, 0.1), (0.05, 0.2, 0.8), (0.0, 2.0)
"""Values over which the correlated errors are averaged: the fast change of b [1], noise of an accelerometer, and what
pitching after burnout adds to it [m/s^2]."""
_RAM_SDS = ((0.4, 0.01), (0.4, 0.04), (0.4, 0.15))
"""The same for the changing error of heights: a constant part [m], and a part of the dynamic pressure [1]."""
_QUIET_RAM = (0.1, 0.01)
"""A setting for logs without an accelerometer, whose heights alone show the drag: a port that pressure waves and pitch
disturb little. With an accelerometer it would add little but time. [m], [1]"""
_PITCH_TIME = 0.5
"""Decay time of pitching after burnout. [s]"""
_ANY_LEVEL_SD, _ANY_CHANGE_SD, _ANY_CHANGE_TIME = 3.0, 1.0, 1.0
"""Wide prior of relative drag with which the path and outliers are found: standard deviations of its level and of its
change [1], and the correlation time of the change [s]."""
_OWN_TIME = 0.5
"""Time over which the drag is averaged to which the changes of a healthy coast are relative. [s]"""
_RAM_TIME = 0.3
"""Correlation time of the changing error of heights. [s]"""
_SPEED_SD, _OFFSET_SD = 20.0, 5.0
"""Prior standard deviations of the first speed [m/s] and height [m] about the first estimates."""
_LONGEST_STEP, _LEAST_RELATIVE = 0.8, 0.05
"""Longest step of a round in relative drag or in `_SPEED_SD`, and smallest relative drag. [1]"""
_SCALE_SD, _LAG_SD = 0.05, 0.1
"""Prior standard deviations of the scale of heights [1] (air 15 K off) and of the lag of a barometer [s]."""
_BIAS_SD, _UNLEVELLED_BIAS_SD, _GAIN_SD = 0.25, 1.0, 0.02
"""Prior standard deviations of an accelerometer's zero with and without a rest on the pad [m/s^2]; of its gain [1]."""
_DRIFT_SD, _DERIVED_DRIFT_SD, _DRIFT_TIME = 0.15, 0.2, 1.5
"""Standard deviation of the slow error of an accelerometer, and of one whose gravity was removed along an estimated
axis [m/s^2], and its correlation time [s]."""
_THRUST_LEFT, _LEAST_LEFT, _FADE_TIMES = 0.15, 3.0, (0.12, 0.4)
"""Thrust below which a coast is taken to begin, as a fraction of the largest [1] and at least [m/s^2]; and the decay
times of what is then left, of which half of that is the standard deviation. [s]"""
_TILT = 0.17
"""Horizontal speed as a fraction of the first speed of the coast: a path 10 degrees off vertical. Drag along a path at
the speed V is V/v times that by its upward speed v; an accelerometer on the axis feels V/v times that again, and one
whose gravity was removed along a wrong axis hides part of it. [1]"""
_TILT_SD = (0.5**2 + 0.5) ** 0.5
"""Root mean square of V/v - 1 over the variance of the angle, if that is normal: V/v is 1 + half of its square. [1]"""
_MOST_SLOWED = 25.0
"""Largest ratio of the squares of first and later speeds in the error of the path's angle. [1]"""
_WORST_BIAS, _LEAST_THRUST = 1.5, 15.0
"""Largest bias of an accelerometer on the pad, and what it feels in every boost. [m/s^2]"""
_PORTS_SD = PORTS_SD / PORT_ERROR
"""Prior standard deviation of the error of static ports, as a fraction of the dynamic pressure. [1]"""
_OWN_PORTS = 0.35
"""Standard deviation of what single flights of a rocket add to that error, relative to it: angle of attack. [1]"""
_OUTLIER = 4.0
"""Standard deviations beyond which an interval's residual gets a larger variance. [1]"""
_OUTLIER_ROUNDS = 3
"""Rounds in which outliers are found: large ones hide smaller ones. [1]"""
_ROUNDS, _TOLERANCE = 12, 1e-3
"""Most rounds of linearization, and the largest relative change of b that ends them. [1]"""
_MIN_WEIGHT, _MOST_KEPT = 0.05, 4
"""Smallest weight, and number, of the noise settings that are kept. [1]"""
_MOST_PUSH = 3.0
"""Standard deviations by which the drag of a coast may be below none. [1]"""
_VAGUE_SD = 1.0
"""Standard deviation of the level of b relative to the reference while the noise settings are weighed. [1]"""
SWITCH_TIMES = (0.1, 0.5, 1.5)
"""Durations of a switch that are tried: a part that is lost, a brake that a servo opens, and one that a controller
opens little by little. [s]"""
_STEP_PROBABILITY, _STEP_SD = 0.2, 0.7
"""Probability of a step, and standard deviation of its relative size, while the noise settings are weighed. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class PortError:
    """How the log likelihood depends on the error e of the static ports that the flights of a rocket share:
    push e - precision e²/2 - e joint'm, with e in prior standard deviations and the relative drag m."""

    joint: Float[Array, "interval"]
    precision: float
    push: float


@dataclass(frozen=True, slots=True, eq=False)
class DragLikelihood:
    """The log likelihood of the relative drag m of each interval, w - m'Pm/2 + s'm, for one setting of the noise.

    `prior` is the covariance of what varies about m in a healthy coast, already integrated out of the likelihood; the
    relative drag given m and the log has the mean m + prior (shift - precision m).
    """

    log_weight: float
    precision: Float[Array, "interval interval"]
    shift: Float[Array, "interval"]
    prior: Float[Array, "interval interval"]
    ports: "PortError"

    def with_ports(self, error: float) -> "DragLikelihood":
        """The same, given the error of the rocket's static ports in prior standard deviations [1]."""
        add = error * self.ports.push - error**2 / 2 * self.ports.precision
        return replace(self, log_weight=self.log_weight + add, shift=self.shift - error * self.ports.joint)

    def with_any_ports(self) -> "DragLikelihood":
        """The same with the error of the static ports integrated out, for a flight alone."""
        gain = 1 / (1 + self.ports.precision)
        return replace(
            self,
            log_weight=self.log_weight + 0.5 * (gain * self.ports.push**2 + float(np.log(gain))),
            precision=self.precision - gain * np.outer(self.ports.joint, self.ports.joint),
            shift=self.shift - gain * self.ports.push * self.ports.joint,
        )

    def given(self, mean: Float[Array, "*many interval"]) -> Float[Array, "*many interval"]:
        """Relative drag in each interval, if this is its mean without the healthy variation. [1]"""
        return np.asarray(mean + (self.shift - mean @ self.precision) @ self.prior)

    @property
    def variance(self) -> Float[Array, "interval"]:
        """Variance of the relative drag given its mean. [1]"""
        spread = self.prior - self.prior @ self.precision @ self.prior
        return np.asarray(np.maximum(np.diagonal(spread), 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class DragProfile:
    """What a log shows of drag along its coast.

    `time_from_liftoff` are the middles of the intervals, `length` [s] each long, `speed` the speed there. Relative drag
    is in units of `reference`, b in 1/m. `likelihoods` are those of the probable noise settings, most probable first.
    """

    time_from_liftoff: Float[Array, "interval"]
    length: float
    speed: Float[Array, "interval"]
    reference: float
    likelihoods: tuple[DragLikelihood, ...]
    source: str

    @property
    def edges(self) -> Float[Array, "edge"]:
        """Boundaries of the intervals, from lift-off. [s]"""
        return np.append(self.time_from_liftoff - self.length / 2, self.time_from_liftoff[-1] + self.length / 2)

    @property
    def level(self) -> tuple[float, float]:
        """Drag b of the coast as if it were constant, and its standard deviation, averaged over the settings of the
        noise and the error of static ports [1/m]."""
        each = [one.with_any_ports() for one in self.likelihoods]
        precision = np.array([one.precision.sum() for one in each])
        shift = np.array([one.shift.sum() for one in each])
        weight = np.array([one.log_weight for one in each]) + 0.5 * (shift**2 / precision - np.log(precision))
        weight = np.exp(weight - np.logaddexp.reduce(weight))
        mean = float(weight @ (shift / precision))
        variance = float(weight @ (1 / precision + (shift / precision - mean) ** 2))
        return self.reference * mean, self.reference * variance**0.5


def drag_profile(clocks: Sequence[Series], recorded: Recorded) -> DragProfile | None:
    """Drag along the coast of a log that was measured as `recorded`; None if the log does not show it, or shows a push:
    no coast has that, so its sensors are wrong."""
    window = _window(clocks, recorded)
    if window is None:
        return None
    begin, end, lift, push = window
    coast = _binned(recorded.track, push, begin, end, lift)
    found = None if coast is None else _profile(coast, lift)
    if found is None:
        return None
    drag, sd = found.level
    return found if drag > -_MOST_PUSH * sd else None


@dataclass(frozen=True, slots=True, eq=False)
class _Coast:
    """Means over the intervals of a coast; nan without samples. `start` is the clock at its beginning [s], the first
    speed and height are estimates [m/s], [m]. `zeroed` if the accelerometer's zero is from the pad,
    `weighs` if it feels gravity at rest, `fade` is the standard deviation of the thrust left at the start [m/s^2]."""

    start: float
    step: float
    height: Float[Array, "interval"]
    height_variance: Float[Array, "interval"]
    felt: Float[Array, "interval"] | None
    felt_variance: Float[Array, "interval"]
    zeroed: bool
    weighs: bool
    fade: float
    barometric: bool
    first: tuple[float, float, float]
    source: str

    @property
    def middles(self) -> Float[Array, "interval"]:
        return np.asarray(self.start + self.step * (np.arange(self.height.size) + 0.5))

    def until(self, count: int) -> "_Coast":
        """Only the first intervals."""
        return replace(
            self,
            height=self.height[:count],
            height_variance=self.height_variance[:count],
            felt=None if self.felt is None else self.felt[:count],
            felt_variance=self.felt_variance[:count],
        )


def _window(clocks: Sequence[Series], recorded: Recorded) -> tuple[float, float, float, Push | None] | None:
    """Beginning and end of the coast and lift-off on the log's clock [s], and the accelerometer."""
    climb, track, events = recorded.climb, recorded.track, recorded.events
    if climb is None or track is None or climb.time.size < 5:
        return None
    lift = events["liftoff"].time if "liftoff" in events else float(climb.time[0])
    top = events["apogee"].time if "apogee" in events else float(climb.time[-1])
    out = [events[name].time for name in ("ejection",) if name in events]
    end = min([top, *out]) - _END_MARGIN
    push = next(pushes(clocks, lift - 15, end), None)
    if push is not None and (push.vertical or not _felt_thrust(push, lift, end)):
        push = None
    burnout = events.get("burnout")
    moment = burnout.time if burnout is not None else float(climb.time[int(np.argmax(climb.speed))])
    late = min(burnout.sd, 0.5) if burnout is not None else 0.2
    felt = _felt_end(push, lift, end) if push is not None else None
    begin = felt + _BEGIN_MARGIN if felt is not None else moment + _BEGIN_MARGIN + 2 * late
    return (begin, end, lift, push) if end - begin > _MIN_TIME else None


def _felt_thrust(push: Push, lift: float, end: float) -> bool:
    """Whether an accelerometer felt a boost, or began too late to feel it."""
    boost = push.felt[(push.time > lift - 0.2) & (push.time < end)]
    return bool(push.time[0] > lift or (boost.size and np.quantile(boost, 0.98) > _LEAST_THRUST))


def _felt_end(push: Push, lift: float, end: float) -> float | None:
    """When an accelerometer last felt thrust for longer than 0.1 s before the end of the coast; None if never. [s]"""
    inside = (push.time > lift - 0.2) & (push.time < end)
    time, felt = push.time[inside], push.felt[inside]
    if time.size < _MIN_INTERVALS:
        return None
    width = max(3, round(0.1 / median_step(time)) | 1)
    if time.size < width:
        return None
    calm = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(felt, width // 2, mode="edge"), width), axis=-1)
    pushed = np.flatnonzero(calm > _left(felt))
    return float(time[pushed[-1]]) if pushed.size and pushed[-1] + 1 < time.size else None


def _left(felt: Float[Array, "time"]) -> float:
    """Thrust over mass that may be left when a coast begins. [m/s^2]"""
    return max(_THRUST_LEFT * float(np.quantile(felt, 0.99)), _LEAST_LEFT)


def _binned(track: HeightTrack | None, push: Push | None, begin: float, end: float, lift: float) -> _Coast | None:
    """A coast averaged over intervals."""
    if track is None:
        return None
    inside = (track.time >= begin) & (track.time <= end)
    if inside.sum() < _MIN_INTERVALS:
        return None
    step = max(_SHORTEST_INTERVAL, (end - begin) / _MAX_INTERVALS, 1.0001 * median_step(track.time[inside]))
    first = _first(track.time[inside] - begin, track.height[inside])
    if first[0] > _MAX_SPEED:  # begins when it has slowed down
        later = _slows_down(first)
        return _binned(track, push, begin + later, end, lift) if end - begin - later > _MIN_TIME else None
    count = int((end - begin) / step)
    if count < _MIN_INTERVALS:
        return None
    height, variance = _means(track.time, track.height, begin, step, count, detrend=True)
    felt, felt_variance, zeroed = None, np.full(count, np.nan), False
    if push is not None:
        rest = push.felt[(push.time < lift - 0.1) & (push.time > lift - 10)]
        level = float(np.median(rest)) if rest.size >= 3 else GRAVITY
        zeroed = rest.size >= 3 and abs(level - GRAVITY) < _WORST_BIAS
        values = push.felt - (level - GRAVITY if zeroed else 0.0)
        felt, felt_variance = _means(push.time - push.blur, values, begin, step, count)
        speeds = _speeds(felt, height, step)
        if speeds is None:
            felt = None
        else:  # the accelerometer shows the speeds better than the heights do
            shows = np.isfinite(felt) & (speeds > 0.5 * speeds[0])
            drag = float(np.median(-felt[shows] / speeds[shows] ** 2))
            first = (float(speeds[0]), first[1], float(np.clip(drag, *_DRAGS)))
    source = " and ".join(one.source for one in (push if felt is not None else None, track) if one is not None)
    barometric = track.source in BAROMETRIC
    weighs = push is not None and push.weighs
    flown = push.felt[(push.time > lift) & (push.time < end)] if push is not None else np.zeros(1)
    fade = _left(flown) / 2
    return _Coast(begin, step, height, variance, felt, felt_variance, zeroed, weighs, fade, barometric, first, source)


def _speeds(
    felt: Float[Array, "interval"], height: Float[Array, "interval"], step: float
) -> Float[Array, "interval"] | None:
    """Speeds of a coast by its accelerometer, integrated back from the last climb rate of the heights [m/s]; None if
    that climb is not the heights'."""
    known, there = np.isfinite(felt), np.isfinite(height)
    if known.sum() < felt.size / 2 or there.sum() < _MIN_INTERVALS:
        return None
    place = np.arange(felt.size)
    rate = np.interp(place, place[known], felt[known]) - GRAVITY
    last = place[there][-min(10, int(there.sum())) :]
    middle = int(last[last.size // 2])
    gained = np.cumsum(rate) * step
    speeds = float(np.polyfit(step * last, height[last], 1)[0]) + gained - gained[middle]
    first = int(place[there][0])
    climbed = float(height[last[-1]] - height[first])
    consistent = SCALES[0] < climbed / max(step * float(speeds[first : last[-1]].sum()), 1.0) < SCALES[1]
    return np.asarray(speeds) if consistent and speeds[0] > _MIN_SPEED else None


def _first(time: Float[Array, "time"], height: Float[Array, "time"]) -> tuple[float, float, float]:
    """Speed [m/s], height [m] and drag [1/m] at the start of a coast, from a cubic through its heights."""
    cubic = np.polynomial.Polynomial.fit(time, height, 3 if time.size > 12 else 2)
    speed, slows = float(cubic.deriv()(0.0)), -float(cubic.deriv(2)(0.0))
    drag = (slows - GRAVITY) / max(speed, 10.0) ** 2
    return speed, float(cubic(0.0)), float(np.clip(drag, *_DRAGS))


def _slows_down(first: tuple[float, float, float]) -> float:
    """How long a coast takes to slow down to `_MAX_SPEED`. [s]

    Derivation: dv/dt = -g - b v² with constant b and density.
    """
    root = sqrt(GRAVITY / first[2])
    return float(np.arctan(first[0] / root) - np.arctan(_MAX_SPEED / root)) / sqrt(GRAVITY * first[2]) + 0.05


def _means(
    time: Float[Array, "time"],
    values: Float[Array, "time"],
    begin: float,
    step: float,
    count: int,
    detrend: bool = False,
) -> tuple[Float[Array, "interval"], Float[Array, "interval"]]:
    """Means of samples in intervals, and their variances from the scatter of a sample; nan without samples."""
    place = np.floor((time - begin) / step).astype(int)
    inside = (place >= 0) & (place < count)
    if inside.sum() < 4:
        return np.full(count, np.nan), np.full(count, np.nan)
    place, values, time = place[inside], values[inside], time[inside]
    middle = begin + step * (place + 0.5)
    if detrend:  # samples off the middle of their interval are moved along the local slope
        slope = np.gradient(np.interp(np.arange(count), place, values), step)
        values = values - slope[place] * (time - middle)
    number = np.bincount(place, minlength=count)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(place, values, minlength=count) / number
        own = mad_sd(np.diff(values, 2)) / sqrt(6) if values.size > 6 else 0.1
        return mean, max(own, 1e-3) ** 2 / number


@dataclass(frozen=True, slots=True, eq=False)
class _LinearGaussian:
    """Residuals of the observations, and their derivatives with respect to relative drag and to the path's start."""

    left: Float[Array, "row"]
    by_drag: Float[Array, "row interval"]
    by_start: Float[Array, "row two"]
    speed: Float[Array, "interval"]
    height: Float[Array, "interval"]
    drag: Float[Array, "interval"]
    relative: Float[Array, "interval"]


def _linearized(coast: _Coast, reference: float, relative: Array, start: Array) -> _LinearGaussian:
    """The path with a relative drag from a start (height, speed), by the midpoint rule, and its derivatives.

    Derivation: the variation of the equations of motion, with the change of density neglected.
    """
    step, count = coast.step, relative.size
    heights, speeds = np.empty(count + 1), np.empty(count + 1)
    heights[0], speeds[0] = start
    height, speed = float(start[0]), float(start[1])
    for place, factor in enumerate((reference * relative).tolist()):
        rate = -GRAVITY - factor * exp(-height / SCALE_HEIGHT) * speed * abs(speed)
        middle = speed + rate * step / 2
        rate = -GRAVITY - factor * exp(-(height + speed * step / 2) / SCALE_HEIGHT) * middle * abs(middle)
        height += step * middle
        speed = min(max(speed + rate * step, -200.0), 2000.0)
        heights[place + 1], speeds[place + 1] = height, speed
    middle, level = (speeds[1:] + speeds[:-1]) / 2, (heights[1:] + heights[:-1]) / 2
    unit = reference * np.exp(-level / SCALE_HEIGHT) * middle * np.abs(middle)
    drag = unit * relative
    decay = -2 * np.abs(drag) / np.maximum(np.abs(middle), 1.0)
    growth = np.concatenate(([0.0], np.cumsum(decay * step)))
    kernel = np.exp(growth[:, None] - growth[1:])
    by_speed = np.tril(kernel * (-unit * step), -1)  # speed at each edge by the drag of each interval before it
    speed_drag = np.concatenate([by_speed, np.exp(growth)[:, None]], axis=-1)
    speed_middle = (speed_drag[1:] + speed_drag[:-1]) / 2
    height_edge = np.concatenate([np.zeros((1, count + 1)), np.cumsum(speed_middle * step, axis=0)])
    height_middle = (height_edge[1:] + height_edge[:-1]) / 2
    by_height = [height_middle[:, :count], np.stack([np.ones(count), height_middle[:, count]], axis=-1)]
    rows, left = [by_height], [coast.height - level]
    if coast.felt is not None:
        slows = decay[:, None] * speed_middle
        felt = -np.diag(unit) + slows[:, :count]
        rows.append([felt, np.stack([np.zeros(count), slows[:, count]], axis=-1)])
        left.append(coast.felt + drag)
    by_drag, by_start = (np.concatenate(part) for part in zip(*rows, strict=True))
    return _LinearGaussian(np.concatenate(left), by_drag, by_start, middle, level, drag, relative)


def _profile(coast: _Coast, lift: float) -> DragProfile | None:
    """The drag profile of a binned coast; None if no path fits."""
    reference, relative = coast.first[2], np.ones(coast.height.size)
    outlying: Array | float = 0.0
    start = first = np.array([coast.first[1], coast.first[0]])
    for _ in range(_ROUNDS):
        linear = _linearized(coast, reference, relative, start)
        every = _Covariances(coast, linear, np.isfinite(linear.left), outlying)
        outlying = every.outlying(relative)
        every = _Covariances(coast, linear, np.isfinite(linear.left), outlying)
        before = relative
        relative, start = every.smoothed(relative, start, first)
        level = float(np.median(relative))
        if not 0.05 < level < 20:
            return None
        reference, relative = reference * level, relative / level
        if np.abs(relative - before / level).max() < _TOLERANCE * 10 and abs(level - 1) < _TOLERANCE:
            break
    linear = _linearized(coast, reference, relative, start)
    fast = linear.speed > max(_MIN_SPEED, _MIN_SPEED_FRACTION * float(linear.speed[0]))
    slow = int(np.argmin(fast)) if not fast.all() else fast.size
    if slow < _MIN_INTERVALS or linear.speed[0] < _MIN_SPEED_RATIO * linear.speed[slow - 1]:
        return None
    if slow < fast.size:
        coast = coast.until(slow)
        relative = relative[:slow]
        linear = _linearized(coast, reference, relative, start)
    seen = np.isfinite(linear.left)
    outlying = _Covariances(coast, linear, seen, 0.0).outlying(relative)
    every = _Covariances(coast, linear, seen, outlying)
    found = [every.likelihood(relative, *setting) for setting in every.settings]
    log_evidence = np.array([log_evidence for _, log_evidence in found])
    weight = np.exp(log_evidence - np.logaddexp.reduce(log_evidence))
    kept = [int(row) for row in np.argsort(-weight)[:_MOST_KEPT] if weight[row] > _MIN_WEIGHT]
    highest = max(found[row][0].log_weight for row in kept)
    likelihoods = tuple(replace(found[row][0], log_weight=found[row][0].log_weight - highest) for row in kept)
    time = coast.middles - lift
    return DragProfile(time, coast.step, linear.speed, reference, likelihoods, coast.source)


class _Covariances:
    """Covariances of the observations of a coast about its path, by their causes."""

    def __init__(self, coast: _Coast, linear: _LinearGaussian, seen: Flags, outlying: Array | float) -> None:
        self._coast, self._linear, self._seen = coast, linear, seen
        count, both = coast.height.size, coast.felt is not None
        self._count = count
        time, speed = coast.middles, np.maximum(np.abs(linear.speed), 1.0)
        distance = np.abs(time[:, None] - time)
        self._ram_shape = np.exp(-distance / _RAM_TIME)
        self._fast_shape = np.exp(-distance / _FAST_TIME)
        self._any_drag = _ANY_LEVEL_SD**2 + _ANY_CHANGE_SD**2 * np.exp(-distance / _ANY_CHANGE_TIME)
        self._drift = (_DRIFT_SD if coast.weighs else _DERIVED_DRIFT_SD) ** 2 * np.exp(-distance / _DRIFT_TIME)
        self._dynamic = linear.speed**2 / (2 * GRAVITY)
        across = np.exp(-np.cumsum(np.abs(linear.drag) / speed) * coast.step)  # drag slows it as the whole speed
        tilt = _TILT**2 * np.minimum((across * speed[0] / speed) ** 2, _MOST_SLOWED)
        logs = np.log(speed)
        slow = _SLOW_SD**2 * np.exp(-0.5 * ((logs[:, None] - logs) / _SLOW_LENGTH) ** 2)
        slow -= slow.mean(axis=0)  # the level of a flight is not part of its change
        slow -= slow.mean(axis=1)[:, None]
        slow += _TILT_SD**2 * np.outer(tilt, tilt)
        self._ramps = [ramp_matrix(count, lasts / coast.step) for lasts in SWITCH_TIMES]
        near = np.exp(-distance / _OWN_TIME)
        own = near @ linear.relative / near.sum(axis=-1)
        self._slow, self._own = slow, np.outer(own, own)
        own = [coast.height_variance, coast.felt_variance] if both else [coast.height_variance]
        self.white = np.concatenate(own) + outlying
        columns = [linear.by_start * [_OFFSET_SD, _SPEED_SD]]
        below = np.zeros((count, 3))
        below[:, 0] = _SCALE_SD * (linear.height - linear.height[0])
        if coast.barometric:
            below[:, 1], below[:, 2] = _OWN_PORTS * _PORTS_SD * self._dynamic, -_LAG_SD * linear.speed
        columns.append(np.concatenate([below, np.zeros((count * both, 3))]))
        if both:
            bias = _BIAS_SD if coast.zeroed else _UNLEVELLED_BIAS_SD
            fades = [coast.fade * np.exp(-(time - time[0]) / lasts) for lasts in _FADE_TIMES]
            at_rest = GRAVITY if coast.zeroed and coast.weighs else 0.0  # where its error of gain is zero
            slanted = -linear.drag / 2 if coast.weighs else GRAVITY / 2
            shapes = (np.full(count, bias), -_GAIN_SD * (linear.drag + at_rest), *fades, slanted * tilt)
            push = np.stack(shapes, axis=-1)
            columns.append(np.concatenate([np.zeros_like(push), push]))
        self._columns = np.concatenate(columns, axis=-1)
        self._ports = np.zeros(self.white.size)
        if coast.barometric:
            self._ports[:count] = _PORTS_SD * self._dynamic

    @property
    def settings(self) -> list[tuple[float, float, tuple[float, float], float]]:
        """The settings of the noise that are tried: fast change of b, accelerometer, pressure, pitching."""
        if self._coast.felt is None:
            return list(product(_FAST_SDS, _PUSH_SDS[:1], (_QUIET_RAM, *_RAM_SDS), _PITCH_SDS[:1]))
        return list(product(_FAST_SDS, _PUSH_SDS, _RAM_SDS, _PITCH_SDS))

    def _noise(
        self, push: float, ram: tuple[float, float], pitch: float, shared: bool = True
    ) -> Float[Array, "row row"]:
        """Covariance of the errors of the observations, with those of the rocket's ports or without."""
        count, rows = self._count, self.white.size
        noise = self._columns @ self._columns.T
        if shared:
            noise += np.outer(self._ports, self._ports)
        own = np.hypot(ram[0], ram[1] * self._dynamic)
        noise[:count, :count] += self._ram_shape * np.outer(own, own)
        if rows > count:
            time = self._coast.middles
            own = np.hypot(push, pitch * np.exp(-(time - time[0]) / _PITCH_TIME))
            noise[count:, count:] += np.outer(own, own) * self._fast_shape + self._drift
        noise[np.diag_indices(rows)] += np.where(self._seen, self.white, 1.0)
        return noise

    def _prior(self, fast: float) -> Float[Array, "interval interval"]:
        return np.asarray((self._slow + fast**2 * self._fast_shape) * self._own)

    def _observed(self, relative: Array) -> tuple[Array, Array]:
        """Observations less those of a path without drag, to first order, and their derivatives; seen rows only."""
        by_drag = self._linear.by_drag[self._seen]
        return self._linear.left[self._seen] + by_drag @ relative, by_drag

    def smoothed(self, relative: Array, start: Array, expected: Array) -> tuple[Array, Array]:
        """The most probable relative drag, if it may vary strongly, and start of the path, whose prior is around an
        expected one; a large step is shortened."""
        wide = self._any_drag
        observed, by_drag = self._observed(relative)
        by_start, scale = self._linear.by_start[self._seen], np.array([_OFFSET_SD, _SPEED_SD])
        observed = observed + by_start @ (start - expected)
        noise = self._noise(_PUSH_SDS[1], _RAM_SDS[1], _PITCH_SDS[1])[np.ix_(self._seen, self._seen)]
        gain = np.linalg.solve(noise + by_drag @ wide @ by_drag.T, observed - by_drag.sum(axis=-1))
        by_drag_step = 1 + wide @ (by_drag.T @ gain) - relative
        start_step = expected + scale**2 * (by_start.T @ gain) - start
        step = min(1.0, _LONGEST_STEP / max(np.abs(by_drag_step).max(), np.abs(start_step).max() / _SPEED_SD, 1e-9))
        return np.maximum(relative + step * by_drag_step, _LEAST_RELATIVE), start + step * start_step

    def outlying(self, relative: Array) -> Float[Array, "row"]:
        """Variance that an interval needs in addition where its residual, left out, is far out."""
        observed, by_drag = self._observed(relative)
        found, rows = np.zeros(self.white.size), np.flatnonzero(self._seen)
        noise = self._noise(_PUSH_SDS[1], _RAM_SDS[1], _PITCH_SDS[1])[np.ix_(self._seen, self._seen)]
        whole = noise + by_drag @ (self._any_drag + self._prior(_FAST_SDS[1])) @ by_drag.T
        for _ in range(_OUTLIER_ROUNDS):  # leave-one-out residuals (Rasmussen and Williams, 2006, section 5.4.2)
            inverse = np.linalg.inv(whole + np.diag(found[rows]))
            precision = np.diagonal(inverse)
            left = inverse @ (observed - by_drag.sum(axis=-1)) / np.sqrt(precision)
            far = np.abs(left) > _OUTLIER
            if not far.any():
                break
            found[rows[far]] += left[far] ** 2 / precision[far]
        return found

    def likelihood(
        self, relative: Array, fast: float, push: float, ram: tuple[float, float], pitch: float
    ) -> tuple[DragLikelihood, float]:
        """The likelihood of relative drag for one setting of the noise, and the log evidence of that setting, which
        allows for a step and any error of the ports. [nat]"""
        observed, by_drag = self._observed(relative)
        prior = self._prior(fast)
        errors = self._noise(push, ram, pitch, shared=False)[np.ix_(self._seen, self._seen)]
        root = np.linalg.cholesky(errors + by_drag @ prior @ by_drag.T)
        from scipy.linalg.lapack import dtrtrs  # takes 0.18 s to import

        solved, _ = dtrtrs(root, np.column_stack([by_drag, self._ports[self._seen], observed]), lower=1)
        slope, port, rest = solved[:, :-2], solved[:, -2], solved[:, -1]
        precision, shift = slope.T @ slope, slope.T @ rest
        ports = PortError(slope.T @ port, float(port @ port), float(port @ rest))
        log_none = -0.5 * float(rest @ rest) - float(np.log(np.diagonal(root)).sum())
        found = DragLikelihood(log_none, precision, shift, prior, ports)
        alone = found.with_any_ports()
        return found, alone.log_weight + _with_any_step(alone.precision, alone.shift, self._ramps)


def step_sums(
    precision: Float[Array, "interval interval"], shift: Float[Array, "interval"]
) -> tuple[Float[Array, "edge edge"], Float[Array, "edge edge"], Float[Array, "edge edge"]]:
    """Of a likelihood, the products with every step from one edge to a later one: of the precision with the step on
    both sides, and with the step and a constant; and of the shift with the step. [1]"""
    whole = np.zeros((shift.size + 1, shift.size + 1))
    whole[1:, 1:] = precision.cumsum(axis=0).cumsum(axis=1)
    diagonal = np.diagonal(whole)
    both = diagonal[None, :] + diagonal[:, None] - 2 * whole
    constant, pushed = whole[:, -1], np.concatenate(([0.0], np.cumsum(shift)))
    return both, constant[None, :] - constant[:, None], pushed[None, :] - pushed[:, None]


def ramp_matrix(count: int, width: float) -> Float[Array, "interval interval"]:
    """The matrix that averages values of intervals over a width, in intervals. [1]"""
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    weight = np.clip((max(width, 1.0) + 1) / 2 - distance, 0.0, 1.0)
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))


def _with_any_step(
    precision: Float[Array, "interval interval"], shift: Float[Array, "interval"], ramps: Sequence[Array]
) -> float:
    """Log likelihood, up to that of no drag at all, of a constant drag that may have a step anywhere."""
    sums = [step_sums(ramp.T @ precision @ ramp, ramp.T @ shift) for ramp in ramps]
    both, constant, pushed = (np.stack(parts) for parts in zip(*sums, strict=True))
    level, amplitude = _VAGUE_SD**-2, _STEP_SD**-2
    first, second, joint = float(precision.sum()) + level, both + amplitude, constant
    start, push = float(shift.sum()) + level, pushed
    determinant = np.maximum(first * second - joint**2, 1e-300)
    squares = (start**2 * second - 2 * start * push * joint + push**2 * first) / determinant
    log = 0.5 * (squares - np.log(determinant / (level * amplitude)) - level)
    steps = log[:, *np.triu_indices(log.shape[-1], 1)]
    alone = 0.5 * (start**2 / first - np.log(first / level) - level)
    some = float(np.logaddexp.reduce(steps, axis=None)) - np.log(steps.size)
    return float(np.logaddexp(np.log1p(-_STEP_PROBABILITY) + alone, np.log(_STEP_PROBABILITY) + some))

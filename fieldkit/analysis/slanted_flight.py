"""A tilted climb from an accelerometer along the axis: the tilt, and the vertical part of the acceleration.

A rocket that leaves its rail at an angle from the vertical turns further as gravity bends its path (a gravity turn):

    dv/dt = f - g cos(angle),    d(angle)/dt = g sin(angle) / v,    dh/dt = v cos(angle),

with f the specific force along the axis. The recorded f gives one climb for each angle at the rail, and the heights
select the angle that was flown. Shocks or air brakes may disturb the pressure for seconds during the climb: the best
angle is the one with which most samples agree, and it identifies those that do not.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.accelerometer_check import MAX_DELAY, MAX_LEAD
from fieldkit.analysis.channels import Heights, Push
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event
from fieldkit.integrals import running_integral
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

_ANGLES = np.radians(np.arange(0.0, 34.0, 3.0))
"""Angles at the rail to try. [rad]"""
_ANGLE_SD = np.radians(12.0)
"""Standard deviation of the angle at the rail, including the effect of wind just after the rail. [rad]"""
_STEP, _SHIFT = 0.02, 0.04
"""Steps of the integration and of the clock shifts to try. [s]"""
_RAIL_LENGTH, _MIN_TURNING_SPEED = 2.0, 5.0
"""Length of the rail [m], and the speed after it below which a rocket does not turn [m/s]."""
_COMPARED_PART = 0.9
"""Fraction of the time to apogee that is compared; the charge may have fired after it. [1]"""
_SCALE_SD, _ZERO_SD, _RAM_SD = 0.03, 0.3, 0.05
"""Standard deviations of the accelerometer's scale [1] and zero [m/s^2], and of the airframe's pressure error as a
fraction of dynamic pressure [1]."""
_AT_REST = (0.85, 1.08)
"""Range of an accelerometer's reading on the pad, along an axis tilted by up to 30 degrees. [g]"""
_WRONG_SCALE_SD, _WRONG_CLOCK = 0.3, 1.5
"""Standard deviation of a scale that no calibration explains [1], and the largest error of a wrong clock [s]."""
_RELATIVE_HEIGHT_SD = 0.015
"""Relative standard deviation of heights, for winds that bend the path in another way. [1]"""
_STUDENT_DOF, _ROUNDS = 3.0, 8
"""Degrees of freedom of the height errors, and number of reweighting iterations. [1]"""
_MIN_AGREEING, _MAX_SDS = 0.55, 3.0
"""Fraction of samples that must agree with the climb of a trusted accelerometer [1], within this many of their standard
deviations [1]."""
_CORRELATION_TIME = 0.5
"""Correlation time of the pressure errors in an airframe. [s]"""
_MIN_SAMPLES = 12


@dataclass(frozen=True, slots=True, eq=False)
class SlantedFlight:
    """Angle at the rail [rad], vertical part of the acceleration, and the resulting climb: times [s] and heights above
    the pad [m], with the standard deviation of a height."""

    angle: float
    upward: Push
    time: Float[Array, "step"]
    height: Float[Array, "step"]
    sd: Float[Array, "step"]

    def agrees(self, track: Heights, pad: float) -> Flags:
        """Which height samples, above `pad` [m], are close to the climb; the others are outliers."""
        away = np.abs(track.height - pad - np.interp(track.time, self.time, self.height))
        near = away < _MAX_SDS * np.hypot(np.interp(track.time, self.time, self.sd), track.noise)
        return np.asarray(near | (track.time < self.time[0]) | (track.time > self.time[-1]))


def slanted_flight(track: Heights, push: Push, seen: Outline, lift: Event) -> SlantedFlight | None:
    """The tilted climb from an accelerometer with which most of the heights agree; None if there is none."""
    net = levelled(push, lift.time)
    end = lift.time + _COMPARED_PART * (seen.top - lift.time)
    inside = (track.time > lift.time) & (track.time < end)
    if net is None or push.vertical or push.time[0] > lift.time or push.time[-1] < end or inside.sum() < _MIN_SAMPLES:
        return None
    time = np.arange(lift.time - MAX_DELAY, seen.top, _STEP)
    total = running_integral(net, push.time)
    felt = np.gradient(np.interp(time, push.time, total), _STEP)
    cosine, climbs, by_scale, by_zero = _paths(felt, time - lift.time)
    when, height = track.time[inside], track.height[inside] - seen.pad
    independent_fraction = min(1.0, (end - lift.time) / _CORRELATION_TIME / when.size)

    def tried(place: int, shift: float, scale_sd: float = _SCALE_SD) -> tuple[float, int, float, Array]:
        columns = [by_scale[:, place], by_zero[:, place], _ram(climbs[:, place])]
        rows = np.stack([np.interp(when + shift, time, column) for column in (climbs[:, place], *columns)])
        cost, values = _fit(rows[0], rows[1:], height, track.noise, independent_fraction, scale_sd)
        return cost + float(_ANGLES[place] / _ANGLE_SD) ** 2 / 2, place, shift, values

    near = np.arange(-MAX_LEAD, MAX_DELAY + _SHIFT, _SHIFT).tolist()
    far = np.arange(-_WRONG_CLOCK, _WRONG_CLOCK, 2 * _SHIFT).tolist()
    cost, place, shift, values = min((tried(p, one) for one in near for p in range(_ANGLES.size)), key=lambda t: t[0])
    weighed = push.weighs and _is_at_rest(push, lift.time)
    rival = _SCALE_SD if weighed else _WRONG_SCALE_SD
    wrong = min(tried(0, one, rival)[0] for one in far if not weighed or one not in near)
    if cost > wrong + np.log(rival / _SCALE_SD) or abs(values[0]) > _MAX_SDS * _SCALE_SD:
        return None
    path = climbs[:, place] + values[0] * by_scale[:, place] + values[1] * by_zero[:, place]
    along = (1 + values[0]) * (net + GRAVITY * np.cos(_ANGLES[place])) + values[1]
    upward = along * np.interp(push.time, time, cosine[:, place])
    upward = np.where(push.time < lift.time + shift, GRAVITY, upward)
    sd = np.hypot(track.noise, _RELATIVE_HEIGHT_SD * path) + _RAM_SD * _ram(climbs[:, place])
    found = SlantedFlight(
        float(_ANGLES[place]),
        replace(push, time=push.time - shift, felt=upward, vertical=True),
        time[time >= lift.time] - shift,
        path[time >= lift.time],
        sd[time >= lift.time],
    )
    agree = found.agrees(replace(track, time=when, height=track.height[inside]), seen.pad)
    return found if agree.mean() > _MIN_AGREEING else None


def _is_at_rest(push: Push, lift: float) -> bool:
    """Whether an accelerometer reads about one g on the pad, which confirms its scale."""
    rest = push.felt[push.time < lift - 0.1]
    return bool(rest.size > 2 and _AT_REST[0] < float(np.median(rest)) / GRAVITY < _AT_REST[1])


def _ram(climb: Float[Array, "step"]) -> Float[Array, "step"]:
    """Height error if the airframe's pressure error equals the full dynamic pressure. [m]"""
    return np.asarray(np.gradient(climb, _STEP) ** 2 / (2 * GRAVITY))


def _paths(
    net: Float[Array, "step"], since: Float[Array, "step"]
) -> tuple[
    Float[Array, "step angle"], Float[Array, "step angle"], Float[Array, "step angle"], Float[Array, "step angle"]
]:
    """Cosine and height along the path for each angle, and the height errors from an error in scale and in zero.

    `net` is the acceleration beyond its value at rest on the rail, which is gravity's component along the rail.
    """
    angle: Array = _ANGLES.copy()
    speed: Array = np.zeros(_ANGLES.size)
    at_rest = GRAVITY * np.cos(_ANGLES)
    height: Array = np.zeros(_ANGLES.size)
    rows = []
    by_scale, by_zero = np.zeros((2, _ANGLES.size)), np.zeros((2, _ANGLES.size))
    for beyond, after in zip(net.tolist(), since.tolist(), strict=True):
        cosine, force = np.cos(angle), beyond + at_rest
        if after > 0:
            speed = np.maximum(speed + (force - GRAVITY * cosine) * _STEP, 0.0)
            free = (height > _RAIL_LENGTH) & (speed > _MIN_TURNING_SPEED)
            turn = GRAVITY * np.sin(angle) / np.maximum(speed, _MIN_TURNING_SPEED)
            angle = np.where(free, angle + turn * _STEP, angle)
            height = height + speed * cosine * _STEP
            by_scale = by_scale + np.stack([by_scale[1], force * cosine]) * _STEP
            by_zero = by_zero + np.stack([by_zero[1], cosine]) * _STEP
        rows.append((cosine, height, by_scale[0], by_zero[0]))
    cosines, heights, scales, zeros = (np.array(column) for column in zip(*rows, strict=True))
    return cosines, heights, scales, zeros


def _fit(
    climb: Float[Array, "sample"],
    columns: Float[Array, "column sample"],
    height: Float[Array, "sample"],
    noise: float,
    independent_fraction: float,
    scale_sd: float,
) -> tuple[float, Float[Array, "column"]]:
    """Robust misfit of a climb to heights, and the errors of scale, zero and static pressure.

    Only the fraction `independent_fraction` of the samples counts, because neighboring samples have correlated errors.
    """
    spread = np.hypot(noise, _RELATIVE_HEIGHT_SD * np.maximum(climb, 0.0)) + 0.3
    prior = np.array([scale_sd, _ZERO_SD, _RAM_SD])
    rows, target = (columns / spread).T, (height - climb) / spread
    weight: Array = np.ones(height.size)
    values: Array = np.zeros(3)
    for _ in range(_ROUNDS):
        counted = independent_fraction * (rows * weight[:, None]).T
        values = np.asarray(np.linalg.solve(counted @ rows + np.diag(prior**-2), counted @ target))
        residual = np.asarray(target - rows @ values)
        weight = np.asarray((_STUDENT_DOF + 1) / (_STUDENT_DOF + residual**2))
    cost = (
        independent_fraction * (_STUDENT_DOF + 1) / 2 * np.log1p(residual**2 / _STUDENT_DOF).sum()
        + ((values / prior) ** 2).sum() / 2
    )
    return float(cost), np.asarray(values)

"""Thrust and drag as they were measured: what is left of the acceleration when gravity is taken out."""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, Heights, Push
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Event, Figure, Forces, MeasuredClimb
from fieldkit.analysis.robust_statistics import median_step, running_median
from fieldkit.analysis.satellites import SOURCE as SATELLITES
from fieldkit.analysis.satellites import sighted_speed
from fieldkit.physics.standard_atmosphere import GRAVITY, standard_density
from fieldkit.shapes import Array, Float

_MIN_DRAG_SPEED = 15.0
"""Below this speed drag drowns in the errors of the acceleration. [m/s]"""
_MIN_DENSITY = 1e-4
"""In thinner air, from some 60 km up, there is no drag to tell. [kg/m^3]"""
_FUSED_SPEED_ERROR, _DERIVED_SPEED_ERROR = 0.02, 0.015
"""Least error of a top speed, to it: with an accelerometer, from heights. [1]"""
_TRANSONIC_PRESSURE_ERROR = 0.06
"""The same as `STATIC_SD` from about Mach 0.8 on, where shocks disturb it. [1]"""
_MAX_SPEED_ERROR = 0.25
"""A top speed by heights alone is off by no more, to it, for all that; it was at most by 0.29 there. [1]"""
_TRANSONIC_SPEED = 270.0
"""Where that begins. [m/s]"""
_BRAKING_TIME = 1.5
"""How long after top speed it shows how hard the rocket brakes. [s]"""
_BURN_TIME_ERROR, _LATEST_DISTURBED = 0.02, 0.1
"""Error of a burn time by heights alone, to it. [1]"""
_PEAK, _PEAK_SPREAD, _SMOOTHED_PEAK_SPREAD = 1.7, 0.4, 0.3
"""Peak to mean acceleration of a boost, the spread of its logarithm, and that of a peak of smoothed heights: over the
thrust curves of the catalogue the ratio is 2.2 in the middle of motors below 40 N·s and 1.35 of the others. [1]"""
_MIN_FELT_FRACTION = 0.9
"""Of a climb, that an accelerometer must have felt to be believed rather than the heights. [1]"""
_WINDOW = 0.05
"""Of the peak acceleration; a log that is too thin for it has a peak between its mean of three samples and one. [s]"""
_MOSTLY = 0.5
"""A speed rests on satellites too, where they have a greater part in it. [1]"""
_MAX_LATE_START = 0.05
"""How long after lift-off an accelerometer may begin and still have felt all. [s]"""
_SCALE = 0.02
"""Of an accelerometer's error, to the acceleration. [1]"""


def climb_of(ascent: Ascent, begin: float, burnout: float, end: float, source: str) -> MeasuredClimb:
    """The ascent between two times, with its standard deviations."""
    inside = (ascent.time >= begin) & (ascent.time <= end)

    def cut(values: Array) -> Array:
        return np.asarray(values[..., inside])

    return MeasuredClimb(
        cut(ascent.time),
        cut(ascent.height),
        cut(ascent.heights).std(axis=0),
        cut(ascent.speed),
        cut(ascent.speeds).std(axis=0),
        cut(ascent.acceleration),
        cut(ascent.accelerations).std(axis=0),
        cut(ascent.time) <= burnout,
        source,
    )


def forces(climb: MeasuredClimb, push: Push | None, track: Heights, pad_elevation: float, free: float) -> Forces | None:
    """Push per mass and, in the coast, Cd·A per mass, from lift-off to what was ejected or to apogee.

    An axial accelerometer gives the push as it is; else it is the smoothed vertical acceleration plus gravity, which
    holds for a rocket that climbs straight.
    """
    flown = climb.time <= free
    if flown.sum() < 5:
        return None
    window = None
    if push is not None and not push.vertical:
        felt_there = flown & (climb.time >= push.time[0]) & (climb.time <= push.time[-1])
        if felt_there.sum() >= _MIN_FELT_FRACTION * flown.sum():
            flown, window = felt_there, 2 * max(0.05, 1.5 * float(np.median(np.diff(push.time))))
    time = climb.time[flown]
    if push is not None and window:
        total = np.concatenate(([0.0], np.cumsum(np.diff(push.time) * (push.felt[1:] + push.felt[:-1]) / 2)))
        after, before = (np.interp(time + half, push.time, total) for half in (window / 2, -window / 2))
        felt = (after - before) / window
        felt_sd, source = np.hypot(0.3, _SCALE * np.abs(felt)), push.source
        if push.full is not None:
            felt_sd = np.hypot(felt_sd, (np.interp(time, push.time, push.full) > 0) * max(push.missed, GRAVITY))
    else:
        felt, felt_sd, source = climb.acceleration[flown] + GRAVITY, climb.acceleration_sd[flown], climb.source
    speed, speed_sd, burning = climb.speed[flown], climb.speed_sd[flown], climb.burning[flown]
    density = standard_density(climb.height[flown] + pad_elevation)
    shows = ~burning & (speed > _MIN_DRAG_SPEED) & (density > _MIN_DENSITY)
    dynamic = np.where(shows, 0.5 * density * speed**2, np.nan)
    area = -felt / dynamic
    area_sd = np.hypot(felt_sd / dynamic, 2 * area * speed_sd / speed)
    return Forces(
        time - climb.time[0],
        climb.height[flown],
        speed,
        speed_sd,
        felt,
        felt_sd,
        burning,
        area,
        area_sd,
        window,
        source,
    )


def peak_push(push: Push | None, ascent: Ascent, begin: float, burnout: float, mean: Figure) -> Figure | None:
    """Strongest acceleration from lift-off to top speed, net of gravity, over a twentieth of a second.

    `mean` is the mean acceleration of the boost, with its source.
    """
    floor = 0.0
    if push is not None and not push.vertical:
        inside = (push.time >= begin - 0.05) & (push.time <= burnout + 0.05)
        level = levelled(push, begin)
        hidden = push.full is not None and bool(push.full[inside].any())
        if inside.sum() >= 8 and level is not None and not hidden:
            return _felt_peak(push.time[inside], level[inside], begin, push.source)
        if hidden and level is not None and push.full is not None:
            floor = float(level[inside & push.full].min()) - push.missed
    inside = (ascent.time >= begin) & (ascent.time <= burnout)
    if not inside.any():
        return None
    peak = _smoothed_peak(ascent.acceleration[inside], ascent.accelerations[:, inside], mean)
    return _above(peak, floor) if peak and floor > 0 else peak


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


def _felt_peak(time: Float[Array, "time"], net: Float[Array, "time"], begin: float, source: str) -> Figure | None:
    """The peak of what an accelerometer felt in the boost; None if it may have come before the first sample."""
    width = max(3, round(_WINDOW / median_step(time)))
    smooth = running_median(net, width | 1)
    value = float(smooth.max())
    if time[0] > begin + _MAX_LATE_START and smooth[:2].max() == smooth.max():
        return None
    coarse = 0.0
    if 3 * median_step(time) > _WINDOW:
        coarse = (float(net.max()) - value) / 2
    if median_step(time) > 1.5 * _WINDOW:  # between samples that differ there may be more than at either
        coarse = max(coarse, float(np.abs(np.diff(net)).max()) / 4)
    sd = np.sqrt((_SCALE * value) ** 2 + 0.5**2 + coarse**2)
    return Figure(value, float(sd), source) if value > 2 * sd else None


def _smoothed_peak(acceleration: Float[Array, "knot"], draws: Float[Array, "draw knot"], mean: Figure) -> Figure | None:
    """The peak by heights alone: what the curve has of it, and what motors have for such a mean, by their precisions.

    A curve is too smooth for a short peak, and pressure that is disturbed at speed makes peaks that no motor has:
    where the two disagree by more than twice their spread, the mean alone tells.
    """
    place = int(np.argmax(acceleration))
    value, usual = float(acceleration[place]), _PEAK * mean.value
    spread = float(np.hypot(mean.sd / mean.value, _PEAK_SPREAD))
    if value <= 0:
        return Figure(usual, spread * usual, mean.source)
    sharp = float(np.hypot(draws[:, place].std() / value, _SMOOTHED_PEAK_SPREAD))
    weight = sharp**-2 if abs(np.log(value / usual)) < 2 * np.hypot(sharp, spread) else 0.0
    sd = (weight + spread**-2) ** -0.5
    peak = float(np.exp((weight * np.log(value) + spread**-2 * np.log(usual)) * sd**2))
    return Figure(peak, float(sd * peak), mean.source)


def boost_event(
    ascent: Ascent, push: Push | None, begin: float, apogee: float, source: str
) -> tuple[Event, Figure] | None:
    """When the rocket was fastest and how fast, by the curve, with the spread of its draws.

    Heights that are off by a part k of v²/2g make a speed v that brakes with a look as if it were off by k·v·a/g; and
    where it is not known to the moment when it was fastest, neither is how much it had braked by then.
    """
    inside = (ascent.time >= begin) & (ascent.time <= apogee)
    time = ascent.time[inside]
    if time.size < 5:
        return None
    place = int(np.argmax(ascent.speed[inside]))
    value = float(ascent.speed[inside][place])
    moments = time[np.argmax(ascent.speeds[:, inside], axis=1)]
    late = float(1.4826 * np.median(np.abs(moments - time[place])))
    spread = float(ascent.speeds[:, inside][:, place].std())
    if ascent.fused and push:
        late, spread = (
            float(np.hypot(late, max(0.02, median_step(push.time) / 2))),
            np.hypot(spread, _FUSED_SPEED_ERROR * value),
        )
    else:
        pressed, disturbed = CHANNEL_TITLES["gps_altitude_msl"] not in source, value > _TRANSONIC_SPEED
        share = _LATEST_DISTURBED if pressed and disturbed else _BURN_TIME_ERROR
        late = float(np.linalg.norm([late, 0.03 + share * (time[place] - begin), ascent.burnout_sd]))
        later = float(np.interp(time[place] + _BRAKING_TIME, ascent.time, ascent.speed))
        brakes = max(GRAVITY, (value - later) / _BRAKING_TIME)
        static = (
            pressed
            * min(
                (_TRANSONIC_PRESSURE_ERROR if disturbed else STATIC_SD) * brakes / GRAVITY,
                _MAX_SPEED_ERROR,
            )
            * value
        )
        off, static, weight = sighted_speed(ascent.sighted, ascent, float(time[place]), float(static))
        value, source = value + off, source + (f" and {SATELLITES}" if weight > _MOSTLY else "")
        spread = float(np.linalg.norm([spread, _DERIVED_SPEED_ERROR * value, static, brakes * late]))
    return Event(float(time[place]), late, source), Figure(value, float(spread), source)

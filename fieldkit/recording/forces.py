"""Thrust and drag as they were measured: what is left of the acceleration when gravity is taken out."""

import numpy as np

from fieldkit.recording.ascent import Ascent
from fieldkit.recording.channels import Heights, Push
from fieldkit.recording.numbers import median_step, running_median
from fieldkit.recording.records import Climb, Event, Figure, Forces
from fieldkit.shapes import Array
from fieldkit.standard_air import GRAVITY, standard_density

_SLOWEST = 15.0
"""Below this speed drag drowns in the errors of the acceleration. [m/s]"""
_THINNEST = 1e-4
"""In thinner air, from some 60 km up, there is no drag to tell. [kg/m^3]"""
_FUSED, _DERIVED, _DISTURBED = 0.02, 0.015, 0.03
"""Error of a top speed, to it: with an accelerometer, from heights, from heights near the speed of sound. [1]"""
_TRANSONIC = 270.0
"""From about Mach 0.8 on, shocks disturb the pressure in the airframe. [m/s]"""
_MOST = 0.9
"""Of a climb, that an accelerometer must have felt to be believed rather than the heights. [1]"""
_WINDOW = 0.05
"""Of the peak acceleration; a log that is too thin for it has a peak between its mean of three samples and one. [s]"""
_LATE = 0.05
"""How long after lift-off an accelerometer may begin and still have felt all. [s]"""
_SCALE = 0.02
"""Of an accelerometer's error, to the acceleration. [1]"""


def climb_of(ascent: Ascent, begin: float, burnout: float, end: float, source: str) -> Climb:
    """The ascent between two times, with its standard deviations."""
    inside = (ascent.time >= begin) & (ascent.time <= end)

    def cut(values: Array) -> Array:
        return np.asarray(values[..., inside])

    return Climb(
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


def forces(climb: Climb, push: Push | None, track: Heights, pad_elevation: float, free: float) -> Forces | None:
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
        if felt_there.sum() >= _MOST * flown.sum():
            flown, window = felt_there, 2 * max(0.05, 1.5 * float(np.median(np.diff(push.time))))
    time = climb.time[flown]
    if push is not None and window:
        total = np.concatenate(([0.0], np.cumsum(np.diff(push.time) * (push.felt[1:] + push.felt[:-1]) / 2)))
        after, before = (np.interp(time + half, push.time, total) for half in (window / 2, -window / 2))
        felt = (after - before) / window
        felt_sd, source = np.hypot(0.3, _SCALE * np.abs(felt)), push.source
    else:
        felt, felt_sd, source = climb.acceleration[flown] + GRAVITY, climb.acceleration_sd[flown], climb.source
    speed, speed_sd, burning = climb.speed[flown], climb.speed_sd[flown], climb.burning[flown]
    density = standard_density(climb.height[flown] + pad_elevation)
    shows = ~burning & (speed > _SLOWEST) & (density > _THINNEST)
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


def peak_push(push: Push | None, ascent: Ascent, begin: float, burnout: float, source: str) -> Figure | None:
    """Strongest acceleration from lift-off to top speed, net of gravity, over a twentieth of a second."""
    if push is not None and not push.vertical:
        inside = (push.time >= begin - 0.05) & (push.time <= burnout + 0.05)
        time, felt = push.time[inside], push.felt[inside]
        if time.size >= 8:
            width = max(3, round(_WINDOW / median_step(time)))
            smooth = running_median(felt, width | 1)
            value = float(smooth.max()) - GRAVITY
            if time[0] > begin + _LATE and smooth[:2].max() == smooth.max():
                return None  # the strongest push may have come before the first sample
            coarse = (float(felt.max()) - float(smooth.max())) / 2 if width * median_step(time) > _WINDOW else 0.0
            sd = np.sqrt((_SCALE * value) ** 2 + 0.5**2 + coarse**2)
            return Figure(value, float(sd), push.source) if value > 2 * sd else None
    inside = (ascent.time >= begin) & (ascent.time <= burnout)
    if not inside.any():
        return None
    place = int(np.argmax(ascent.acceleration[inside]))
    value = float(ascent.acceleration[inside][place])
    sd = np.hypot(float(ascent.accelerations[:, inside][:, place].std()), 0.15 * value)
    return Figure(value, float(sd), source) if value > 2 * sd else None


def boost_event(
    ascent: Ascent, push: Push | None, begin: float, apogee: float, source: str
) -> tuple[Event, Figure] | None:
    """When the rocket was fastest and how fast, by the curve, with the spread of its draws."""
    inside = (ascent.time >= begin) & (ascent.time <= apogee)
    time = ascent.time[inside]
    if time.size < 5:
        return None
    place = int(np.argmax(ascent.speed[inside]))
    value = float(ascent.speed[inside][place])
    moments = time[np.argmax(ascent.speeds[:, inside], axis=1)]
    sd = np.hypot(
        1.4826 * np.median(np.abs(moments - time[place])),
        max(0.02, median_step(push.time) / 2)
        if push and ascent.fused
        else np.hypot(0.03 + 0.02 * (time[place] - begin), ascent.burnout_sd),
    )
    spread = float(ascent.speeds[:, inside][:, place].std())
    least = _FUSED if ascent.fused else _DERIVED if value < _TRANSONIC else _DISTURBED
    return Event(float(time[place]), float(sd), source), Figure(value, float(np.hypot(spread, least * value)), source)

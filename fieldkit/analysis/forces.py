"""Measured thrust and drag: the acceleration with gravity removed.

Derivation: Newton's second law for a vertical path: thrust and drag per mass are the acceleration plus gravity.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, Push
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Event, Figure, Forces, MeasuredClimb
from fieldkit.analysis.robust_statistics import mad_sd, median_step
from fieldkit.analysis.satellites import SOURCE as SATELLITES
from fieldkit.analysis.satellites import sighted_speed
from fieldkit.integrals import running_integral
from fieldkit.physics.standard_atmosphere import GRAVITY, standard_density
from fieldkit.shapes import Array, Flags

_MIN_DRAG_SPEED = 15.0
"""Speed below which errors of the acceleration exceed drag. [m/s]"""
_MIN_DENSITY = 1e-4
"""Air density below which drag cannot be measured, reached about 60 km up. [kg/m^3]"""
_SPEED_ERROR = 0.015
"""Smallest relative error of a top speed. [1]"""
_TRANSONIC_PRESSURE_ERROR = 0.06
"""The same as `STATIC_SD`, but above `_TRANSONIC_SPEED`, where shocks disturb the pressure. [1]"""
_MAX_SPEED_ERROR = 0.25
"""Upper limit of this relative error of a top speed from heights only; the largest one observed was 0.29. [1]"""
_TRANSONIC_SPEED = 270.0
"""Speed above which shocks disturb the pressure, about Mach 0.8. [m/s]"""
_BRAKING_TIME = 1.5
"""Time after top speed over which the deceleration is measured. [s]"""
FADE, FADE_SD = 0.12, 0.10
"""Impulse of a motor after its thrust has fallen for good to a fraction x of its mean, as a fraction of x² times the
total: mean and standard deviation over the catalog, each impulse class weighted equally (a test recomputes them). A
linear decrease over a fifth of the burn has 0.1. [1]"""
_MOST_FADE, _FADE_TIME = 0.8, 0.3
"""Largest x, and time after top speed over which the deceleration is measured. [1], [s]"""
_BURN_TIME_ERROR, _LATEST_DISTURBED = 0.02, 0.1
"""Relative error of a burn time from heights only, and from a barometer disturbed by shocks. [1]"""
_MIN_FELT_FRACTION = 0.9
"""Fraction of a climb that an accelerometer must have recorded to be trusted instead of the heights. [1]"""
_MAIN_FRACTION = 0.5
"""Fraction of a speed that satellites must contribute to be named as its source. [1]"""
_SCALE = 0.02
"""Relative error of an accelerometer. [1]"""
_AVERAGING_TIME = 0.06
"""Longest interval over which sensors average their own samples. [s]"""
CHERNOFF_SD = 0.513
"""Standard deviation of Chernoff's distribution (Groeneboom and Wellner, Journal of Computational and Graphical
Statistics 10, 2001). [1]"""
_CROSSING_STEPS = 2.5
"""Largest distance of a sample of an accelerometer from the top speed of the curve, in steps of whichever has longer
ones: the curve spreads the end of thrust over one knot to either side, and that may lie anywhere between two samples.
[1]"""
_CROSSING_WINDOW, _NOISE_WINDOW, _LEAST_SLOPE = 0.15, 1.0, 5.0
"""Time to both sides of top speed over which the slope of the acceleration [s] and the noise of the accelerometer [s]
are taken, and the slowest decrease of net acceleration at burnout [m/s^3]."""


def climb_of(ascent: Ascent, begin: float, burnout: float, end: float, source: str) -> MeasuredClimb:
    """The ascent between two times [s], with its standard deviations."""
    inside = (ascent.time >= begin) & (ascent.time <= end)

    def cut(values: Array) -> Array:
        return np.asarray(values[..., inside])

    return MeasuredClimb(
        cut(ascent.time),
        cut(ascent.height),
        cut(ascent.speed),
        cut(ascent.speeds).std(axis=0),
        cut(ascent.acceleration),
        cut(ascent.accelerations).std(axis=0),
        cut(ascent.time) <= burnout,
        source,
    )


def forces(climb: MeasuredClimb, push: Push | None, pad_elevation: float, free: float) -> Forces | None:
    """Acceleration without gravity and, in the coast, Cd·A per mass, from lift-off to ejection (`free` [s]) or apogee,
    with the pad at an elevation [m].

    An axial accelerometer measures it directly, with its zero from the pad. Otherwise it is the smoothed vertical
    acceleration plus gravity, which is valid for a rocket that climbs straight.
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
        net = levelled(push, float(climb.time[0]))
        every = push.felt if net is None else net + GRAVITY
        total = running_integral(every, push.time)
        ends = [np.clip(time + half, push.time[0], push.time[-1]) for half in (-window / 2, window / 2)]
        before, after = (np.interp(end, push.time, total) for end in ends)
        felt = (after - before) / (ends[1] - ends[0])
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
    return Forces(
        time - climb.time[0],
        climb.height[flown],
        speed,
        speed_sd,
        felt,
        felt_sd,
        burning,
        area,
        window,
        source,
    )


def boost_event(
    ascent: Ascent, push: Push | None, begin: float, apogee: float, source: str, by_climb: Figure | None = None
) -> tuple[Event, Figure] | None:
    """Time and size of the top speed between lift-off `begin` [s] and `apogee` [s] according to the curve, with the
    spread of its draws.

    Heights that are off by a fraction k of v²/2g shift a speed v that decreases with a by k·v·a/g. An uncertain time of
    top speed also makes the deceleration until then uncertain. From heights alone both errors nearly cancel
    (`fieldkit.analysis.burnout`), except those of shocks, which the coast after them does not have. If an accelerometer
    shows between which of its samples thrust ended, that is the only error of the time. If the most probable burnout
    contradicts the curve, as where air brakes open at burnout, the difference is an error of the time. `by_climb` is
    the top speed by the whole of a hard climb, which has less of the ports' error: if heights alone show the boost,
    both are averaged, by Birge's ratio if they differ by more than their errors.
    """
    inside = (ascent.time >= begin) & (ascent.time <= apogee)
    time = ascent.time[inside]
    if time.size < 5:
        return None
    fastest = int(np.argmax(ascent.speed[inside]))
    place = fastest if ascent.ended is None else int(np.argmin(np.abs(time - ascent.ended.time)))
    value = float(ascent.speed[inside][place])
    moments = time[np.argmax(ascent.speeds[:, inside], axis=1)]
    late = float(1.4826 * np.median(np.abs(moments - time[place])))
    moment = float(time[place])
    spread = float(ascent.speeds[:, inside][:, place].std())
    if ascent.fused and push:
        step, noise = median_step(push.time), _moved_by_noise(push, ascent, time[place])
        crossed = _crossed(push, begin, moment, max(step, median_step(time)))
        if crossed is None:
            late = float(np.linalg.norm([late, max(step, median_step(time)) / np.sqrt(12), noise]))
        else:
            moment, late = crossed[0], float(np.hypot(crossed[1] / np.sqrt(12), noise))
            value, sd = _before_coast(push, ascent, begin, crossed, apogee) or (value, 0.0)
            spread = float(np.hypot(spread, sd))
        gained = _gained_between(push, begin, time[place])
        scale = float(np.hypot(push.scale - 1, push.scale_sd)) / 2 * value if push.scale_sd else _SPEED_ERROR * value
        spread = float(np.linalg.norm([spread, scale, push.missed_speed_sd, gained]))
    else:
        is_barometric, disturbed = CHANNEL_TITLES["gps_altitude_msl"] not in source, value > _TRANSONIC_SPEED
        fraction = _LATEST_DISTURBED if is_barometric and disturbed else _BURN_TIME_ERROR
        burn = float(time[place]) - begin
        faded, level = _faded(ascent, value, float(time[place]), begin)
        blind = 0.03 + fraction * burn
        shape = fades = float(np.hypot(blind, FADE_SD * burn * max(1 - 2 * level, 0.0)))
        if is_barometric:
            moment -= 2 * FADE * (level - 0.25) * burn
            even = 2 * np.hypot(FADE, FADE_SD) / np.sqrt(48)
            fades = float(np.linalg.norm([blind, 2 * FADE_SD * (level - 0.25) * burn, even * burn]))
        late = float(np.linalg.norm([late, fades, ascent.burnout_sd])) if ascent.ended is None else ascent.ended.sd
        blurred = _moved_by_pressure(ascent, inside) if is_barometric else 0.0
        later = float(np.interp(time[place] + _BRAKING_TIME, ascent.time, ascent.speed))
        brakes = max(GRAVITY, (value - later) / _BRAKING_TIME)
        climbs = float(np.interp(apogee, ascent.time, ascent.height)) - float(ascent.height[inside][place])
        contradicted = 0.0
        if ascent.burnout is not None and ascent.burnout.is_of(float(time[place]), ascent.resolution, climbs):
            expected, static = ascent.burnout.speed - value, ascent.burnout.speed_sd
            shocks = np.sqrt(_TRANSONIC_PRESSURE_ERROR**2 - STATIC_SD**2) * brakes / GRAVITY if disturbed else 0.0
            static = float(np.hypot(static, min(shocks, _MAX_SPEED_ERROR) * value))
            spread = float(np.linalg.norm([spread, brakes * shape, brakes * ascent.burnout.lift_sd]))
        else:
            contradicted = float(time[place]) - ascent.burnout.marks.burnout if ascent.burnout is not None else 0.0
            expected, error = 0.0, (_TRANSONIC_PRESSURE_ERROR if disturbed else STATIC_SD) * is_barometric
            static = min(error * brakes / GRAVITY, _MAX_SPEED_ERROR) * value
            spread = float(np.hypot(spread, brakes * late))
        off, static, weight = sighted_speed(ascent.sighted, ascent, float(time[place]), float(static), expected)
        value, source = value + off - faded, source + (f" and {SATELLITES}" if weight > _MAIN_FRACTION else "")
        spread = float(np.linalg.norm([spread, _SPEED_ERROR * value, static, faded * FADE_SD / FADE]))
        late = float(np.linalg.norm([late, blurred, contradicted]))
        if by_climb is not None:
            value, spread = _averaged(value, spread, by_climb.value - faded, by_climb.sd)
    if ascent.ended is not None:
        return ascent.ended, Figure(value, float(spread), source)
    return Event(moment, late, source), Figure(value, float(spread), source)


def _averaged(value: float, sd: float, other: float, other_sd: float) -> tuple[float, float]:
    """Mean of two measurements from the same samples, so that their errors do not average out, and its standard
    deviation, larger by Birge's ratio if they differ by more than their errors."""
    ratio = max(1.0, abs(other - value) / float(np.hypot(sd, other_sd)))
    part = sd**2 / (sd**2 + other_sd**2)
    return value + part * (other - value), ratio * ((1 - part) * sd + part * other_sd)


def _faded(ascent: Ascent, speed: float, moment: float, begin: float) -> tuple[float, float]:
    """What a curve through heights misses because its thrust ends at once, while that of motors fades: by how much it
    is faster at burnout than the rocket [m/s], and the thrust then as a fraction of its mean [1].

    Derivation: the curve at burnout is the coast after it, extrapolated back to the time when thrust equals weight and
    drag. Thrust that fades from its mean to zero within t has t x²/2 of impulse left when it is the fraction x of its
    mean: the coast is faster by that. A curve of the same impulse would end (1/2 - x) t before top speed, one that ends
    with the motor x t after it; static ports that are off make a fade look like such an end. So by a barometer it is
    evenly distributed in between, around (x - 1/4) t after top speed with the standard deviation t/sqrt(48). Thrust per
    mass is the mean acceleration plus gravity plus a third of the drag at burnout, the mean of v² in an even boost.
    """
    burn = moment - begin
    later = float(np.interp(moment + _FADE_TIME, ascent.time, ascent.speed))
    slows = max((speed - later) / _FADE_TIME, GRAVITY)
    if burn <= 0:
        return 0.0, 0.0
    thrust = speed / burn + GRAVITY + (slows - GRAVITY) / 3
    level = min(slows / thrust, _MOST_FADE)
    return FADE * level**2 * thrust * burn, level


def _gained_between(push: Push, begin: float, burnout: float) -> float:
    """Standard deviation of the speed that a boost gained between samples of an accelerometer. [m/s]

    Derivation: if the acceleration jumps by j anywhere in an interval d, the trapezoidal rule is off by up to j d / 2
    either way, with equal probability: its standard deviation is j d / sqrt(12). Over short intervals sensors average.
    """
    first, last = np.searchsorted(push.time, (begin, burnout))
    inside = slice(max(first - 1, 0), last + 1)
    intervals, jumps = np.diff(push.time[inside]), np.diff(push.felt[inside])
    wide = intervals > _AVERAGING_TIME
    return float(np.linalg.norm(jumps[wide] * intervals[wide]) / np.sqrt(12))


def _crossed(push: Push, begin: float, moment: float, step: float) -> tuple[float, float] | None:
    """Time of top speed by the samples of an accelerometer, which are up to a `step` apart [s]: the middle between two
    around a `moment` [s] of which the first one feels thrust and the second one none, and the interval between them
    [s], anywhere in which it may lie.

    A curve through widely spaced samples spreads the end of thrust, and is fastest too late. None if more than two
    samples change sides there: thrust fades slowly. `begin` is lift-off. [s]
    """
    net = levelled(push, begin)
    near = np.flatnonzero(np.abs(push.time - moment) <= _CROSSING_STEPS * step)
    if net is None or near.size < 2:
        return None
    pushed = net[near] > 0
    ends = near[:-1][pushed[:-1] & ~pushed[1:]]
    if ends.size != 1 or (~pushed[:-1] & pushed[1:]).any():
        return None
    first, second = push.time[ends[0]], push.time[ends[0] + 1]
    return float(first + second) / 2, float(second - first)


def _before_coast(
    push: Push, ascent: Ascent, begin: float, crossed: tuple[float, float], apogee: float
) -> tuple[float, float] | None:
    """Speed at the end of thrust between two samples of an accelerometer, as `_crossed` has it, from the coast after
    it, and its standard deviation, because thrust may end anywhere between the two; None if the coast is too short.
    [m/s]

    A curve through knots a step d apart, and samples c apart, spreads the end of thrust over about 2 d + c and stays
    below the highest speed. Derivation: v(end) = v(t) + integral of g - a from the end to a t beyond that, with the
    first sample without thrust for the half interval before it.
    """
    net, (moment, interval) = levelled(push, begin), crossed
    after = moment + 1.5 * interval + 2 * median_step(ascent.time)
    if net is None or after >= apogee:
        return None
    inside = (push.time > moment) & (push.time <= after)  # never empty: the second of the two samples is in it
    time = np.concatenate(([moment], push.time[inside], [after]))
    lost = np.concatenate((net[inside][:1], net[inside], [np.interp(after, push.time, net)]))
    speed = np.interp(after, ascent.time, ascent.speed) - np.trapezoid(lost, time)
    return float(speed), float(abs(lost[0]) * interval / np.sqrt(12))


def _moved_by_noise(push: Push, ascent: Ascent, moment: float) -> float:
    """How far the noise of an accelerometer moves the time of top speed. [s]

    Derivation: where the net acceleration crosses zero with the slope -s, the speed is s t²/2 below its maximum, and
    the noise n of samples d apart adds a Brownian motion of variance n² d t. The maximum of W(t) - t² has Chernoff's
    distribution (Annals of the Institute of Statistical Mathematics 16, 1964), and t scales as (2 n sqrt(d) / s)^(2/3).
    """
    near = np.abs(ascent.time - moment) < _CROSSING_WINDOW
    felt = push.felt[np.abs(push.time - moment) < _NOISE_WINDOW]
    if near.sum() < 4 or felt.size < 4:
        return 0.0
    slope = max(-2 * float(np.polyfit(ascent.time[near] - moment, ascent.speed[near], 2)[0]), _LEAST_SLOPE)
    noise = mad_sd(np.diff(felt)) / np.sqrt(2)
    return CHERNOFF_SD * float((2 * noise * np.sqrt(median_step(push.time)) / slope) ** (2 / 3))


def _moved_by_pressure(ascent: Ascent, inside: Flags) -> float:
    """How far the error of the pressure in the airframe moves the time of top speed: its root mean square. [s]

    Heights that are low by k v²/2g show the speed v (1 - k a/g). A sudden burnout stays where it is, but thrust that
    fades crosses zero net acceleration slowly, and the apparent crossing moves by up to k v/g. The most probable
    burnout has the ports' error for a sudden one only, so this is not counted twice: without it burn times are off by
    more than their standard deviation on the recorder bench.
    """
    time, speed, acceleration = ascent.time[inside], ascent.speed[inside], ascent.acceleration[inside] / GRAVITY
    usual, *moved = (time[int(np.argmax(speed * (1 + k * acceleration)))] for k in (0.0, -STATIC_SD, STATIC_SD))
    return float(np.sqrt(np.mean((np.array(moved) - usual) ** 2)))

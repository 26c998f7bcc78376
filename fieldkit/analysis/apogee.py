"""Apogee of a fitted ascent: its time and height, if the samples show it.

Derivation: the apogee is the maximum of the fitted curve; the difference of two independent heights has sqrt(2) times
the standard deviation of one.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, Heights
from fieldkit.analysis.phases import WIND_PRESSURE_SD, Outline
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import lag_one, mad_sd
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float, Int, Integers

_MIN_TIME_AFTER_TOP, _FALL = 0.8, 1.0
"""How long a curve must continue after its top [s] and how far it must clearly fall [m] to count as coming down."""
_TOP_REACH, _LEAST_TOP_SAMPLES = 2.0, 6
"""How far around the highest heights a parabola shows the top [s], and in how many samples [1]."""
_MAX_TAKEN = 0.8
"""Largest fraction of the variance that subtracting the mean of a short rest may have removed. [1]"""
_LEAST_GPS = 2.0
"""Smallest error of a satellite apogee: the drift of one receiver's height within a minute. [m]"""
_MAX_HEARD_GAP = 2.0
"""Longest gap between samples in which an apogee can still be located. [s]"""
_MIN_BEFORE, _MAX_BEFORE = 0.02, 0.3
"""How long before an event the samples end that show its height, at least and at most. [s]"""
_REST, _MAX_REST_MOVEMENT = 10.0, 20.0
"""Length of the end of a log that is searched for a rest [s], and the largest movement of heights in a rest [m]."""


def falls(ascent: Ascent) -> bool:
    """Whether the curve clearly comes down at its end, even though few samples show it."""
    late = ascent.time[-1] - ascent.time[int(np.argmax(ascent.height))]
    return bool(
        late > _MIN_TIME_AFTER_TOP and np.quantile(ascent.heights.max(axis=1) - ascent.heights[:, -1], 0.05) > _FALL
    )


def apogee_of(ascent: Ascent, seen: Outline, track: Heights) -> tuple[Event, Figure] | None:
    """The top of the curve, or of the heights if the curve misses it; None if they still rise when the log ends.

    The curve misses the heights around the top if they are farther from it than from a parabola of their own: something
    disturbed the pressure in the climb, such as air brakes, but hardly at the top, where the air is at rest.
    """
    has_samples = _has_samples(ascent.time, track, seen.top)
    place = int(np.argmax(np.where(has_samples, ascent.height, -np.inf)))
    if place >= ascent.time.size - 2 or place == 0:
        return _by_heights(seen, track) if seen.down else None
    drawn = np.where(has_samples, ascent.heights, -np.inf)
    tops = drawn.max(axis=1)
    moment = float(_vertices(ascent.time, ascent.speed[None], np.array([place]))[0])
    moments = _vertices(ascent.time, ascent.speeds, np.argmax(drawn, axis=1))
    near = np.abs(track.time - ascent.time[place]) < 1.0
    residual = track.height[near] - seen.pad - np.interp(track.time[near], ascent.time, ascent.height)
    fit_error = mad_sd(residual) / 2 if mad_sd(residual) > 3 * track.noise else 0.0
    sd = float(np.linalg.norm([tops.std(), seen.pad_sd, fit_error, slow_error_sd(track, seen), track.held_sd]))
    shown = _by_heights(seen, track) if seen.down and fit_error > 0 else None
    if shown is not None and shown[1].sd < fit_error:
        return shown
    spread = 1.4826 * np.median(np.abs(moments - moment))
    event = Event(moment, float(np.linalg.norm([spread, track.lag_sd, track.top_held])), track.source)
    return event, Figure(float(ascent.height[place]), sd, track.source)


def _by_heights(seen: Outline, track: Heights) -> tuple[Event, Figure] | None:
    """The top of a parabola through the heights around their highest running median, for a log that is seen to come
    down though a curve through the climb would still rise: pressure is off in the climb, or was held for a while."""
    near = np.abs(track.time - seen.top) < _TOP_REACH
    since, height = track.time[near] - seen.top, track.height[near] - seen.pad
    if near.sum() < _LEAST_TOP_SAMPLES or not since.min() < 0 < since.max():
        return None
    bend, slope, level = (float(one) for one in np.polyfit(since, height, 2))
    at = float(np.clip(-slope / (2 * bend), since.min(), since.max())) if bend < 0 else 0.0
    value = level + slope * at + bend * at**2
    off = abs(value - (seen.top_height - seen.pad))
    left = float(np.std(height - np.polyval((bend, slope, level), since)))
    sd = float(np.linalg.norm([left, off, seen.pad_sd, slow_error_sd(track, seen), track.held_sd]))
    moment_sd = max(float(np.sqrt(2 * max(sd, track.noise) / GRAVITY)), abs(at))
    return Event(seen.top + at, moment_sd, track.source), Figure(value, sd, track.source)


def _vertices(
    time: Float[Array, "knot"], speeds: Float[Array, "draw knot"], places: Int[Integers, "draw"]
) -> Float[Array, "draw"]:
    """When curves turn around, each near its highest knot: where the line through the speeds before and after it is
    zero. [s]"""
    places = np.clip(places, 1, time.size - 2)
    draws = np.arange(places.size)
    before, after = speeds[draws, places - 1], speeds[draws, places + 1]
    width = time[places + 1] - time[places - 1]
    falls = np.maximum(before - after, 1e-9)
    return np.asarray(time[places - 1] + width * np.clip(before / falls, 0, 1))


def _has_samples(time: Float[Array, "knot"], track: Heights, top: float) -> Flags:
    """Which knots of a curve lie among the samples around the top of the heights, without a long gap between. [s]

    In a gap the curve is unconstrained, and before it a curve that had to bridge the gap may be far off.
    """
    ends = np.flatnonzero(np.diff(track.time) > _MAX_HEARD_GAP)
    begin = track.time[np.append(0, ends + 1)]
    end = track.time[np.append(ends, track.time.size - 1)]
    around = max(int(np.searchsorted(begin, top, side="right")) - 1, 0)
    has_samples = np.asarray((time >= begin[around]) & (time <= end[around]))
    return has_samples if has_samples.any() else np.ones(time.size, bool)


def slow_error_sd(track: Heights, seen: Outline) -> float:
    """Standard deviation between the heights that a sensor shows at one height a while apart, besides noise. [m]"""
    if track.source != CHANNEL_TITLES["gps_altitude_msl"]:
        return WIND_PRESSURE_SD
    return max(_LEAST_GPS, _drift_of_receiver(track, seen))


def _drift_of_receiver(track: Heights, seen: Outline) -> float:
    """Drift of a receiver's height on the ground, before lift-off or after landing [m].

    The difference of two such heights, at the pad and at apogee, is larger.
    """
    first, last = track.time[0], track.time[-1]
    rests = (
        track.height[(track.time < (seen.lift or first) - 0.5)],
        track.height[(track.time > max(seen.top + 5, last - _REST))],
    )
    spreads = [_spread(one) for one in rests if one.size >= 8 and np.ptp(one) < _MAX_REST_MOVEMENT]
    return float(np.sqrt(2)) * max(spreads, default=0.0)


def _spread(values: Float[Array, "_"]) -> float:
    """Standard deviation of autocorrelated values, corrected for the variance that the mean of a short rest removes.

    With autocorrelation p^k, the mean of n values has (1 + 2 sum (1 - k/n) p^k) / n times their variance.
    """
    lag1, count = lag_one(values), values.size
    steps = np.arange(1, count)
    taken = (1 + 2 * float(((1 - steps / count) * lag1**steps).sum())) / count
    return float(values.std() / np.sqrt(1 - min(taken, _MAX_TAKEN)))


def height_at(ascent: Ascent, track: Heights, seen: Outline, moment: Event) -> Figure:
    """Height above the pad at an event, by a parabola through the samples of the second before it, up to its standard
    deviation: the gas of a charge disturbs those after it. [m]

    The error of a lag that was removed from the heights moves them by that much of their slope, and that of static
    ports by a part of the dynamic pressure, in a fall as well. Derivation: around an apogee, where the slope is zero, a
    time that is off by t moves them by g t²/2, whose root mean square is sqrt(3) g s²/2 for a normal t of spread s.
    """
    if ascent.time[0] <= moment.time <= ascent.time[-1]:
        value = float(np.interp(moment.time, ascent.time, ascent.height))
        slope = float(np.interp(moment.time, ascent.time, ascent.speed))
        spread = float(np.interp(moment.time, ascent.time, ascent.heights.std(axis=0)))
    else:
        end = moment.time - float(np.clip(moment.sd, _MIN_BEFORE, _MAX_BEFORE))
        last = int(np.searchsorted(track.time, end))
        first = min(int(np.searchsorted(track.time, end - 1)), max(0, last - 6))
        when, where = track.time[first:last] - moment.time, track.height[first:last] - seen.pad
        if when.size < 3:
            return Figure(
                float(np.interp(moment.time, track.time, seen.calm)) - seen.pad, 3 * track.noise + 5, track.source
            )
        _, slope, value = (float(one) for one in np.polyfit(when, where, 2))
        left = where - np.polyval(np.polyfit(when, where, 2), when)
        spread = max(3 * track.noise / np.sqrt(when.size), float(left.std()))
    ports = STATIC_SD * slope**2 / (2 * GRAVITY) if track.is_barometric else 0.0
    late = slope * np.hypot(moment.sd, track.lag_sd)
    bent = np.sqrt(3) * GRAVITY * moment.sd**2 / 2
    sd = float(np.linalg.norm([spread, seen.pad_sd, slow_error_sd(track, seen), late, bent, ports]))
    return Figure(value, sd, track.source)

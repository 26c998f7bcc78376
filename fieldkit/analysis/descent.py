"""The descent from ejection: landing, and the speed until then.

Derivation: a rocket lands where the line through the end of its descent meets the level that follows it, and its mean
speed is a height divided by a time.
"""

from dataclasses import replace

import numpy as np

from fieldkit.analysis.apogee import slow_error_sd
from fieldkit.analysis.channels import Heights, resolution_at
from fieldkit.analysis.descent_stages import SLOWEST_DESCENT
from fieldkit.analysis.ejection import EARLIEST_CHARGE
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import mad_sd, median_step, student_line
from fieldkit.flight.recovery import DESCENT_SPEED
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float, Int, Integers

_BRAKED_SLACK, _BRAKED_SAMPLES = 2.0, 5
"""Slack in the speed of a fall [m/s]: a fall to less than 1.5 times the descent speed plus this
slack does not reveal when it was braked, nor does one within the samples that show its speed [1]."""
_SAME_HEIGHT, _LAST_SECOND = 3.0, 1.0
"""Heights closer than this many standard deviations may be of a rocket at rest [1]; the end of a log whose median is
its last height [s]."""
_MIN_LINE_SAMPLES, _MAX_LINE_SAMPLES, _LINES, _BENT = 6, 200, 2, 0.4
"""Fewest and most samples of the last line of a descent, the number of lines, each up to the landing that the one
before it shows [1], and how long before that a filter or small vents may bend the descent [s]."""
_TAIL = 3.5
"""Time for which heights behind a filter approach the level of a landing visibly, in its time constants. [1]"""
_LONG_REST, _REST_HEIGHT, _REST_MARGIN = 2.5, 0.5, 0.5
"""A rest of this length shows in a difference of heights two seconds apart [s]; how much above a shorter one smoothed
heights may be [m]; uncertainty of the beginning of a rest from smoothed heights [s]."""
_MIN_REST_SAMPLES, _REST_SDS = 3, 3.0
"""Fewest samples of a rest, so that one outlier does not determine its level, and number of standard deviations by
which it excludes a descent. [1]"""
_BRAKED_LANDING, _LATE_SDS = 3.0, 3.0
"""For how long after the end of the last line heights may show that the rocket is still in the air [s], and how late
that is for a line that does not describe its last seconds, in standard deviations [1]."""
_GUST_WALK = 2 * 0.5**2 / 3.0
"""Variance that the speed of a descent gains per second in gusts of 0.5 m/s that last for 3 s, 2 u²/T. [m^2/s^3]"""


def landing(track: Heights, seen: Outline, apogee: float) -> tuple[Event | None, float | None]:
    """Time of landing [s] and the ground's height in this channel [m]; (None, None) if it is not in the log.

    The last line of the descent is intersected with the level that follows it. Gusts change both.
    """
    time, calm, height = track.time, seen.calm, track.height
    fall = np.flatnonzero(time > apogee)
    if fall.size < 8:
        return None, None
    even = np.arange(apogee, time[-1], max(0.25, (time[-1] - apogee) / 2000))
    smooth = np.interp(even, time[fall], calm[fall])
    half_width = max(1, round(2.0 / (even[1] - even[0]))) if even.size > 2 else 1
    if even.size < 4 * half_width:
        return None, None
    speed = (smooth[:-half_width] - smooth[half_width:]) / (half_width * (even[1] - even[0]))
    typical = float(np.median(speed[speed > max(0.5, 0.1 * np.quantile(speed, 0.9))])) if (speed > 0.5).any() else 0.0
    typical = min(typical, DESCENT_SPEED)  # after a fast drogue, a main is slow, but not at rest
    going = np.flatnonzero(
        speed > max(0.12 * typical, min(0.5 * typical, max(1.0, _speed_noise(track, seen, half_width, even))))
    )
    if typical < 0.5 or going.size == 0:
        return None, None
    last_going = _last_fall(going, speed, typical)
    about = float(even[min(last_going + half_width, even.size - 1)])
    margin = _REST_MARGIN
    if time[-1] - about < _LONG_REST:
        about, margin = _touchdown(time[fall], calm[fall], track.noise), 0.0
    rest = (time >= about + margin) & (time < about + 8)
    if not _is_at_rest(time[rest], height[rest], track.noise):
        return None, None
    level = float(np.median(height[rest]))
    slow_error = slow_error_sd(track, seen)
    level_sd = float(np.hypot(slow_error, track.noise / np.sqrt(rest.sum())))
    one = float(resolution_at(height[rest][:1], height)[0]) if np.ptp(height[rest]) == 0 else 0.0
    held = max(track.held, one) / np.sqrt(12)  # the ground is anywhere within the one number that is shown of it
    found, end = Event(about, 1.0, track.source), about
    high = calm > level + 4 * np.hypot(track.noise, slow_error)
    bent = max(_BENT, _TAIL * track.bend)
    for _ in range(_LINES):
        falls = (time > max(apogee, about - 8 - bent)) & (time < end - bent) & high
        if falls.sum() < 4:
            break
        line = _final_line(time[falls], track.noise)
        when = time[falls][line]
        slope, middle = student_line(when, height[falls][line], track.noise)
        end = (level - middle) / slope if slope < -0.3 else about
        end = float(np.clip(end, about - 2 - bent, about + 1 + one / max(-slope, 0.5)))
        sd = float(np.hypot(_line_error(when, track.noise, end), level_sd)) / max(-slope, 0.5)
        sd = float(np.linalg.norm([sd, track.lag_sd, held / max(-slope, 0.5)]))
        found, high = Event(end, sd, track.source), np.full(time.size, True)
    above = 4 * float(np.hypot(track.noise, slow_error))
    return _until_down(found, track, level + above, 2 * above / typical), level  # braked, so slower than before


def _until_down(found: Event, track: Heights, bar: float, lasts: float) -> Event:
    """A landing that heights are above the ground after, by more than noise, up to a `bar` [m] from which the rest of
    the way `lasts` [s]: anywhere from the end of the last line until then, with equal probability.

    A parachute that opens just above the ground brakes the rocket below the line, and a filter is late.
    """
    later = (track.time > found.time) & (track.time < found.time + _BRAKED_LANDING)
    up = track.time[later][track.height[later] > bar]
    after = float(up[-1]) + lasts - found.time if up.size else 0.0
    if after - lasts < _LATE_SDS * found.sd:
        return found
    return replace(found, time=found.time + after / 2, sd=float(np.hypot(found.sd, after / np.sqrt(12))))


def _touchdown(time: Float[Array, "_"], height: Float[Array, "_"], noise: float) -> float:
    """When the last stretch of smoothed heights begins that stays at the level of its second half. [s]"""
    within = max(2 * noise, _REST_HEIGHT)
    starts = np.flatnonzero(time > time[-1] - _LONG_REST - _REST_MARGIN)
    still = [i for i in starts if np.abs(height[i:] - np.median(height[(i + time.size) // 2 :])).max() < within]
    return float(time[still[0]]) if still else float(time[-1])


def _is_at_rest(time: Float[Array, "_"], height: Float[Array, "_"], noise: float) -> bool:
    """Whether heights exclude a descent: its rate is smaller than that of the slowest one by several standard
    deviations.

    Derivation: the slope of a straight line through samples at the times t with the error s each has the variance
    s² / sum (t - mean t)². So a quiet barometer shows a rest in less than a second, and a noisy or slow one later.
    """
    if time.size < _MIN_REST_SAMPLES:
        return False
    away = time - time.mean()
    slope = float(away @ height / (away @ away))
    scatter = float(np.std(height - height.mean() - slope * away))
    sd = max(noise, scatter) / float(np.sqrt(away @ away))
    return -slope + _REST_SDS * sd < SLOWEST_DESCENT


def _final_line(time: Float[Array, "time"], noise: float) -> slice:
    """Which samples of a descent, each with a noise [m], to fit its last line to: all of a length, thinned if many.

    A long line averages the noise, but gusts bend it, and a fall without a parachute accelerates: the length is that
    for which `_line_error` is smallest, L⁴ = 140 s² d / q for samples d apart.
    """
    step = median_step(time)
    length = float((140 * noise**2 * step / _GUST_WALK) ** 0.25)
    first = min(int(np.searchsorted(time, time[-1] - length)), max(time.size - _MIN_LINE_SAMPLES, 0))
    return slice(first, None, max(1, (time.size - first) // _MAX_LINE_SAMPLES))


def _line_error(time: Float[Array, "time"], noise: float, moment: float) -> float:
    """Standard deviation of a line through a descent at a moment after its samples [s], each with a noise [m]. [m]

    Derivation: least squares for n samples over a length L with independent errors s, and for a speed that is a random
    walk of variance q t; at the end of the line their variances are 4 s² / n and q L³ / 105.
    """
    length, after = float(np.ptp(time)), max(moment - float(time[-1]), 0.0)
    independent = noise**2 / time.size * (1 + 12 * (0.5 + after / length) ** 2)
    bends = length**3 / 105 + 11 / 105 * length**2 * after + 13 / 35 * length * after**2 + after**3 / 3
    return float(np.sqrt(independent + _GUST_WALK * bends))


def _last_fall(going: Int[Integers, "_"], speed: Float[Array, "_"], typical: float) -> int:
    """Index of the end of the last stretch of `going` that is a descent: faster somewhere than half the typical speed.

    A rocket lands at about its descent speed and then stays; slower movement after that is drift of the sensor.
    """
    stretches = np.split(going, np.flatnonzero(np.diff(going) > 1) + 1)
    falls = [one for one in stretches if speed[one].max() > 0.5 * typical]
    return int((falls or stretches)[-1][-1])


def _speed_noise(track: Heights, seen: Outline, half_width: int, even: Float[Array, "time"]) -> float:
    """Apparent rate of change of heights when nothing moves, from wind and noise: three standard deviations. [m/s]"""
    step = even[1] - even[0]
    pad = np.arange(max(track.time[0], even[0] - 60), seen.lift - 1, step) if seen.lift is not None else even[:0]
    if pad.size < 4 * half_width:
        return 1.5 * track.noise
    smooth = np.interp(pad, track.time, seen.calm)
    return 3 * mad_sd((smooth[half_width:] - smooth[:-half_width]) / (half_width * step))


def _from_unseen_ejection(slowest: float, height: float, lasts: float, step: float) -> tuple[float, float]:
    """Mean speed from an unseen ejection, and its standard deviation, from the mean speed since apogee. [m/s]

    All times are as likely, from the earliest, after which a parachute has ended the climb, to the latest: until
    ejection the rocket fell freely, and after a longer fall the braking would have been visible, unless it falls
    between samples that are a `step` apart [s]. Such a distribution has bounds: all of it is within two standard
    deviations.
    """
    latest = min((1.5 * slowest + _BRAKED_SLACK) / GRAVITY + _BRAKED_SAMPLES * step, lasts / 2)
    after = np.linspace(-EARLIEST_CHARGE, latest, 41)
    speeds = (height - GRAVITY * after**2 / 2) / (lasts - after)
    return float(speeds.mean()), float(speeds.std())


def descent_speed(
    track: Heights,
    seen: Outline,
    begin: Event,
    end: Event | None,
    level: float | None,
    ejected: Figure | None = None,
    *,
    known: bool,
) -> Figure | None:
    """Mean speed from ejection, or from apogee if ejection is not `known`, to landing, as the AltimeterTwo defines it.
    `ejected` is the height above the pad at ejection, if it was measured.

    In a ledger of that device, ejection height divided by the time from ejection to landing is 1.03 times its descent
    speed, the median of 47 flights. Without landing it is the mean over what the log contains, if that is at least a
    fifth of the way down. The rest may be slower or faster in proportion to its length, because a second parachute may
    open. `level` is the height of the landing [m].
    """
    start = begin.time
    upper = ejected.value + seen.pad if ejected else float(np.interp(start, track.time, seen.calm))
    if end is not None and level is not None and end.time - start > 1:
        value = (upper - level) / (end.time - start)
        if known:
            sd = value * np.hypot(begin.sd, end.sd) / (end.time - start)
        else:
            value, sd = _from_unseen_ejection(value, upper - level, end.time - start, median_step(track.time))
            sd = np.hypot(sd, value * end.sd / (end.time - start))
        sd = np.hypot(sd, (ejected.sd if ejected else 2 * track.noise) / (end.time - start))
        return Figure(value, float(sd), track.source) if value > 0 else None
    last = float(np.median(track.height[track.time > track.time[-1] - _LAST_SECOND]))
    gone, rest, way = float(track.time[-1]) - _LAST_SECOND / 2 - start, last - seen.pad, upper - seen.pad
    if gone < 2 or upper <= last or upper - last < 0.2 * way:
        return None
    # it may have landed before, if it is as low for longer than it falls through heights that the sensor cannot
    # distinguish
    same = _SAME_HEIGHT * float(np.hypot(track.noise, slow_error_sd(track, seen)))
    higher = np.flatnonzero(seen.calm >= last + same)
    since = float(track.time[-1] - track.time[higher[-1]]) if higher.size else 0.0
    rested = max(since - _LAST_SECOND - same * gone / (upper - last), 0.0)
    gone -= rested / 2
    value = (upper - last) / gone
    unseen = float(np.clip(rest / way, 0, 1)) / 2
    timing = np.hypot(begin.sd, rested / np.sqrt(12)) / gone
    return Figure(value, float(value * np.sqrt(0.03**2 + unseen**2 + timing**2)), track.source)

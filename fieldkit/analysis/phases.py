"""The phases of the flight in a log (pad, rise, apogee and fall) as robust starting values for the fits.

Derivation: a climb is a rise between two minima of smoothed heights; running medians reject spikes.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.channels import Heights, resolution_at, rest_level
from fieldkit.analysis.robust_statistics import lag_one, median_step, running_median_over, stretches
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

LEAST_GAIN = 5.0
"""Smallest rise that counts as a flight. [m]"""
LEAST_SPEED = 5.0
"""Smallest climb rate that counts as a flight. [m/s]"""
_MIN_PAD_TIME, _PAD_UNCERTAINTY = 0.15, 0.5
"""If a log begins less than this before lift-off [s], it may begin in flight; error of its pad height then [m]."""
_ZERO, _GROUND = 1.0, 20.0
"""Drift of a logger's own zero while it waits, and the largest difference of the landing from it that is attributed to
the zero instead of the terrain. [m]"""
TERRAIN_SD = 10.0
"""Standard deviation of the ground where a rocket lands, above the pad. [m]"""
_FEWEST_FIRST, _LOST_TIME, _FAST_AT_ZERO = 6, 0.15, 10.0
"""Fewest heights that show the speed of a climb at zero [1], for how long those before them may be lost as spikes [s],
and such a speed that is not that of a start [m/s]."""
WIND_PRESSURE_SD = 0.15
"""Standard deviation of heights from the pressure of gusts, U u / g by Bernoulli's equation: gusts u of 0.5 m/s in a
wind U of 3 m/s. A few seconds later it is another. [m]"""
_PARTS = 5
"""Number of parts into which the time on the pad is divided to detect gusts and drift. [1]"""
_WINDOW, _TRANSONIC_SPEED, _TRANSONIC_WINDOW = 0.25, 270.0, 1.0
"""The climb rate is that over a window to both sides [s]. If it is above this [m/s], it is evaluated over a window of
this length to both sides [s]."""
_TOP_WINDOW = 1.0
"""Window of the median whose maximum is the top. [s]"""
LONGEST_CLIMB = 120.0
"""Longest time from lift-off to apogee. [s]"""
_LANDED_FRACTION, _LEAST_NEXT, _MIN_NEXT = 0.25, 0.3, 20
"""Below this fraction of its climb a rocket is down; the next flight of a log climbs at least by this fraction of the
climb and of its speed, and has at least so many samples. [1]"""
_LOW_FLIGHT, _OTHER_CHANGES = 50.0, 5.0
"""A climb below this height [m] is this many times as high as what is usual in the rest of its log [1]."""

_HOVERS = 10.0
"""How long something stays right below its top that is no rocket, beyond the time of a coast. [s]"""
_BETWEEN_FLIGHTS = 5.0
"""Shortest rest between two flights; shocks make a rocket appear to fall for less. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Times on the log's clock [s], and heights in the log's own reference [m].

    `lift` is None if the log begins in flight; `down` (apogee was passed) is False if it ends before apogee. `pad` and
    `pad_sd` are the level before lift-off; `fastest` is when the climb was fastest.
    """

    lift: float | None
    fastest: float
    top: float
    down: bool
    pad: float
    pad_sd: float
    top_height: float
    calm: Float[Array, "time"]
    """Heights after a running median of about a second. [m]"""
    transonic: bool
    """Whether the apparent climb rate comes near the speed of sound."""
    climbs: float
    """Highest apparent climb rate of the heights. [m/s]"""


def outline(track: Heights) -> Outline | None:
    """Find the flight in a height channel. None if nothing rises like a rocket."""
    time, height = track.time, track.height
    calm = running_median_over(time, height, _TOP_WINDOW, 3, 201)
    top = int(np.argmax(calm))
    from_ = int(np.searchsorted(time, time[top] - LONGEST_CLIMB))
    if top - from_ < 3:
        return None
    climb = np.maximum.accumulate(running_median_over(time, height, _WINDOW, 3, 201)[from_ : top + 1])
    speed = _slope(time[from_ : top + 1], climb, _WINDOW)
    transonic = bool(speed.max() > _TRANSONIC_SPEED)
    least = max(10 * track.noise, 15.0)
    early = (
        _lift(time[from_ : top + 1], climb, speed, int(np.argmax(speed)), least) if not track.is_barometric else None
    )
    if transonic:  # brief shocks make a rocket appear to jump, so a longer window is used
        speed = _slope(time[from_ : top + 1], climb, _TRANSONIC_WINDOW)
    fastest = int(np.argmax(speed))
    lift = _lift(time[from_ : top + 1], climb, speed, fastest, least)
    lift = early if lift is None else lift  # satellites show no shocks: so little of the pad is seen by a short window
    start = from_ + lift if lift is not None else from_
    pad, pad_sd = _pad(track, time[start] if lift is not None else None, float(time[top]))
    gain = calm[top] - (pad if lift is not None or track.zeroed else height[from_])
    if gain < max(LEAST_GAIN, 8 * track.noise) or speed[fastest] < LEAST_SPEED:
        return None
    if gain < _LOW_FLIGHT and not _stands_out(time, calm, (start, top), gain):
        return None
    fall = calm[top] - calm[top:].min()
    down = bool(fall > max(1.5, 4 * track.noise) and time[-1] - time[top] > 2 * median_step(time))
    rises = not down and time[-1] - time[top] < _TOP_WINDOW  # the median does not follow a climb to the end of a log
    return Outline(
        float(time[start]) if lift is not None else None,
        float(time[from_ + fastest]),
        float(time[-1] if rises else time[top]),
        down,
        pad,
        pad_sd,
        float(calm[top]),
        calm,
        transonic,
        float(speed[fastest]),
    )


def _stands_out(time: Float[Array, "_"], calm: Float[Array, "_"], climb: tuple[int, int], gain: float) -> bool:
    """Whether a climb is much more than what heights of the same log change before and after it in as long a time, or
    some seconds: wind and doors move them by meters on the pad. Too few other samples count as quiet."""
    first, top = climb
    low = np.flatnonzero(calm[top:] < calm[top] - (1 - _LANDED_FRACTION) * gain)
    rest = [slice(0, first), slice(top + int(low[0]) if low.size else time.size, time.size)]
    lasts = max(float(time[top] - time[first]), _BETWEEN_FLIGHTS)
    changes = [
        np.abs(np.interp(part[part < part[-1] - lasts] + lasts, part, height) - height[part < part[-1] - lasts])
        for part, height in ((time[one], calm[one]) for one in rest)
        if part.size
    ]
    every = np.concatenate(changes) if changes else np.empty(0)
    return every.size < _MIN_NEXT or gain > _OTHER_CHANGES * float(np.median(every))


def after_hovering(track: Heights, seen: Outline) -> Heights | None:
    """The heights once what rose is down again, if it hovered before its top, as in a vacuum chamber or a drone; None
    for a rocket.

    Derivation: a coast climbs its last meters h in sqrt(2h/g), with drag in less.
    """
    last = max(LEAST_GAIN, 8 * track.noise)
    top = int(np.searchsorted(track.time, seen.top))
    below = np.flatnonzero(seen.calm[:top] < seen.top_height - last)
    there = track.time[below[-1] + 1 : top] if below.size else track.time[:top]
    if not there.size or seen.top - there[0] < _HOVERS + float(np.sqrt(2 * last / GRAVITY)):
        return None
    low = np.flatnonzero(seen.calm[top:] - seen.pad < _LANDED_FRACTION * (seen.top_height - seen.pad))
    rest = slice(top + int(low[0]) if low.size else track.time.size, None)
    return replace(track, time=track.time[rest], height=track.height[rest])


def next_flight(track: Heights, seen: Outline) -> float | None:
    """When the next flight in the same log lifts off, after the rocket is down; None if there is none. [s]"""
    gain = seen.top_height - seen.pad
    after = int(np.searchsorted(track.time, seen.top))
    low = np.minimum.accumulate(seen.calm[after:])
    again = np.flatnonzero(
        (low - seen.pad < _LANDED_FRACTION * gain)
        & (seen.calm[after:] - low > max(LEAST_GAIN, 8 * track.noise, _LEAST_NEXT * gain))
    )
    if not again.size:
        return None
    begin = after + int(np.argmin(seen.calm[after : after + again[0]]))
    end = int(np.searchsorted(track.time, track.time[after + again[0]] + LONGEST_CLIMB))
    rest = replace(track, time=track.time[begin:end], height=track.height[begin:end])
    found = outline(rest) if rest.time.size >= _MIN_NEXT else None
    return found.lift if found is not None and found.climbs > _LEAST_NEXT * seen.climbs else None


def rest_in_climb(track: Heights, seen: Outline) -> float | None:
    """When the last rest on the ground began after a descent shortly before the highest point; None if there is none.

    The descent of an earlier flight would hide the lift-off of the highest one. [s]
    """
    first, top = np.searchsorted(track.time, (seen.top - LONGEST_CLIMB, seen.top))
    time, calm = track.time[first:top], seen.calm[first:top] - seen.pad
    high, least = np.maximum.accumulate(calm), max(LEAST_GAIN, 8 * track.noise)
    down = (high > least) & (calm < _LANDED_FRACTION * high)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], down, [False])).astype(int))).reshape(-1, 2)
    rests = [slice(*edge) for edge in edges.tolist() if np.ptp(time[slice(*edge)]) > _BETWEEN_FLIGHTS]
    if not rests:
        return None
    ground = calm[rests[-1]]
    return float(time[rests[-1]][np.argmax(ground < ground.min() + least)])


def is_similar(other: Outline, seen: Outline) -> bool:
    """Whether another climb of a log is high and fast enough, compared with its flight, to be a flight too."""
    gains = (other.top_height - other.pad, seen.top_height - seen.pad)
    return gains[0] > _LEAST_NEXT * gains[1] and other.climbs > _LEAST_NEXT * seen.climbs


def _slope(time: Float[Array, "_"], height: Float[Array, "_"], window: float) -> Float[Array, "_"]:
    """Speed over the samples of a window to either side [s], at least one. [m/s]"""
    places, reach = np.arange(time.size), np.empty(time.size, np.int64)
    for part, step in stretches(time):
        reach[part] = max(1, round(min(window / step, time.size)))
    before, after = np.maximum(places - reach, 0), np.minimum(places + reach, time.size - 1)
    return np.asarray((height[after] - height[before]) / np.maximum(time[after] - time[before], 1e-9))


def _lift(
    time: Float[Array, "_"], climb: Float[Array, "_"], speed: Float[Array, "_"], fastest: int, least: float
) -> int | None:
    """Index of the last sample before the climb; None if the log begins in the climb.

    Near the speed of sound the air around a rocket can make it appear to stop or fall for a while, so a sample counts
    as quiet only if nothing rose in the ten seconds before it.
    """
    earlier = climb[np.searchsorted(time, time - 10)]
    quiet = (speed < max(0.06 * speed[fastest], 1.0)) & (climb - earlier < least)
    before = np.flatnonzero(quiet[:fastest])
    return int(before[-1]) if before.size and before[-1] >= 1 else None


def _pad(track: Heights, lift: float | None, top: float) -> tuple[float, float]:
    """The pad's height in this channel and its standard deviation, from the log up to lift-off. [m]

    A zero that drifts there continues to drift, and has that error at apogee. If all samples there are one number, or
    two because it is near the step between them, the pad is anywhere within a resolution that hides the noise. Without
    samples at rest on the pad, the pad is the logger's own zero. If the logger does not set a zero and the log begins
    in flight, the standard deviation is infinite.
    """
    if lift is None:
        return _zero_in_flight(track) if track.zeroed else (float(track.height[0]), np.inf)
    before = (track.time < lift - 0.1) & (track.time > lift - 10)
    before = before if before.sum() >= 3 else track.time <= lift
    height = track.height[before]
    level, third = float(np.median(height)), max(1, height.size // 3)
    moves = float(np.median(height[-third:]) - np.median(height[:third])) > 4 * track.noise + 1.0
    if height.size < 3 or moves:
        return (min(level, 0.0), _own_zero(track)) if track.zeroed else (level, 3.0)
    least = _PAD_UNCERTAINTY if float(np.ptp(track.time[before])) < _MIN_PAD_TIME else 0.0
    gusts = [float(np.median(part)) for part in np.array_split(height, _PARTS)] if height.size >= 4 * _PARTS else []
    lag1 = lag_one(height)
    independent = max(height.size * (1 - lag1) / (1 + lag1), 1.0)
    wind_sd = max(float(np.std(gusts or [0.0])) / np.sqrt(_PARTS - 1), WIND_PRESSURE_SD)
    scatter = float(np.hypot(track.noise / np.sqrt(independent), wind_sd))
    one = float(resolution_at(height[:1], track.height)[0]) if np.ptp(height) == 0 else track.held
    coarse = one / float(np.sqrt(12))
    return level, float(np.linalg.norm([scatter, least, coarse, _drift(track, lift) * (top - lift + 5)]))


def _drift(track: Heights, lift: float) -> float:
    """Drift rate of the zero in the minute before lift-off; 0 if not significant. [m/s]

    Carrying the rocket to the pad and setting it up causes jumps and pauses; a drift has one direction throughout.
    """
    before = (track.time < lift - 0.5) & (track.time > lift - 60)
    height, time = track.height[before], track.time[before]
    if height.size < 6 * _PARTS:
        return 0.0
    steps = np.diff([np.median(part) for part in np.array_split(height, _PARTS)])
    sure = abs(steps.sum()) > 4 * track.noise / np.sqrt(height.size / _PARTS)
    is_monotonic = bool((np.sign(steps) == np.sign(steps[0])).all())
    return float(np.median(np.abs(steps)) / (np.ptp(time) / _PARTS)) if sure and is_monotonic else 0.0


def _zero_in_flight(track: Heights) -> tuple[float, float]:
    """The pad's height in a log that begins in the climb, by the logger's own zero, and its standard deviation. [m]

    A logger that was switched on again in flight, or begins when it notices one, sets its zero there: then it shows a
    fast climb at zero. Nothing but the ground where the rocket comes to rest shows the pad then.
    """
    if not _is_fast_at_zero(track):
        return 0.0, _own_zero(track)
    rest = rest_level(track)
    return (float(track.height[0]), np.inf) if rest is None else (rest, TERRAIN_SD)


def _is_fast_at_zero(track: Heights) -> bool:
    """Whether the first heights, as those of an even acceleration, are about zero and climb fast there.

    Derivation: v² - 2 a h, which is zero for heights of a flight from rest at zero.
    """
    first = slice(0, max(_FEWEST_FIRST, int(np.searchsorted(track.time, track.time[0] + _TOP_WINDOW / 2))))
    time, height = track.time[first] - track.time[0], track.height[first]
    if time.size < _FEWEST_FIRST or time[-1] > _TOP_WINDOW:
        return False
    terms = np.column_stack([np.ones(time.size), time, time**2 / 2])
    (start, speed, push), *_ = np.linalg.lstsq(terms, height, rcond=None)
    near = max(_ZERO, 4 * track.noise)
    if not -near < start < near + _LOST_TIME * speed:
        return False
    scatter = max(track.noise, float(np.std(height - terms @ (start, speed, push))))
    errors = scatter * np.sqrt(np.diag(np.linalg.inv(terms.T @ terms)))
    squared = float(speed**2 - 2 * push * start)
    sd = float(np.linalg.norm([2 * speed * errors[1], 2 * push * errors[0], 2 * start * errors[2]]))
    return squared - 3 * sd > _FAST_AT_ZERO**2


def _own_zero(track: Heights) -> float:
    """Standard deviation of a logger's own zero. [m]

    The zero and the ground where the log comes to rest measure the same level equally well, so each is assigned half of
    their difference as its error.
    """
    rest = rest_level(track)
    return _ZERO if rest is None else float(np.hypot(_ZERO, min(abs(rest), _GROUND) / 2))

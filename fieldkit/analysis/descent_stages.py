"""The two speeds of a descent on two devices, a drogue or streamer and then a main, and where the main opened.

Under a device drag balances weight, so the speed is proportional to the inverse square root of the air density (Knacke,
Parachute Recovery Systems Design Manual, 1991, chapter 5). Along the path whose steps are scaled by the square root of
the density ratio, each device descends at one speed, so one device is a straight line in time, and two are a line with
a corner. The two are compared by the Bayesian information criterion (Schwarz, Annals of Statistics 6, 1978).
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.channels import Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Figure
from fieldkit.analysis.robust_statistics import lag_one, mad_sd, median_step
from fieldkit.flight.recovery import OPENING_TIME
from fieldkit.physics.atmosphere import Air
from fieldkit.physics.descent import lag
from fieldkit.physics.standard_atmosphere import GRAVITY, STANDARD_TEMPERATURE
from fieldkit.shapes import Array, Flags, Float, Int, Integers

AIR_SD = 1.0
"""Standard deviation of the vertical speed of the air averaged over part of a descent. [m/s]

In the convective layer of a summer day it is at most 0.63 of a velocity scale of 1 to 2 m/s (Stull, An Introduction to
Boundary Layer Meteorology, 1988, sections 4.2 and 9.6)."""
_LEAST_AREA_RATIO = 2.0
"""Smallest ratio of the drag areas of main and drogue: less is no second device but a reefed or tangled one. [1]"""
_SDS = 3.0
"""Number of standard deviations by which the vertical air does not explain two speeds. [1]"""
_PARTS, _MIN_PART, _MIN_SAMPLES = 60, 1.0, 3
"""Number of parts of a descent whose speeds are compared [1], shortest part [s], and its fewest samples [1]."""
_MIN_PARTS = 3
"""Fewest parts under each device. [1]"""
SLOWEST_DESCENT = 1.5
"""A rocket slower than this is on the ground or in a tree. [m/s]"""
_OPENING_SD = 0.3
"""Standard deviation of the time that a main takes to open. [s]"""
_CORNER_PARTS = 8
"""Number of parts on either side of the corner that locate it. [1]"""
_STANDARD_AIR = Air(np.ones(1), np.array([STANDARD_TEMPERATURE]))
"""The air by which the density falls with height: the fall depends little on the weather."""


@dataclass(frozen=True, slots=True)
class DescentStages:
    """Speeds near the ground under the drogue and under the main [m/s], and the height above the pad at which the main
    was released if it opened in the default time, as in a forecast [m]."""

    drogue: Figure
    main: Figure
    main_altitude: Figure


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """The speed in each part of a descent, along the scaled path [m/s]; times of its middles [s], and the scaled height
    there [m]."""

    time: Float[Array, "part"]
    path: Float[Array, "part"]
    speed: Float[Array, "part"]
    length: float


def descent_stages(track: Heights, seen: Outline, begin: float, end: float | None) -> DescentStages | None:
    """The two speeds of a descent from `begin` to `end` or the end of the log [s]; None if it shows only one.

    Two speeds are reported if the information criterion prefers two, the slower one is later, its device has at least
    twice the drag area, and the vertical motion of the air does not explain the difference.
    """
    parts = _parts(track, seen, begin, end if end is not None else float(track.time[-1]))
    corner = _corner(parts, track.noise) if parts is not None else None
    if parts is None or corner is None:
        return None
    before, after = np.arange(corner), np.arange(corner + 1, parts.speed.size)
    before = before[parts.time[before] > begin + _settling_time(float(np.median(parts.speed[before])))]
    if before.size < _MIN_PARTS:
        return None
    drogue, main = _speed(parts, before, track), _speed(parts, after, track)
    enough = _SDS * np.sqrt(2 * AIR_SD**2 + drogue.sd**2 + main.sd**2)
    if main.value < SLOWEST_DESCENT or drogue.value < max(main.value + enough, _LEAST_AREA_RATIO**0.5 * main.value):
        return None
    return DescentStages(
        drogue, main, _main_altitude(parts, before[-_CORNER_PARTS:], after[:_CORNER_PARTS], track, seen)
    )


def _settling_time(speed: float) -> float:
    """Time after which a body that falls from rest has 96% of its terminal speed [m/s]: tanh 2. [s]"""
    return 2 * speed / GRAVITY


def _parts(track: Heights, seen: Outline, begin: float, end: float) -> _Parts | None:
    """A descent in parts of equal length; None if it is too short. Parts without samples are left out, and
    so is a rest at the end, in a log that shows too little of it to find the landing."""
    length = max(_MIN_PART, _MIN_SAMPLES * median_step(track.time), (end - begin) / _PARTS)
    edges = np.arange(begin, end, length)
    if edges.size < 2 * _MIN_PARTS + 2:
        return None
    path = _STANDARD_AIR.sinking_path(np.interp(edges, track.time, seen.calm) - seen.pad)
    filled = _filled(track, edges)
    middle, height = (edges[1:] + edges[:-1]) / 2, (path[1:] + path[:-1]) / 2
    speed = (-np.diff(path) / length)[filled]
    falls = np.flatnonzero(speed > SLOWEST_DESCENT)
    rests = falls.size > 0 and falls[-1] < speed.size - 1
    last = int(falls[-1]) if rests else speed.size  # it lands in the last part in which it falls
    parts = _Parts(middle[filled][:last], height[filled][:last], speed[:last], float(length))
    return parts if last >= 2 * _MIN_PARTS + 1 else None


def _filled(track: Heights, edges: Float[Array, "edge"]) -> Flags:
    """Which parts between edges have samples near both ends."""
    first, last = np.searchsorted(track.time, (edges[:-1], edges[1:]))
    return np.asarray(last - first >= min(_MIN_SAMPLES - 1, 2))


def _corner(parts: _Parts, noise: float) -> int | None:
    """The part in which the speed changes, if two speeds explain the parts better than one; else None.

    Errors follow a Laplace distribution, so each speed is a median; a part is as good as its errors are independent,
    by their autocorrelation (Bartlett, 1946). Two speeds have two parameters more: a speed and the place of the corner.
    """
    speed, floor = parts.speed, max(noise, 0.1) / parts.length
    places = np.arange(_MIN_PARTS, speed.size - _MIN_PARTS)
    if not places.size:
        return None
    deviations = [
        np.concatenate([speed[:at] - np.median(speed[:at]), speed[at + 1 :] - np.median(speed[at + 1 :])])
        for at in places
    ]
    scales = np.array([np.abs(one).mean() for one in deviations])
    best = int(np.argmin(scales))
    alone = float(np.abs(speed - np.median(speed)).mean())
    together = lag_one(deviations[best])
    independent = max(speed.size * (1 - together) / (1 + together), 2.0)
    gain = 2 * independent * np.log(max(alone, floor) / max(scales[best], floor))
    return int(places[best]) if gain > 2 * np.log(independent) else None


def _speed(parts: _Parts, which: Int[Integers, "_"], track: Heights) -> Figure:
    """Mean of the middle half of the speeds of some parts. Its standard deviation is from their scatter, the noise of
    heights, its distance from the mean of all, which a robust mean leaves open, and a trend beyond their scatter,
    because under one device there is none: evenly distributed speeds differ by their range over sqrt(12). [m/s]"""
    speeds = parts.speed[which]
    together = lag_one(speeds)
    independent = max(speeds.size * (1 - together) / (1 + together), 1.0)
    noise = np.sqrt(2) * track.noise / (parts.length * speeds.size)
    middle = np.sort(speeds)[speeds.size // 4 : speeds.size - speeds.size // 4]
    scatter, off = mad_sd(speeds) / np.sqrt(independent), middle.mean() - speeds.mean()
    since = np.arange(speeds.size) - (speeds.size - 1) / 2
    slope = float(since @ speeds / (since @ since))
    left = float(np.square(speeds - speeds.mean() - slope * since).sum()) / max(speeds.size - 2, 1)
    trend = max(slope**2 - left / float(since @ since), 0.0) * speeds.size**2 / 12
    return Figure(float(middle.mean()), float(np.sqrt(scatter**2 + noise**2 + off**2 + trend)), track.source)


def _main_altitude(
    parts: _Parts, before: Int[Integers, "_"], after: Int[Integers, "_"], track: Heights, seen: Outline
) -> Figure:
    """Height above the pad at which a main was released that opens in the default time, from the corner of two lines
    through the parts before and after it. [m]

    A body that slows from one speed to another reaches the second line as if the speed had changed at a corner that is
    later by the time gained while slowing, `lag`, at the slow speed over the difference of the speeds.
    """
    fast, slow = float(np.median(parts.speed[before])), float(np.median(parts.speed[after]))
    high, low = parts.path[before] + fast * parts.time[before], parts.path[after] + slow * parts.time[after]
    corner = float(np.median(high) - np.median(low)) / (fast - slow)
    slowing = -float(lag(np.array(slow), np.array(fast), np.array(slow))) * slow / (fast - slow)
    earliest, latest = parts.time[before[-1]] - parts.length, parts.time[after[0]]
    released = float(np.clip(corner - slowing - OPENING_TIME, earliest, latest))
    gap = max(float(latest - parts.time[before[-1]]) - 2 * parts.length, 0.0) / np.sqrt(12)
    spread = np.hypot(mad_sd(high) / np.sqrt(high.size), mad_sd(low) / np.sqrt(low.size)) / (fast - slow)
    height = float(np.interp(released, track.time, seen.calm)) - seen.pad
    sd = np.sqrt(fast**2 * (_OPENING_SD**2 + spread**2 + gap**2) + track.noise**2 + seen.pad_sd**2)
    return Figure(height, float(sd), track.source)

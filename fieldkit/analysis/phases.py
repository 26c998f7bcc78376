"""The phases of the flight in a log: pad, rise, top and fall, as robust starting values for the fits."""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.channels import Heights
from fieldkit.analysis.robust_statistics import median_step, running_median
from fieldkit.shapes import Array, Float

LEAST_GAIN = 5.0
"""A rise that is less is no flight. [m]"""
LEAST_SPEED = 5.0
"""A rise that is slower throughout is no flight. [m/s]"""
_MIN_PAD_TIME, _PAD_UNCERTAINTY = 0.15, 0.5
"""A log that begins later than this before lift-off [s] may begin in it, and its pad be off by so much [m]."""
_ZERO, _GROUND = 1.0, 20.0
"""What a logger's own zero drifts by while it waits, and how far from it a landing may be before that is the ground's
doing and not the zero's. [m]"""
_PARTS = 5
"""In so many parts what stands on a pad is looked at, to see gusts and a drift. [1]"""
_TRANSONIC_SPEED, _TRANSONIC_WINDOW = 270.0, 1.0
"""A climb that seems faster than this [m/s] is looked at over so long a time to both sides [s]"""
LONGEST_CLIMB = 120.0
"""From lift-off to apogee, at most. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Times on the log's clock [s], and heights as it has them [m].

    `lift` is None if the log begins in flight, `down` (the top was passed) False if it ends before apogee.
    `pad` and `pad_sd` are the level before lift-off; `fastest` is when the climb was fastest.
    """

    lift: float | None
    fastest: float
    top: float
    down: bool
    pad: float
    pad_sd: float
    top_height: float
    calm: Float[Array, "time"]
    """The heights through a running median of about a second. [m]"""
    transonic: bool
    """Whether the climb seems as fast as to come near the speed of sound."""
    climbs: float
    """How fast the heights seem to climb where they do so fastest. [m/s]"""


def outline(track: Heights) -> Outline | None:
    """The flight in a height channel, or None if nothing rises as a rocket does."""
    time, height = track.time, track.height
    step = median_step(time)
    calm = running_median(height, int(np.clip(1.0 / step, 3, 201)) | 1)
    top = int(np.argmax(calm))
    from_ = int(np.searchsorted(time, time[top] - LONGEST_CLIMB))
    if top - from_ < 3:
        return None
    reach = max(1, round(0.25 / step))
    climb = np.maximum.accumulate(running_median(height, max(3, reach | 1))[from_ : top + 1])
    speed = _slope(time[from_ : top + 1], climb, reach)
    transonic = bool(speed.max() > _TRANSONIC_SPEED)
    if transonic:  # shocks that come and go make a rocket seem to jump: looked at over a longer time
        speed = _slope(time[from_ : top + 1], climb, max(reach, round(_TRANSONIC_WINDOW / step)))
    fastest = int(np.argmax(speed))
    lift = _lift(time[from_ : top + 1], climb, speed, fastest, max(10 * track.noise, 15.0))
    start = from_ + lift if lift is not None else from_
    pad, pad_sd = _pad(track, time[start] if lift is not None else None, float(time[top]))
    gain = calm[top] - (pad if lift is not None or track.zeroed else height[from_])
    if gain < max(LEAST_GAIN, 8 * track.noise) or speed[fastest] < LEAST_SPEED:
        return None
    fall = calm[top] - calm[top:].min()
    down = bool(fall > max(1.5, 4 * track.noise) and time[-1] - time[top] > 2 * step)
    return Outline(
        float(time[start]) if lift is not None else None,
        float(time[from_ + fastest]),
        float(time[top]),
        down,
        pad,
        pad_sd,
        float(calm[top]),
        calm,
        transonic,
        float(speed[fastest]),
    )


def _slope(time: Float[Array, "_"], height: Float[Array, "_"], reach: int) -> Float[Array, "_"]:
    """Speed over `reach` samples to both sides. [m/s]"""
    before = np.maximum(np.arange(time.size) - reach, 0)
    after = np.minimum(np.arange(time.size) + reach, time.size - 1)
    return np.asarray((height[after] - height[before]) / np.maximum(time[after] - time[before], 1e-9))


def _lift(
    time: Float[Array, "_"], climb: Float[Array, "_"], speed: Float[Array, "_"], fastest: int, least: float
) -> int | None:
    """The last sample before the climb that is not part of it; None if the log begins in the climb.

    Near the speed of sound the air around a rocket can make it seem to stand still or to fall for a while; so a
    sample counts as quiet only if nothing rose in the ten seconds before.
    """
    earlier = climb[np.searchsorted(time, time - 10)]
    quiet = (speed < max(0.06 * speed[fastest], 1.0)) & (climb - earlier < least)
    before = np.flatnonzero(quiet[:fastest])
    return int(before[-1]) if before.size and before[-1] >= 1 else None


def _pad(track: Heights, lift: float | None, top: float) -> tuple[float, float]:
    """The pad's height in this channel and its standard deviation: what stands in the log up to lift-off.

    A zero that drifts there continues to drift, and is off by that at the top. Without such samples, or if they rise
    already, it is what the logger took for zero, or for a height that counts from elsewhere nothing: then its standard
    deviation is infinite.
    """
    if lift is None:
        return (0.0, _own_zero(track)) if track.zeroed else (float(track.height[0]), np.inf)
    before = (track.time < lift - 0.1) & (track.time > lift - 10)
    before = before if before.sum() >= 3 else track.time <= lift
    height = track.height[before]
    level, third = float(np.median(height)), max(1, height.size // 3)
    moves = float(np.median(height[-third:]) - np.median(height[:third])) > 4 * track.noise + 1.0
    if height.size < 3 or moves:
        return (min(level, 0.0), _own_zero(track)) if track.zeroed else (level, 3.0)
    least = _PAD_UNCERTAINTY if float(np.ptp(track.time[before])) < _MIN_PAD_TIME else 0.0
    gusts = [float(np.median(part)) for part in np.array_split(height, _PARTS)] if height.size >= 4 * _PARTS else []
    scatter = max(track.noise / np.sqrt(min(height.size, 10)), float(np.std(gusts or [0.0])) / np.sqrt(_PARTS - 1))
    return level, float(np.linalg.norm([scatter, least, _drift(track, lift) * (top - lift + 5)]))


def _drift(track: Heights, lift: float) -> float:
    """How fast the zero drifts in the minute before lift-off; 0 if it does not surely. [m/s]

    What is carried to the pad and set up there jumps and stands still; a drift goes one way all the time.
    """
    before = (track.time < lift - 0.5) & (track.time > lift - 60)
    height, time = track.height[before], track.time[before]
    if height.size < 6 * _PARTS:
        return 0.0
    steps = np.diff([np.median(part) for part in np.array_split(height, _PARTS)])
    sure = abs(steps.sum()) > 4 * track.noise / np.sqrt(height.size / _PARTS)
    steady = bool((np.sign(steps) == np.sign(steps[0])).all())
    return float(np.median(np.abs(steps)) / (np.ptp(time) / _PARTS)) if sure and steady else 0.0


def _own_zero(track: Heights) -> float:
    """How far a logger's own zero may be off, as a standard deviation. [m]

    Of two equally good witnesses of one level, the zero and the ground that the log comes to rest on, each is off by
    half of what they differ.
    """
    last = track.height[track.time > track.time[-1] - 5]
    early, late = np.array_split(last, 2)
    if last.size < 6 or abs(np.median(early) - np.median(late)) > 4 * track.noise + 0.5:
        return _ZERO
    return float(np.hypot(_ZERO, min(abs(float(np.median(last))), _GROUND) / 2))

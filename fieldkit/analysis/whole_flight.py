"""A flight from lift-off to landing for plots: smoothed height, speed and acceleration over time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.records import HeightTrack, Recorded
from fieldkit.analysis.robust_statistics import local_slopes, median_step, running_median
from fieldkit.shapes import Array, Float

_MARGIN = 1.0
"""Time plotted before lift-off and after landing. [s]"""
_POINTS = 200
"""Number of points of the climb, and of the rest of the flight. [1]"""
_WINDOW, _LEAST_STEP = 1.5, 0.05
"""Window over which the slope of the heights is computed, and the smallest time step. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class FlightCurve:
    """Heights above the pad [m], vertical speeds [m/s] and net accelerations [m/s^2], and the events by name [s].

    Times are relative to lift-off, or to the beginning of the log if `from_liftoff` is False. [s]
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    acceleration: Float[Array, "time"]
    events: Mapping[str, float]
    from_liftoff: bool

    def at(self, moment: float) -> tuple[float, float, float]:
        """Height [m], speed [m/s] and acceleration [m/s^2] at a time."""
        channels = (self.height, self.speed, self.acceleration)
        height, speed, acceleration = (float(np.interp(moment, self.time, channel)) for channel in channels)
        return height, speed, acceleration


def flight_curve(recorded: Recorded) -> FlightCurve | None:
    """The whole flight in a log; None if it has no heights.

    The climb is the fitted one; the rest uses the slopes of the heights.
    """
    track, climb = recorded.track, recorded.climb
    if track is None or track.time.size < 3:
        return None
    lift, landed = recorded.events.get("liftoff"), recorded.events.get("landing")
    zero = lift.time if lift else float(track.time[0])
    begin = max(float(track.time[0]), zero - _MARGIN)
    end = min(float(track.time[-1]), landed.time + _MARGIN if landed else np.inf)
    top = float(np.clip(climb.time[-1] if climb else (begin + end) / 2, begin, end))
    time = np.unique(np.concatenate([np.linspace(begin, top, _POINTS), np.linspace(top, end, _POINTS)]))
    channels = _by_heights(track, time)
    if climb is not None:
        inside = (time >= climb.time[0]) & (time <= climb.time[-1])
        fitted = (climb.height, climb.speed, climb.acceleration)
        for channel, known in zip(channels, fitted, strict=True):
            channel[inside] = np.interp(time[inside], climb.time, known)
        channels[1][time < climb.time[0]] = channels[2][time < climb.time[0]] = 0.0
    events = {name: event.time - zero for name, event in recorded.events.items()}
    height, speed, acceleration = channels
    return FlightCurve(time - zero, height, speed, acceleration, events, lift is not None)


def _by_heights(track: HeightTrack, time: Float[Array, "time"]) -> list[Array]:
    """Height, speed and acceleration at given times from the heights only. [m], [m/s], [m/s^2]"""
    step = max(_LEAST_STEP, median_step(track.time))
    even = np.arange(track.time[0], track.time[-1] + step, step)
    height = np.interp(even, track.time, running_median(track.height, 3))
    width = min(max(3, round(_WINDOW / step)) | 1, (even.size - 1) | 1)
    speed = _slope(height, width, step)
    return [np.asarray(np.interp(time, even, one)) for one in (height, speed, _slope(speed, width, step))]


def _slope(values: Float[Array, "even"], width: int, step: float) -> Float[Array, "even"]:
    """Slope of evenly spaced values, with the same length as the values."""
    if values.size < width:
        return np.zeros(values.size)
    found = local_slopes(values, width, step)
    return np.asarray(np.pad(found, (width // 2, values.size - found.size - width // 2), mode="edge"))

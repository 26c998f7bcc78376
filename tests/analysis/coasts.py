"""Simulated coasts with a known drag along time, as samples of a log."""

from collections.abc import Callable

import numpy as np

from fieldkit.analysis.records import Event, HeightTrack, MeasuredClimb, Recorded
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY

SCALE_HEIGHT = 9500.0
BURN, SPEED = 1.2, 70.0


def coast_log(
    drag: Callable[[float], float],
    seed: int,
    *,
    rate: float = 50.0,
    felt: bool = True,
    bias: float = 0.2,
    gain: float = 1.0,
    ports: float = 0.0,
    lag: float = 0.0,
    speed: float = SPEED,
) -> tuple[tuple[Series, ...], Recorded]:
    """Samples of a flight whose drag b [1/m] is a function of the time from lift-off, and its measurement.

    The boost is constant. The accelerometer has a gain, a bias and noise, the heights noise, a pressure error of
    static ports as a fraction of the dynamic pressure, and a first-order lag.
    """
    rng, step = np.random.default_rng(seed), 1e-3
    times = np.arange(-2.0, 30.0, step)
    height, velocity, rows = 0.0, 0.0, []
    for time in times:
        push = 0.0
        if time >= 0:
            thrust = speed / BURN + GRAVITY if time < BURN else 0.0
            push = thrust - drag(time) * np.exp(-height / SCALE_HEIGHT) * velocity * abs(velocity)
            velocity += (push - GRAVITY) * step
            height += velocity * step
        rows.append((height, velocity, push if time >= 0 else GRAVITY))
        if time > BURN and velocity < -3:
            break
    height_, velocity_, push_ = np.array(rows).T
    times = times[: len(rows)]
    seen = height_ - ports * velocity_**2 / (2 * GRAVITY)
    if lag:
        kept = np.exp(-step / lag)
        for row in range(1, len(seen)):
            seen[row] = kept * seen[row - 1] + (1 - kept) * seen[row]
    every = max(1, round(1 / (rate * step)))
    time = times[::every]
    noise = rng.normal(0, 0.3, time.size)
    series = Series(time=time, altitude=seen[::every] + noise)
    if felt:
        own = gain * push_[::every] + bias + rng.normal(0, 0.15, time.size)
        series = Series(time=time, altitude=seen[::every] + noise, felt=own)
    top = float(times[int(np.argmax(height_))])
    flown = (time >= 0) & (time <= top)
    one = np.ones(int(flown.sum()))
    climb = MeasuredClimb(
        time[flown], height_[::every][flown], velocity_[::every][flown], one, push_[::every][flown] - GRAVITY, one,
        time[flown] < BURN, "test",
    )  # fmt: skip
    events = {
        "liftoff": Event(0.0, 0.02, "test"),
        "burnout": Event(BURN, 0.03, "test"),
        "apogee": Event(top, 0.05, "test"),
    }
    track = HeightTrack(time, series.altitude if series.altitude is not None else time, "barometric altitude")
    return (series,), Recorded(events=events, climb=climb, track=track)

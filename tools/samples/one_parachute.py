"""A vertical flight with a constant descent from apogee."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY

ATM = 101_325.0


@dataclass(frozen=True)
class Made:
    """A made-up flight at 200 samples a second: seconds from lift-off, m, m/s, m/s^2 felt along the axis, Pa."""

    time: np.ndarray
    height: np.ndarray
    speed: np.ndarray
    felt: np.ndarray
    pad: float
    apogee: float
    time_to_apogee: float

    def at(self, times: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.interp(times, self.time, values)

    def pressure(self, height: np.ndarray) -> np.ndarray:
        return ATM * (1 - (self.pad + height) / 44_330.77) ** 5.25588


def flight(
    thrust: float = 60.0, burn: float = 1.6, drag: float = 0.0016, descent: float = 9.0, pad: float = 310.0
) -> Made:
    """Boost, coast with drag that grows with the square of speed, and a descent at constant speed."""
    step = 0.005
    height, speed, rows = 0.0, 0.0, []
    time, apogee, top = -2.0, 0.0, 0.0
    while time < 300:
        push = thrust if 0 <= time < burn else 0.0
        deceleration = drag * speed * abs(speed)
        felt = push - deceleration
        if time < 0 or (rows and height <= 0 and time > burn + 1):
            felt = GRAVITY
        rows.append((time, height, speed, felt if speed >= 0 or time < burn else GRAVITY))
        if time > burn + 3 and height <= 0 and time > landed_at(rows):
            break
        if time >= 0:
            if speed < 0 and time > burn:
                speed += (-descent - speed) * step / 0.4
            else:
                speed += (push - deceleration - GRAVITY) * step
            height = max(height + speed * step, 0.0)
            if height == 0 and time > burn:
                speed = 0.0
            if height > apogee:
                apogee, top = height, time + step
        time += step
    columns = np.array(rows).T
    return Made(*columns, pad=pad, apogee=apogee, time_to_apogee=top)


def landed_at(rows: Sequence[tuple[float, float, float, float]]) -> float:
    """Two seconds at rest after landing."""
    return next((row[0] for row in reversed(rows[-420:]) if row[1] > 0), rows[-1][0] - 3) + 2.0

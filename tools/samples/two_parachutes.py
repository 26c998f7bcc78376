"""A vertical flight with a drogue at apogee, a main parachute at 60 m, and rest on the ground."""

from dataclasses import dataclass

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY

STEP = 0.01
"""Time between samples of a flight. [s]"""
PAD = 240.0
"""Elevation of the field. [m]"""


@dataclass(frozen=True)
class Flight:
    """A flight at 100 samples a second: seconds from lift-off, m above the pad, m/s, m/s^2, Pa, AltOS state."""

    time: np.ndarray
    height: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    state: np.ndarray

    @property
    def apogee(self) -> float:
        return float(self.height.max())

    @property
    def pressure(self) -> np.ndarray:
        return air(self.height + PAD)

    def between(self, start: float, stop: float, step: float) -> "Flight":
        """The flight as recorded by a slower device."""
        rows = np.arange(round((start - self.time[0]) / STEP), round((stop - self.time[0]) / STEP), round(step / STEP))
        rows = rows[rows < len(self.time)]
        return Flight(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


def air(height: np.ndarray) -> np.ndarray:
    """Pressure of the standard atmosphere at a height above sea level. [Pa]"""
    return 101325.0 * (1 - 0.0065 * height / 288.15) ** 5.255877


def flight(
    push: float = 75.0, burn: float = 1.1, drag: float = 0.004, drogue: float = 15.0, main: float = 6.0
) -> Flight:
    """A flight with a drogue and a main parachute, whose speeds of descent are given. [m/s^2, s, 1/m, m/s, m/s]"""
    rows: list[tuple[float, float, float, float, int]] = []
    height = speed = 0.0
    landed = None
    for i in range(-300, 20_000):
        time = i * STEP
        under = 0 if time < 0 else 1 if time < burn else 2 if speed > 0 else 3 if height > 60 else 4
        acceleration = [0.0, push - GRAVITY - drag * speed**2, -GRAVITY - drag * speed**2, 0.0, 0.0][under]
        if under >= 3:
            acceleration = (-(drogue if under == 3 else main) - speed) / 0.4
        if landed is not None:
            acceleration, speed, height = 0.0, 0.0, 0.0
        rows.append((time, height, speed, acceleration, 8 if landed and time > landed + 1 else [2, 3, 5, 6, 7][under]))
        speed += acceleration * STEP
        height = max(height + speed * STEP, 0.0)
        if height == 0 and time > burn and landed is None:
            landed = time
        if landed and time > landed + 2:
            break
    return Flight(*np.array(rows).T)

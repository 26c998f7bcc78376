"""A vertical coast with drag and gravity: the shape that heights after burnout are first compared with.

Drag per mass is `k v²`. It decreases with height as the air does, and is 50% greater above the speed of sound, which
is typical of slender rockets. If the true drag differs, the true curve bends slightly away from this one; the fit of
the correction absorbs that.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import copysign, exp

import numpy as np

from fieldkit.analysis.optimize import least_soft_squares
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_STEP = 0.1
SCALE_HEIGHT = 9500.0
"""Scale height of air density in the lower troposphere. [m]"""
_SPEED_OF_SOUND, _TRANSITION = 335.0, 12.0
_MAX_SPEED = 1200.0
_ROUNDS = 25
"""Largest number of fit steps. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class Coast:
    """A coast on evenly spaced times: height above the pad [m], speed [m/s], acceleration [m/s^2]."""

    time: Float[Array, "step"]
    height: Float[Array, "step"]
    speed: Float[Array, "step"]
    acceleration: Float[Array, "step"]


def coast(apogee: float, top: float, drag: float, begin: float, end: float) -> Coast:
    """The coast through an apogee [s], [m] with a drag per mass at the pad [1/m], integrated both ways from apogee.

    In the backward integration the speed is limited to one that no hobby rocket reaches.
    """
    back = _integrated(top, drag, -_STEP, max(0, int((apogee - begin) / _STEP) + 2))
    forth = _integrated(top, drag, _STEP, max(0, int((end - apogee) / _STEP) + 2))
    rows = np.concatenate((back[:0:-1], forth))
    time = np.asarray(apogee + _STEP * (np.arange(len(rows)) - len(back) + 1), float)
    return Coast(time, *rows.T)


@lru_cache(maxsize=16)  # a fit varies one value at a time, and most of them only move the coast in time
def _integrated(top: float, drag: float, step: float, count: int) -> Float[Array, "step three"]:
    """Height, speed and acceleration from apogee on, by the midpoint rule. Shared, so that it must not be changed."""

    def push(height: float, speed: float) -> float:
        fast = abs(speed)
        rise = 1 + 0.5 / (1 + exp((_SPEED_OF_SOUND - fast) / _TRANSITION))
        return -GRAVITY - drag * rise * exp(-height / SCALE_HEIGHT if height > -SCALE_HEIGHT else 1.0) * speed * fast

    height, speed, now = top, 0.0, -GRAVITY
    rows = [(height, speed, now)]
    for _ in range(count):
        middle = speed + now * step / 2
        height += step * middle
        speed += step * push(height - step * middle / 2, middle)
        if not -_MAX_SPEED < speed < _MAX_SPEED:
            speed = copysign(_MAX_SPEED, speed)
        now = push(height, speed)
        rows.append((height, speed, now if abs(speed) < _MAX_SPEED else 0.0))
    return np.array(rows)


def fitted_coast(
    time: Float[Array, "time"], height: Float[Array, "time"], begin: float, burnout: float, end: float
) -> Coast | None:
    """Fit a coast, starting at `begin`, to heights [m] at times [s], from shortly after `burnout` to `end` [s].

    None if too few samples.
    """
    inside = (time > burnout + 0.25) & (time < end + 0.3)
    if inside.sum() < 6:
        return None
    every = max(1, inside.sum() // 300)
    when, where = time[inside][::every], height[inside][::every]
    scale = max(0.003 * float(np.ptp(where)), 0.3)

    def curve(values: Float[Array, "three"], start: float) -> Coast:
        return coast(float(values[0]), float(values[1]), exp(float(values[2])), start, end + 3)

    def misfit(values: Float[Array, "three"]) -> Float[Array, "time"]:
        found = curve(values, float(when[0]))
        return np.asarray((np.interp(when, found.time, found.height) - where) / scale)

    top = int(np.argmax(where))
    start = np.array([when[top], where[top], np.log(1e-3)])
    room = np.array([60.0, 1e4, 5.0])
    steps = np.array([1.0, 10.0, 0.3])
    return curve(least_soft_squares(misfit, start, steps, room, _ROUNDS), begin)

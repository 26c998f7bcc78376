"""A coast against drag and gravity, straight up: the shape that heights after burnout are first compared with.

With the drag k v² per mass the way up is `v = sqrt(g/k) tan(sqrt(g k) (t_apogee - t))`, the way down the same with
tanh, and heights are their integrals (any text on exterior ballistics). Air that thins and drag that depends on
Mach number bend the true curve a little away from it, which is what the fit to the rest is for.
"""

import numpy as np

from fieldkit.shapes import Array, Float
from fieldkit.standard_air import GRAVITY


def coast(time: Float[Array, "time"], apogee: float, drag: float) -> tuple[Array, Array, Array]:
    """Height from apogee [m], speed [m/s] and acceleration [m/s^2] of a coast with a drag per mass [1/m]."""
    ahead = np.sqrt(GRAVITY * drag) * (apogee - time)
    up = np.clip(ahead, 0, 1.45)  # tan has no end to it: further back, the speed stays at what it is there
    down = np.maximum(-ahead, 0)
    height = np.where(ahead > 0, np.log(np.cos(up)), -_log_cosh(down)) / drag
    speed = np.sqrt(GRAVITY / drag) * np.where(ahead > 0, np.tan(up), -np.tanh(down))
    return height, speed, -GRAVITY - drag * speed * np.abs(speed)


def coast_guess(
    knots: Float[Array, "knot"], time: Float[Array, "time"], height: Float[Array, "time"], burnout: float, end: float
) -> tuple[Array, float]:
    """Acceleration of the coast that fits the heights from burnout to `end` best, and its speed at burnout."""
    from scipy.optimize import least_squares

    inside = (time > burnout + 0.25) & (time < end + 0.3)
    flat = np.full(knots.size, -GRAVITY)
    if inside.sum() < 6:
        return flat, GRAVITY * max(end - burnout, 0.0)
    when, where = time[inside], height[inside]
    scale = max(0.01 * np.ptp(where), 0.3)

    def misfit(values: Float[Array, "three"]) -> Float[Array, "time"]:
        return np.asarray((values[0] + coast(when, values[1], np.exp(values[2]))[0] - where) / scale)

    start = np.array([where.max(), when[np.argmax(where)], np.log(1e-3)])
    lower, upper = start - [1e4, 60, 7], start + [1e4, 60, 5]
    found = least_squares(misfit, start, loss="soft_l1", bounds=(lower, upper), max_nfev=60).x
    _, speed, acceleration = coast(knots, found[1], float(np.exp(found[2])))
    return acceleration, float(np.interp(burnout, knots, speed))


def _log_cosh(value: Float[Array, "_"]) -> Float[Array, "_"]:
    return np.asarray(value + np.log1p(np.exp(-2 * value)) - np.log(2))

"""Initial guess of a rocket's acceleration: from its accelerometer, or a coast with drag after a typical thrust.

Derivation: thrust that decreases evenly in the boost, then Newton's second law with drag in proportion to v².
"""

import math
from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.ballistic import Coast
from fieldkit.analysis.channels import Push
from fieldkit.analysis.smooth import Grid
from fieldkit.integrals import running_integral
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

MAX_SENSOR_GAP = 0.3
"""Longest gap in the boost after which an accelerometer is still complete. [s]"""
THRUST_DECREASE = 0.70
"""By how much thrust decreases from the start to the end of a burn, as a fraction of its mean: median over the catalog,
each impulse class weighted equally (a test recomputes it). [1]"""
SHORTEST_BURN = 0.1
"""Shortest burn of a guess. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """Acceleration at the knots, and its integrals. [m/s^2], [m/s], [m]"""

    acceleration: Float[Array, "knot"]
    speed: Float[Array, "knot"]
    height: Float[Array, "knot"]


def lagged(values: Float[Array, "knot"], first: float, step: float, lag: float) -> Float[Array, "knot"]:
    """Values at knots `step` [s] apart as a first-order lag [s] shows them, starting at `first`; in their unit.

    Exact for values that change linearly between knots.
    """
    from scipy.linalg.lapack import dtbtrs  # takes 0.18 s to import

    if lag <= 0:
        return values
    kept = math.exp(-step / lag)
    gained = (1 - kept) * values[:-1] + np.diff(values) * (1 - lag / step * (1 - kept))
    recursion = np.stack([np.ones(values.size), np.full(values.size, -kept)])
    return np.asarray(dtbtrs(recursion, np.concatenate(([first], gained)), uplo="L", diag="U")[0])


def fastest(grid: Grid, guess: Guess, lift: float | None, released: float) -> float:
    """Time at which a guess is fastest between lift-off and release. [s]"""
    inside = (grid.time >= (lift if lift is not None else grid.start)) & (grid.time <= released)
    return float(grid.time[inside][np.argmax(guess.speed[inside])]) if inside.any() else released


def first_guess(
    grid: Grid, coast: Coast | None, push: Push | None, lift: float | None, burnout: float, released: float
) -> tuple[Guess, bool]:
    """An initial acceleration, zero on the pad, and whether it comes from an accelerometer; lift-off, burnout and
    release of the parachute are times [s]."""
    knots = grid.time
    start = lift if lift is not None else knots[0]
    if coast is None:
        guess, top_speed = np.full(knots.size, -GRAVITY), GRAVITY * max(released - burnout, 0.0)
    else:
        guess = np.interp(knots, coast.time, coast.acceleration)
        top_speed = float(np.interp(burnout, coast.time, coast.speed))
    if lift is not None:
        pushed = (knots >= start) & (knots < burnout)
        guess[pushed] = boost(knots[pushed] - start, top_speed, burnout - start)
    fused = False
    if push is not None:
        level = levelled(push, lift)
        inside = (knots >= push.time[0]) & (knots <= push.time[-1]) & (knots < released)
        pushes = push.time[(push.time > start) & (push.time < burnout)]
        if (
            level is not None
            and np.diff(pushes).max(initial=0.0) < MAX_SENSOR_GAP
            and (inside & (knots > start) & (knots < burnout)).sum() > 2
        ):
            total = running_integral(level, push.time)
            gained = np.gradient(np.interp(knots, push.time, total), grid.step)
            inside &= ~_in_silence(knots, push)
            guess[inside] = gained[inside]
            fused = True
    if lift is not None:
        guess[knots < (_last_rest(push, lift) - grid.step if push is not None and fused else lift)] = 0.0
    speed = np.concatenate(([0.0], np.cumsum((guess[1:] + guess[:-1]) / 2))) * grid.step
    rise = speed[:-1] * grid.step + (2 * guess[:-1] + guess[1:]) * grid.step**2 / 6
    return Guess(guess, speed, np.concatenate(([0.0], np.cumsum(rise)))), fused


def _last_rest(push: Push, lift: float) -> float:
    """Time of the last sample of an accelerometer before lift-off: what is felt between that and the next one rises in
    between, on average half of the interval, and belongs to the boost. [s]"""
    return float(push.time[max(int(np.searchsorted(push.time, lift)) - 1, 0)])


def boost(since: Float[Array, "_"], top_speed: float, burn: float) -> Float[Array, "_"]:
    """Typical net acceleration at times since lift-off [s] of a boost to a top speed [m/s] in a burn [s]. [m/s^2]"""
    burn = max(burn, SHORTEST_BURN)
    mean = top_speed / burn
    return np.asarray(mean + THRUST_DECREASE * (mean + GRAVITY) * (0.5 - since / burn))


def _in_silence(knots: Float[Array, "knot"], push: Push) -> Flags:
    """Knots in a gap of the accelerometer, in which interpolation between the samples before and after is not valid."""
    after = np.clip(np.searchsorted(push.time, knots), 1, push.time.size - 1)
    return np.asarray(push.time[after] - push.time[after - 1] > MAX_SENSOR_GAP)


def levelled(push: Push, lift: float | None) -> Float[Array, "time"] | None:
    """Net acceleration with the accelerometer's zero from the pad; None if it is implausible. [m/s^2]"""
    if lift is None:
        return push.felt - GRAVITY
    rest = push.felt[(push.time < lift - 0.1) & (push.time > lift - 10)]
    if rest.size < 3:
        return push.felt - GRAVITY
    level = float(np.median(rest))
    if abs(level - GRAVITY) > 12.0:
        return None
    return push.felt - (level if abs(level - GRAVITY) < 1.5 else GRAVITY)

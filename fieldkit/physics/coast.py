"""The coast: from burnout to apogee, integrated over upward speed.

Upward speed only decreases, so it serves as the independent variable and the last step ends exactly at apogee; no event
search is needed. A vertical coast with drag as the only effect has a closed form in a layer of constant density;
otherwise Runge-Kutta steps are taken.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fieldkit.physics.burn import AscentState
from fieldkit.physics.descent import Devices, filling, opening_time
from fieldkit.physics.forces import EquationsOfMotion
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float

LAYER = 50.0
"""Mean thickness of the layers of constant density in the closed form; those passed at high speed are thicker. [m]"""
LEAST_DRAG = 1e-12
"""Drag per mass and speed squared below which drag counts as zero, so that one formula covers all cases. [1/m]"""
SPEED_STEP = 12.0
"""Longest step of upward speed in the Runge-Kutta integration. [m/s]"""


@dataclass(frozen=True, slots=True)
class Apogee:
    """Apogee, one entry per draw: time, height, and distance and speed downwind and crosswind. SI units.

    `eject_height` is the height at which the ejection charge fired if it fired before apogee, else nan. `cut_short` is
    how much longer the climb would have been without that charge, 0 for one after apogee.
    """

    time: Float[Array, "draw"]
    height: Float[Array, "draw"]
    drift: Float[Array, "draw"]
    across: Float[Array, "draw"]
    sideways: Float[Array, "draw"]
    sideways_across: Float[Array, "draw"]
    eject_height: Float[Array, "draw"]
    eject_speed: Float[Array, "draw"]
    cut_short: Float[Array, "draw"]


@dataclass(frozen=True, slots=True)
class _Point:
    """Time, height, upward speed and acceleration of all draws, downwind and crosswind drift, and the horizontal speed
    in both directions."""

    time: Array
    height: Array
    upward: Array
    acceleration: Array
    drift: Array
    across: Array
    sideways: Array
    sideways_across: Array


def coast(setup: Setup, track: AscentState, eject_time: Float[Array, "draw"], *, timed: bool = True) -> Apogee:
    """The apogee that follows a burn; the charge fires at `eject_time` (nan: never) [s].

    Without `timed`, the time of apogee may be omitted (nan), which is faster.
    """
    fires = np.maximum(eject_time, track.time)
    ever = bool(np.isfinite(fires).any())
    closed = track.position.shape[0] == 1 and not setup.forces and setup.closed_coast
    points = _layers(setup, track, timed=timed or ever) if closed else _steps(setup, track)
    last = next(points)
    charge = [np.full(len(fires), np.nan)] * 2
    passed = [last]
    for point in points:
        if ever:
            charge = _mark(charge, last, point, fires)
            passed.append(point)
        last = point
    early = np.isfinite(charge[0])
    height, time = last.height, last.time
    if early.any():
        chute = parachute(setup)
        opens = fires + opening_time(chute, chute.first, np.where(early, charge[1], 0.0))
        opened = [np.full(len(fires), np.nan)] * 2
        for before, after in pairwise(passed):
            opened = _mark(opened, before, after, opens)
        height, time = _under_parachute(setup, opened, opens, height, time)
    fell = track.velocity[0] <= 0
    if fell.any():
        height = np.where(fell, np.maximum(track.highest, track.position[0]), height)
        time = np.where(fell, track.highest_time, time)
    return Apogee(
        time,
        height,
        last.drift,
        last.across,
        last.sideways,
        last.sideways_across,
        charge[0],
        charge[1],
        np.where(early & ~fell, last.time - time, 0.0),
    )


def _layers(setup: Setup, track: AscentState, *, timed: bool) -> Iterator[_Point]:
    """Closed form, layer by layer: the height gained is ln((v1^2+u^2)/(v2^2+u^2)) u^2/2g at terminal speed u.

    `thin` is 1/u^2 at the density halfway up the layer.

    Source: Fehskens and Malewicki (Malewicki, Model Rocket Altitude Prediction Charts, 1967).
    """
    burns, motor, g = setup.burns, setup.motor, setup.gravity
    mass = setup.dry_mass + burns.casing_mass[motor]
    even = np.maximum((0.5 * setup.drag_area * setup.air.density) / mass, LEAST_DRAG) / g
    time, height, upward = track.time, track.position[0], np.maximum(track.velocity[0], 0.0)
    zero, undefined = np.zeros(len(time)), np.full(len(time), np.nan)
    thin = even * setup.air.density_ratio(height)
    yield _Point(time, height, upward, -g * (1 + thin * upward**2), zero, zero, zero, zero)
    count = _count(np.log1p(thin * upward**2) / (thin * (2 * LAYER * g)))
    decrease = upward / count
    for _ in range(int(count.max())):
        slower = np.maximum(upward - decrease, 0.0)
        total, fall = upward + slower, upward - slower
        squares = total * fall
        middle = height + squares * (0.25 / g) / (1 + 0.25 * thin * total**2)
        thin = even * setup.air.density_ratio(middle)
        height = height + np.log1p(squares * thin / (1 + thin * slower**2)) / thin * (0.5 / g)
        if timed:
            root = np.sqrt(thin)
            time = time + np.arctan(root * fall / (1 + thin * upward * slower)) / (g * root)
            yield _Point(time, height, slower, -g * (1 + thin * slower**2), zero, zero, zero, zero)
        upward = slower
    if not timed:
        yield _Point(undefined, height, upward, undefined, zero, zero, zero, zero)


def _count(wanted: Array) -> Array:
    """Between 2 and 400 layers or steps, chosen separately for each draw so that draws do not influence each other."""
    return np.asarray(np.fmin(np.fmax(np.ceil(wanted), 2.0), 400.0))


def _steps(setup: Setup, track: AscentState) -> Iterator[_Point]:
    """Classical Runge-Kutta in upward speed for time, position and horizontal speed."""
    burns, motor = setup.burns, setup.motor
    acceleration = EquationsOfMotion(setup, burning=False)
    mass = setup.dry_mass + burns.casing_mass[motor]
    upward = np.maximum(track.velocity[0], 0.0)
    axes = len(track.position)
    count = _count(4 + upward / (SPEED_STEP * setup.stride))
    decrease = upward / count

    def look(y: Array, at: Array) -> tuple[Array, Array]:
        """Velocity and acceleration at a point."""
        velocity = np.concatenate([at[None], y[sideways]])
        return velocity, acceleration(y[:axes], velocity, 0.0, mass)

    def rates(velocity: Array, accelerations: Array) -> Array:
        """Derivatives of (position, horizontal velocity, time) with respect to upward speed."""
        return np.asarray(np.concatenate([velocity, accelerations[1:], ones]) / accelerations[0])

    y = np.concatenate([track.position, track.velocity[1:], track.time[None]])
    sideways = slice(axes, 2 * axes - 1)
    zero, ones = np.zeros(len(upward)), np.ones((1, len(upward)))

    def point(y: Array, at: Array, slope: Array) -> _Point:
        if axes == 1:
            return _Point(y[-1], y[0], at, slope, zero, zero, zero, zero)
        if axes == 2:
            return _Point(y[-1], y[0], at, slope, y[1], zero, y[2], zero)
        return _Point(y[-1], y[0], at, slope, y[1], y[2], y[3], y[4])

    velocity, accelerations = look(y, upward)
    yield point(y, upward, accelerations[0])
    for _ in range(int(count.max())):
        after = np.maximum(upward - decrease, 0.0)
        step = after - upward
        half = upward + 0.5 * step
        k1 = rates(velocity, accelerations)
        k2 = rates(*look(y + 0.5 * step * k1, half))
        k3 = rates(*look(y + 0.5 * step * k2, half))
        k4 = rates(*look(y + step * k3, after))
        y, upward = y + step / 6 * (k1 + 2 * (k2 + k3) + k4), after
        velocity, accelerations = look(y, upward)
        yield point(y, upward, accelerations[0])


def _mark(marks: list[Array], before: _Point, after: _Point, moment: Array) -> list[Array]:
    """Height and upward speed at a given time, from the cubic of speed in time between two points."""
    inside = (moment >= before.time) & (moment < after.time)
    if not inside.any():
        return marks
    dt = np.where(inside, after.time - before.time, 1.0)
    s = np.where(inside, (moment - before.time) / dt, 0.0)
    rise, lift0, lift1 = after.upward - before.upward, before.acceleration * dt, after.acceleration * dt
    square, cubic = 3 * rise - 2 * lift0 - lift1, lift0 + lift1 - 2 * rise
    upward = before.upward + s * (lift0 + s * (square + s * cubic))
    gain = dt * s * (before.upward + s * (lift0 / 2 + s * (square / 3 + s * cubic / 4)))
    return [np.where(inside, new, old) for new, old in zip((before.height + gain, upward), marks, strict=True)]


def parachute(setup: Setup) -> Devices:
    """The recovery device that the charge of a setup deploys."""
    mass = setup.dry_mass + setup.burns.casing_mass[setup.motor]
    return Devices(setup.descent_speed, opening=setup.opening_time, filling=filling(mass, setup.air.density))


def _under_parachute(
    setup: Setup, opened: list[Array], opens: Array, height: Array, time: Array
) -> tuple[Array, Array]:
    """Apogee if the parachute opens during the climb: the rocket keeps climbing, slowed by the parachute."""
    climbing = np.isfinite(opened[0])
    thin = setup.air.density_ratio(np.where(climbing, opened[0], 0.0))
    g, terminal = setup.gravity, setup.descent_speed / np.sqrt(thin)
    gain = terminal**2 / (2 * g) * np.log1p((opened[1] / terminal) ** 2)
    stop = terminal / g * np.arctan(opened[1] / terminal)
    return np.where(climbing, opened[0] + gain, height), np.where(climbing, opens + stop, time)

"""Thrust curves on the integrator's steps.

A curve is piecewise linear. Each of its knots ends a step, so thrust is smooth within a step; a segment longer than a
fraction of the burn is split.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, runtime_checkable

import numpy as np

from fieldkit.integrals import running_integral
from fieldkit.shapes import Array, Float

STEPS = 14
"""The longest step is the burn time divided by this number. [1]"""


@dataclass(frozen=True, slots=True)
class Resolution:
    """How finely flights are simulated: `steps` and `knots` of thrust curves as in `burns`, `stride` as in `Setup`."""

    steps: int = STEPS
    knots: int | None = None
    stride: float = 1.0


FORECAST_RESOLUTION = Resolution()
"""The resolution of forecasts."""


@runtime_checkable
class Curve(Protocol):
    """The motor data that the simulator needs."""

    @property
    def time(self) -> Float[Array, "knot"]:
        """Knot times. [s]"""

    @property
    def thrust(self) -> Float[Array, "knot"]:
        """Thrust at the knots. [N]"""

    @property
    def burnout(self) -> float:
        """Time from ignition at which the burn ends and the delay starts. [s]"""

    @property
    def propellant_mass(self) -> float:
        """Propellant mass. [kg]"""

    @property
    def casing_mass(self) -> float:
        """Mass of the motor after burnout. [kg]"""


@dataclass(frozen=True, slots=True)
class Burns:
    """Several motors on the integrator's steps; shorter burns are padded with steps of zero length.

    `thrust` [N] and `spent` (fraction of the propellant burned, [1]) are at the start, middle and end of each step.
    `rise_time` and `rise_thrust` are the knots up to peak thrust, for lift-off. Steps are the first axis, which keeps
    one step of all motors contiguous. `drag` is the ratio of the drag in each step to that after the last step [1],
    None if no motor drops a stage with a different drag.
    """

    thrust: Float[Array, "step 3 motor"]
    edge: Float[Array, "step+1 motor"]
    spent: Float[Array, "step 3 motor"]
    rise_time: Float[Array, "knot motor"]
    rise_thrust: Float[Array, "knot motor"]
    burnout: Float[Array, "motor"]
    propellant_mass: Float[Array, "motor"]
    casing_mass: Float[Array, "motor"]
    drag: Float[Array, "step motor"] | None = None

    @property
    def lengths(self) -> Float[Array, "motor"]:
        """Number of steps in the burn of each motor. [1]"""
        return np.asarray((np.diff(self.edge, axis=0) > 0).sum(axis=0), float)


def _edges(time: Array, steps: int) -> Array:
    """Step edges of one curve: every knot, plus splits between distant knots."""
    gap = np.diff(time)
    pieces = np.ceil(gap / ((time[-1] - time[0]) / steps) - 1e-9).astype(int)
    place = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    starts = np.repeat(time[:-1], pieces) + place * np.repeat(gap / pieces, pieces)
    return np.append(starts, time[-1])


def impulse_until(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], at: Float[Array, "*some"]
) -> Float[Array, "*some"]:
    """Impulse that a curve [s], [N] delivers up to given times within it [s]. [N s]

    Derivation: the trapezoidal rule is exact for a curve of straight lines.
    """
    total = running_integral(thrust, time)
    segment = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    since = at - time[segment]
    slope = np.diff(thrust)[segment] / np.diff(time)[segment]
    return np.asarray(total[segment] + since * (thrust[segment] + 0.5 * slope * since))


def strictly_increasing(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"]
) -> tuple[Float[Array, "knot"], Float[Array, "knot"]]:
    """A curve [s], [N] with simultaneous knots separated by a microsecond: slopes are divided by their distance.

    Derivation: at 1 kN a microsecond is an impulse of 1 mN s.
    """
    time = time.copy()
    for knot in range(1, len(time)):
        time[knot] = max(time[knot], time[knot - 1] + 1e-6)
    return time, thrust


def simplified(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], most: int
) -> tuple[Float[Array, "kept"], Float[Array, "kept"]]:
    """A curve [s], [N] with the same impulse and at most `most` knots: knots whose triangle with their neighbors has
    the smallest area are dropped first.

    Source: Visvalingam and Whyatt, Line generalisation by repeated elimination of points, Cartographic J. 30, 1993.
    """
    at, push = time.tolist(), thrust.tolist()
    before = _area(at, push)

    def triangle(knot: int) -> float:
        over = (push[knot + 1] - push[knot - 1]) * (at[knot] - at[knot - 1]) / (at[knot + 1] - at[knot - 1])
        return float(abs(push[knot] - push[knot - 1] - over) * (at[knot + 1] - at[knot - 1]))

    areas = [0.0, *map(triangle, range(1, len(at) - 1))]
    while len(at) > max(most, 3):
        least = min(range(1, len(areas)), key=areas.__getitem__)
        del at[least], push[least], areas[least]
        for knot in (least - 1, least):
            if 0 < knot < len(areas):
                areas[knot] = triangle(knot)
    return np.array(at), np.array(push) * (before / _area(at, push))


def _area(at: Sequence[float], push: Sequence[float]) -> float:
    """Twice the impulse of a curve. [N s]"""
    pieces = zip(pairwise(at), pairwise(push), strict=True)
    return sum((end - start) * (first + last) for (start, end), (first, last) in pieces)


def _side_by_side(rows: list[Array], fill: float | None = None) -> Array:
    """Stack rows along the last axis; shorter rows are padded with `fill`, or with their last entry if it is None."""
    longest = max(len(row) for row in rows)
    tails = [
        np.broadcast_to(row[-1] if fill is None else np.asarray(fill), (longest - len(row), *row.shape[1:]))
        for row in rows
    ]
    return np.stack([np.concatenate([row, tail]) for row, tail in zip(rows, tails, strict=True)], axis=-1)


def burns(motors: Sequence[Curve], *, steps: int = STEPS, knots: int | None = None, linear_burn: bool = False) -> Burns:
    """The motors on at least `steps` steps each, with curves of at most `knots` knots if given.

    Propellant burns off in proportion to the delivered impulse or, with `linear_burn`, to time.
    """
    rows = []
    for motor in motors:
        time, thrust = strictly_increasing(np.asarray(motor.time, float), np.asarray(motor.thrust, float))
        if knots is not None:
            time, thrust = simplified(time, thrust, knots)
        edge = _edges(time, steps)
        nodes = np.stack([edge[:-1], 0.5 * (edge[:-1] + edge[1:]), edge[1:]], axis=1)
        spent = nodes / time[-1] if linear_burn else impulse_until(time, thrust, nodes)
        spent = spent / spent[-1, -1]
        if (gone := getattr(motor, "spent", None)) is not None:
            spent = np.interp(nodes, motor.time, gone)
        rise = slice(0, int(np.argmax(thrust)) + 1)
        rows.append((edge, np.interp(nodes, time, thrust), spent, time[rise], thrust[rise], _drag(motor, edge)))
    edges, pushes, shares, rise_times, rise_thrusts, drags = (list(values) for values in zip(*rows, strict=True))
    return Burns(
        edge=_side_by_side(edges),
        thrust=_side_by_side(pushes, 0.0),
        spent=_side_by_side(shares, 1.0),
        rise_time=_side_by_side(rise_times),
        rise_thrust=_side_by_side(rise_thrusts),
        burnout=np.array([motor.burnout for motor in motors], float),
        propellant_mass=np.array([motor.propellant_mass for motor in motors], float),
        casing_mass=np.array([motor.casing_mass for motor in motors], float),
        drag=None if all((drag == 1).all() for drag in drags) else _side_by_side(drags),
    )


def _drag(motor: Curve, edge: Array) -> Array:
    """Ratio of the drag in each step of a motor to the drag at the end. [1]"""
    drag = getattr(motor, "drag", None)
    if drag is None:
        return np.ones(len(edge) - 1)
    return np.asarray(drag[np.searchsorted(motor.time, edge[:-1] + 1e-9, side="right") - 1])

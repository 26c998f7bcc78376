"""Thrust curves on the steps of the integrator.

A curve is piecewise linear. The integrator's steps end on its knots: a segment longer than a fraction of
the burn is split, and neighbouring short ones share a step. Inside a step the thrust is the quadratic that
has the curve's own zeroth, first and second moment there (the curve itself where the step is one segment),
so that impulse, and the time at which it is delivered, are exact however few the steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fieldkit.shapes import Array, Float

STEPS = 8
"""The burn is cut into about this many steps."""
_SIMPSON = np.array([[1, -3, 2], [0, 4, -4], [0, -1, 2]], float)
"""Shapes of the quadratic through start, middle and end of a step; column = power of the place in it."""
_GRAM = np.array([[1 / (i + j + 1) for j in range(3)] for i in range(3)])
_FROM_MOMENTS = np.linalg.inv(_SIMPSON @ _GRAM).T


class Curve(Protocol):
    """What the simulator needs to know of a motor."""

    @property
    def time(self) -> Array:
        """Knots. [s]"""

    @property
    def thrust(self) -> Array:
        """At the knots. [N]"""

    @property
    def burn_time(self) -> float:
        """From ignition to burnout, where the delay begins. [s]"""

    @property
    def propellant_mass(self) -> float:
        """Burnt in flight. [kg]"""

    @property
    def casing_mass(self) -> float:
        """What stays of the motor. [kg]"""


@dataclass(frozen=True, slots=True)
class Burns:
    """Several motors on the integrator's steps; shorter burns end in steps of no length.

    `thrust` [N] and `spent` (share of the propellant burnt, [1]) stand at start, middle and end of each
    step; `knot_thrust` is the curve itself at the edges. Rows are steps first, so that one step of all
    motors lies together.
    """

    edge: Float[Array, "step+1 motor"]
    thrust: Float[Array, "step 3 motor"]
    spent: Float[Array, "step 3 motor"]
    knot_thrust: Float[Array, "step+1 motor"]
    burn_time: Float[Array, "motor"]
    propellant_mass: Float[Array, "motor"]
    casing_mass: Float[Array, "motor"]


def _edges(time: Array, thrust: Array, steps: int) -> Array:
    """Step edges of one curve: its first, highest and last knot, and knots or splits between."""
    longest = (time[-1] - time[0]) / steps
    kept = [0]
    highest = int(np.argmax(thrust))
    for knot in range(1, len(time)):
        last_chance = knot == len(time) - 1 or time[knot + 1] - time[kept[-1]] > longest
        if knot == highest or last_chance:
            kept.append(knot)
    knots = time[kept]
    pieces = [
        np.linspace(a, b, int(np.ceil((b - a) / longest - 1e-9)) + 1)[1:]
        for a, b in zip(knots[:-1], knots[1:], strict=True)
    ]
    return np.concatenate([time[:1], *pieces])


def _quadratic(time: Array, thrust: Array, start: float, end: float) -> Array:
    """Start, middle and end of the quadratic with the curve's first three moments in a step. [N]"""
    inside = (time > start) & (time < end)
    t = np.concatenate([[start], time[inside], [end]])
    f = np.interp(t, time, thrust)
    s, width = (t - start) / (end - start), np.diff(t) / (end - start)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    u = 0.5 * (nodes + 1)
    place = s[:-1, None] + width[:, None] * u
    value = f[:-1, None] + np.diff(f)[:, None] * u
    share = 0.5 * weights * width[:, None]
    moments = np.array([(value * place**power * share).sum() for power in range(3)])
    return np.asarray(_FROM_MOMENTS @ moments)


def _impulse(time: Array, thrust: Array, at: Array) -> Array:
    """Impulse delivered by some moments. [N s]"""
    total = np.concatenate([[0], np.cumsum(np.diff(time) * 0.5 * (thrust[1:] + thrust[:-1]))])
    segment = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    since = at - time[segment]
    slope = np.diff(thrust)[segment] / np.diff(time)[segment]
    return np.asarray(total[segment] + since * (thrust[segment] + 0.5 * slope * since))


def _strictly_increasing(time: Array, thrust: Array) -> tuple[Array, Array]:
    """The curve with knots at the same moment pulled apart by a microsecond."""
    time = time.copy()
    for knot in range(1, len(time)):
        time[knot] = max(time[knot], time[knot - 1] + 1e-6)
    return time, thrust


def burns(motors: Sequence[Curve], *, steps: int = STEPS, linear_burn: bool = False) -> Burns:
    """The motors on about `steps` steps each.

    Propellant burns off in proportion to the impulse delivered or, with `linear_burn`, to time.
    """
    rows = []
    for motor in motors:
        time, thrust = _strictly_increasing(np.asarray(motor.time, float), np.asarray(motor.thrust, float))
        edge = _edges(time, thrust, steps)
        nodes = np.stack([edge[:-1], 0.5 * (edge[:-1] + edge[1:]), edge[1:]], axis=1)
        spent = nodes / time[-1] if linear_burn else _impulse(time, thrust, nodes)
        spent = spent / spent[-1, -1]
        shape = np.stack([_quadratic(time, thrust, a, b) for a, b in zip(edge[:-1], edge[1:], strict=True)])
        rows.append((edge, shape, spent, np.interp(edge, time, thrust)))
    longest = max(len(edge) for edge, *_ in rows)

    def padded(values: Array, fill: float) -> Array:
        return np.concatenate([values, np.full((longest - len(values), *values.shape[1:]), fill)])

    return Burns(
        edge=np.stack([np.pad(e, (0, longest - len(e)), mode="edge") for e, *_ in rows], axis=-1),
        thrust=np.stack([padded(shape, 0.0)[: longest - 1] for _, shape, *_ in rows], axis=-1),
        spent=np.stack([padded(spent, 1.0)[: longest - 1] for *_, spent, _ in rows], axis=-1),
        knot_thrust=np.stack([padded(knot, 0.0) for *_, knot in rows], axis=-1),
        burn_time=np.array([motor.burn_time for motor in motors], float),
        propellant_mass=np.array([motor.propellant_mass for motor in motors], float),
        casing_mass=np.array([motor.casing_mass for motor in motors], float),
    )

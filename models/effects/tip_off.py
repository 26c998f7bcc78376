"""Tip-off: off a slow rail the rocket turns aside before its fins hold it, the more the slower it leaves.

What turns it (gravity, a crosswind on the part that is free of the rail) acts for the time it takes to leave, and its
fins right it with a moment that goes with the square of the speed; so the angle falls with the square of the speed.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.flight import Flight
from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.rail import rail_exit_speed
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float

REFERENCE_SPEED = 15.0
"""Speed off the rail that the strength is stated at, a usual least speed for model rockets. [m/s]"""
MAX_ANGLE = 60.0
"""Limit of the angle, for rockets that hardly leave. [deg]"""


def setup(setup: Setup, strength: Float[Array, "*draw flight"], flights: Sequence[Flight]) -> Setup:
    """The path off the rail, inclined by this angle at the reference speed, at right angles to a recorded launch
    angle, to the same side."""
    slower = (REFERENCE_SPEED / np.maximum(rail_exit_speed(setup), 1.0)) ** 2
    angle = np.minimum(strength * slower, MAX_ANGLE)
    steeper = np.hypot(setup.rail_angle, np.radians(angle))
    return setup.with_changes(rail_angle=np.where(setup.rail_angle < 0, -steeper, steeper))


EFFECT = Effect(
    title="tip-off",
    family="launch",
    explains="the rocket leaves the rail slowly and turns, most with heavy loads and weak motors",
    unit="deg at 15 m/s off the rail",
    prior=Prior(mean=60.0, sd=80.0, low=0.0, high=900.0),
    source="Mandell, Caporaso and Bengen, Topics in Advanced Model Rocketry (1973), launch of unguided rockets",
    tell_apart="fly the same rocket from a longer rail or on a motor with more initial thrust",
    setup=setup,
    squared=True,
)

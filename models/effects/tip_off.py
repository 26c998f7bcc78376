"""Tip-off: a rocket that leaves the rail slowly turns before its fins stabilize it, more so the slower it leaves.

The disturbance (gravity, or a crosswind on the part that is off the rail) lasts for the time the rocket takes to leave,
and the restoring moment of the fins grows with the square of the speed, so the angle falls with the square of the
speed.
"""

import numpy as np

from fieldkit.messages import amount, message
from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.rail import rail_exit_speed
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float

REFERENCE_SPEED = 15.0
"""Speed off the rail for which the strength is given, a usual minimum for model rockets. [m/s]"""
MAX_ANGLE = 60.0
"""Upper limit of the angle, for rockets that barely leave the rail. [deg]"""


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Turns the path off the rail by this angle at the reference speed, always to the same side, perpendicular to a
    recorded launch angle. [deg]"""
    slower = (REFERENCE_SPEED / np.maximum(rail_exit_speed(setup), 1.0)) ** 2
    angle = np.minimum(strength * slower, MAX_ANGLE)
    steeper = np.hypot(setup.rail_angle, np.radians(angle))
    return setup.with_changes(rail_angle=np.where(setup.rail_angle < 0, -steeper, steeper))


EFFECT = Effect(
    title="tip-off",
    family="launch",
    explains="the rocket leaves the rail slowly and turns, most with heavy loads and weak motors",
    unit=message(f"deg at {amount(REFERENCE_SPEED, 'm/s')} off the rail"),
    prior=Prior(mean=60.0, sd=80.0, low=0.0, high=900.0),
    source="Mandell, Caporaso and Bengen, Topics in Advanced Model Rocketry (1973), launch of unguided rockets",
    tell_apart="fly the same rocket from a longer rail or on a motor with more initial thrust",
    setup=setup,
    squared=True,
)

"""Launch angle: the rail is off vertical, and nobody recorded it."""

import numpy as np

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Adds this launch angle perpendicular to the recorded one. [deg]"""
    angle = np.hypot(setup.rail_angle, np.radians(strength))
    return setup.with_changes(rail_angle=np.where(setup.rail_angle < 0, -angle, angle))


EFFECT = Effect(
    title="a rail off vertical",
    family="launch",
    explains="the rocket leaves the pad at an angle from vertical, so part of its speed is spent sideways",
    unit="deg",
    prior=Prior(mean=60.0, sd=80.0, low=0.0, high=900.0),
    source="projection of thrust and speed; angle from vertical",
    tell_apart="measure the rail's angle, or fly once with the rail vertical",
    setup=setup,
    per="site",
    squared=True,
    measured=4.0,
    says=(
        "{where} leaves the rail about {amount} off vertical",
        "{where} leaves the rail about {amount} off vertical",
    ),
)

"""Rail friction: buttons or lugs bind and slow the rocket on the rail."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Slows the rocket by this acceleration until it leaves the rail. [m/s^2]"""
    return setup.with_changes(rail_friction=setup.rail_friction + strength)


EFFECT = Effect(
    title="friction on the rail",
    family="launch",
    explains="the rail or rod holds the rocket back until it leaves",
    unit="m/s^2",
    prior=Prior(mean=15.0, sd=15.0, low=0.0, high=120.0),
    source="Coulomb friction of a side load, an acceleration of the order of g",
    tell_apart="polish or replace the rail and fly the same motor again",
    setup=setup,
)

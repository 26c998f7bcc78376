"""Mass offset: a configuration is heavier or lighter than its recorded mass."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases the dry mass by this fraction."""
    return setup.with_changes(dry_mass=setup.dry_mass * (1 + strength))


EFFECT = Effect(
    title="a wrong mass",
    family="mass",
    explains="the rocket weighs more or less than the mass entered",
    unit="fraction of the dry mass",
    prior=Prior(mean=0.0, sd=0.09, low=-0.5, high=0.6),
    source="weighing without payload, recovery or ballast is a common mistake",
    tell_apart="weigh the rocket again, ready to fly but without the motor",
    setup=setup,
    per="config",
    measured=0.005,
    says=(
        "{where} is about {amount} lighter than entered",
        "{where} is about {amount} heavier than entered",
    ),
)

"""Motor thrust: a motor type or a whole lot has more or less thrust than its certificate."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases thrust and impulse by this fraction."""
    return setup.with_changes(thrust_factor=setup.thrust_factor * (1 + strength))


EFFECT = Effect(
    title="a weak or strong motor",
    family="motor",
    explains="this motor delivers less or more thrust and impulse than certified",
    unit="fraction of the thrust",
    prior=Prior(mean=0.0, sd=0.09, low=-0.5, high=0.5),
    source="mean impulse may differ from the certified one; single motors scatter with an sd of up to 6.7% (NFPA 1125)",
    tell_apart="fly a motor from another lot, or record top speed and peak acceleration",
    setup=setup,
    per="motor",
    starts_anywhere=True,
    quantity="thrust",
    shared_by=("motor_type", "lot"),
    says=(
        "{where} delivers about {amount} less thrust than certified",
        "{where} delivers about {amount} more thrust than certified",
    ),
)

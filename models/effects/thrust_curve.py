"""Thrust curve: the motor delivers the same impulse over a longer or shorter burn than its certificate."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Lengthens the burn by this fraction at the same impulse."""
    return setup.with_changes(burn_stretch=setup.burn_stretch * (1 + strength))


EFFECT = Effect(
    title="a different thrust curve",
    family="motor",
    explains="this motor delivers its impulse over a longer or shorter burn than its certified curve",
    unit="fraction of the burn time",
    prior=Prior(mean=0.0, sd=0.25, low=-0.7, high=1.5),
    source="curves of one motor differ between certifications, temperatures and nozzles (ThrustCurve.org)",
    tell_apart="record burn time and peak acceleration",
    setup=setup,
    per="motor",
    quantity="stretch",
    shared_by=("motor_type", "lot"),
    says=(
        "{where} burns about {amount} shorter than certified",
        "{where} burns about {amount} longer than certified",
    ),
)

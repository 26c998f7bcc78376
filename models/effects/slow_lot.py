"""Slow lot: from some flight on, motors of another lot burn longer at the same impulse."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Lengthens the burn by this fraction at the same impulse."""
    return setup.with_changes(burn_stretch=setup.burn_stretch * (1 + strength))


EFFECT = Effect(
    title="a motor lot that burns longer",
    family="motor",
    explains="from some flight on this motor ignites more slowly and burns longer, as another lot may",
    unit="fraction of the burn time",
    prior=Prior(mean=0.15, sd=0.12, low=0.0, high=1.0),
    source="NFPA 1125 allows average thrust to differ by 20%, which at the same impulse changes the burn time",
    tell_apart="record burn time and peak acceleration, and write down the lot",
    setup=setup,
    per="motor",
    form_of="thrust_curve",
    starts_anywhere=True,
    from_first=False,
    says=(
        "{where} burns about {amount} shorter than certified",
        "{where} burns about {amount} longer than certified",
    ),
)

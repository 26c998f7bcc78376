"""Wear: dents, scratches and loose fins make drag grow flight by flight."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases drag by this fraction."""
    return setup.with_changes(drag_area=setup.drag_area * (1 + strength))


EFFECT = Effect(
    title="wear",
    family="aging",
    explains="drag grows from flight to flight as finish and fins wear",
    unit="fraction of Cd per flight",
    prior=Prior(mean=0.02, sd=0.02, low=0.0, high=0.2),
    source="a rough finish alone adds a tenth to a third of Cd (Hoerner, Fluid-Dynamic Drag, 1965)",
    tell_apart="repair and polish the rocket and fly the same motor again",
    setup=setup,
    grows=True,
    says=(
        "{where} loses about {amount} of its drag with every flight",
        "{where} gains about {amount} of drag with every flight",
    ),
)

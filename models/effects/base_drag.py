"""Base drag: with the plume gone, the wake behind the rocket adds drag.

Every rocket has some of it: the base accounts for an eighth to a fifth of Cd, and the plume fills a tenth to all of it.
"""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases the drag in the coast by this fraction."""
    return setup.with_changes(power_off_drag=setup.power_off_drag * (1 + strength))


EFFECT = Effect(
    title="base drag",
    family="drag",
    explains="drag is higher in the coast than under power, because the plume no longer fills the wake",
    unit="fraction of Cd",
    prior=Prior(mean=0.1, sd=0.12, low=-0.4, high=1.0),
    source="Hoerner, Fluid-Dynamic Drag (1965), chapter 3; power-on and power-off Cd differ by 5 to 20%",
    tell_apart="record top speed and coast time on a long-burning and a short-burning motor",
    setup=setup,
    background=Prior(mean=0.08, sd=0.05),
    says=(
        "{where} has about {amount} less drag in the coast than under power",
        "{where} has about {amount} more drag in the coast than under power",
    ),
)

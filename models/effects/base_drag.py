"""Base drag: with the plume gone, the wake behind the rocket pulls harder."""

import numpy as np

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import State
from fieldkit.shapes import Array, Float


def acceleration(state: State, strength: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Drag in the coast, more by this share than under power."""
    return np.zeros_like(state.drag) if state.burning else np.asarray(-strength * state.drag)


EFFECT = Effect(
    title="base drag",
    family="drag",
    explains="drag is higher in the coast than under power, because the plume no longer fills the wake",
    unit="fraction of Cd",
    prior=Prior(mean=0.1, sd=0.12, low=-0.4, high=1.0),
    source="Hoerner, Fluid-Dynamic Drag (1965), chapter 3; power-on and power-off Cd differ by 5 to 20 %",
    tell_apart="record top speed and coast time on a long-burning and a short-burning motor",
    acceleration=acceleration,
)

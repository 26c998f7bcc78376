"""Mach drag: drag rises toward the speed of sound."""

import numpy as np

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.forces import smooth_step
from fieldkit.physics.state import State
from fieldkit.shapes import Array, Float

ONSET_MACH = 0.6
"""Mach number at which the rise starts. [1]"""
FULL_MACH = 1.05
"""Mach number at which the rise is complete. [1]"""


def acceleration(state: State, strength: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Increases drag gradually from `ONSET_MACH`, by this fraction from `FULL_MACH` on. [m/s^2]"""
    mach = state.speed / state.air.sound_speed(state.height)
    return np.asarray(-strength * smooth_step((mach - ONSET_MACH) / (FULL_MACH - ONSET_MACH)) * state.drag)


EFFECT = Effect(
    title="drag rise near the speed of sound",
    family="drag",
    explains="fast flights have more drag than slow ones, because Cd rises toward Mach 1",
    unit="fraction of Cd added at Mach 1.05",
    prior=Prior(mean=0.5, sd=0.5, low=0.0, high=3.0),
    source="Hoerner, Fluid-Dynamic Drag (1965), chapter 16: drag of slender bodies doubles through Mach 1",
    tell_apart="fly a slower motor of the same diameter",
    acceleration=acceleration,
)

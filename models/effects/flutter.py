"""Flutter: vibrating fins or flow separation add drag that grows with speed."""

import numpy as np

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import State
from fieldkit.shapes import Array, Float

ONSET_MACH = 0.3
"""Mach number at which the added drag starts. [1]"""


def acceleration(state: State, strength: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Increases drag in proportion to the speed above `ONSET_MACH`, by this fraction at twice that speed. [m/s^2]"""
    mach = state.speed / state.air.sound_speed(state.height)
    return np.asarray(-strength * np.maximum(mach / ONSET_MACH - 1, 0.0) * state.drag)


EFFECT = Effect(
    title="drag that grows with speed",
    family="drag",
    explains="drag grows with speed above a third of the speed of sound, as when fins flutter",
    unit="fraction of Cd added at Mach 0.6",
    prior=Prior(mean=0.3, sd=0.3, low=0.0, high=3.0),
    source="flutter of thin fins starts well below Mach 1 (Martin, NACA TN 4197, 1958); its drag is a judgment",
    tell_apart="fly a slower motor, or stiffen the fins and fly the same motor again",
    acceleration=acceleration,
)

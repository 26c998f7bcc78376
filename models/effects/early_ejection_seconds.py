"""Early ejection in seconds: delays drilled shorter by the same time, whatever their rating."""

import numpy as np

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Shortens the delay by this time, down to zero. [s]"""
    return setup.with_changes(delay=np.maximum(setup.delay - strength, 0.0))


EFFECT = Effect(
    title="ejection a few seconds early",
    family="recovery",
    explains="the ejection charge fires a few seconds early and the parachute ends the climb",
    unit="s",
    prior=Prior(mean=1.5, sd=1.0, low=0.4, high=8.0),
    source="delays of certified motors vary by up to 20% or 1.5 s, whichever is more, at most 3 s (NFPA 1125); "
    "adjustable ones are drilled in seconds",
    tell_apart="record apogee to ejection, or fly motors with a short and with a long delay",
    setup=setup,
    per="motor",
    needs_delay=True,
    form_of="early_ejection",
    starts=(0.5, 1.2, 2.5, 4.0),
    says=(
        "The charge fires about {amount} late",
        "The charge fires about {amount} early",
    ),
)

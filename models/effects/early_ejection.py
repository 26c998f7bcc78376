"""Early ejection: the delay is shorter than its rating, and the parachute opens on the way up.

Motors ordinarily scatter by a tenth of the delay; this effect is larger.
"""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Shortens the delay by this fraction."""
    return setup.with_changes(delay=setup.delay * (1 - strength))


EFFECT = Effect(
    title="early ejection",
    family="recovery",
    explains="the ejection charge fires before apogee and the parachute ends the climb",
    unit="fraction of the rated delay",
    prior=Prior(mean=0.3, sd=0.2, low=0.1, high=0.9),
    source="delays of certified motors vary by up to 20% or 1.5 s, whichever is more, at most 3 s (NFPA 1125)",
    tell_apart="record apogee to ejection, or fly the same motor with a longer delay",
    setup=setup,
    per="motor",
    needs_delay=True,
    starts=(0.12, 0.25, 0.45, 0.65),
    says=(
        "The charge fires about {amount} of its delay late",
        "The charge fires about {amount} of its delay early",
    ),
)

"""Wind: after leaving the rail, a stable rocket turns into the relative wind and climbs at an angle.

The rocket is a point mass whose axis follows the relative wind. The strength scales the wind that it follows: at 1 the
rocket turns fully and immediately, at 0 not at all.
"""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Scales the recorded wind by how strongly the rocket turns into it."""
    return setup.with_changes(wind=strength * setup.recorded_wind)


EFFECT = Effect(
    title="weathercocking in the wind",
    family="path",
    explains="off the rail the rocket turns into the wind and flies a slanted, lower path",
    unit="fraction of full weathercocking",
    prior=Prior(mean=0.5, sd=0.7, low=0.0, high=6.0),
    source="Mandell, Caporaso and Bengen, Topics in Advanced Model Rocketry (1973), dynamic stability",
    tell_apart="fly the same motor once in calm air and once in wind, and record the wind",
    setup=setup,
    needs="wind",
    declared=True,
    squared=True,
)

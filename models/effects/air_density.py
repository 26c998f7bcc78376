"""Air density: the air is thinner or denser than expected from what was recorded, as at a higher site or in heat."""

from dataclasses import replace

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases the air density at the pad by this fraction."""
    return setup.with_changes(air=replace(setup.air, density=setup.air.density * (1 + strength)))


EFFECT = Effect(
    title="wrong air density",
    family="air",
    explains="the air at a site is thinner or denser than recorded, so drag is lower or higher",
    unit="fraction of the density",
    prior=Prior(mean=0.0, sd=0.12, low=-0.45, high=0.4),
    source="U.S. Standard Atmosphere 1976: a tenth less density per 1,000 m (3,300 ft) or 28 K (50 °F)",
    tell_apart="record the site's elevation, the temperature, and the pressure",
    setup=setup,
    per="site",
    everywhere=False,
    measured=0.01,
    quantity="drag",
    shared_by=("day", "site"),
    says=(
        "The air is about {amount} thinner than recorded",
        "The air is about {amount} denser than recorded",
    ),
)

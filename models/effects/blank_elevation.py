"""Blank elevation: a field whose elevation nobody wrote down, and which lies somewhere above the sea.

The plain model takes it for sea level. Half of mankind lives below 194 m (Cohen and Small, Hypsographic demography,
PNAS 95, 1998); fields of rocketry clubs reach from there to 2,700 m.
"""

from collections.abc import Sequence

from fieldkit.flight import Flight
from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.setups import at_elevation
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"], flights: Sequence[Flight]) -> Setup:
    """The air of a pad this much higher, and what an altimeter makes of it. [m]"""
    return at_elevation(setup, strength, flights)


EFFECT = Effect(
    title="a site of unknown elevation",
    family="air",
    explains="a site whose elevation is blank lies well above the sea, so its air is thinner",
    unit="m",
    prior=Prior(mean=600.0, sd=700.0, low=0.0, high=4000.0),
    source="Cohen and Small, Hypsographic demography, PNAS 95 (1998); U.S. Standard Atmosphere 1976",
    tell_apart="record the site's elevation",
    setup=setup,
    per="site",
    everywhere=False,
    lacks="site_elevation",
    form_of="air_density",
    measured=10.0,
)

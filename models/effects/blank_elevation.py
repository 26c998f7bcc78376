"""Blank elevation: the elevation of the field is not recorded and is above sea level.

The plain model assumes sea level. Half of the world's population lives below 194 m (Cohen and Small, Hypsographic
demography, PNAS 95, 1998); the fields of rocketry clubs range from sea level to 2,700 m.
"""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.setups import at_elevation

EFFECT = Effect(
    title="a site of unknown elevation",
    family="air",
    explains="a site whose elevation is blank lies well above the sea, so its air is thinner",
    unit="m",
    prior=Prior(mean=600.0, sd=700.0, low=0.0, high=4000.0),
    source="Cohen and Small, Hypsographic demography, PNAS 95 (1998); U.S. Standard Atmosphere 1976",
    tell_apart="record the site's elevation",
    setup=at_elevation,
    per="site",
    everywhere=False,
    lacks="site_elevation",
    form_of="air_density",
    measured=10.0,
)

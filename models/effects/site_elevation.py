"""Site elevation: a field that lies higher or lower than was written down, and the air and the altimeter that go
with it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.physics.atmosphere import pad_air, standard_temperature
from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.setups import recorded
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"], flights: Sequence[Flight]) -> Setup:
    """The air of a pad this much higher [m]: less pressure, and colder where no temperature was written down.

    An altimeter takes the air for standard at the pressure it feels, which is colder the higher the pad; where
    the temperature was written down it is true, and heights are shown the lower.
    """
    coolness = standard_temperature(strength) / standard_temperature(np.zeros(()))
    thinness = _density(strength) / _density(np.zeros(()))
    known = np.isfinite(recorded(flights, "temperature")) if flights else np.asarray(False)
    density = setup.air.density * thinness * np.where(known, coolness, 1.0)
    air = replace(setup.air, density=density, temperature=setup.air.temperature * np.where(known, 1.0, coolness))
    return setup.with_changes(air=air, altimeter_gain=setup.altimeter_gain * np.where(known, coolness, 1.0))


def _density(elevation: Float[Array, "*draw flight"]) -> Float[Array, "*draw flight"]:
    """Of the standard air at a height above sea level. [kg/m^3]"""
    unknown = np.full((), np.nan)
    return pad_air(elevation, unknown, unknown, unknown).density


EFFECT = Effect(
    title="a higher or lower site",
    family="air",
    explains="a site is higher or lower than recorded, so its air is thinner or denser",
    unit="m",
    prior=Prior(mean=0.0, sd=1200.0, low=-3000.0, high=5000.0),
    source="U.S. Standard Atmosphere 1976: a tenth less density per 1,000 m",
    tell_apart="record the site's elevation",
    setup=setup,
    per="site",
    everywhere=False,
    form_of="air_density",
    measured=10.0,
)

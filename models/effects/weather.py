"""Weather: days hotter or colder than the standard air that is assumed if no temperature is recorded.

Hot air is less dense, so the rocket flies higher; a barometric altimeter also reads low by the same fraction.
"""

from dataclasses import replace

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Makes the air at the pad warmer by this temperature and adjusts the reading of an altimeter that assumes standard
    air. [K]
    """
    temperature = setup.air.temperature + strength
    ratio = setup.air.temperature / temperature
    air = replace(setup.air, density=setup.air.density * ratio, temperature=temperature)
    return setup.with_changes(air=air, altimeter_gain=setup.altimeter_gain * ratio)


EFFECT = Effect(
    title="hot and cold days",
    family="air",
    explains="days were hotter or colder than assumed, which changes both drag and the altimeter reading",
    unit="K",
    prior=Prior(mean=0.0, sd=12.0, low=-45.0, high=45.0),
    source="U.S. Standard Atmosphere 1976 and the ideal gas: 0.35% of density and of the reading per kelvin",
    tell_apart="record the temperature at the pad",
    setup=setup,
    per="day",
    everywhere=False,
    each=True,
    lacks="temperature",
    form_of="air_density",
)

"""Altimeter temperature: the device corrects for the day's temperature and shows true heights on hot and cold days.

Most barometric altimeters assume standard air and read low on a hot day; the plain model expects that.
"""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Corrects the heights by this fraction of the error due to the day's temperature."""
    return setup.with_changes(altimeter_gain=setup.altimeter_gain ** (1 - strength))


EFFECT = Effect(
    title="an altimeter that corrects for temperature",
    family="device",
    explains="the altimeter corrects for the day's temperature, while the model expects it to read low in heat",
    unit="fraction of the correction",
    prior=Prior(mean=1.0, sd=0.25, low=0.0, high=1.5),
    source="the hypsometric equation: 0.35% of height for each kelvin; a device corrects for all of it or for none",
    tell_apart="read its manual, or fly the same motor on a hot and on a cold day",
    setup=setup,
    needs="temperature",
)

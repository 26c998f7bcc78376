"""Altimeter scale: heights read high or low by a constant fraction; times are right."""

from fieldkit.physics.effect import Effect, Prior, Readings
from fieldkit.shapes import Array, Float


def reading(readings: Readings, strength: Float[Array, "*draw flight"]) -> Readings:
    """Increases heights by this fraction; speeds and times do not change."""
    heights = {name: readings[name] * (1 + strength) for name in ("apogee", "eject_altitude") if name in readings}
    return {**readings, **heights}


EFFECT = Effect(
    title="an altimeter that reads high or low",
    family="device",
    explains="the altimeter's heights are off by a constant percentage, while speed and times are right",
    unit="fraction of the height",
    prior=Prior(mean=0.0, sd=0.05, low=-0.3, high=0.3),
    source="a barometric altimeter that assumes standard air errs by 0.35% per kelvin",
    tell_apart="fly a second altimeter next to it",
    reading=reading,
    starts_anywhere=True,
    measured=0.01,
    quantity="apogee",
    shared_by=("day", "device", "fleet"),
    says=(
        "The altimeter reads about {amount} low",
        "The altimeter reads about {amount} high",
    ),
)

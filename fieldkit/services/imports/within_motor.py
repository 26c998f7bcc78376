"""Removing readouts from a log that no rocket of this mass can reach on its motor."""

from fieldkit.errors import UnknownMotor
from fieldkit.flight import BY_NAME, SENSORS, Flight
from fieldkit.flight.plausibility import beyond_motor
from fieldkit.motors import catalogue

_READOUT_DETAILS = ("sd", "source")
"""Fields of a flight that describe its readouts."""


def within_motor(flight: Flight) -> tuple[Flight, list[str]]:
    """A flight without the readouts from samples that its motor and mass rule out, and a phrase for each. Typed
    readouts stay; they are checked elsewhere."""
    if not flight.motor or flight.dry_mass is None or not set(SENSORS) & set(flight.source.values()):
        return flight, []

    try:
        motor = catalogue().resolve(flight.motor).motor
    except UnknownMotor:
        return flight, []
    found = {name: why for name, why in beyond_motor(flight, motor).items() if flight.source.get(name) in SENSORS}
    if not found:
        return flight, []
    left = {part: {n: v for n, v in getattr(flight, part).items() if n not in found} for part in _READOUT_DETAILS}
    kept = flight.with_changes(**dict.fromkeys(found), **left)
    return kept, [f"not measured: {BY_NAME[name].title.lower()}; {why}" for name, why in found.items()]

"""Flights beside the others of their rocket, for the pages that list flights."""

from collections.abc import Iterable, Mapping

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.tui.asking import go_on
from fieldkit.tui.resources import Resources

Beside = Mapping[tuple[str, str], FlightBesideOthers]
"""Flights beside the others of their rocket, by rocket and flight_id."""


def beside_others(resources: Resources, flights: Iterable[Flight]) -> Beside:
    """Every flight of the rockets of some flights beside the others. Raises Dropped."""
    found: dict[tuple[str, str], FlightBesideOthers] = {}
    for rocket in dict.fromkeys(flight.rocket for flight in flights if flight.rocket):
        go_on()
        try:
            every = resources.comparisons.of(resources.ledger, resources.motors, rocket)
        except FieldkitError:
            continue  # the page of the rocket reports what cannot be read
        found |= {(rocket, one.flight.flight_id): one for one in every}
    return found

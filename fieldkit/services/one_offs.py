"""The flights of a rocket in a ledger, each beside its forecast from the others."""

from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers, beside_others
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.selection.candidates import Averaged
from fieldkit.services.fleet import fleet_prior
from fieldkit.services.forecasts import accepted_average, flown


def flights_beside_others(
    ledger: Ledger, motors: Catalogue, rocket: str, averaged: Averaged | None = None
) -> tuple[FlightBesideOthers, ...]:
    """The flights of a rocket that can be simulated, in the order flown; empty if there are none.

    By default with the sets of effects that its forecasts use. Raises BadValue for a recovery figure or rail direction
    that cannot be read, DamagedModel if the hyperprior cannot be read.
    """
    history = flown(ledger, motors, rocket)
    if not history:
        return ()
    flights = [flight for flight, _ in history]
    sets = accepted_average(ledger, rocket, flights=flights) if averaged is None else averaged
    shared = fleet_prior(ledger, motors, rocket)
    cds = ledger.rocket(rocket).cds(flight.config for flight in flights)
    return beside_others(history, sets, cds=cds, shared=shared)


def flight_beside_others(ledger: Ledger, motors: Catalogue, flight: Flight) -> FlightBesideOthers | None:
    """One flight of the ledger; None if it cannot be simulated or has nothing to compare. Errors as in
    `flights_beside_others`."""
    for one in flights_beside_others(ledger, motors, flight.rocket):
        if one.flight.flight_id == flight.flight_id and one.departures:
            return one
    return None

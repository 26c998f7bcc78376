"""The flights that fits may use, each with its motor, and notes on the implausible ones."""

from collections.abc import Iterator, Sequence

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.plausibility import implausible
from fieldkit.motors import Catalogue, Found


def followed(flights: Sequence[Flight], motors: Catalogue) -> list[tuple[Flight, Found]]:
    """The flights that can be simulated, each with its motor."""
    return [(flight, found) for flight, found in _with_motors(flights, motors) if not implausible(flight, found.motor)]


def plausible(flights: Sequence[Flight], motors: Catalogue) -> list[Flight]:
    """The flights whose setup a plan can start from, whatever their readouts; clusters are not checked."""
    odd = {id(one) for one, found in _with_motors(flights, motors) if implausible(_set_up(one), found.motor)}
    return [flight for flight in flights if flight.dry_mass is not None and id(flight) not in odd]


def _set_up(flight: Flight) -> Flight:
    return flight.with_changes(**dict.fromkeys(flight.readouts()))


def implausible_flights(flights: Sequence[Flight], motors: Catalogue) -> list[str]:
    """A line for each clean flight that is implausible and therefore not used in a fit."""
    found = [(flight, implausible(flight, found.motor)) for flight, found in _with_motors(flights, motors)]
    return [
        f"flight {flight.flight_id} of {flight.rocket} is excluded from every fit: {reason}"
        for flight, reason in found
        if reason and flight.clean
    ]


def _with_motors(flights: Sequence[Flight], motors: Catalogue) -> Iterator[tuple[Flight, Found]]:
    for flight in flights:
        if flight.dry_mass is None:
            continue
        try:
            yield flight, motors.resolve(flight.motor)
        except UnknownMotor:
            continue

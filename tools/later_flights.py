"""Flights of tables, and those of rockets flown before with what was known then."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from fieldkit.inference.laplace.fleet import RocketFit, rocket_fit, shared_prior
from fieldkit.ledger import Ledger
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import FlownFlight, FlownFlights
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import catalogue
from fieldkit.services.imports.add_files import bring_in
from fieldkit.services.learn import read_flyer
from fieldkit.services.plausible_flights import followed

EXACT_SINCE = date(2011, 8, 1)
"""The public journal's altitudes before are estimates."""


def flights_of(path: Path) -> FlownFlights:
    """The flights of a table, in the order flown, with their motors."""
    motors = catalogue()
    with tempfile.TemporaryDirectory() as home, Ledger.open(str(Path(home) / "ledger.db")) as ledger:
        bring_in(ledger, [path], lambda _: None, motors=motors)
        return followed(ledger.flights(), motors)


@dataclass(frozen=True, slots=True)
class LaterFlight:
    """A flight of a rocket flown before, with the earlier flights and the information from the flyer's others."""

    earlier: FlownFlights
    flown: FlownFlight
    shared: SharedPrior | None


def later_flights(path: Path) -> Iterator[LaterFlight]:
    """Every clean flight with an apogee of a rocket that flew before, in the order flown."""
    known = learned()
    past: dict[str, list[FlownFlight]] = {}
    fits: dict[str, tuple[int, RocketFit]] = {}
    for flight, motor in read_flyer(path, catalogue(), EXACT_SINCE).flown:
        own = past.setdefault(flight.rocket, [])
        if flight.clean and flight.apogee is not None and any(one.clean and one.apogee for one, _ in own):
            period = period_of(one for some in past.values() for one, _ in some)
            for name, some in past.items():
                used = [one for one in some if one[0].clean and one[0].readouts()]
                if used and fits.get(name, (0,))[0] != len(used):
                    fits[name] = len(used), rocket_fit(used, known, period)
            others = [fit for name, (_, fit) in fits.items() if name != flight.rocket]
            yield LaterFlight(tuple(own), (flight, motor), shared_prior(others, period))
        own.append((flight, motor))

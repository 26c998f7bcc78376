"""The flights of a rocket in a ledger, each beside its forecast from the others."""

from dataclasses import dataclass, field
from threading import Lock

from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers, beside_others
from fieldkit.forecast.predict import Fits
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.services.forecasts import accepted_average, assumed_of, flown


def flights_beside_others(
    ledger: Ledger, motors: Catalogue, rocket: str, fits: Fits | None = None
) -> tuple[FlightBesideOthers, ...]:
    """The flights of a rocket that can be simulated, in the order flown; empty if there are none.

    With the sets of effects that its forecasts use. `fits` as in `fieldkit.forecast.predict.predict`. Raises BadValue
    for a saved model that cannot be read, DamagedModel if the hyperprior cannot be read.
    """
    history = flown(ledger, motors, rocket)
    if not history:
        return ()
    flights = [flight for flight, _ in history]
    sets = accepted_average(ledger, rocket, flights=flights)
    return beside_others(history, assumed_of(ledger, motors, rocket, flights, sets), fits=fits)


def flight_beside_others(
    ledger: Ledger, motors: Catalogue, flight: Flight, fits: Fits | None = None
) -> FlightBesideOthers | None:
    """One flight of the ledger; None if it cannot be simulated or has nothing to compare. `fits` and errors as in
    `flights_beside_others`."""
    for one in flights_beside_others(ledger, motors, flight.rocket, fits=fits):
        if one.flight.flight_id == flight.flight_id and one.departures:
            return one
    return None


@dataclass(slots=True)
class Comparisons:
    """The flights of rockets beside the others, compared once until the ledger changes, for all pages of an app, with
    the fits of the rocket asked for last."""

    _length: int = -1
    _found: dict[str, tuple[FlightBesideOthers, ...]] = field(default_factory=dict)
    _fitted: str = ""
    _fits: Fits = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    def of(self, ledger: Ledger, motors: Catalogue, rocket: str) -> tuple[FlightBesideOthers, ...]:
        """The flights of a rocket as in `flights_beside_others`. Raises BadValue for a saved model that cannot be read,
        DamagedModel if the hyperprior cannot be read."""
        fits = self.fits(ledger, rocket)
        with self._lock:
            if rocket not in self._found:
                self._found[rocket] = flights_beside_others(ledger, motors, rocket, fits=fits)
            return self._found[rocket]

    def fits(self, ledger: Ledger, rocket: str) -> Fits:
        """The fits of the flights of a rocket so far, to be used and added to while the ledger does not change."""
        with self._lock:
            if (length := ledger.length()) != self._length:
                self._length, self._found, self._fitted = length, {}, ""
            if rocket != self._fitted:
                self._fitted, self._fits = rocket, {}
            return self._fits

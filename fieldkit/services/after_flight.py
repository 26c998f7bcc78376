"""A flight that was just entered: whether it is plausible, how it compares with its forecast, and what to do next."""

from dataclasses import dataclass

import numpy as np

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.forecast.predict import Fits
from fieldkit.forecast.prediction import Prediction, quantiles
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue, is_cluster
from fieldkit.planning.quantiles import Three
from fieldkit.services.forecasts import forecast_from_others, predict_plans
from fieldkit.services.one_offs import flight_beside_others
from fieldkit.services.plausible_flights import plausible
from fieldkit.services.saved_forecasts import of_flight

SURPRISING_PROBABILITY = 0.001
"""Probability that the apogee of a good flight is questioned because it is too low, and because it is too high. [1]"""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Forecast of a flight, forecast of the next flight like it, and Cd before and after the flight. [m, 1]

    `kept` states whether the forecast was saved before the flight; otherwise it is computed from the other flights, as
    in `beside`, which all pages show.
    `before` is the forecast from the other flights, `after` that of the next flight like it, `beside` the flight
    compared with the others of its rocket.
    """

    flight: Flight
    forecast: Three
    kept: bool
    before: Prediction
    after: Prediction
    cd: tuple[float, float]
    beside: FlightBesideOthers | None = None

    @property
    def next_flight(self) -> Three:
        """The forecast of the next flight like it."""
        return self.after.apogee_quantiles()

    @property
    def narrows(self) -> float:
        """The fraction by which one more such flight narrows the next interval. [1]"""
        return 1 - self.after.narrowed(1)

    @property
    def miss(self) -> float | None:
        """Flown minus forecast apogee, None without a forecast. [m]"""
        return None if self.flight.apogee is None else self.flight.apogee - self.forecast[1]

    @property
    def inside(self) -> bool:
        """Whether the flown apogee is inside the 90% interval."""
        apogee = self.flight.apogee
        return apogee is not None and self.forecast[0] <= apogee <= self.forecast[2]


def expected_instead(ledger: Ledger, motors: Catalogue, flight: Flight) -> Three | None:
    """The apogee to expect of a flight whose apogee is implausible; None if it is plausible.

    Also None if nothing can be expected: without an apogee, a motor or a dry mass.
    """
    made = _forecast(ledger, motors, flight)
    if made is None or flight.apogee is None:
        return None
    low, high = quantiles(made.apogee, np.array([SURPRISING_PROBABILITY, 1 - SURPRISING_PROBABILITY])).tolist()
    return None if low <= flight.apogee <= high else made.apogee_quantiles()


def outcome(ledger: Ledger, motors: Catalogue, flight: Flight) -> Outcome | None:
    """A flight of the ledger compared with its forecast, None if none can be made, for example for a rocket too heavy
    for its motor. Raises BadValue for a file of kits or a saved model that cannot be read, DamagedModel if the
    hyperprior cannot be read."""
    before = _forecast(ledger, motors, flight)
    if before is None or not plausible([flight], motors):
        return None
    plan, fits = before.plan.with_changes(flight_id="", date_time=None), Fits()
    (after,) = predict_plans(ledger, motors, [plan], save="nothing", fits=fits)
    kept, beside = of_flight(ledger, motors, flight), flight_beside_others(ledger, motors, flight, fits)
    expected = beside.interval if beside is not None else None
    return Outcome(
        flight=flight,
        forecast=kept.interval if kept is not None else expected or before.apogee_quantiles(),
        kept=kept is not None,
        before=before,
        after=after,
        cd=(float(before.cd.mean()), float(after.cd.mean())),
        beside=beside,
    )


def _forecast(ledger: Ledger, motors: Catalogue, flight: Flight) -> Prediction | None:
    """The forecast of a flight from the other flights; None if its motor or mass is unknown."""
    if not flight.motor or is_cluster(flight.motor) or flight.dry_mass is None:
        return None
    try:
        return forecast_from_others(ledger, motors, flight)
    except FieldkitError:
        return None

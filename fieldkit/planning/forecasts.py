"""Forecasts of alternative plans, from what is known about a rocket."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fieldkit.flight import Flight
from fieldkit.flight.start import Start, design_cds
from fieldkit.forecast.earlier_forecasts import EarlierForecasts
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.predict import FittedForecast, fly_ahead, learn
from fieldkit.forecast.prediction import Prediction
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.selection.candidates import Averaged

PlannedFlights = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True)
class Rocket:
    """The data about a rocket that forecasts are based on: its flights, the effect sets in its model, the results of
    earlier forecasts, its starting designs, and the data of the user's other rockets."""

    history: tuple[tuple[Flight, Found], ...]
    averaged: Averaged
    earlier: EarlierForecasts = EarlierForecasts()
    starts: tuple[Start, ...] = ()
    shared: SharedPrior | None = None
    excluded: tuple[str, ...] = ()
    """One line for each flight that no rocket can have flown and that is excluded from forecasts."""
    mount: float | None = None
    """Diameter of the motor mount of the kit that it is named after; None if not known. [m]"""

    @property
    def flights(self) -> list[Flight]:
        """The flights that can be simulated, in order."""
        return [flight for flight, _ in self.history]

    @property
    def motors(self) -> list[Found]:
        """The motors of these flights."""
        return [found for _, found in self.history]

    def same_as(self, other: "Rocket") -> bool:
        """Whether forecasts of a plan are the same for both."""
        mine, theirs = self.shared, other.shared
        if mine is None or theirs is None:
            return mine is theirs and self == other
        return mine.same_as(theirs) and replace(self, shared=None) == replace(other, shared=None)


def forecasts(
    rocket: Rocket,
    planned: PlannedFlights,
    *,
    draws: int,
    paired: bool = True,
) -> list[Prediction]:
    """Forecasts of alternative plans, each as the next flight, as `predict` would make them, in the given order;
    nothing is saved.

    `paired` as in `fieldkit.forecast.predict.fly_ahead`. Raises ImpossibleFlight for a plan without a
    mass.
    """

    def of_rows(rows: Sequence[int]) -> list[Prediction]:
        fitted = fitted_forecast(rocket, [planned[row] for row in rows], draws)
        return forecast_plans(rocket, fitted, paired)

    return by_kind(rocket.history, planned, of_rows)


def fitted_forecast(rocket: Rocket, planned: PlannedFlights, draws: int) -> FittedForecast:
    """The forecast model fitted to a rocket's flights for similar plans, each as the next flight. Raises
    ImpossibleFlight for a flight without a dry mass, BadValue for a recovery figure or rail direction that cannot be
    read, DamagedModel if the hyperprior cannot be read.
    """
    cds = design_cds(rocket.starts, [flight for flight, _ in (*rocket.history, *planned)])
    return learn(rocket.history, planned, averaged=rocket.averaged, cds=cds, shared=rocket.shared, draws=draws)


def forecast_plans(
    rocket: Rocket,
    fitted: FittedForecast,
    paired: bool = True,
) -> list[Prediction]:
    """Simulate the plans of a fit as in `fly_ahead`, corrected by the results of earlier forecasts. Raises
    ImpossibleFlight for a flight without a dry mass and BadValue for a recovery figure or rail direction that cannot be
    read.
    """
    made = fly_ahead(fitted, paired=paired)
    corrected = rocket.earlier.corrected(made)
    return [replace(one, left_out=(*rocket.excluded, *one.left_out)) for one in corrected]

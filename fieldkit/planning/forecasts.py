"""Forecasts of alternative plans, from what is known about a rocket."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.flight.plausibility import MIN_CALIBER_RATIO
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.earlier_forecasts import EarlierForecasts
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.predict import DRAWS, Fits, FittedForecast, fly_ahead, learn
from fieldkit.forecast.prediction import Prediction
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found, Motor
from fieldkit.physics.history import flown_and_planned
from fieldkit.planning.descent_rate import Fall, fall_of
from fieldkit.rocket import Rocket
from fieldkit.selection.candidates import Averaged

PlannedFlights = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True)
class RocketData:
    """The data about a rocket that forecasts are based on: its flights, the effect sets in its model, the results of
    earlier forecasts, its designs, and the data of the user's other rockets; `known` is the rocket apart from its
    flights, and with `declared` recorded wind acts although no effect of wind was accepted."""

    history: tuple[tuple[Flight, Found], ...]
    averaged: Averaged
    earlier: EarlierForecasts = EarlierForecasts()
    known: Rocket = Rocket("")
    shared: SharedPrior | None = None
    excluded: tuple[str, ...] = ()
    """One line for each flight that no rocket can have flown and that is excluded from forecasts."""
    declared: bool = True
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

    def assumed(self, flights: Iterable[Flight]) -> Assumed:
        """What forecasts of flights assume beside the rocket's own."""
        return Assumed(self.averaged, self.declared, self.known.cds(one.config for one in flights), self.shared)

    def same_as(self, other: "RocketData") -> bool:
        """Whether forecasts of a plan are the same for both."""
        mine, theirs = self.shared, other.shared
        if mine is None or theirs is None:
            return mine is theirs and self == other
        return mine.same_as(theirs) and replace(self, shared=None) == replace(other, shared=None)


@dataclass(frozen=True, slots=True)
class Plan:
    """What is flown next: a rocket with what is known about it, its flight, and the motor."""

    rocket: RocketData
    flight: Flight
    found: Found

    @property
    def fall(self) -> Fall:
        """The descent of the flight, from those of the rocket. Errors as in `fall_of`."""
        return fall_of(self.rocket.history, self.flight, self.found)

    def with_changes(self, **changes: Any) -> "Plan":
        """The same plan with other figures of its flight."""
        return replace(self, flight=self.flight.with_changes(**changes))

    def forecast(self, draws: int = DRAWS) -> Prediction:
        """The forecast of the plan. Errors as in `forecasts`."""
        return self.forecasts([self.flight], draws=draws)[0]

    def forecasts(self, flights: Iterable[Flight], *, draws: int, paired: bool = True) -> list[Prediction]:
        """Forecasts of other flights on the motor of the plan, each instead of its own, as in `forecasts`."""
        return forecasts(self.rocket, [(one, self.found) for one in flights], draws=draws, paired=paired)

    def forecasts_at(self, masses: Iterable[float], *, draws: int, paired: bool = True) -> list[Prediction]:
        """Forecasts of the plan at several dry masses [kg], as in `forecasts`."""
        flights = [self.flight.with_changes(dry_mass=float(mass)) for mass in masses]
        return self.forecasts(flights, draws=draws, paired=paired)


def forecasts(
    rocket: RocketData,
    planned: PlannedFlights,
    *,
    draws: int = DRAWS,
    paired: bool = True,
    in_order: bool = False,
    fits: Fits | None = None,
) -> list[Prediction]:
    """Forecasts of plans, each as the next flight or `in_order` flown one after the other, in the given order; nothing
    is saved. Every forecast of fieldkit for a flyer is made here.

    `paired` as in `fieldkit.forecast.predict.fly_ahead`, `fits` as in `fieldkit.forecast.predict.predict`. Raises
    ImpossibleFlight for a plan without a mass.
    """

    def of_rows(rows: Sequence[int]) -> list[Prediction]:
        index = [len(rocket.history) + row for row in rows] if in_order else None
        fitted = fitted_forecast(rocket, [planned[row] for row in rows], draws, index, fits)
        return forecast_plans(rocket, fitted, paired)

    return by_kind(rocket.history, planned, of_rows)


def check_width(plan: Flight, motor: Motor) -> None:
    """Raise ImpossibleFlight for a motor that does not fit into the body of a plan."""
    if plan.diameter and plan.diameter < MIN_CALIBER_RATIO * motor.diameter:
        wide, body = (f"{1e3 * one:.4g} mm" for one in (motor.diameter, plan.diameter))
        raise ImpossibleFlight(
            f"{motor.designation}: found a motor of {wide} in a body of {body}, expected a wider body"
        )


def fitted_forecast(
    rocket: RocketData,
    planned: PlannedFlights,
    draws: int = DRAWS,
    flight_index: Sequence[int] | None = None,
    fits: Fits | None = None,
) -> FittedForecast:
    """The forecast model fitted to a rocket's flights for similar plans, each with its flight index, by default the
    next for all; `fits` as in `fieldkit.forecast.predict.predict`. Raises ImpossibleFlight for a flight without a dry
    mass and for a motor that is wider than the body, DamagedModel if the hyperprior cannot be read."""
    for plan, motor in planned:
        check_width(plan, motor.motor)
    return learn(
        flown_and_planned(rocket.history, planned, flight_index),
        rocket.assumed([flight for flight, _ in (*rocket.history, *planned)]),
        draws=draws,
        fits=fits,
    )


def forecast_plans(rocket: RocketData, fitted: FittedForecast, paired: bool = True) -> list[Prediction]:
    """Simulate the plans of a fit as in `fly_ahead`, corrected by the results of earlier forecasts. Raises
    ImpossibleFlight for a flight without a dry mass."""
    made = fly_ahead(fitted, paired=paired)
    corrected = rocket.earlier.corrected(made)
    return [replace(one, left_out=(*rocket.excluded, *one.left_out)) for one in corrected]

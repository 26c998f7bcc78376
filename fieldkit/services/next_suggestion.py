"""What to do after a flight: search for a missing effect, fly the motor nearest to the target, or repeat the flight."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb
from typing import Literal

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.paths import data_file
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import MotorOrder, Wanted, guide, suitable_motors, widest_motor
from fieldkit.planning.quantiles import Three
from fieldkit.services.after_flight import Outcome
from fieldkit.services.forecasts import predict_plans, rocket_of
from fieldkit.services.plans import completed_plan
from fieldkit.services.quick_look import MIN_FLIGHTS
from fieldkit.services.saved_forecasts import SavedForecast, list_forecasts
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings

RECENT_FORECASTS = 10
"""Number of a rocket's latest forecasts to count. [1]"""
OUTSIDE_PROBABILITY = 0.1
"""Probability of a flight outside its 90% interval, if forecasts are calibrated. [1]"""
SIGNIFICANCE = 0.05
"""The loop is suggested if the probability of as many flights outside by chance is below this. [1]"""
COMPARED_DRAWS = 200
"""Number of simulations for each motor compared with a target. [1]"""


@dataclass(frozen=True, slots=True)
class Suggestion:
    """What to do next.

    `loop`: `outside` of the last `forecasts` clean flights were outside their 90% interval. `motor`: the safe `motor`
    with the `apogee` nearest to the `target` [m], which is within its interval. `repeat`: one more flight narrows the
    interval by the fraction `narrows`. [1]
    """

    kind: Literal["loop", "motor", "repeat"]
    outside: int = 0
    forecasts: int = 0
    motor: str = ""
    apogee: Three | None = None
    target: float = 0.0
    narrows: float = 0.0


def suggestion(
    ledger: Ledger,
    motors: Catalogue,
    settings: Settings,
    found: Outcome,
    forecasts: Sequence[SavedForecast] | None = None,
) -> Suggestion:
    """What to do after a flight; `forecasts` are its rocket's forecasts, by default from the ledger."""
    flight = found.flight
    recent = forecasts if forecasts is not None else list_forecasts(ledger, motors, flight.rocket)
    if questioned := _model_questioned(recent, ledger.flights(flight.rocket)):
        return questioned
    if settings.target is not None:
        try:
            nearest = _nearest_motor(ledger, motors, settings, flight, settings.target)
        except FieldkitError:
            nearest = None
        if nearest is not None:
            motor, interval = nearest
            if interval[0] <= settings.target <= interval[2]:
                return Suggestion("motor", motor=motor, apogee=interval, target=settings.target)
    return Suggestion("repeat", motor=flight.motor, apogee=found.next_flight, narrows=found.narrows)


def _model_questioned(forecasts: Sequence[SavedForecast], flights: Sequence[Flight]) -> Suggestion | None:
    """The loop, if more of the latest clean flights were outside their intervals than by chance, and the rocket has
    enough flights."""
    flown = [one for one in forecasts if one.flight and one.flight.clean and one.flown is not None][-RECENT_FORECASTS:]
    outside = sum(not one.interval[0] <= (one.flown or 0.0) <= one.interval[2] for one in flown)
    usable = sum(flight.clean and flight.apogee is not None for flight in flights)
    if usable < MIN_FLIGHTS or not outside or chance_of(outside, len(flown)) >= SIGNIFICANCE:
        return None
    return Suggestion("loop", outside=outside, forecasts=len(flown))


def chance_of(outside: int, forecasts: int) -> float:
    """Probability that at least a number of calibrated forecasts miss, each independently: a binomial tail. [1]"""
    p = OUTSIDE_PROBABILITY
    return sum(comb(forecasts, k) * p**k * (1 - p) ** (forecasts - k) for k in range(outside, forecasts + 1))


def _nearest_motor(
    ledger: Ledger, motors: Catalogue, settings: Settings, flight: Flight, target: float
) -> tuple[str, Three] | None:
    """The safe motor nearest to a target [m] for the same configuration in the same conditions, and its forecast as it
    would be saved."""
    rocket = rocket_of(ledger, motors, flight.rocket)
    again = flight.unflown(flight_id="", date_time=None, delay=None)
    plan = completed_plan(ledger, motors, again, settings)
    wanted = Wanted(widest_motor(rocket, plan), adapter=True, dry_mass=plan.dry_mass)
    rules, site = limits(data_file("limits.toml")), site_of(ledger, plan.site)
    choices = guide(rocket, plan, suitable_motors(motors, wanted), rules, site, COMPARED_DRAWS)
    nearest = next((one for one in MotorOrder(target).sorted(choices) if one.fits), None)
    if nearest is None:
        return None
    (made,) = predict_plans(ledger, motors, [nearest.plan], save="nothing")
    return nearest.name, made.apogee_quantiles()

"""A planned flight with its complete forecast: apogee, descent, safety lines, and the best rail angle."""

from dataclasses import dataclass
from typing import Any

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.predict import DRAWS
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found
from fieldkit.planning.check import UNSAFE_RISK, SafetyCheck
from fieldkit.planning.descent_rate import Fall, fall_of
from fieldkit.planning.forecasts import Rocket, forecasts
from fieldkit.planning.landing import (
    MAX_RECOMMENDED_ANGLE,
    Landing,
    RailChoice,
    landing,
    rail_choices,
    wind_that_holds,
)
from fieldkit.planning.limits import Limits
from fieldkit.planning.safety import safety_lines


@dataclass(frozen=True, slots=True)
class PlannedFlight:
    """A plan, its forecast, the basis of its descent, its landing, its safety lines, and rail settings from best to
    worst; none if the wind is not known, or if the rocket would probably land without a parachute.

    `holds` is the result of `wind_that_holds` [m/s]; None with a wind, or without the size of the field.
    """

    prediction: Prediction
    fall: Fall
    down: Landing
    lines: tuple[SafetyCheck, ...]
    rail: tuple[RailChoice, ...]
    holds: float | None = None

    @property
    def name(self) -> str:
        """The plan's id, or its rocket if it has none."""
        return self.prediction.plan.flight_id or self.prediction.plan.rocket or "plan"

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "landing": self.down.json(),
            "rail": [one.json() for one in self.rail],
            "timed_flights": self.fall.flights,
        }


def planned_flight(rocket: Rocket, plan: Flight, found: Found, site: Site, limits: Limits) -> PlannedFlight:
    """The complete forecast of a plan for a rocket at a site, with the draws of `predict`, so that both show the same
    figures. Raises BadValue, ImpossibleFlight.
    """
    (prediction,) = forecasts(rocket, [(plan, found)], draws=DRAWS)
    fall = fall_of(rocket.history, prediction.plan, found)
    down = landing(prediction, fall)
    opens = down.down.ballistic.mean() < UNSAFE_RISK
    rail = rail_choices(rocket, plan, found, MAX_RECOMMENDED_ANGLE) if opens else ()
    lines = safety_lines(prediction, site, fall, limits)
    unknown = plan.wind is None and site.size is not None
    holds = wind_that_holds(rocket, plan, found, site.size or 0.0) if unknown else None
    return PlannedFlight(prediction, fall, down, tuple(lines), tuple(rail), holds)

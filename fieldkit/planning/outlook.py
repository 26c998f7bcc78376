"""The expected points of a plan by the rule of a season, and the parachute with the fewest."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.air import air_of
from fieldkit.planning.contest import Season
from fieldkit.planning.descent import durations
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.flown_descent import landing_mass
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.gain import gain_of, is_clear
from fieldkit.planning.landing import landing
from fieldkit.shapes import Array, Float

DRAWS = 1000
"""Number of rockets drawn, each of which flies all flights that may be declared. [1]"""
AREAS = (0.4, 2.5)
"""Range of the tried parachute areas, as a ratio to the area flown. [1]"""
AREA_TOLERANCE = 5e-3
"""Tolerance of the log of the best area. [1]"""


@dataclass(frozen=True, slots=True)
class Outlook:
    """Forecast of a plan's points: draws for each flight that may be declared, and what they are based on.

    `forecast` has the draws of `predict`, and `duration` those of `landing` [s], so that every page shows the same
    figures. `fall` is the basis of the durations. `area` is the ratio of the parachute's area with the fewest points to
    the area flown [1], `points_there` the mean points with it, `speed_there` its descent speed near the ground [m/s];
    `gain` is the mean improvement by it in points per flight, `gain_error` its standard error, with as many flights as
    the forecast is based on.
    """

    forecast: Prediction
    points: Float[Array, "draw declared"]
    duration: Float[Array, "draw"]
    fall: Fall
    area: float
    points_there: float
    speed_there: float
    gain: float
    gain_error: float

    @property
    def clear(self) -> bool:
        """Whether a change of the parachute is worth it: the points saved are significant."""
        return is_clear(self.gain, self.gain_error)

    @property
    def at_edge(self) -> bool:
        """Whether the best area is the smallest or the largest that was tried, within the tolerance of the search."""
        return any(abs(math.log(self.area / edge)) < 2 * AREA_TOLERANCE for edge in AREAS)

    def chance(self, rule: Season, cut: float) -> float:
        """Probability that the sum of the best declared flights is within a cut. [1]"""
        return float((rule.sums(self.points) <= cut).mean())


def outlook(rule: Season, plan: Plan, area: float = 1.0, draws: int = DRAWS) -> Outlook:
    """Simulate a plan as often as flights may be declared, with a fraction of the current parachute area [1].

    The flights of a row share the uncertainty about the rocket and differ in their random draws, which gives their sum
    the right uncertainty. Raises ImpossibleFlight for a plan without a mass.
    """
    forecast = plan.forecast(draws)
    predictions = plan.forecasts([plan.flight] * rule.declared, draws=draws, paired=False)
    fall, shape = plan.fall, (draws, rule.declared)
    mass, density = landing_mass(plan.flight, plan.found), air_of(plan.flight).density

    def timed(area_ratio: float) -> Float[Array, "draw declared"]:
        speeds = fall.speeds(np.random.default_rng(6), shape, mass, density, area_ratio)
        return durations(predictions, fall, speeds)

    apogee = np.stack([one.apogee for one in predictions], axis=-1)
    best_area, fewest = _best_area(lambda area_ratio: float(rule.points(apogee, timed(area_ratio)).mean()))
    points = rule.points(apogee, timed(area))
    return Outlook(
        forecast,
        points,
        landing(forecast, fall.on_area(area)).duration,
        fall,
        best_area,
        fewest,
        fall.on_area(best_area).usual_speed(mass, density),
        *gain_of(points - rule.points(apogee, timed(best_area)), predictions[0].rests_on),
    )


def _best_area(cost: Callable[[float], float]) -> tuple[float, float]:
    """The fraction of the area with the lowest cost, and that cost; searched in its logarithm, where half and double
    are equal steps."""
    from scipy.optimize import minimize_scalar  # takes 0.3 s to import

    bounds = float(np.log(AREAS[0])), float(np.log(AREAS[1]))
    best = minimize_scalar(
        lambda log: cost(float(np.exp(log))), bounds=bounds, method="bounded", options={"xatol": AREA_TOLERANCE}
    )
    return float(np.exp(best.x)), float(best.fun)

"""The dry mass that best meets a target, optimized over the forecast with common random numbers for all masses."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.forecast.prediction import Prediction
from fieldkit.messages import amount, message
from fieldkit.planning.contest import Season
from fieldkit.planning.descent import common_durations
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.gain import gain_json, gain_of, is_clear
from fieldkit.planning.quantiles import Three, named, three_of_all
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

GRID = 16
"""Number of masses simulated. [1]"""
DRAWS = 500
"""Flights simulated at each mass. [1]"""
MIN_MASS_RATIO, MAX_MASS_RATIO = 0.6, 1.8
"""Range of masses tried if the user sets no bounds, relative to the current dry mass. [1]"""
BAND_SMOOTHING = 0.5
"""Width over which the edge of the band is smoothed, which makes the probability smooth in the mass. [m]"""
SEARCH_SMOOTHING = 0.15
"""The same during the search for the best mass, in standard deviations of the apogee; with less, the search would fit
the random scatter of so few draws. On the order of Silverman's bandwidth for `DRAWS` (Density Estimation, 1986, section
3.4.2). [1]"""

Figures = Float[Array, "draw"]


@dataclass(frozen=True, slots=True)
class Goal:
    """What to optimize: the probability of an apogee `within` of a `target` [m] ("chance"), the mean miss ("error"), or
    the points of a season ("points", fewer are better)."""

    target: float
    within: float
    aim: Literal["chance", "error", "points"] = "chance"
    rule: Season | None = None

    def chance(self, apogee: Figures, soft: float = BAND_SMOOTHING) -> float:
        """Probability of being within the band, with its edges smoothed by `soft`. [1]"""
        miss = np.abs(apogee - self.target)
        return float(np.mean(1 / (1 + np.exp(np.clip((miss - self.within) / soft, -50, 50)))))

    def error(self, apogee: Figures) -> float:
        """Mean miss. [m]"""
        return float(np.abs(apogee - self.target).mean())

    def points(self, apogee: Figures, duration: Figures) -> float | None:
        """Mean points per flight, None without a season. [1]"""
        return None if self.rule is None else float(self.rule.points(apogee, duration).mean())

    def cost(self, apogee: Figures, duration: Figures) -> float:
        """The quantity to minimize, in the unit of the goal."""
        if self.aim == "points":
            return self.points(apogee, duration) or 0.0
        blurred = max(BAND_SMOOTHING, SEARCH_SMOOTHING * float(apogee.std()))
        return -self.chance(apogee, blurred) if self.aim == "chance" else self.error(apogee)


@dataclass(frozen=True, slots=True)
class Result:
    """Result at a mass: probability of the band [1], mean miss [m], mean points if there is a season [1]."""

    chance: float
    error: float
    points: float | None

    def json(self) -> dict[str, float | None]:
        """Ready for JSON, with the unit in the key."""
        return {"chance": self.chance, "mean_error_m": self.error, "points": self.points}


@dataclass(frozen=True, slots=True)
class Ballast:
    """The dry mass to fly [kg], the mass to add to the current one [kg], and the results.

    `forecast` is the flight at that mass and `unchanged` the one at the current mass with the draws of
    `predict`, `slope` the change of apogee with
    mass [m/kg], `there` the result at that mass and `today` the result without a change. `reach` is the lowest and the
    highest median apogee of the masses tried [m]; the target is `met` if it lies between. `gain` is the mean
    improvement in points per flight, `gain_error` its standard error, with as many flights as the forecast is based on;
    without a season a point is a foot off the target, as in altitude contests.
    """

    mass: float
    add: float
    forecast: Prediction
    unchanged: Prediction
    slope: float
    there: Result
    today: Result
    reach: tuple[float, float]
    met: bool
    gain: float
    gain_error: float
    too_heavy: bool = False

    @property
    def clear(self) -> bool:
        """Whether the change is worth it: the points saved are significant, or the current mass exceeds the limit."""
        return self.too_heavy or is_clear(self.gain, self.gain_error)

    @property
    def advised(self) -> Prediction:
        """The forecast at the mass to fly: the current one unless a change is worth it."""
        return self.forecast if self.clear else self.unchanged

    @property
    def apogee(self) -> Three:
        """Apogee as the altimeter will read it, at 5, 50 and 95%. [m]"""
        return three_of_all(self.forecast.apogee)

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "dry_mass_g": self.mass * 1e3,
            "add_g": self.add * 1e3,
            "apogee_m": named(self.apogee),
            "true_apogee_m": named(three_of_all(self.forecast.true_apogee)),
            "slope_m_per_g": self.slope / 1e3,
            **self.there.json(),
            "today": self.today.json(),
            "reach_m": list(self.reach),
            "met": self.met,
            **gain_json(self.gain, self.gain_error, self.clear),
            "too_heavy": self.too_heavy,
        }


def ballast(
    plan: Plan, goal: Goal, bounds: tuple[float | None, float | None] = (None, None), draws: int = DRAWS
) -> Ballast:
    """The dry mass within `bounds` [kg] that best meets a goal; with a season the duration counts as well.

    The apogee is as the altimeter reads it, including its error. Raises ImpossibleFlight if no mass lifts off.
    """
    from scipy.interpolate import PchipInterpolator  # takes 0.3 s to import

    current = plan.flight.dry_mass
    if current is None:
        raise ImpossibleFlight("no dry mass, expected --dry-mass, the rocket's mass without its motor")
    masses = _masses(current, _legal(goal, plan, bounds))
    predictions = plan.forecasts_at((*masses, current), draws=draws)
    apogee = np.stack([one.apogee for one in predictions], axis=-1)
    if not np.median(apogee[:, 0]) > 0:
        raise ImpossibleFlight(f"{plan.found.motor.designation}: found too little thrust for the lowest mass")
    duration = common_durations(predictions, plan.fall)
    curve = PchipInterpolator(masses, np.stack([apogee, duration])[:, :, :-1], axis=2)
    mass = _best(curve, masses, goal)
    if goal.aim == "chance" and goal.chance(curve(mass)[0]) < 1e-3:
        # far from the target every probability is zero; there the mean miss guides the search
        mass = _best(curve, masses, Goal(goal.target, goal.within, "error"))
    forecast, low, high = _named(plan, mass, masses, np.median(apogee[:, :-1], axis=0), draws)
    saved = _points(goal, apogee[:, -1], duration[:, -1]) - _points(goal, *curve(mass))
    gain, error = gain_of(saved, predictions[0].rests_on)
    return Ballast(
        mass=mass,
        add=mass - current,
        forecast=forecast,
        unchanged=plan.forecast(),
        slope=float(np.median(curve(mass, 1)[0])),
        there=_result(goal, *curve(mass)),
        today=_result(goal, apogee[:, -1], duration[:, -1]),
        reach=(low, high),
        met=low <= goal.target <= high,
        gain=gain,
        gain_error=error,
        too_heavy=_too_heavy(goal, plan),
    )


def _points(goal: Goal, apogee: Figures, duration: Figures) -> Figures:
    """Points of a season; without a season, feet off the target."""
    return np.abs(apogee - goal.target) / FOOT if goal.rule is None else goal.rule.points(apogee, duration)


def _legal(goal: Goal, plan: Plan, bounds: tuple[float | None, float | None]) -> tuple[float | None, float | None]:
    """Bounds of the dry mass within the season's limit for the mass on the pad. [kg]"""
    if goal.rule is None or goal.rule.mass is None:
        return bounds
    most = goal.rule.mass - plan.found.motor.loaded_mass
    return bounds[0], most if bounds[1] is None else min(most, bounds[1])


def _too_heavy(goal: Goal, plan: Plan) -> bool:
    """Whether a plan exceeds its season's limit for the mass on the pad."""
    most, dry_mass = None if goal.rule is None else goal.rule.mass, plan.flight.dry_mass
    return most is not None and dry_mass is not None and dry_mass + plan.found.motor.loaded_mass > most + 1e-6


def _masses(current: float, bounds: tuple[float | None, float | None]) -> Float[Array, "mass"]:
    low, high = (edge or current * ratio for edge, ratio in zip(bounds, (MIN_MASS_RATIO, MAX_MASS_RATIO), strict=True))
    if not 0 < low < high:
        ends = f"a lowest mass of {amount(low, 'g')} is not below the highest, a mass of {amount(high, 'g')}"
        raise ImpossibleFlight(message(ends))
    return np.linspace(low, high, GRID)


def _named(plan: Plan, mass: float, masses: Array, medians: Array, draws: int) -> tuple[Prediction, float, float]:
    """The flight at a mass, and the lowest and the highest median apogee of all masses [m], with common random numbers,
    which ensures that the flight lies within that range."""
    ends = masses[int(np.argmin(medians))], masses[int(np.argmax(medians))]
    predictions = plan.forecasts_at((mass, *ends), draws=draws)
    heights = [float(np.median(one.apogee)) for one in predictions]
    return predictions[0], min(heights), max(heights)


def _best(curve: Any, masses: Float[Array, "mass"], goal: Goal) -> float:
    """The mass with the lowest cost: the best grid point, refined between its neighbors. [kg]"""
    from scipy.optimize import minimize_scalar  # takes 0.3 s to import

    costs = [goal.cost(*curve(mass)) if np.median(curve(mass)[0]) > 0 else np.inf for mass in masses]
    best = int(np.argmin(costs))
    around = masses[max(best - 1, 0)], masses[min(best + 1, len(masses) - 1)]
    found = minimize_scalar(
        lambda mass: goal.cost(*curve(mass)), bounds=around, method="bounded", options={"xatol": 1e-5}
    )
    return float(found.x) if found.fun <= costs[best] else float(masses[best])


def _result(goal: Goal, apogee: Figures, duration: Figures) -> Result:
    return Result(goal.chance(apogee), goal.error(apogee), goal.points(apogee, duration))

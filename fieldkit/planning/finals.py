"""Optimize mass and parachute together for altitude and time, with a table for the targets of finals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.forecast.prediction import Prediction
from fieldkit.messages import amount, message
from fieldkit.planning.check import SafetyCheck, strictest
from fieldkit.planning.contest import Season
from fieldkit.planning.descent import common_durations
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.quantiles import Three, three, three_of_all
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

MASSES = 13
"""Number of masses simulated; values between them are interpolated. [1]"""
FINE_MASSES = 97
"""Number of masses evaluated. [1]"""
AREAS = tuple(np.exp(0.1 * np.arange(-12, 10)))
"""Areas of the parachute that are evaluated, the current one among them, as a ratio to it. [1]"""
CURRENT_AREA = int(np.argmin(np.abs(np.log(AREAS))))
"""Place of the current area among `AREAS`. [1]"""
MIN_MASS_RATIO = 0.6
"""Lowest dry mass evaluated, as a ratio to the current mass. [1]"""
DRAWS = 300
STEP = 5 * FOOT
"""Interval between the targets of a table. [m]"""


@dataclass(frozen=True, slots=True)
class FinalsRow:
    """The dry mass [kg] and the ratio of the parachute's area to the current one [1] with the fewest points for a
    target [m] and a window [s]: apogee and duration at 5, 50 and 95%, and points per flight.

    Without a measured descent there is nothing to find the area by: it stays the current one, and the points are those
    for the altitude.
    """

    target: float
    window: tuple[float, float]
    mass: float
    area: float
    apogee: Three
    duration: Three | None
    points: float
    at_edge: bool = False
    """Whether the optimum is at the edge of the masses or areas evaluated."""


@dataclass(frozen=True, slots=True)
class TrialFlights:
    """Simulated flights of a plan at several masses [kg], with common draws: altimeter readings [m] and the duration
    with each area [s]; the forecasts from the lightest to the heaviest, and the basis of the descent."""

    masses: Float[Array, "mass"]
    apogee: Float[Array, "mass draw"]
    duration: Float[Array, "area mass draw"]
    forecasts: tuple[Prediction, ...]
    fall: Fall

    def forecast_at(self, mass: float) -> Prediction:
        """The forecast at the simulated dry mass nearest to a mass. [kg]"""
        return min(self.forecasts, key=lambda one: abs((one.plan.dry_mass or 0.0) - mass))

    def area_index(self, area: float) -> int:
        """The place among `AREAS` of the nearest to an area. [1]"""
        return int(np.argmin(np.abs(np.log(np.array(AREAS) / area))))

    def best(self, rule: Season) -> FinalsRow:
        """The mass and area with the fewest points under a season's rules."""
        timed = np.full_like(self.duration, np.nan) if self.fall.assumed else self.duration
        points = np.array([rule.points(self.apogee, one).mean(axis=-1) for one in timed])
        best, row = np.unravel_index(int(np.argmin(points)), points.shape)
        area = CURRENT_AREA if self.fall.assumed else int(best)
        return FinalsRow(
            rule.target,
            rule.window,
            float(self.masses[row]),
            float(AREAS[area]),
            three_of_all(self.apogee[row]),
            three(self.duration[area, row]),
            float(points[area, row]),
            bool(area in (0, len(AREAS) - 1) or row == 0),
        )


@dataclass(frozen=True, slots=True)
class FinalsPlan:
    """A plan for the finals of a season: its trial flights, the best mass and area for each target, and the safety
    checks of the lightest or the heaviest of these flights, whichever is worse; `heaviest` is the forecast of the
    latter."""

    plan: Plan
    rule: Season
    flown: TrialFlights
    table: Sequence[FinalsRow]
    lines: Sequence[SafetyCheck]
    heaviest: Prediction


def finals_plan(
    plan: Plan,
    rule: Season,
    checks: Callable[[Prediction, float], Sequence[SafetyCheck]],
    lightest: float | None = None,
) -> FinalsPlan:
    """A plan for every target that the finals of a season may have, with masses from the `lightest` [kg]; `checks` are
    those of a forecast with a fraction of the parachute's area. Raises ImpossibleFlight as `trials`."""
    flown = trials(plan, rule, (lightest, None))
    table = finals_table(flown, rule, finals_targets(rule))
    ends = end_flights(plan, table)
    return FinalsPlan(
        plan, rule, flown, table, strictest(*(list(checks(one, area)) for one, area in ends)), ends[-1][0]
    )


def trials(plan: Plan, rule: Season, bounds: tuple[float | None, float | None] = (None, None)) -> TrialFlights:
    """Simulate a plan at masses within the legal range, or within bounds of the dry mass [kg].

    Raises ImpossibleFlight for a plan without a dry mass, or if no mass within bounds lifts off.
    """
    from scipy.interpolate import PchipInterpolator  # takes 0.3 s to import

    dry_mass, motor = plan.flight.dry_mass, plan.found.motor
    if dry_mass is None:
        raise ImpossibleFlight("no dry mass, expected --dry-mass, the rocket's mass without its motor")
    most = bounds[1] or (rule.mass - motor.loaded_mass if rule.mass else 1.3 * dry_mass)
    low = bounds[0] or min(MIN_MASS_RATIO * dry_mass, MIN_MASS_RATIO * most)
    if not 0 < low < most:
        ends = f"a lowest mass of {amount(low, 'g')} is not below the highest, a mass of {amount(most, 'g')}"
        raise ImpossibleFlight(message(ends))
    flown = np.linspace(low, most, MASSES)
    predictions, fall = plan.forecasts_at(flown, draws=DRAWS), plan.fall
    if not np.median(predictions[0].apogee) > 0:
        raise ImpossibleFlight(f"{motor.designation}: found too little thrust for the lowest mass")
    timed = [common_durations(predictions, fall, float(area)).T for area in AREAS]
    fine = np.linspace(low, most, FINE_MASSES)
    apogee = PchipInterpolator(flown, np.stack([one.apogee for one in predictions]), axis=0)(fine)
    duration = np.stack([PchipInterpolator(flown, one, axis=0)(fine) for one in timed])
    return TrialFlights(fine, np.asarray(apogee), np.asarray(duration), tuple(predictions), fall)


def finals_targets(rule: Season) -> list[float]:
    """Targets that finals may have, every five feet, without one that is never announced; the season's target if its
    rules have no range. [m]"""
    if rule.finals_range is None:
        return [rule.target]
    low, high = rule.finals_range
    every = [float(one) for one in np.arange(low, high + 0.5 * STEP, STEP)]
    return [one for one in every if rule.finals_never is None or abs(one - rule.finals_never) > 0.5 * FOOT] or every


def finals_table(flown: TrialFlights, rule: Season, targets: Sequence[float]) -> list[FinalsRow]:
    """The best mass and area for each target [m], in the window of the rules."""
    return [flown.best(rule.announced(target, None)) for target in targets]


def end_flights(plan: Plan, table: Sequence[FinalsRow]) -> list[tuple[Prediction, float]]:
    """Forecasts of the lightest and the heaviest flight of a table with their parachute areas [1]: no other one goes
    higher than the first, or leaves the rail slower than the last. Raises ImpossibleFlight as `forecasts`."""
    ordered = sorted(table, key=lambda one: one.mass)
    ends = ordered[0], ordered[-1]
    made = plan.forecasts_at((one.mass for one in ends), draws=DRAWS)
    return list(zip(made, (one.area for one in ends), strict=True))

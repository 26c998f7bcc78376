"""A contest season step by step, from the kit to the finals: what is done, what is missing, and what helps most."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.flight import Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found
from fieldkit.paths import data_file
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.contest import Season, score
from fieldkit.planning.contest_limits import allowed, approved_motors
from fieldkit.planning.finals import finals_table, finals_targets, trials
from fieldkit.planning.forecasts import RocketData
from fieldkit.planning.outlook import Outlook, outlook
from fieldkit.planning.practice import Practice, Setting, final_scores, practice, setting
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger

CHECK_SHAPES = False


@dataclass(frozen=True, slots=True)
class SeasonGuide:
    """Where a team stands: the flights `scored` by the season's rule, by id in `points`; mass and parachute together
    (`now`), with their flight `ahead` and its checks; the practice; the `scores` at the end, None if all are flown."""

    rule: Season
    scored: Sequence[tuple[Flight, float]]
    points: dict[str, float]
    lines: Sequence[SafetyCheck]
    now: Setting
    practice: Practice
    ahead: Outlook
    scores: Float[Array, "draw"] | None


def season_guide(
    ledger: "Ledger",
    rocket: RocketData,
    plan: Flight,
    found: Found,
    rule: Season,
    declared: Sequence[str],
    length: float | None,
    safety: Callable[[Prediction, float], list[SafetyCheck]],
) -> SeasonGuide:
    """The guide of a plan through a season, with the flights `declared` so far and the rocket's length [m].

    `safety` has the checks of a forecast with a fraction of the parachute's area. Raises ImpossibleFlight for a plan
    without a mass or with too little thrust, BadValue for a recovery or a record of a flight that cannot be read.
    """
    scored = score(rule, ledger.flights(plan.rocket))
    flown = trials(rocket, plan, found, rule)
    plans, shared_sd = practice(rocket, plan, found, rule, flown, finals_table(flown, rule, finals_targets(rule)))
    now = setting(flown, flown.best(rule), shared_sd)
    ready = plan.with_changes(dry_mass=now.row.mass)
    ahead = outlook(rule, rocket, ready, found, now.row.area)
    limits = allowed(rule, ready, found, length, approved_motors(rule.year, data_file("seasons")))
    points = {flight.flight_id: own for flight, own in scored}
    known = [own for name in declared if not math.isnan(own := points.get(name, math.nan))]
    scores = final_scores(rule, known, ahead.points, max(rule.declared - len(declared), 0))
    return SeasonGuide(
        rule, scored, points, [*safety(ahead.forecast, now.row.area), *limits], now, plans, ahead, scores
    )

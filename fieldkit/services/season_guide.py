"""A contest season step by step, from the kit to the finals: what is done, what is missing, and what helps most."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.contest import Scored, Season, score
from fieldkit.planning.contest_day import Day
from fieldkit.planning.contest_limits import allowed
from fieldkit.planning.finals import finals_table, finals_targets, trials
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.outlook import Outlook, outlook
from fieldkit.planning.practice import Practice, Setting, final_scores, practice, setting
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger


@dataclass(frozen=True, slots=True)
class SeasonGuide:
    """Where a team stands with a plan on a day of a season: the flights `scored` by its rule, by id in `points`; mass
    and parachute together (`now`), with their flight `ahead` and its checks; the practice; the `scores` at the end,
    None if all are flown."""

    plan: Plan
    rule: Season
    day: Day
    scored: Sequence[Scored]
    points: dict[str, float | None]
    lines: Sequence[SafetyCheck]
    now: Setting
    practice: Practice
    ahead: Outlook
    scores: Float[Array, "draw"] | None


def season_guide(
    ledger: "Ledger", plan: Plan, rule: Season, day: Day, safety: Callable[[Prediction, float], list[SafetyCheck]]
) -> SeasonGuide:
    """The guide of a plan through a season, by the flights declared so far.

    `safety` has the checks of a forecast with a fraction of the parachute's area. Raises ImpossibleFlight for a plan
    without a mass or with too little thrust, BadValue for a recovery or a record of a flight that cannot be read.
    """
    scored = score(rule, ledger.flights(plan.flight.rocket))
    flown = trials(plan, rule)
    plans, shared_sd = practice(plan, rule, flown, finals_table(flown, rule, finals_targets(rule)))
    now = setting(flown, flown.best(rule), shared_sd)
    ready = plan.with_changes(dry_mass=now.row.mass)
    ahead = outlook(rule, ready, now.row.area)
    lines = [*safety(ahead.forecast, now.row.area), *allowed(rule, ready.flight, ready.found, day.length)]
    points = {flight.flight_id: own for flight, own in scored}
    known = [own for name in day.declared if (own := points.get(name)) is not None]
    scores = final_scores(rule, known, ahead.points, max(rule.declared - len(day.declared), 0))
    return SeasonGuide(plan, rule, day, scored, points, lines, now, plans, ahead, scores)

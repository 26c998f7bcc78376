"""Decisions for a plan on one motor, in words: delay, ballast, points, saved forecasts and their results.

The pictures of the Decide screen: delays around apogee, densities of apogees and points, forecasts and results.

The landing of a plan: draws of its flight from the side, and their landings on the field from above.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import Flight
from fieldkit.flight.short_name import short_name
from fieldkit.flight.site import Site
from fieldkit.forecast.evaluation.comparison import judged_report
from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.forecast.prediction import Prediction
from fieldkit.ledger import Ledger
from fieldkit.messages import message
from fieldkit.motors import Catalogue
from fieldkit.motors.several import CLUSTER_NOTE
from fieldkit.paths import data_file
from fieldkit.planning.ballast import Goal, ballast
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.contest import Season, declared_score, rule_of, score
from fieldkit.planning.contest_day import Day
from fieldkit.planning.contest_flight import judged_duration, why_no_score
from fieldkit.planning.contest_limits import allowed
from fieldkit.planning.delay import Delays, delays, drill_of
from fieldkit.planning.descent_rate import fall_of
from fieldkit.planning.finals import FinalsRow
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.limits import Limit
from fieldkit.planning.outlook import outlook
from fieldkit.planning.planned_flight import PlannedFlight, planned_flight
from fieldkit.planning.quantiles import three_of_all
from fieldkit.planning.safety import safety_lines
from fieldkit.presentation.forecast_text import in_words as forecast_in_words
from fieldkit.presentation.landing_text import landing_in_words
from fieldkit.presentation.planning_text import ballast_in_words, conditions_in_words, delays_in_words, outlook_in_words
from fieldkit.presentation.score_text import in_brief
from fieldkit.presentation.season_text import SeasonWays, season_steps
from fieldkit.quantities import ShownUnits, in_system, measure, number, shown_unit, spelled, unit_of
from fieldkit.services.saved_forecasts import LISTED_STATES, SavedForecast, in_words, list_forecasts, standing
from fieldkit.services.season_guide import season_guide
from fieldkit.services.track_record import replayed
from fieldkit.shapes import Array, Float
from fieldkit.tui.next.answer import Answer, with_ballast, with_delay, with_misses, with_points
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.next.motor_rows import TARGET_BAND
from fieldkit.tui.next.next_words import by_keys, folded, unfolded
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.plots import Marked, draw_density, round_axes

DRAWN_FLIGHTS = 30
"""Number of draws with lines from pad to apogee to landing. [1]"""
DRAWN_LANDINGS = 200
"""Number of draws with a dot at the landing. [1]"""
CIRCLE = 90
"""Points of the outline of a field. [1]"""
DRAWN_WINDS = {"m/s": (2, 4, 6, 8), "mph": (5, 10, 15, 20)}
"""Winds at the pad in which a drift is drawn, by the unit of speed that is shown; the codes allow 20 mph."""
CELL_ASPECT = 2.0
"""Aspect ratio of a terminal's cell, height over width. [1]"""


def of_landing(answer: Answer, one: PlannedFlight, size: float | None, system: str) -> Answer:
    """The answer with both pictures; `size` is of the field across. [m]"""
    unit = spelled(unit_of(cards.APOGEE, system))
    field = ", circle the field" if size else ""
    title = f"{DRAWN_FLIGHTS} simulations from the side, pad to apogee to landing; and landings from above, "
    title += f"wind to the right: ▲ pad, ellipse 90% of them{field} [{unit}]"
    scaled = partial(_scaled, system)
    return replace(
        answer, title=title, draw=partial(_from_the_side, one, scaled), second=partial(_from_above, one, size, scaled)
    )


def of_drift(answer: Answer, one: PlannedFlight, size: float | None, system: str) -> Answer:
    """The answer with the drift of the descent in several winds; `size` is of the field across. [m]"""
    if one.prediction.stays_on_rail:
        return answer
    shown, drift = ShownUnits(system), three_of_all(one.down.drift)
    winds = [wind * shown.speed_factor for wind in DRAWN_WINDS[shown.speed_unit]]
    rows = tuple(IntervalBar(shown.speed(wind, 0), *(wind * end for end in drift)) for wind in winds)
    edge = {"edge of the field": size / 2} if size else {}
    title = "Drift on the way down by the wind at the pad: 90% of flights, ● median" + "; ◎ the field ends" * bool(size)
    ends = [_scaled(system, winds[-1] * end) for end in drift]
    edges = [_scaled(system, end) for end in edge.values()]
    plot = partial(_drift_by_wind, ends, DRAWN_WINDS[shown.speed_unit][-1], edges)
    unit = spelled(unit_of(cards.APOGEE, system))
    below = f"Drift [{unit}] by the wind [{spelled(shown.speed_unit)}]"
    return replace(answer, title=title, intervals=Intervals(rows, shown.length, edge), below=below, draw=plot)


def _drift_by_wind(ends: Sequence[float], wind: float, edges: Sequence[float], plt: Any, ink: Any) -> None:
    """Draw the drift from none in calm air to the 5, 50 and 95% quantiles `ends` at a wind, in displayed units, and the
    edge of the field where it is known."""
    for end, color in zip(ends, (ink.text, ink.line, ink.text), strict=True):
        plt.plot([0.0, wind], [0.0, end], marker="braille", color=color)
    for edge in edges:
        plt.hline(edge, color=ink.mark)
    round_axes(plt, ink, (0.0, wind), (0.0, max(*ends, *edges)))


def _from_the_side(one: PlannedFlight, scaled: Callable[[float], float], plt: Any, ink: Any) -> None:
    """Draw pad, apogee and landing of some draws, joined by straight lines."""
    prediction, down = one.prediction, one.down
    drift = np.broadcast_to(np.nan_to_num(prediction.drift), prediction.apogee.shape)
    tops, across = [], [0.0]
    for row in range(min(DRAWN_FLIGHTS, len(prediction.apogee))):
        up, end, top = (scaled(float(part[row])) for part in (drift, down.along, prediction.apogee))
        plt.plot([0.0, up, end], [0.0, top, 0.0], marker="braille", color=ink.line)
        across += [up, end]
        tops.append(top)
    plt.scatter([0.0], [0.0], marker="▲", color=ink.mark)
    round_axes(plt, ink, (min(across), max(across)), (0.0, 1.05 * max(tops)))


def _from_above(one: PlannedFlight, size: float | None, scaled: Callable[[float], float], plt: Any, ink: Any) -> None:
    """Draw landings, their ellipse and the field around the pad, with equal scales on the screen."""
    down = one.down
    along, across = ([scaled(float(x)) for x in part[:DRAWN_LANDINGS]] for part in (down.along, down.across))
    outline = [[scaled(float(x)) for x in column] for column in down.ellipse().outline().T]
    turn = np.linspace(0, 2 * np.pi, CIRCLE)
    radius = scaled(size / 2) if size else 0.0
    field = [(radius * np.cos(turn)).tolist(), (radius * np.sin(turn)).tolist()]
    plt.scatter(along, across, marker="·", color=ink.text)
    plt.plot(*outline, marker="braille", color=ink.line)
    if size:
        plt.plot(*field, marker="braille", color=ink.mark)
    plt.scatter([0.0], [0.0], marker="▲", color=ink.mark)
    xs, ys = [*along, *outline[0], *field[0], 0.0], [*across, *outline[1], *field[1], 0.0]
    middle = [(min(one) + max(one)) / 2 for one in (xs, ys)]
    half = max((max(xs) - min(xs)) / 2 * ink.height * CELL_ASPECT / ink.width, (max(ys) - min(ys)) / 2) * 1.05
    wide = half * ink.width / (ink.height * CELL_ASPECT)
    round_axes(plt, ink, (middle[0] - wide, middle[0] + wide), (middle[1] - half, middle[1] + half))


def _scaled(system: str, height: float) -> float:
    """A length [m] in the units in which apogees are shown."""
    return float(number(cards.APOGEE, abs(height), system)) * (1 if height >= 0 else -1)


MAX_DRAWN_FORECASTS = 24
"""Number of latest forecasts to draw."""


def of_delays(answer: Answer, judged: Delays) -> Answer:
    """When each delay fires, relative to apogee, and below it the coast to apogee with the delays."""
    rows = tuple(
        IntervalBar(f"{one.delay:g} s{'' if one.on_sale else '*'}", *one.after_apogee)
        for one in sorted(judged.delays, key=lambda one: one.delay)
        if one.after_apogee is not None
    )
    if not rows:
        return answer
    title = "When each delay fires, 90% of flights, ● median; ◎ is apogee"
    delays = [one.delay for one in judged.delays]
    return replace(
        answer,
        title=title,
        intervals=Intervals(rows, lambda value: f"{value:+.1f} s", {"apogee": 0.0}),
        below="Coast to apogee; lines are the delays",
        draw=draw_density(judged.coasts, lambda value: f"{value:g} s", ticks=delays),
    )


def of_apogee(answer: Answer, apogee: Float[Array, "draw"], target: float | None, system: str) -> Answer:
    """The density of the apogee at that mass, with the target; without one, at the mass of the plan."""
    marks = [Marked("◎", target)] if target is not None else []
    at = " at that mass; ◎ is the target" if target is not None else ""
    title = f"Apogee on the altimeter{at}; filled 90%, line the median"
    unit = shown_unit(cards.APOGEE, system)
    return replace(
        answer, title=title, draw=draw_density(apogee, lambda height: _height(height, system), *marks, unit=unit)
    )


def of_points(answer: Answer, points: Float[Array, "draw"], what: str = "Points of a flight") -> Answer:
    """The density of the points of a flight, or of `what`."""
    draw = draw_density(points, lambda value: f"{value:.0f}")
    return replace(answer, title=f"{what}, fewer are better; filled 90%, line the median", draw=draw)


def of_targets(answer: Answer, table: Sequence[FinalsRow], system: str) -> Answer:
    """The points of a flight for each target of a table, as a line."""
    if len(table) < 2:
        return answer
    targets, points = [_scaled(system, row.target) for row in table], [row.points for row in table]
    unit = spelled(unit_of(cards.APOGEE, system))

    def draw(plt: Any, ink: Any) -> None:
        plt.plot(targets, points, marker="braille", color=ink.line)
        plt.scatter(targets, points, marker="●", color=ink.mark)
        margin = 0.1 * (max(points) - min(points)) or 1.0
        round_axes(plt, ink, (targets[0], targets[-1]), (min(points) - margin, max(points) + margin))

    return replace(answer, title=f"Points of a flight by the target [{unit}], fewer are better", draw=draw)


def saved_forecast_plot(answer: Answer, found: Sequence[SavedForecast], system: str) -> Answer:
    """The saved forecasts, newest first, and the apogees flown."""
    rows = tuple(
        IntervalBar(f"{one.made.at.astimezone():%m-%d} {one.made.payload.get('motor', '')}", *one.interval, one.flown)
        for one in reversed([one for one in found if one.state in LISTED_STATES][-MAX_DRAWN_FORECASTS:])
    )
    return _against_flown(answer, rows, system)


def of_forecasts(answer: Answer, rows: Sequence[Forecast], system: str) -> Answer:
    """Each flight with its forecast from the earlier ones, the newest first."""
    last = [(one, one.corrected or (one.p05, one.p95)) for one in reversed(rows[-MAX_DRAWN_FORECASTS:])]
    drawn = tuple(
        IntervalBar(f"{one.flight_id} {one.motor}", low, one.p50, high, one.flown) for one, (low, high) in last
    )
    return _against_flown(answer, drawn, system)


def _against_flown(answer: Answer, rows: tuple[IntervalBar, ...], system: str) -> Answer:
    if not rows:
        return answer
    title = "Forecast and flown: 90% should fall on the line; ● median, ◆ flown"
    return replace(answer, title=title, intervals=Intervals(rows, lambda height: _height(height, system), {}))


def _height(height: float, system: str) -> str:
    return measure(cards.APOGEE, height, system)


Aim = Literal["chance", "error", "points"]
AIMS: tuple[Aim, ...] = ("chance", "error", "points")
"""The goals for ballast, as in the command: the band, the mean miss, the points of a season."""
SEASON_KEYS = SeasonWays(
    add="a to add it, with its duration",
    parachute="enter its diameter with p on the Fly page",
    motors="Esc for the list, g for the target",
    finals="w to write it",
)
"""The keys that do what the steps of a season ask for."""
UNCHECKED_TOOL = "  Drill by the marks on your tool: its cuts were not checked (! for more)."
"""The note on a drilling tool that was not checked against its instructions."""
MAX_SCORED_FLIGHTS = 6
"""Number of latest flights whose points are listed."""


@dataclass(frozen=True, slots=True)
class Decision:
    """A plan on a motor, and the inputs of its answers; pictures are in the units of a `system`."""

    plan: Plan
    site: Site
    limits: dict[str, Limit]
    system: str = "SI"

    def delay(self) -> Answer:
        """The delays on sale and those that the maker's tool drills."""
        fast = self.limits["eject_speed"].value
        tool = drill_of(self.plan.found.motor, data_file("drills.toml"))
        takes_off = tool.takes_off if tool else ()
        left = tool.least_left if tool else 0.0
        judged = delays(self.plan, fast, takes_off, left)
        answer = self._answer(tuple(delays_in_words(judged, fast, None, self.system)), judged.forecast)
        if tool is not None and tool.caveat and not all(one.on_sale for one in judged.delays):
            caveat = "  " + in_system(message(tool.caveat), self.system)
            answer = replace(answer, words=(*answer.words, UNCHECKED_TOOL), beside=(caveat, "", *answer.beside))
        return of_delays(with_delay(answer, judged), judged)

    def ballast(self, target: float | None, aim: Aim, year: int, day: Day) -> Answer:
        """The dry mass that best meets a target [m], or has the fewest expected points of a season."""
        rule = day.rule(rule_of(year).announced(target, None)) if aim == "points" else None
        wanted = rule.target if rule else target
        if wanted is None:
            return self._without_target()
        goal = Goal(wanted, TARGET_BAND, aim, rule)
        best = ballast(self.plan, goal)
        prediction = best.advised
        more = _limits_of(rule, prediction, day) if rule else ()
        answer = self._answer(tuple(ballast_in_words(best, goal, self.system)), prediction, more)
        answer = with_ballast(answer, best, self.system)
        return of_apogee(answer, prediction.apogee, goal.target, self.system)

    def _without_target(self) -> Answer:
        """The forecast as the rocket is, and what a target would add."""
        prediction = self.plan.forecast()
        words = (
            "No target yet. g to set one",
            "",
            "With a target: the mass to add or to take off, the chance to be near it, and the forecast at that mass. j "
            "changes what is aimed at.",
        )
        answer = self._answer(words, prediction)
        return of_apogee(answer, prediction.apogee, None, self.system)

    def contest(self, ledger: Ledger, year: int, area: float, day: Day) -> Answer:
        """The expected points of a plan by a season's rule with a fraction of the parachute's area [1], the chance to
        qualify, and the points of the flights flown."""
        rule = day.rule(rule_of(year))
        ahead = outlook(rule, self.plan, area)
        prediction = ahead.forecast
        words = (*outlook_in_words(ahead, rule, area, day.cut, self.system), *self._scored(ledger, rule, day))
        answer = self._answer(words, prediction, _limits_of(rule, prediction, day), area)
        points = ahead.points.ravel()
        return of_points(with_points(answer, points), points)

    def season(self, ledger: Ledger, year: int, day: Day) -> Answer:
        """A season's steps: what is done, what is missing, and what to do next."""
        one = season_guide(ledger, self.plan, rule_of(year), day, self._checks)
        words = [f"Season {year}: {self.plan.flight.rocket}"]
        for step, (name, state, texts) in enumerate(season_steps(one, SEASON_KEYS, self.system), start=1):
            state = f": {state}" if state else ""
            words += ["", f"{step}. {name}{state}", *(f"   {by_keys(text)}" for text in texts)]
        answer = Answer(
            tuple(words), tuple(unfolded(one.lines, self.system)), folded=tuple(folded(one.lines, self.system))
        )
        if one.scores is None:
            return of_points(answer, one.ahead.points.ravel())
        return of_points(answer, one.scores, "Score at the end of qualification, as in step 6")

    def contest_checks(self, rule: Season, day: Day) -> Callable[[Prediction, float], list[SafetyCheck]]:
        """The safety checks of a forecast with a fraction of the parachute's area [1], and the season's limits."""
        return lambda prediction, area: [*self._checks(prediction, area), *_limits_of(rule, prediction, day)]

    def _checks(self, prediction: Prediction, area: float) -> list[SafetyCheck]:
        """The safety checks of a forecast with a fraction of the parachute's area. [1]"""
        fall = fall_of(self.plan.rocket.history, prediction.plan, prediction.found).on_area(area)
        return safety_lines(prediction, self.site, fall, self.limits)

    def landing(self) -> Answer:
        """The landing of the plan in its wind, relative to the field, and the rail angle that brings it nearest."""
        one = planned_flight(self.plan, self.site, self.limits)
        words = tuple(map(by_keys, landing_in_words(one, self.site, self.system)))
        words += ("", "w to write the range safety sheet, R the range card")
        answer = Answer(words, tuple(unfolded(one.lines, self.system)), folded=tuple(folded(one.lines, self.system)))
        place = of_drift if one.down.wind is None else of_landing
        return place(answer, one, self.site.size, self.system)

    def noted(self, answer: Answer) -> Answer:
        """An answer with a note on what is not modeled for a cluster."""
        return (
            replace(answer, words=(*answer.words, f"  note      {CLUSTER_NOTE}"))
            if self.plan.found.motor.parts
            else answer
        )

    def saved_forecasts(self, ledger: Ledger, motors: Catalogue) -> Answer:
        """The saved forecasts of the rocket, the newest first, each marked if it is stale, with the reason."""
        found = list_forecasts(ledger, motors, self.plan.flight.rocket)
        if not found:
            fared = self.fared(ledger, motors)
            none = "No saved forecasts of this rocket yet. Press Enter on the Fly page to save one."
            instead = ("As they would have been, from the flights before each:", "") if fared.intervals else ("",)
            return replace(fared, words=(none, *instead, *fared.words))
        words = [standing(found)]
        for one in reversed([one for one in found if one.state in LISTED_STATES]):
            payload = one.made.payload
            words += ["", f"{one.state}: {payload.get('motor', '')} {payload.get('config', '')}".rstrip()]
            words += [f"  {line}" for line in in_words(one, self.system)]
        return saved_forecast_plot(Answer(tuple(words)), found, self.system)

    def fared(self, ledger: Ledger, motors: Catalogue) -> Answer:
        """The quality of forecasts of this rocket: of each flight from all rockets' earlier flights."""
        rocket = self.plan.flight.rocket
        rows = [row for row in replayed(ledger, motors, rocket) if row.earlier]
        if not rows:
            return self._unscored(ledger.flights(rocket))
        found = judged_report(rows)
        answer = with_misses(Answer(tuple(in_brief(found, self.system))), found, rocket, self.system)
        return of_forecasts(answer, rows, self.system)

    def _unscored(self, flights: Sequence[Flight]) -> Answer:
        """What a score needs and will show, the flights so far, and the next forecast if it can be made."""
        normal = sum(one.clean and one.apogee is not None for one in flights)
        words = [
            f"A score needs two normal flights with an apogee; {self.plan.flight.rocket} has {normal or 'none'}.",
            "Each flight is then forecast from the earlier ones: how far off that is, beside simpler methods, and "
            "whether nine flights in ten fall inside the 90% interval.",
        ]
        if flights:
            words += ["", "Flights so far", *self._flown(flights[-MAX_DRAWN_FORECASTS:])]
        try:
            prediction = self.plan.forecast()
        except FieldkitError as error:
            return Answer((*words, "", f"No forecast yet: {in_system(error, self.system)}"))
        words += ["", "The next flight", *forecast_in_words(prediction, self.system)]
        unit, last = shown_unit(cards.APOGEE, self.system), self.plan.found.motor.designation
        flown = [Marked("◆", one.apogee) for one in flights if one.clean and one.apogee is not None]
        title = f"Apogee of the next flight on {last}; filled 90%, line the median" + ", ◆ flown so far" * bool(flown)
        number = partial(_height, system=self.system)
        return Answer(tuple(words), title=title, draw=draw_density(prediction.apogee, number, *flown, unit=unit))

    def _flown(self, flights: Sequence[Flight]) -> Iterator[str]:
        """Each flight in a line, the newest first: `  1   F24-4W   128.0 m`."""
        for one in reversed(flights):
            day = f"{one.date_time:%Y-%m-%d}" if one.date_time else ""
            apogee = measure(cards.APOGEE, one.apogee, self.system) or "no apogee"
            parts = (f"{short_name(one):6}", day, f"{one.motor:16}", f"{apogee:>9}", *one.tags)
            yield "  " + "  ".join(part for part in parts if part)

    def _scored(self, ledger: Ledger, rule: Season, day: Day) -> Iterator[str]:
        scored = score(rule, ledger.flights(self.plan.flight.rocket))
        if not scored:
            return
        last = scored[-MAX_SCORED_FLIGHTS:]
        per_flight = [(one, own) for one, own in last if own is not None]
        alone = [short_name(one) for one, _ in per_flight if judged_duration(one) is None]
        none = [f"{short_name(one)} ({why_no_score(one, rule.egg_count)})" for one, own in last if own is None]
        if per_flight:
            points = ", ".join(f"{short_name(one)}: {own:.0f}" for one, own in per_flight)
            yield f"  flights   {points} points by this rule"
        if none:
            yield f"            no score, count as attempts: {', '.join(none)}"
        if alone:
            yield f"            altitude only, no duration: {', '.join(alone)}"
        if not day.declared:
            return
        try:
            total = declared_score(rule, scored, day.declared)
            yield f"  declared  {total:.0f} points, the best {rule.best} of {', '.join(day.declared)}"
        except BadValue as error:
            yield f"  declared  {error}"

    def _answer(
        self, words: tuple[str, ...], prediction: Prediction, more: Iterable[SafetyCheck] = (), area: float = 1.0
    ) -> Answer:
        """An answer beside the conditions of a forecast and its safety checks, with a fraction of the parachute's
        area. [1]"""
        lines = [*self._checks(prediction, area), *more]
        every, brief = (
            (*conditions_in_words(prediction.plan, self.plan.rocket.known, self.system, brief=brief), "")
            for brief in (False, True)
        )
        return Answer(words, (*every, *unfolded(lines, self.system)), folded=(*brief, *folded(lines, self.system)))


def _limits_of(rule: Season, prediction: Prediction, day: Day) -> list[SafetyCheck]:
    """The season's limits on a plan, with the flyer's own list of approved motors."""
    return allowed(rule, prediction.plan, prediction.found, day.length)

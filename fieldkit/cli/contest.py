"""`fieldkit contest`: flights and plans scored by the rule of a season."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import about_plan, length, planning, print_plan, season_rule
from fieldkit.cli.screen import complain, print_json, say, say_wrapped

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.planning.contest import Outlook, Season

app = typer.Typer()


def contest(
    context: typer.Context,
    season: Annotated[int, typer.Option(help="2020 to 2027.")],
    target: Annotated[str | None, typer.Option(help="As announced that day: 785ft.")] = None,
    window: Annotated[str | None, typer.Option(help="Seconds as announced that day: 37-40.")] = None,
    parachute: Annotated[
        str | None, typer.Option(help="Area over that of the parachute flown: 85% or 0.85; plan with --motor.")
    ] = None,
    reef: Annotated[str | None, typer.Option(help="Share of the area that reefing takes out: 10%.")] = None,
    rocket_length: Annotated[str | None, typer.Option(help="Of the rocket: 700mm.")] = None,
    cut: Annotated[float | None, typer.Option(help="Points that qualify; asks for --motor.")] = None,
    declared: Annotated[str | None, typer.Option(help="Flights whose best are summed: 4,5,6.")] = None,
    own: Annotated[bool, typer.Option("--own", help="Copy the rule to a file of yours, to check and change.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    **given: str | None,
) -> None:
    """Score flights by the rule of a season and, with --motor, say what points a plan can expect."""
    from fieldkit.paths import data_folder
    from fieldkit.planning.contest import allowed, copy_season, declared_score, outlook, score
    from fieldkit.planning.contest_day import read_declared, read_window
    from fieldkit.presentation.planning_text import outlook_in_words

    if own:
        complain(f"your own rule, used from now on: {copy_season(season, data_folder() / 'seasons')}")
    if cut is not None and given.get("motor") is None:
        raise typer.BadParameter("found --cut without --motor, expected both: the chance is that of a plan")
    rule = season_rule(season).announced(length(target), read_window(window) if window else None)
    area = _share(parachute, 1.0) * (1 - _share(reef, 0.0))
    ahead, lines = None, []
    with planning(context, given) as plan:
        scored = score(rule, plan.ledger.flights(plan.flight.rocket))
        if plan.flight.motor:
            ahead = outlook(rule, plan.rocket, plan.flight, plan.motor(), area)
            said = ahead.forecast
            lines = plan.safety(said) + allowed(rule, said.plan, said.found, length(rocket_length, "mm"))
    names = read_declared(declared or "")
    total = declared_score(rule, scored, names) if names else None
    if json:
        document = _document(rule, scored)
        if total is not None:
            document["score"] = {"declared": names, "points": total}
        if ahead is not None:
            document["plan"] = _plan_document(ahead, rule, area) | about_plan(ahead.forecast, lines)
        if ahead is not None and cut is not None:
            document["qualifies"] = {"cut": cut, "chance": ahead.chance(rule, cut)}
        print_json(document)
        return
    if not scored and ahead is None:
        complain("found no flight with an apogee to score; with --motor a plan is")
    if rule.caveat and ahead is None:
        say_wrapped(rule.caveat)
    for flight, points in scored:
        say(f"  {flight.flight_id:>8}  {points:6.1f} points  {_flown(flight)}")
    if total is not None:
        say(f"  score     {total:.1f} points, the best {rule.best} of {', '.join(names)}")
    if ahead is not None:
        print_plan(outlook_in_words(ahead, rule, area, cut), ahead.forecast.plan, lines, plan.rocket.starts)


takes_plan(contest)
app.command()(contest)


def _flown(flight: "Flight") -> str:
    """What a flight is scored by: `706 ft, 48.3 s`."""
    from fieldkit.units import FOOT

    lasted = "height alone" if flight.duration is None else f"{flight.duration:.1f} s"
    return f"{(flight.apogee or 0.0) / FOOT:.0f} ft, {lasted}"


def _share(text: str | None, default: float) -> float:
    """A share typed as `85%` or `0.85`. Raises BadValue, BadParameter."""
    from fieldkit.units import parse

    if text is None:
        return default
    share = parse(text, "fraction", "fraction")
    if not 0 <= share < 10 or (share == 0 and default):
        raise typer.BadParameter(f"found {text!r}, expected a share such as 85%")
    return share


def _document(rule: "Season", scored: "Sequence[tuple[Flight, float]]") -> dict[str, Any]:
    """The rule, and every flight with its points."""
    flights = [
        {"flight_id": flight.flight_id, "points": points, "timed": flight.duration is not None}
        for flight, points in scored
    ]
    return {"season": rule.year, "checked": rule.checked, "remarks": rule.remarks, "flights": flights}


def _plan_document(ahead: "Outlook", rule: "Season", area: float) -> dict[str, object]:
    from fieldkit.planning.quantiles import named, three

    said = ahead.forecast
    return {
        "motor": said.found.motor.designation,
        "apogee_m": named(three(said.apogee)),
        "true_apogee_m": named(three(said.true_apogee)),
        "duration_s": named(three(ahead.duration.ravel())),
        "points": {"mean": float(ahead.points.mean()), **named(three(ahead.points.ravel()))},
        "score": {"mean": float(rule.sums(ahead.points).mean()), **named(three(rule.sums(ahead.points)))},
        "timed": ahead.timed > 0,
        "timed_flights": ahead.timed,
        "parachute": {"area": area, "best_area": ahead.area, "points_there": ahead.points_there},
        "flights": said.rests_on,
        "model": said.model,
    }

"""`fieldkit contest`, `finals`: flights and plans scored by the rule of a season."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit import files
from fieldkit.cli.numbers import finite, length, typed
from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import (
    AllChecks,
    RocketLength,
    about_plan,
    planning,
    print_basis,
    print_plan,
    season_year,
)
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say, say_wrapped, system
from fieldkit.cli.session import open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.flight.short_name import short_name
from fieldkit.paths import data_file
from fieldkit.units import FOOT, parse

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.forecast.prediction import Prediction
    from fieldkit.planning.check import SafetyCheck
    from fieldkit.planning.contest import Scored, Season
    from fieldkit.planning.outlook import Outlook

app = typer.Typer()
MIN_AREA = 0.01
"""Smallest area of a parachute relative to the one flown. [1]"""


def finals(
    context: typer.Context,
    season: Annotated[int | None, typer.Option(help="2019 to 2027; default: the current season.")] = None,
    targets: Annotated[str | None, typer.Option(help="Lowest and highest target, in feet: 775-825.")] = None,
    window: Annotated[str | None, typer.Option(help="Duration window announced that day, in seconds: 37-40.")] = None,
    lightest: Annotated[str | None, typer.Option(help="Lowest possible dry mass: 480g, 17oz.")] = None,
    rocket_length: RocketLength = None,
    card: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write a one-page card: .png, .pdf, .svg.")
    ] = None,
    force: ForceOption = False,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Find the mass and parachute for each target that the finals of the American Rocketry Challenge (TARC) may
    announce."""
    from fieldkit.planning.contest import rule_of
    from fieldkit.planning.contest_day import read_targets, read_window
    from fieldkit.planning.contest_limits import allowed
    from fieldkit.planning.finals import finals_plan
    from fieldkit.presentation.finals_text import (
        ENDS_NOTE,
        FINALS_NOTES,
        finals_document,
        finals_headers,
        finals_heading,
        finals_notes,
        finals_rows,
    )

    announced, between = read_window(window) if window else None, read_targets(targets) if targets else None
    if card is not None:
        from fieldkit.presentation.report.finals_card import check_card
        from fieldkit.presentation.report.plan_pages import finals_card_of

        check_card(card)
        force = settled(card, force)
    least = typed("--lightest", lightest, "mass", "g") if lightest else None
    long = length("--rocket-length", rocket_length, "mm")
    with planning(context, given) as planned:
        plan = planned.plan()
        rule = rule_of(season_year(season)).announced(None, announced)
        if between is not None:
            rule = replace(rule, finals_range=(between[0] * FOOT, between[1] * FOOT), finals_never=None)

        def checked(one: "Prediction", area: float) -> "list[SafetyCheck]":
            return [*planned.safety(one, area), *allowed(rule, one.plan, one.found, long)]

        one = finals_plan(plan, rule, checked, least)
    chosen, fall, prediction = system(), one.flown.fall, one.heaviest
    if card is not None:
        files.write(card, finals_card_of(one, card.suffix.lower(), chosen), force=force)
        complain(f"Wrote the card to {card}")
    if json:
        document = {"season": rule.year, "motor": plan.found.motor.designation, "finals": finals_document(one)}
        document |= {"flights": prediction.rests_on, "timed_flights": fall.flights}
        print_json(document | about_plan(prediction, one.lines))
        return
    for line in (*FINALS_NOTES, *finals_notes(one), *finals_heading(one, chosen)):
        say_wrapped(line)
    headers = finals_headers(fall, chosen)
    print_table(headers, finals_rows(one, chosen), numbers=headers)
    print_basis(prediction.plan, one.lines, plan.rocket.known, every=checks)
    say_wrapped(ENDS_NOTE)


takes_plan(finals)
app.command()(finals)


def contest(
    context: typer.Context,
    season: Annotated[
        int | None,
        typer.Option(help="2019 to 2027; default: the season of the last flight; with --motor, the current one."),
    ] = None,
    target: Annotated[str | None, typer.Option(help="Target announced that day: 785ft, 239m.")] = None,
    window: Annotated[str | None, typer.Option(help="Duration window announced that day, in seconds: 37-40.")] = None,
    parachute: Annotated[
        str | None, typer.Option(help="Parachute area relative to the one flown: 85% or 0.85; needs --motor.")
    ] = None,
    reef: Annotated[str | None, typer.Option(help="Fraction of the area removed by reefing: 10%.")] = None,
    rocket_length: RocketLength = None,
    cut: Annotated[float | None, typer.Option(callback=finite, help="Points that qualify; needs --motor.")] = None,
    declared: Annotated[str | None, typer.Option(help="Flights declared, of which the best are summed: 4,5,6.")] = None,
    own: Annotated[bool, typer.Option("--own", help="Copy the rule to a file of your own, to check and edit.")] = False,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Score flights by a season of the American Rocketry Challenge (TARC); with --motor, also forecast the points of a
    plan."""
    from fieldkit.planning.contest import copy_season, declared_score, rule_of, score
    from fieldkit.planning.contest_day import read_declared, read_window
    from fieldkit.planning.contest_flight import judged_duration
    from fieldkit.planning.contest_limits import allowed
    from fieldkit.planning.outlook import outlook
    from fieldkit.presentation.planning_text import outlook_in_words

    if own:
        season = season_year(season)
        complain(f"Copied the rule to {copy_season(season, data_file('seasons'))}; it is used from now on")
    if cut is not None and given.get("motor") is None:
        raise typer.BadParameter("found --cut without --motor, expected both: the chance is for a plan")
    announced = length("--target", target), read_window(window) if window else None
    area = _area(parachute, reef)
    if not json and not (given.get("motor") or given.get("rocket")) and _has_no_flight(context):
        _print_rule(rule_of(season_year(season)).announced(*announced))
        return
    ahead, lines = None, []
    with planning(context, given) as planned:
        ledger, rocket = planned.ledger, planned.flight.rocket
        plan = planned.plan() if planned.flight.motor else None
        last = None if plan else ledger.latest(rocket)
        year = season_year(season, last.date_time if last is not None else None)
        rule = rule_of(year).announced(*announced)
        scored = score(rule, ledger.flights(rocket))
        if plan is not None:
            ahead = outlook(rule, plan, area)
            long = length("--rocket-length", rocket_length, "mm")
            lines = planned.safety(ahead.forecast, area) + allowed(rule, plan.flight, plan.found, long)
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
        complain("found no flight with an apogee to score; use --motor to score a plan")
    if rule.caveat and ahead is None:
        say_wrapped(rule.caveat)
    _print_points(rule, scored)
    if total is not None:
        untimed = [short_name(one) for one, _ in scored if one.flight_id in names and judged_duration(one) is None]
        without = (
            f"; {', '.join(untimed)} without a duration: altitude only, too few points by "
            f"{rule.per_second:g} for each second outside the window"
            if untimed
            else ""
        )
        say_wrapped(f"  score     {total:.2f} points, the best {rule.best} of {', '.join(names)}{without}", " " * 10)
    if ahead is not None:
        print_plan(
            outlook_in_words(ahead, rule, area, cut, system()),
            ahead.forecast.plan,
            lines,
            planned.rocket.known,
            every=checks,
        )


takes_plan(contest)
app.command()(contest)


def _has_no_flight(context: typer.Context) -> bool:
    """Whether the ledger is empty, as at the start of a season."""
    with open_ledger(context) as ledger:
        return ledger.latest() is None


def _print_rule(rule: "Season") -> None:
    """Print the rules of a season."""
    from fieldkit.presentation.season_text import rule_lines

    say(f"season {rule.year}")
    for line in rule_lines(rule):
        say_wrapped(f"  {line}", "    ")
    complain("no flights yet; --motor with --dry-mass and --diameter forecasts the points of a plan")


def _print_points(rule: "Season", scored: "Sequence[Scored]") -> None:
    """Print a line for each flight, with its points or why it has none."""
    from fieldkit.planning.contest_flight import why_no_score

    called = [short_name(flight) for flight, _ in scored]
    width = max(map(len, [" " * 8, *called]))
    for name, (flight, points) in zip(called, scored, strict=True):
        id = "" if name == flight.flight_id else f"  ({flight.flight_id})"
        result = f"no score      {why_no_score(flight, rule.egg_count)}; counts as an attempt"
        if points is not None:
            result = f"{points:6.2f} points  {_flown(flight)}"
        say(f"  {name:>{width}}  {result}{id}")


def _flown(flight: "Flight") -> str:
    """The values that a flight is scored on: `706 ft, 48.3 s`."""
    from fieldkit.planning.contest_flight import judged_duration, whole_feet

    duration = judged_duration(flight)
    lasted = "altitude only" if duration is None else f"{duration:.2f} s"
    return f"{whole_feet(flight.apogee or 0.0):.0f} ft, {lasted}"


def _area(parachute: str | None, reef: str | None) -> float:
    """The parachute's area relative to the one flown [1]. Raises BadValue, BadParameter."""
    area = _fraction(parachute, 1.0) * (1 - _fraction(reef, 0.0))
    if area < MIN_AREA:
        found = " ".join(f"--{name} {text}" for name, text in (("parachute", parachute), ("reef", reef)) if text)
        raise typer.BadParameter(f"found {found}, expected at least {MIN_AREA:.0%} of the parachute's area")
    return area


def _fraction(text: str | None, default: float) -> float:
    """A fraction typed as `85%` or `0.85`. Raises BadValue, BadParameter."""
    if text is None:
        return default
    fraction = parse(text, "fraction", "fraction")
    if not 0 <= fraction < 10:
        raise typer.BadParameter(f"found {text!r}, expected a percentage such as 85%")
    return fraction


def _document(rule: "Season", scored: "Sequence[Scored]") -> dict[str, Any]:
    """The rule, and every flight with its points."""
    from fieldkit.planning.contest_flight import judged_duration, why_no_score

    flights = [
        {
            "flight_id": flight.flight_id,
            "points": points,
            "no_score": why_no_score(flight, rule.egg_count),
            "timed": judged_duration(flight) is not None,
        }
        for flight, points in scored
    ]
    return {"season": rule.year, "checked": rule.checked, "remarks": rule.remarks, "flights": flights}


def _plan_document(ahead: "Outlook", rule: "Season", area: float) -> dict[str, object]:
    from fieldkit.planning.gain import gain_json
    from fieldkit.planning.quantiles import named, three

    prediction = ahead.forecast
    return {
        "motor": prediction.found.motor.designation,
        "apogee_m": named(three(prediction.apogee)),
        "true_apogee_m": named(three(prediction.true_apogee)),
        "duration_s": named(three(ahead.duration.ravel())),
        "points": {"mean": float(ahead.points.mean()), **named(three(ahead.points.ravel()))},
        "score": {"mean": float(rule.sums(ahead.points).mean()), **named(three(rule.sums(ahead.points)))},
        "timed": ahead.fall.flights > 0,
        "timed_flights": ahead.fall.flights,
        "parachute": {
            "area": area,
            "best_area": ahead.area,
            "points_there": ahead.points_there,
            "speed_there_mps": ahead.speed_there,
            **gain_json(ahead.gain, ahead.gain_error, ahead.clear),
        },
        "flights": prediction.rests_on,
        "model": prediction.model,
    }

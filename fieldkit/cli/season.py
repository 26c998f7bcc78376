"""`fieldkit season`: a contest season step by step, from the kit to the finals."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.numbers import finite, length
from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import RocketLength, about_plan, planning, season_year
from fieldkit.cli.screen import AsJson, print_json, say, say_wrapped, system

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldkit.planning.practice import PracticePlan

app = typer.Typer()


def season(
    context: typer.Context,
    year: Annotated[
        int | None, typer.Option("--season", metavar="YEAR", help="2019 to 2027; default: the current one.")
    ] = None,
    declared: Annotated[
        str | None, typer.Option(help="Qualification flights declared so far, of which the best are summed: 4,5.")
    ] = None,
    cut: Annotated[float | None, typer.Option(callback=finite, help="Points that qualify, as in other years.")] = None,
    rocket_length: RocketLength = None,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Guide a team through a season of the American Rocketry Challenge (TARC): limits, mass and parachute, practice,
    qualification, finals.

    Each step states what is done, what is missing and which command does it.
    """
    from fieldkit.planning.contest import rule_of
    from fieldkit.planning.contest_day import Day, read_declared
    from fieldkit.presentation.season_text import season_commands, season_steps
    from fieldkit.services.season_guide import season_guide

    names = read_declared(declared or "")
    day = Day(cut=cut, declared=names, length=length("--rocket-length", rocket_length, "mm"))
    with planning(context, given) as planned:
        plan, rule = planned.plan(), rule_of(season_year(year))
        one = season_guide(planned.ledger, plan, rule, day, planned.safety)
    steps, now = season_steps(one, season_commands(plan.flight, rule.year, system()), system()), one.now
    if json:
        document: dict[str, Any] = {
            "season": rule.year,
            "motor": plan.found.motor.designation,
            "declared": [{"flight_id": name, "points": one.points.get(name)} for name in names],
            "setting": {
                "dry_mass_g": now.row.mass * 1e3,
                "dry_mass_sd_g": now.mass_sd * 1e3,
                "parachute_area": None if now.area_sd is None else now.row.area,
                "parachute_area_sd": now.area_sd,
                "points": now.row.points,
            },
            "practice": [_document(flown) for flown in one.practice.plans],
            "next_practice": [_document(flown) for flown in one.practice.single],
            "score": None if one.scores is None else {"mean": float(one.scores.mean())},
            "steps": [{"step": name, "state": state, "lines": list(texts)} for name, state, texts in steps],
        }
        if cut is not None and one.scores is not None:
            document["qualifies"] = {"cut": cut, "chance": float((one.scores <= cut).mean())}
        print_json(document | about_plan(one.ahead.forecast, one.lines))
        return
    for number, (name, state, texts) in enumerate(steps, start=1):
        say(f"{number}. {name}: {state}" if state else f"{number}. {name}")
        for text in texts:
            say_wrapped(f"   {text}", "  ")


takes_plan(season)
app.command()(season)


def _document(one: "PracticePlan") -> "dict[str, float | Sequence[float]]":
    return {
        "dry_masses_g": [mass * 1e3 for mass in one.masses],
        "apogee_relative_sd": one.apogee_sd,
        "descent_relative_sd": one.descent_sd,
        "finals_points": one.points,
    }

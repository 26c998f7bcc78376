"""`fieldkit delay`, `ballast`: decisions between flights."""

from math import inf
from typing import Annotated

import typer

from fieldkit.cli.numbers import length, typed
from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import AllChecks, RocketLength, about_plan, planning, print_plan
from fieldkit.cli.screen import AsJson, print_json, system
from fieldkit.paths import data_file

app = typer.Typer()


def delay(
    context: typer.Context,
    limit: Annotated[str | None, typer.Option(help="Fastest acceptable speed at ejection: 15m/s, 34mph.")] = None,
    cuts: Annotated[
        str | None, typer.Option(help="Seconds that your tool can remove from the longest delay: 2,4,6,8.")
    ] = None,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Choose the ejection delay to buy or drill, from the coast time."""
    from fieldkit.planning.delay import delays, drill_of
    from fieldkit.presentation.planning_text import delays_in_words

    with planning(context, given) as planned:
        plan = planned.plan()
        motor = plan.found.motor
        fast = planned.limits["eject_speed"].value if limit is None else typed("--limit", limit, "speed", "m/s")
        tool = drill_of(motor, data_file("drills.toml")) if cuts is None else None
        takes_off = _seconds(cuts) if cuts else tool.takes_off if tool else ()
        left = tool.least_left if tool else 0.0
        judged = delays(plan, fast, takes_off, left)
        prediction, lines = judged.forecast, planned.safety(judged.forecast)
    if json:
        document = {"rocket": prediction.plan.rocket, "motor": motor.designation, "limit_mps": fast}
        document |= {
            "coast_s": dict(zip(("p05", "p50", "p95"), judged.coast, strict=True)),
            "flights": prediction.rests_on,
        }
        document |= {"delays": [one.json() for one in judged.delays], "words": list(judged.words)}
        print_json(document | {"drill": tool.json() if tool else None} | about_plan(prediction, lines))
        return
    print_plan(delays_in_words(judged, fast, tool, system()), prediction.plan, lines, plan.rocket.known, every=checks)


LONGEST_CUT = 10.0
"""A step is repeated up to this total, the most that a shipped tool removes. [s]"""
SMALLEST_CUT = 0.1
"""Smallest step of a tool, far below the 1.5 s by which delays vary. [s]"""


def _seconds(text: str) -> tuple[float, ...]:
    """`2,4,6,8`, or a step such as `1`, repeated up to `LONGEST_CUT`. Raises BadParameter."""
    try:
        off = tuple(float(part) for part in text.split(","))
    except ValueError:
        off = ()
    if not off or not all(SMALLEST_CUT <= one < inf for one in off):
        raise typer.BadParameter(
            f"found --cuts {text!r}, expected seconds such as 2,4,6,8, or a step such as 0.5, "
            f"each at least {SMALLEST_CUT:g}"
        )
    if len(off) > 1:
        return off
    return tuple(off[0] * times for times in range(1, max(1, round(LONGEST_CUT / off[0])) + 1))


takes_plan(delay)
app.command()(delay)


def ballast(
    context: typer.Context,
    target: Annotated[str | None, typer.Option(help="Target apogee, as the altimeter shows it: 250m, 800ft.")] = None,
    within: Annotated[str, typer.Option(help="Tolerance around the target that counts as a hit.")] = "10ft",
    season: Annotated[
        int | None, typer.Option(help="Minimize the expected points by this season's rule: 2027.")
    ] = None,
    lightest: Annotated[str | None, typer.Option(help="Lowest possible dry mass: 280g, 10oz.")] = None,
    heaviest: Annotated[str | None, typer.Option(help="Highest possible dry mass: 420g, 15oz.")] = None,
    miss: Annotated[
        bool, typer.Option("--miss", help="Minimize the mean miss instead of the chance of a miss.")
    ] = False,
    rocket_length: RocketLength = None,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Find the dry mass that best meets a target, and the mass to add or remove."""
    from fieldkit.planning.ballast import Goal
    from fieldkit.planning.ballast import ballast as solve
    from fieldkit.planning.contest import rule_of
    from fieldkit.planning.contest_limits import allowed
    from fieldkit.presentation.planning_text import ballast_in_words

    rule = None if season is None else rule_of(season).announced(length("--target", target), None)
    wanted, band = rule.target if rule else length("--target", target), length("--within", within)
    if wanted is None or band is None:
        raise typer.BadParameter("found no --target, expected one such as 800ft, or a --season that has one")
    low, high = (
        None if edge is None else typed(option, edge, "mass", "g")
        for option, edge in (("--lightest", lightest), ("--heaviest", heaviest))
    )
    goal = Goal(wanted, band, "points" if rule else "error" if miss else "chance", rule)
    with planning(context, given) as planned:
        plan = planned.plan()
        best = solve(plan, goal, (low, high))
        prediction, long = best.advised, length("--rocket-length", rocket_length, "mm")
        lines = planned.safety(prediction)
        lines += allowed(rule, prediction.plan, prediction.found, long) if rule else []
    if json:
        document = {"rocket": prediction.plan.rocket, "motor": prediction.found.motor.designation, "target_m": wanted}
        document |= {"flights": prediction.rests_on, "model": prediction.model}
        print_json(document | best.json() | about_plan(prediction, lines))
        return
    print_plan(ballast_in_words(best, goal, system()), prediction.plan, lines, plan.rocket.known, every=checks)


takes_plan(ballast)
app.command()(ballast)

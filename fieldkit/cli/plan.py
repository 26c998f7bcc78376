"""`fieldkit delay`, `ballast`, `contest`, `sites`: what is decided between flights."""

from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import about_plan, length, planning, print_plan
from fieldkit.cli.screen import complain, print_json, print_table, say, say_wrapped
from fieldkit.cli.session import open_ledger

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.plan.contest import Outlook, Season

app = typer.Typer()


def delay(
    context: typer.Context,
    limit: Annotated[str | None, typer.Option(help="Too fast at ejection: 15m/s.")] = None,
    cuts: Annotated[str | None, typer.Option(help="Seconds your tool can take off the longest delay: 2,4,6,8.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    **given: str | None,
) -> None:
    """Choose the ejection delay to buy or drill, from how long the rocket coasts."""
    from fieldkit.places import data_folder
    from fieldkit.plan.delay import delays, drill_of
    from fieldkit.plan.words import delays_in_words
    from fieldkit.units import parse

    with planning(context, given) as plan:
        found = plan.motor()
        fast = plan.limits["eject_speed"].value if limit is None else parse(limit, "speed", "m/s")
        tool = drill_of(found.motor, data_folder() / "drills.toml") if cuts is None else None
        takes_off = _seconds(cuts) if cuts else tool.takes_off if tool else ()
        judged = delays(plan.rocket, plan.flight, found, fast, takes_off)
        said, lines = judged.forecast, plan.safety(judged.forecast)
    if json:
        document = {"rocket": said.plan.rocket, "motor": found.motor.designation, "limit_mps": fast}
        document |= {"coast_s": dict(zip(("p05", "p50", "p95"), judged.coast, strict=True)), "flights": said.rests_on}
        document |= {"delays": [one.json() for one in judged.delays], "words": list(judged.words)}
        print_json(document | {"drill": tool.json() if tool else None} | about_plan(said, lines))
        return
    for note in found.notes:
        complain(f"note: {note}")
    print_plan(delays_in_words(judged, fast, tool), said.plan, lines, plan.rocket.starts)


def _seconds(text: str) -> tuple[float, ...]:
    """`2,4,6,8` or a step such as `1`, which is taken off up to ten times."""
    try:
        off = tuple(float(part) for part in text.split(","))
    except ValueError:
        off = ()
    if not off or min(off) <= 0:
        raise typer.BadParameter(f"found --cuts {text!r}, expected seconds such as 2,4,6,8, or a step such as 0.5")
    return off if len(off) > 1 else tuple(off[0] * times for times in range(1, round(10 / off[0]) + 1))


takes_plan(delay)
app.command()(delay)


def ballast(
    context: typer.Context,
    target: Annotated[str | None, typer.Option(help="Apogee wanted, as the altimeter shows it: 800ft.")] = None,
    within: Annotated[str, typer.Option(help="The band about the target that counts as met.")] = "10ft",
    season: Annotated[int | None, typer.Option(help="Expect the fewest points by its rule: 2027.")] = None,
    lightest: Annotated[str | None, typer.Option(help="The least dry mass possible: 280g.")] = None,
    heaviest: Annotated[str | None, typer.Option(help="The most: 420g.")] = None,
    miss: Annotated[bool, typer.Option("--miss", help="Minimise the mean miss, not the chance to miss.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    **given: str | None,
) -> None:
    """Find the dry mass that best meets a target, and the grams to add or take off."""
    from fieldkit.plan.ballast import Goal
    from fieldkit.plan.ballast import ballast as solve
    from fieldkit.plan.contest import allowed
    from fieldkit.plan.words import ballast_in_words

    rule = None if season is None else _rule(season).announced(length(target), None)
    wanted, band = rule.target if rule else length(target), length(within)
    if wanted is None or band is None:
        raise typer.BadParameter("found no --target, expected one such as 800ft, or a --season that has one")
    low, high = (None if edge is None else _mass(edge) for edge in (lightest, heaviest))
    goal = Goal(wanted, band, "points" if rule else "error" if miss else "chance", rule)
    with planning(context, given) as plan:
        best = solve(plan.rocket, plan.flight, plan.motor(), goal, (low, high))
        said = best.forecast
        lines = plan.safety(said) + (allowed(rule, said.plan, said.found) if rule else [])
    if json:
        document = {"rocket": said.plan.rocket, "motor": said.found.motor.designation, "target_m": wanted}
        document |= {"flights": said.rests_on, "model": said.model}
        print_json(document | best.json() | about_plan(said, lines))
        return
    print_plan(ballast_in_words(best, goal), said.plan, lines, plan.rocket.starts)


def _mass(text: str) -> float:
    from fieldkit.units import parse

    return parse(text, "mass", "g")


takes_plan(ballast)
app.command()(ballast)


def _rule(year: int) -> "Season":
    from fieldkit.places import data_folder
    from fieldkit.plan.contest import season

    return season(year, data_folder() / "seasons")


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
    from fieldkit.errors import NoFlights
    from fieldkit.places import data_folder
    from fieldkit.plan.contest import allowed, copy_season, declared_score, outlook, score
    from fieldkit.plan.day import read_declared, read_window
    from fieldkit.plan.words import outlook_in_words

    if own:
        complain(f"your own rule, used from now on: {copy_season(season, data_folder() / 'seasons')}")
    if cut is not None and given.get("motor") is None:
        raise typer.BadParameter("found --cut without --motor, expected both: the chance is that of a plan")
    rule = _rule(season).announced(length(target), read_window(window) if window else None)
    area = _share(parachute, 1.0) * (1 - _share(reef, 0.0))
    document: dict[str, object] = {"season": rule.year, "checked": rule.checked, "remarks": rule.remarks}
    ahead = lines = None
    with planning(context, given) as plan:
        try:
            scored = score(rule, plan.ledger.flights(plan.flight.rocket))
        except NoFlights:
            scored = []
        if plan.flight.motor:
            ahead = outlook(rule, plan.rocket, plan.flight, plan.motor(), area)
            said = ahead.forecast
            lines = plan.safety(said) + allowed(rule, said.plan, said.found, length(rocket_length, "mm"))
    document["flights"] = [
        {"flight_id": flight.flight_id, "points": points, "timed": flight.duration is not None}
        for flight, points in scored
    ]
    names = read_declared(declared or "")
    total = declared_score(rule, scored, names) if names else None
    if total is not None:
        document["score"] = {"declared": names, "points": total}
    if ahead is not None and lines is not None:
        document["plan"] = _plan_document(ahead, rule, area) | about_plan(ahead.forecast, lines)
        if cut is not None:
            document["qualifies"] = {"cut": cut, "chance": ahead.chance(rule, cut)}
    if json:
        print_json(document)
        return
    if rule.caveat and ahead is None:
        say_wrapped(rule.caveat)
    for flight, points in scored:
        say(f"  {flight.flight_id:>8}  {points:6.1f} points  {_flown(flight)}")
    if total is not None:
        say(f"  score     {total:.1f} points, the best {rule.best} of {', '.join(names)}")
    if ahead is not None and lines is not None:
        print_plan(outlook_in_words(ahead, rule, area, cut), ahead.forecast.plan, lines, plan.rocket.starts)


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


def _plan_document(ahead: "Outlook", rule: "Season", area: float) -> dict[str, object]:
    from fieldkit.plan.quantiles import named, three

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


takes_plan(contest)
app.command()(contest)


@app.command()
def sites(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="The site to save what follows of.")] = None,
    elevation: Annotated[str | None, typer.Option(help="Of the pad above sea level: 212m.")] = None,
    size: Annotated[str | None, typer.Option(help="The field's shorter side: 400m.")] = None,
    ceiling: Annotated[str | None, typer.Option(help="Above the pad, by waiver or rule: 3000ft.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List launch sites, or save the elevation, size and ceiling of one."""
    from fieldkit.ledger.sites import keep_site
    from fieldkit.ledger.sites import sites as sites_of

    given = {"elevation": length(elevation), "size": length(size), "ceiling": length(ceiling)}
    if name is None and any(value is not None for value in given.values()):
        raise typer.BadParameter("found what to save and no site, expected its name first")
    with open_ledger(context) as ledger:
        if name is not None and any(value is not None for value in given.values()):
            keep_site(ledger, name, **given)
        known = [site for site in sites_of(ledger) if name in (None, site.name)]
    if json:
        keys = ("elevation", "size", "ceiling")
        print_json({"sites": [{"site": one.name} | {f"{key}_m": getattr(one, key) for key in keys} for one in known]})
        return
    rows = [
        (one.name, *("" if value is None else f"{value:.0f}" for value in (one.elevation, one.size, one.ceiling)))
        for one in known
    ]
    headers = ("site", "elevation m", "size m", "ceiling m")
    print_table(headers, rows, numbers=headers[1:])

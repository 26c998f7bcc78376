"""`fieldkit delay`, `fieldkit ballast`: what is decided between flights."""

from typing import Annotated

import typer

from fieldkit.cli.screen import complain, print_json, print_table, say, say_wrapped
from fieldkit.cli.session import known_motors, open_ledger

app = typer.Typer()


@app.command()
def delay(
    context: typer.Context,
    motor: Annotated[str, typer.Option(help="F24-4W, or F24.")],
    rocket: Annotated[str | None, typer.Option(help="The one flown last, where not said.")] = None,
    config: Annotated[str | None, typer.Option(help="The one flown last, where not said.")] = None,
    dry_mass: Annotated[str | None, typer.Option(help="In g, or with its unit.")] = None,
    limit: Annotated[str | None, typer.Option(help="Too fast at ejection: 15m/s.")] = None,
    step: Annotated[float | None, typer.Option(help="Seconds your drilling tool takes off at a time.", min=0.1)] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Choose the ejection delay to buy or drill, from how long the rocket coasts."""
    from fieldkit.cli.guide import planned
    from fieldkit.places import data_folder
    from fieldkit.plan.delay import delays
    from fieldkit.plan.desk import learn_rocket
    from fieldkit.plan.limits import limits
    from fieldkit.plan.safety import DECIDES
    from fieldkit.units import parse

    motors = known_motors()
    found = motors.resolve(motor)
    with open_ledger(context) as ledger:
        plan = planned(ledger, rocket, {"config": config, "dry_mass": dry_mass})
        learnt = learn_rocket(ledger, motors, plan, draws=1000)
    fast = limits(data_folder() / "limits.toml")["eject_speed"].value if limit is None else parse(limit, "speed", "m/s")
    judged = delays(learnt, found, fast, step)
    if json:
        p05, p50, p95 = judged.coast
        document = {"rocket": plan.rocket, "motor": found.motor.designation, "limit_mps": fast, "decides": DECIDES}
        document |= {"coast_s": {"p05": p05, "p50": p50, "p95": p95}, "flights": learnt.rests_on}
        print_json({**document, "delays": [one.json() for one in judged.delays], "words": list(judged.words)})
        return
    for note in found.notes:
        complain(f"note: {note}")
    p05, p50, p95 = judged.coast
    say(f"{plan.rocket} on {found.motor.maker} {found.motor.designation}: coasts {p50:.1f} s from burnout to apogee")
    say(f"90 % between {p05:.1f} and {p95:.1f} s; rests on {learnt.rests_on} clean flights")
    headers = ("delay s", "after apogee s", "5 %", "95 %", "speed m/s", f"over {fast:.0f} m/s", "")
    rows = [
        (
            f"{one.delay:g}",
            *(f"{one.after_apogee[i]:+.1f}" for i in (1, 0, 2)),
            f"{one.speed[1]:.0f}",
            f"{one.too_fast:.0%}",
            "" if one.on_sale else "drilled",
        )
        for one in judged.delays
    ]
    if rows:
        print_table(headers, rows, numbers=headers[:6])
    for words in judged.words:
        say_wrapped(words)
    say_wrapped(f"Delays vary by 20 % or 1.5 s (NFPA 1125), which is in these figures. {DECIDES}")


@app.command()
def ballast(
    context: typer.Context,
    target: Annotated[str, typer.Option(help="Apogee wanted, as the altimeter shows it: 800ft.")],
    motor: Annotated[str | None, typer.Option(help="That of the last flight, where not said.")] = None,
    within: Annotated[str, typer.Option(help="The band about the target that counts as met.")] = "10ft",
    rocket: Annotated[str | None, typer.Option(help="The one flown last, where not said.")] = None,
    config: Annotated[str | None, typer.Option(help="The one flown last, where not said.")] = None,
    dry_mass: Annotated[str | None, typer.Option(help="As it is now; in g, or with its unit.")] = None,
    lightest: Annotated[str | None, typer.Option(help="The least dry mass possible: 280g.")] = None,
    heaviest: Annotated[str | None, typer.Option(help="The most: 420g.")] = None,
    temperature: Annotated[str | None, typer.Option(help="In c, or with its unit.")] = None,
    pressure: Annotated[str | None, typer.Option(help="Reduced to sea level; in hpa, or with its unit.")] = None,
    site_elevation: Annotated[str | None, typer.Option(help="In m, or with its unit.")] = None,
    wind: Annotated[str | None, typer.Option(help="In m/s, or with its unit.")] = None,
    points: Annotated[bool, typer.Option("--points", help="Minimise the mean miss, not the chance to miss.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Find the dry mass that best meets a target, and the grams to add or take off."""
    from fieldkit.cli.guide import planned
    from fieldkit.plan.ballast import ballast as solve
    from fieldkit.plan.desk import learn_rocket
    from fieldkit.units import FOOT, parse

    given = {"config": config, "dry_mass": dry_mass, "temperature": temperature, "pressure": pressure, "wind": wind}
    motors = known_motors()
    with open_ledger(context) as ledger:
        plan = planned(ledger, rocket, {**given, "site_elevation": site_elevation})
        last = ledger.latest(plan.rocket)
        found = motors.resolve(motor or (last.motor if last else ""))
        learnt = learn_rocket(ledger, motors, plan, draws=500)
    wanted, band = parse(target, "length", "m"), parse(within, "length", "m")
    low, high = (None if edge is None else parse(edge, "mass", "g") for edge in (lightest, heaviest))
    best = solve(learnt, found, wanted, band, "error" if points else "chance", (low, high))
    if json:
        print_json({"rocket": plan.rocket, "motor": found.motor.designation, "target_m": wanted, **best.json()})
        return
    p05, p50, p95 = best.apogee
    say(f"{plan.rocket} on {found.motor.maker} {found.motor.designation}, target {wanted / FOOT:.0f} ft")
    say(f"  dry mass  {best.mass * 1e3:.0f} g: {'add' if best.add >= 0 else 'take off'} {abs(best.add) * 1e3:.0f} g")
    say(f"  apogee    {p50:.0f} m, 90 % between {p05:.0f} and {p95:.0f} m, as the altimeter will show it")
    say(f"  within {band / FOOT:.0f} ft  chance {best.chance:.0%} ({best.today[0]:.0%} without change)")
    say(f"  mean miss {best.error / FOOT:.0f} ft ({best.today[1] / FOOT:.0f} ft without change)")
    say(f"  a gram more is {best.slope / FOOT / 1e3:+.1f} ft")
    say(f"  rests on  {learnt.rests_on} clean flights, model {learnt.name}")
    if not best.met:
        least, most = (f"{height:.0f} m ({height / FOOT:.0f} ft)" for height in best.reach)
        say_wrapped(f"  Out of reach: with these masses the altimeter will show from {least} to {most} in the middle.")


@app.command()
def contest(
    context: typer.Context,
    season: Annotated[int, typer.Option(help="2020 to 2027.")],
    motor: Annotated[str | None, typer.Option(help="Plan with this motor, and say what points to expect.")] = None,
    rocket: Annotated[str | None, typer.Option(help="The one flown last, where not said.")] = None,
    dry_mass: Annotated[str | None, typer.Option(help="Of the plan; in g, or with its unit.")] = None,
    cut: Annotated[float | None, typer.Option(help="Points that qualify; asks for --motor.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Score flights by the rule of a season, and say what points a plan can expect."""
    import numpy as np

    from fieldkit.cli.guide import planned
    from fieldkit.plan.contest import chance_to_qualify, expected_points, score
    from fieldkit.plan.contest import season as season_of
    from fieldkit.plan.desk import learn_rocket

    if cut is not None and motor is None:
        raise typer.BadParameter("found --cut without --motor, expected both: the chance is that of a plan")
    rule = season_of(season)
    motors = known_motors()
    document: dict[str, object] = {"season": rule.year, "checked": rule.checked, "remarks": rule.remarks}
    with open_ledger(context) as ledger:
        plan = planned(ledger, rocket, {"dry_mass": dry_mass})
        flights = ledger.flights(plan.rocket)
        scored = score(rule, flights)
        document["flights"] = [
            {"flight_id": flight.flight_id, "points": points, "timed": flight.duration is not None}
            for flight, points in scored
        ]
        if motor is not None:
            found = motors.resolve(motor)
            learnt = learn_rocket(ledger, motors, plan, draws=1000)
            points, timed = expected_points(rule, learnt, learnt.plan, found, flights)
            p05, p50, p95 = (float(value) for value in np.quantile(points, (0.05, 0.5, 0.95)))
            expected: dict[str, object] = {"mean": float(points.mean()), "p05": p05, "p50": p50, "p95": p95}
            document["plan"] = {"motor": found.motor.designation, "points": expected, "timed": timed}
            if cut is not None:
                document["qualifies"] = {"cut": cut, "chance": chance_to_qualify(rule, points, cut)}
    if json:
        print_json(document)
        return
    if not rule.checked:
        say(f"The rule of {season} ({rule.remarks}) was not checked against the official text.")
    for flight, own in scored:
        say(f"  {flight.flight_id:>8}  {own:6.1f} points{'' if flight.duration is not None else ', height alone'}")
    if motor is not None:
        say(
            f"With {motor}: {points.mean():.0f} points expected, 90 % between {p05:.0f} and {p95:.0f}, median {p50:.0f}"
        )
        if not timed:
            say("  height alone: no flight told how fast this rocket comes down")
    if cut is not None:
        say(
            f"  chance that the best {rule.best} of {rule.declared} sum to {cut:g} or less: "
            f"{chance_to_qualify(rule, points, cut):.0%}"
        )

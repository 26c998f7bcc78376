"""What `fieldkit motors --fit` prints: every motor that fits a rocket, and how it would fly."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.numbers import length
from fieldkit.cli.options import GuideOptions
from fieldkit.cli.plan_options import Given
from fieldkit.cli.planning import PlanContext, planning, print_conditions
from fieldkit.cli.screen import complain, print_json, print_table, say, say_wrapped, system
from fieldkit.errors import NoFlights, UnknownMotor, of_rocket
from fieldkit.messages import fine, message
from fieldkit.paths import data_file
from fieldkit.physics.setups import RAIL_LENGTH
from fieldkit.planning.check import ADVICE_NOTE, MARKS, SEVERITY, Verdict
from fieldkit.quantities import ShownUnits, counted, in_system
from fieldkit.settings import read_settings

if TYPE_CHECKING:
    from fieldkit.motors import Catalogue, Motor
    from fieldkit.planning.contest import Season
    from fieldkit.planning.motor_advice import MotorAdvice
    from fieldkit.planning.motor_guide import MotorChoice, MotorOrder, Wanted

MotorNames = dict["Motor", str]
"""The name of each motor in the guide."""
MOST_UNREAD_LINES = 5
"""Number of lines of a list in stock that are printed because they name no motor; the others are counted. [1]"""
SHOWN_DELAYS, ALL_DELAYS = 2, 99
"""Maximum number of delays listed per motor: as many as fit in 80 characters, or all. [1]"""


def print_guide(context: typer.Context, given: Given, asked: GuideOptions, *, json: bool) -> None:
    """Print the motor guide of a rocket in the order of the app's Fly page, and with a season the motor with the fewest
    points; or only quick forecasts. Raises UnknownMotor if no motor fits."""
    from fieldkit.planning.contest import rule_of
    from fieldkit.planning.contest_limits import approved_motors
    from fieldkit.planning.motor_guide import LEAST_THRUST, guide, label, lifts, motor_order, suitable_motors
    from fieldkit.presentation.planning_text import advice_in_words
    from fieldkit.services.saved_forecasts import motors_with_open_forecast

    target = length("--target", asked.target) or read_settings().target
    with planning(context, given) as plan:
        wanted = _wanted(plan, asked)
        try:
            motors = suitable_motors(plan.motors, wanted)
        except UnknownMotor as error:
            if not asked.box or not (box := _box(plan)):
                raise
            held = ", ".join(f"{count} × {label(motor)}" for motor, count in box.items())
            raise UnknownMotor(f"{error}; your range box has {held}; --adapter takes narrower ones") from error
        if asked.box:
            own = {label(motor): motor for motor in _box(plan)}
            motors = [own[label(motor)] for motor in motors]
        mass = plan.flight.dry_mass or 0.0  # without one the guide prints a note
        strong = [motor for motor in motors if lifts(motor, mass)] or motors
        names = {motor: _called(motor, plan.motors) for motor in motors}
        weak = [motor for motor in motors if not lifts(motor, mass)] if strong is not motors else []
        flight = plan.flight
        saved = motors_with_open_forecast(plan.ledger, plan.motors, flight.rocket, flight.config)
        order = motor_order(plan.rocket, flight.config, target, saved)
        if asked.quick:
            print_quick_guide(plan, wanted, order, strong, names, json=json)
            return
        found = guide(plan.rocket, plan.flight, strong, plan.limits, plan.site, saved=saved)
    rule = None if asked.season is None else rule_of(asked.season)
    advice = None
    if rule is not None:
        found, advice = _in_season(plan, found, rule)
        order = replace(order, target=order.target or rule.target)
    choices = order.sorted(found)
    if json:
        _print_json(plan, wanted, order.target, choices, [motor.designation for motor in weak], advice)
        return
    motors_that_fit = [choice for choice in choices if choice.fits]
    shown = motors_that_fit or choices
    _print(plan, wanted, order.target, shown, names, len(choices), every=asked.all_)
    _print_checks(shown, names, every=asked.all_)
    if motors_that_fit:
        _print_excluded([choice for choice in choices if not choice.fits], names)
    if advice is not None and rule is not None:
        listed = approved_motors(rule.year, data_file("seasons")) is not None
        for line in advice_in_words(advice, rule, listed=listed):
            say_wrapped(line, "    ")
    if weak:
        left_out = ", ".join(names[motor] for motor in weak)
        say_wrapped(f"left out, thrust below {LEAST_THRUST:g} times the weight: {left_out}", "  ")
    say()
    delays = "every delay sold" if asked.all_ else "the delays sold that are nearest to it; --all lists every one"
    say_wrapped(f"eject: seconds after apogee, with {delays}. Checks not listed pass. {ADVICE_NOTE}")


def _in_season(
    plan: PlanContext, found: "list[MotorChoice]", rule: "Season"
) -> "tuple[list[MotorChoice], MotorAdvice]":
    """The motors checked against the limits of a season and the flyer's copy of its list, and advice by its points,
    compared with the motor last flown."""
    from fieldkit.planning.motor_advice import in_season, motor_advice
    from fieldkit.planning.motor_guide import label

    last = plan.rocket.motors[-1].motor if plan.rocket.motors else None
    held = [in_season(one, rule) for one in found]
    return held, motor_advice(held, rule, label(last) if last is not None else None)


def _box(plan: PlanContext) -> "Counter[Motor]":
    """How many of each motor are in the flyer's range box."""
    from fieldkit.services.range_box import box_left, motors_in_box

    return motors_in_box(box_left(read_settings().flyer.box, plan.ledger, plan.motors), plan.motors)


def _in_stock(plan: PlanContext, file: Path) -> frozenset[str]:
    """The motors in stock by a saved list; lines that name none are printed."""
    from fieldkit.importing.tables.text import decode_whole
    from fieldkit.motors.stock import read_stock
    from fieldkit.planning.motor_guide import label
    from fieldkit.services.imports import read_file

    found = read_stock(decode_whole(read_file(file, kind="a list of motors")), plan.motors, file.name)
    for number, text in found.unread[:MOST_UNREAD_LINES]:
        complain(f"note: {file.name}, row {number}: no motor of the catalog in {text!r}")
    if more := len(found.unread[MOST_UNREAD_LINES:]):
        complain(f"note: and {counted(more, 'more line')} without a motor of the catalog")
    return frozenset(label(motor) for motor in found.motors)


def _wanted(plan: PlanContext, asked: GuideOptions) -> "Wanted":
    from fieldkit.planning.motor_guide import Wanted, label, mount_of, widest_motor
    from fieldkit.services.shortlist import shortlist

    last = mount_of(plan.rocket, plan.flight.config) or plan.rocket.mount
    mount = length("--mount", asked.mount, "mm") or plan.mount or last
    adapter = asked.adapter or mount is None
    mount = mount or widest_motor(plan.rocket, plan.flight)
    if mount is None:
        raise UnknownMotor("found no flights that show the motor mount and no diameter, expected --mount such as 29mm")
    names = shortlist(plan.ledger, plan.flight.rocket) if asked.shortlist else None
    if asked.box:
        box = frozenset(label(motor) for motor in _box(plan))
        names = box if names is None else box & names
    if asked.in_stock is not None:
        stock = _in_stock(plan, asked.in_stock)
        names = stock if names is None else stock & names
    return Wanted(
        mount=mount,
        length=length("--max-length", asked.max_length, "mm") or math.inf,
        impulse=math.inf if asked.max_impulse is None else asked.max_impulse,
        classes=_classes(asked.class_),
        retired=asked.retired,
        adapter=adapter,
        names=names,
    )


def _classes(text: str) -> tuple[str, str] | None:
    """The first and the last impulse class of `D` or `D-F`; None if it is empty. Raises BadParameter."""
    first, _, last = text.upper().replace(" ", "").partition("-")
    if not text:
        return None
    if not (first.isalpha() and len(first) == 1 and (not last or (last.isalpha() and len(last) == 1))):
        raise typer.BadParameter(f"found --class {text!r}, expected a letter such as D, or two such as D-F")
    return first, last or first


def _print_json(
    plan: PlanContext,
    wanted: "Wanted",
    target: float | None,
    choices: "list[MotorChoice]",
    weak: list[str],
    advice: "MotorAdvice | None",
) -> None:
    from fieldkit.planning.air import air_of, conditions

    prediction = choices[0].prediction
    document = {"rocket": plan.flight.rocket, "mount_mm": (wanted.mount or 0.0) * 1e3, "target_m": target}
    document |= {"flights": prediction.rests_on, "model": prediction.model, "decides": ADVICE_NOTE}
    document |= {"conditions": conditions(prediction.plan), "air": air_of(prediction.plan).json()}
    document |= {} if advice is None else {"contest": advice.json()}
    print_json({**document, "too_weak": weak, "motors": [choice.json() for choice in choices]})


def _print(
    plan: PlanContext,
    wanted: "Wanted",
    target: float | None,
    choices: "list[MotorChoice]",
    names: MotorNames,
    of: int,
    *,
    every: bool,
) -> None:
    from fieldkit.planning.motor_guide import EJECTION_CHECK, RAIL_CHECK, label
    from fieldkit.presentation.forecast_text import rests_in_words

    prediction, flight = choices[0].prediction, plan.flight
    name = " ".join(filter(None, (flight.rocket, flight.config)))
    say(f"{name}, {ShownUnits(system()).mass(prediction.plan.dry_mass or 0.0)} without the motor")
    width = f"{'up to ' if wanted.adapter else ''}{(wanted.mount or 0.0) * 1e3:.3g} mm"
    fit = f"{len(choices) if choices[0].fits else 'none'} of {counted(of, 'motor')} of {width}"
    say(f"{fit} fit and are not excluded by a check" if choices[0].fits else f"{fit} fits: checks exclude every one")
    _say_target(target)
    say()
    _table(choices, names, ALL_DELAYS if every else SHOWN_DELAYS)
    if choices[0].plan.rail_length is None and any(RAIL_CHECK in choice.not_judged for choice in choices):
        assumed, twice = (in_system(message(fine(one, "m")), system()) for one in (RAIL_LENGTH, 2 * RAIL_LENGTH))
        say_wrapped(
            f"rail    not given: {assumed} assumed for the speed off it; off {twice} it is 20 to 45% higher; give "
            "--rail-length",
            "        ",
        )
    if plan.site.ceiling is None:
        say_wrapped(
            "ceiling not given: no motor is excluded by its height; give --waiver, or save the site's", "        "
        )
    if plan.site.size is None:
        say_wrapped(
            "field   not given: no motor is excluded for needing a larger one; give --field-size, or save the site's",
            "        ",
        )
    if no_delay := [names[one.motor] for one in choices if EJECTION_CHECK in one.not_judged]:
        say_wrapped(f"delay   unknown: {', '.join(no_delay)}", "        ")
    if wanted.mount is not None and wanted.mount == flight.diameter and not plan.rocket.motors:
        say_wrapped(
            "mount   not given: all motors no wider than the body are listed; give --mount, as in 29mm", "        "
        )
    box = {label(motor): count for motor, count in _box(plan).items()}
    if held := [f"{names[one.motor]} ({box[label(one.motor)]})" for one in choices if label(one.motor) in box]:
        say_wrapped(f"box     in your range box: {', '.join(held)}; --box forecasts only those", "        ")
    say_wrapped(f"based on {rests_in_words(prediction)}")
    print_conditions(prediction.plan, plan.rocket.known)


def _print_checks(choices: "list[MotorChoice]", names: MotorNames, *, every: bool) -> None:
    """Print each failed or unknown check once with the motors that it concerns, or `every` one in full."""
    if every:
        for choice in choices:
            for line in choice.lines:
                if line.verdict != "ok":
                    say_wrapped(f"  {names[choice.motor]}: {line.words(system())}", "    ")
        return
    motors_by_check: "dict[tuple[Verdict, str], list[str]]" = {}
    by_eye: dict[str, None] = {}
    for choice in choices:
        for line in choice.lines:
            if line.by_eye:
                by_eye[line.name] = None
            else:
                motors_by_check.setdefault((line.verdict, line.name), []).append(names[choice.motor])
    everywhere = [
        name
        for (verdict, name), motors in motors_by_check.items()
        if verdict == "unknown" and len(motors) == len(choices)
    ]
    for verdict in reversed(SEVERITY[1:]):
        some = {check: motors for (of, check), motors in motors_by_check.items() if of == verdict}
        for checks, motors in _of_the_same({name: some[name] for name in some if name not in everywhere}):
            named = _in_short(motors, [names[one.motor] for one in choices])
            say_wrapped(f"  {MARKS[verdict]} {', '.join(checks)}: {verdict}: {named}", "    ")
    if everywhere:
        say_wrapped(f"  ? not checked, inputs missing: {', '.join(everywhere)}", "    ")
    if by_eye:
        say_wrapped(f"  ? check yourself, where they apply: {', '.join(by_eye)}", "    ")
    say("  values, limits, and rules of each motor: --all")


def _in_short(motors: list[str], every: list[str]) -> str:
    """`F24W, F39T`, or `all but F39T` if that is shorter."""
    others = [name for name in every if name not in motors]
    if not others:
        return "all"
    return f"all but {', '.join(others)}" if len(others) < len(motors) else ", ".join(motors)


def _print_excluded(excluded_motors: "list[MotorChoice]", names: MotorNames) -> None:
    """Print a line for each combination of reasons that exclude motors, with these motors."""
    reasons: dict[tuple[str, ...], list[str]] = {}
    for choice in excluded_motors:
        reasons.setdefault(tuple([line.name for line in choice.why_not]), []).append(names[choice.motor])
    for why, excluded in reasons.items():
        say_wrapped(f"  excluded by {', '.join(why)}: {', '.join(excluded)}", "    ")


def _of_the_same(motors_by_check: Mapping[str, list[str]]) -> list[tuple[list[str], list[str]]]:
    """The names of checks that concern the same motors together, with these motors."""
    together: dict[tuple[str, ...], list[str]] = {}
    for check, motors in motors_by_check.items():
        together.setdefault(tuple(motors), []).append(check)
    return [(checks, list(motors)) for motors, checks in together.items()]


def _called(motor: "Motor", known: "Catalogue") -> str:
    """The designation, with the maker if the designation alone would be read as another motor."""
    from fieldkit.planning.motor_guide import label

    alone = label(known.resolve(motor.designation).motor) == label(motor)
    return motor.designation if alone else f"{motor.designation} {motor.maker}"


def _ejections(choice: "MotorChoice", most: int) -> str:
    """When the delays nearest to apogee would fire, shortest delay first: `5:-0.2 6:+0.8`."""
    nearest = sorted(choice.ejections, key=lambda one: abs(one[1]))[:most]
    return " ".join(f"{delay:g}:{after:+.1f}" for delay, after in sorted(nearest)) or "no delay"


def _table(choices: "list[MotorChoice]", names: MotorNames, most: int) -> None:
    from fieldkit.forecast.prediction import median
    from fieldkit.planning.quantiles import three_of_all

    shown = ShownUnits(system())
    headers = ("motor", "shown", "90%", "true", "rail", "T:W", "avg", "top", "✗", "eject")
    rows = []
    for choice in choices:
        prediction = choice.prediction
        low, middle, high = three_of_all(prediction.apogee)
        failed = len(choice.failed)
        rows.append(
            (
                f"{names[choice.motor]}{'' if choice.flown else ' *'}",
                shown.length(middle).split()[0],
                "-".join(shown.length(end).split()[0] for end in (low, high)),
                shown.length(three_of_all(prediction.true_apogee)[1]).split()[0],
                shown.speed(median(prediction.rail_speed) or 0.0, 0).split()[0],
                f"{choice.first_thrust:.1f}",
                f"{choice.average_thrust:.1f}",
                shown.speed(median(prediction.top_speed) or 0.0, 0).split()[0],
                str(failed or ""),
                _ejections(choice, most),
            )
        )
    print_table(headers, rows, numbers=headers[1:9])
    say_wrapped(
        f"*: not flown by this rocket. shown: apogee on the altimeter, true: true apogee [{shown.length_unit}]. "
        f"rail, top: speed off the rail and top speed [{shown.speed(0.0).split()[1]}]. "
        "T:W, avg: thrust to weight in the first half second and on average. ✗: number of failed checks. With "
        "few simulations of each motor, apogees may be 3% off either way (in wind 7%), and the ends of the "
        "90% interval 11%: `fieldkit predict` has more."
    )


def _say_target(target: float | None) -> None:
    """Print the apogee [m] by which motors are sorted, if there is one."""
    if target is not None:
        say(f"target  {ShownUnits(system()).length(target)}")


def print_quick_guide(
    plan: PlanContext,
    wanted: "Wanted",
    order: "MotorOrder",
    motors: "list[Motor]",
    names: "dict[Motor, str]",
    *,
    json: bool,
) -> None:
    """Print quick forecasts. Raises NoFlights for a rocket that has not flown."""
    from fieldkit.planning.quick_guide import QUICK_ERROR, quick_guide, sorted_quickly
    from fieldkit.presentation.quick_look import EVALUATION

    if not plan.rocket.history:
        raise NoFlights(of_rocket(plan.flight.rocket, "found no flights, expected at least one for a quick forecast"))
    found = sorted_quickly(quick_guide(plan.rocket, plan.flight, motors), order, plan.limits)
    if json:
        document = {"rocket": plan.flight.rocket, "mount_mm": (wanted.mount or 0.0) * 1e3, "target_m": order.target}
        print_json({**document, "evaluation": EVALUATION, "motors": [choice.json() for choice in found]})
        return
    shown = ShownUnits(system())
    name = " ".join(part for part in (plan.flight.rocket, plan.flight.config) if part)
    say_wrapped(f"{name}: forecasts on {counted(len(found), 'motor')}, {QUICK_ERROR}; nothing is saved")
    _say_target(order.target)
    headers = ("motor", "shown", "90%", "T:W", "avg", "top")
    rows = []
    for one in found:
        low, middle, high = (shown.length(value).split()[0] for value in one.interval)
        top = "" if one.top_speed is None else shown.speed(one.top_speed, 0).split()[0]
        thrust = (f"{one.first_thrust:.1f}", f"{one.average_thrust:.1f}")
        rows.append((f"{names[one.motor]}{'' if one.flown else ' *'}", middle, f"{low}-{high}", *thrust, top))
    print_table(headers, rows, numbers=headers[1:])
    say_wrapped(
        f"*: not flown by this rocket. shown: apogee on the altimeter [{shown.length_unit}]. "
        f"top: top speed [{shown.speed(0.0).split()[1]}]. T:W, avg: thrust to weight in the first half second and on "
        "average. Without delays and safety checks: leave out --quick for those."
    )

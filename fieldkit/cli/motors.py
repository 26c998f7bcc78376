"""`fieldkit motors`: search motors, show their data, and add your own."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.motor_tables import print_comparison, print_own_corrections, print_records
from fieldkit.cli.numbers import not_negative
from fieldkit.cli.options import GuideOptions, dashed, takes_plan
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.errors import UnknownMotor
from fieldkit.paths import motor_folder
from fieldkit.quantities import SYSTEMS, counted, rounded
from fieldkit.units import unit

if TYPE_CHECKING:
    from fieldkit.motors import Motor

app = typer.Typer()

GUIDE = "With --fit"
"""Heading of the options of the motor guide in the command's help."""
MAX_LISTED_MOTORS = 40
"""Maximum number of motors in a table. [1]"""
MAX_CORRECTED_MOTORS = 3
"""Maximum number of motors whose corrected figures are printed. [1]"""
ABOUT_TITLES = {
    "licence": "license",
    "kept": "in the catalog",
    "read": "in the source",
    "impulse of the samples off the certified one by more than 25 %": "impulse of the samples off by more than 25%",
    "masses not on record": "masses unknown",
}
"""What is printed for some keys of the catalog's description, which programs read."""


def motors(
    context: typer.Context,
    search: Annotated[list[str] | None, typer.Argument(help="F24, aerotech 24mm, a case, or a propellant.")] = None,
    about: Annotated[bool, typer.Option("--about", help="Show the source of the motor data.")] = False,
    import_: Annotated[
        Path | None, typer.Option("--import", metavar="FILE", help="Add the motors of a .eng or .rse file.")
    ] = None,
    compare: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Compare the motors with a table of test results (CSV).")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Compare every thrust curve, or those searched for, with its record.")
    ] = False,
    corrections: Annotated[
        bool,
        typer.Option("--corrections", help="Show the file of your own corrections and lots; create it if missing."),
    ] = False,
    shortlist_for: Annotated[
        str | None,
        typer.Option(
            metavar="ROCKET", help="Add what is found to this rocket's shortlist.", autocompletion=rocket_names
        ),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(
            metavar="ROCKET",
            help="Forecast every motor that fits this rocket.",
            rich_help_panel=GUIDE,
            autocompletion=rocket_names,
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(help="Target apogee: 250m, 800ft. Default: that set in the app.", rich_help_panel=GUIDE),
    ] = None,
    class_: Annotated[str, typer.Option("--class", help="Impulse class: D, or D-F.", rich_help_panel=GUIDE)] = "",
    mount: Annotated[str | None, typer.Option(help="Motor mount: 29mm.", rich_help_panel=GUIDE)] = None,
    adapter: Annotated[
        bool, typer.Option("--adapter", help="Include motors narrower than the mount.", rich_help_panel=GUIDE)
    ] = False,
    season: Annotated[
        int | None, typer.Option(help="Rank by the expected points of this season's rule: 2027.", rich_help_panel=GUIDE)
    ] = None,
    max_length: Annotated[
        str | None, typer.Option(help="Longest motor that fits: 124mm, 5in.", rich_help_panel=GUIDE)
    ] = None,
    max_impulse: Annotated[
        float | None,
        typer.Option(callback=not_negative, help="Highest total impulse of a motor, in N s.", rich_help_panel=GUIDE),
    ] = None,
    retired: Annotated[
        bool, typer.Option("--retired", help="Include motors no longer made.", rich_help_panel=GUIDE)
    ] = False,
    shortlist: Annotated[
        bool, typer.Option("--shortlist", help="Only motors on the shortlist.", rich_help_panel=GUIDE)
    ] = False,
    box: Annotated[
        bool, typer.Option("--box", help="Only motors in your range box (fieldkit flyer).", rich_help_panel=GUIDE)
    ] = False,
    stock: Annotated[
        Path | None,
        typer.Option(
            "--in-stock",
            metavar="FILE",
            help="Only motors in a shop's saved list: one per line, or a table with a column of motors.",
            rich_help_panel=GUIDE,
        ),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Show the checks of every motor.", rich_help_panel=GUIDE)
    ] = False,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="Provisional apogees at once, off by up to 10% either way; without delays and safety checks.",
            rich_help_panel=GUIDE,
        ),
    ] = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Search motors, add your own, or with --fit forecast every motor that fits a rocket."""
    tasks = {"--fit": fit, "--compare": compare, "--corrections": corrections, "--import": import_, "--about": about}
    _check_one_task({**tasks, "--check": check} if check else {**tasks, "a search": search})
    limits = target, class_, mount, adapter, season, max_length, max_impulse, retired
    asked = GuideOptions(*limits, shortlist, box, stock, every, quick)
    if fit is None and (unused := [*asked.given(), *dashed(given)]):
        raise typer.BadParameter(f"found {', '.join(unused)} without --fit, expected --fit ROCKET too")
    if shortlist_for is not None and (fit or compare or corrections or about or check):
        raise typer.BadParameter("found --shortlist-for without a search or --import, expected one of them")
    if quick and (season is not None or every):
        raise typer.BadParameter(f"found --quick with {'--all' if every else '--season'}, expected one of the two")
    if fit is not None:
        from fieldkit.cli.guide import print_guide

        print_guide(context, {**given, "rocket": fit}, asked, json=json)
        return
    from fieldkit.motors import describe

    if compare is not None:
        print_comparison(compare, json)
        return
    if corrections:
        print_own_corrections(json)
        return
    if import_ is not None:
        found = _added(import_)
    elif about:
        _about(json)
        return
    else:
        known, text = known_motors(always=check), " ".join(search or ())
        found = known.search(text)
        if not known.knows(text):
            _check_near(text, found, known.complaint(text), strict=json or shortlist_for is not None)
        if note := known.unknown_lot(text, found):
            complain(f"note: {note}")
    if check:
        print_records(found, json)
        return
    if shortlist_for is not None and found:
        _put_by(context, shortlist_for, found)
    if json:
        print_json({"motors": [describe(motor) for motor in found]})
    else:
        _list(found)


takes_plan(motors, ("config", "site"))
app.command()(motors)


def _check_one_task(tasks: Mapping[str, object]) -> None:
    """Raise BadParameter if more than one task is requested: only the first would be done."""
    if len(wanted := [name for name, value in tasks.items() if value]) > 1:
        raise typer.BadParameter(f"found {' and '.join(wanted)}, expected one of them")


def _check_near(text: str, found: "list[Motor]", complaint: str | None, *, strict: bool) -> None:
    """Print a note that motors only resemble a text. Raises UnknownMotor if there are none, or if `strict`: a program
    or a shortlist would mistake them for the one named."""
    if strict or not found:
        raise UnknownMotor(complaint or f"no motor {text!r}, expected a name such as F24-4W")
    complain(f"note: no motor {text!r}; these have the nearest names")


def _put_by(context: typer.Context, rocket: str, found: "list[Motor]") -> None:
    """Add motors to a rocket's shortlist. A search that finds more than fit in one table is refused as a likely
    mistake."""
    from fieldkit.planning.motor_guide import label
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.shortlist import keep_shortlist, shortlist

    if len(found) > MAX_LISTED_MOTORS:
        raise typer.BadParameter(
            f"found {len(found)} motors for the shortlist, expected at most {MAX_LISTED_MOTORS}; use a longer name"
        )
    with open_ledger(context) as ledger:
        name = which_rocket(ledger, rocket)
        labels = shortlist(ledger, name) | {label(motor) for motor in found}
        keep_shortlist(ledger, name, labels)
    complain(f"{counted(len(labels), 'motor')} on the shortlist of {name}")


def _added(file: Path) -> "list[Motor]":
    from fieldkit.motors.own import import_file

    found, _ = import_file(file, motor_folder())
    remarks = [remark for motor in found for remark in motor.remarks]
    complain("\n".join([f"Added {counted(len(found), 'motor')} from {file}", *remarks]))
    known_motors()  # reports the motors that cannot be used
    return found


def _about(json: bool) -> None:
    catalogue = known_motors()
    about = {"motors": len(catalogue), **catalogue.about}
    about = {key: value for key, value in about.items() if key != "columns"}
    if json:
        print_json(about)
        return
    for key, value in about.items():
        text = "; ".join(_counted(*item) for item in value.items()) if isinstance(value, Mapping) else value
        say(f"{ABOUT_TITLES.get(key, key.replace('_', ' '))}: {text}")


def _counted(what: str, value: object) -> str:
    """A line about the catalog: dictionaries as counts, `[read, kept]` as a fraction."""
    if isinstance(value, list) and all(isinstance(item, int) for item in value):
        return f"{what} {' of '.join(map(str, reversed(value)))}"
    count = len(value) if isinstance(value, list) else value
    return f"{ABOUT_TITLES.get(what, what)} {count}"


def _list(found: "list[Motor]") -> None:
    from fieldkit.motors.motor import delays_text

    user = system()
    mass = unit("mass", SYSTEMS[user].get("g", "g"))
    headers = ("motor", "mm", "N s", "avg N", "burn s", SYSTEMS[user].get("g", "grams"), "delays", "")
    rows = [
        (
            f"{motor.maker} {motor.designation}",
            f"{motor.diameter * 1e3:g}",
            rounded(motor.total_impulse),
            rounded(motor.rated_thrust),
            f"{motor.rated_burn:.3g}",
            rounded(mass.from_si(motor.loaded_mass)),
            delays_text(motor.delays),
            "" if motor.available else "no longer made",
        )
        for motor in found[:MAX_LISTED_MOTORS]
    ]
    print_table(headers, rows, numbers=headers[1:6])
    if len(found) > MAX_LISTED_MOTORS:
        complain(f"and {len(found) - MAX_LISTED_MOTORS} more; narrow it by a longer name or a diameter such as 24mm")
    for motor in found if len(found) <= MAX_CORRECTED_MOTORS else ():
        for text in (*([motor.curve] if motor.curve else ()), *(one.text() for one in motor.corrections)):
            complain(f"{motor.maker} {motor.designation}: {text}")

"""`fieldkit simulate`: one forward flight."""

from collections.abc import Iterator, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.numbers import finite, typed
from fieldkit.cli.options import CONDITIONS, SETUP, takes_columns
from fieldkit.cli.planning import AllChecks, own_limits, print_safety
from fieldkit.cli.screen import AsJson, complain, measured, print_json, say, say_wrapped
from fieldkit.cli.session import known_motors
from fieldkit.errors import BadValue
from fieldkit.flight import COLUMNS, Flight
from fieldkit.flight.site import Site
from fieldkit.messages import marked, message
from fieldkit.planning.check import OFF_APOGEE, SafetyCheck
from fieldkit.units import unit

if TYPE_CHECKING:
    from fieldkit.motors.several import Booster

app = typer.Typer()

BODY = ("motor", "dry_mass", "diameter")
"""Columns that both simulators take, as typer names them: without the unit."""
SPEEDS = {"rail_speed_mps": "Rail exit speed", "eject_speed_mps": "Speed at ejection"}
"""Speeds that no flight table has, and their titles."""


class Physics(StrEnum):
    """The simulator to use."""

    paper = "paper"
    field = "field"


def simulate(
    cd: Annotated[
        float | None,
        typer.Option(min=0.001, max=50.0, callback=finite, help="Drag coefficient; default: that of other rockets."),
    ] = None,
    alpha: Annotated[
        float,
        typer.Option(min=0.01, max=10.0, callback=finite, help="Thrust factor: thrust relative to the certified."),
    ] = 1.0,
    physics: Annotated[
        Physics, typer.Option(help="fieldkit's simulator (field), or the reference paper's.")
    ] = Physics.field,
    lift_off_mass: Annotated[
        str | None,
        typer.Option(help="Mass on the pad with all motors and stages: 620g, 22oz; replaces the dry mass."),
    ] = None,
    booster_mass: Annotated[
        str | None,
        typer.Option(
            help="Mass of each lower stage without its motor, lowest first: 60g, or 2oz/1.4oz; for motors such as "
            "D12-0/C6-7."
        ),
    ] = None,
    booster_cd: Annotated[
        str | None,
        typer.Option(
            help="Drag coefficient of the rocket on each lower stage, lowest first, for the same diameter: 0.9; "
            "default: that of --cd."
        ),
    ] = None,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Simulate one flight from motor, mass, diameter, and Cd. The rocket weathercocks fully into the wind."""
    from fieldkit.importing.manual_entry import read_changes
    from fieldkit.physics.single import field_flight, paper_flight
    from fieldkit.planning.staged_safety import staged_lines
    from fieldkit.services.manual_entry import dry_mass_under
    from fieldkit.services.usual_cd import usual_cd

    options = {name: text for name, text in given.items() if text is not None}
    if bool(lift_off_mass) == ("dry_mass" in options):
        raise typer.BadParameter("found both or none of --dry-mass and --lift-off-mass, expected one of them")
    for name in ("motor", "diameter"):
        if name not in options:
            raise typer.BadParameter(f"found no --{_dashed(name)}, expected one")
    unused = [f"--{_dashed(name)}" for name in options if name not in BODY]
    unused += ["--lift-off-mass"] if lift_off_mass else []
    if physics is Physics.paper and unused:
        raise BadValue(
            f"{', '.join(unused)}: found a value, expected none: the paper's physics takes motor, dry mass and diameter"
        )
    plan = Flight().with_changes(**read_changes(Flight(), options))
    if physics is Physics.paper:
        if cd is None:
            raise typer.BadParameter("found no --cd, expected one for the paper's physics")
        _print(paper_flight(plan, cd, alpha), json=json)
        return
    low, drag, high = (cd, cd, cd) if cd is not None else usual_cd()
    found = known_motors().resolve_several(plan.motor, _boosters(booster_mass, booster_cd, drag))
    for note in found.notes:
        complain(f"note: {note}")
    if lift_off_mass:
        weighed = typed("--lift-off-mass", lift_off_mass, "mass", "g")
        try:
            plan = plan.with_changes(dry_mass=dry_mass_under(weighed, found.motor))
        except BadValue as error:
            raise BadValue(message(f"lift-off mass: {marked(error)}")) from error
    result = field_flight(plan, found, drag, alpha)
    highest = result if cd is not None else field_flight(plan, found, low, alpha)
    if cd is None:
        least = field_flight(plan, found, high, alpha)
        ends = [measured("apogee", one["apogee_m"]) for one in (least, highest)]
        complain(
            f"note: Cd not given: {drag:.2f}, the median of other rockets; 90% of them have {low:.2f} to {high:.2f}, "
            f"which gives an apogee of {ends[0]} to {ends[1]}"
        )
        result |= {"cd": drag, "cd_p05": low, "cd_p95": high, "apogee_m_p05": least["apogee_m"]}
        result |= {"apogee_m_p95": highest["apogee_m"]}
    if "duration_s" in result and "apogee_to_eject_s" not in result:
        complain(
            "note: the motor has no known charge, so duration and descent speed are those of a parachute open at "
            f"apogee: {OFF_APOGEE}"
        )
    lines = []
    if found.motor.kind == "stages":
        lines = staged_lines(plan, found, highest, Site(), own_limits())
    _print(result, lines, every=checks, json=json)


def _print(
    result: dict[str, Any], lines: "Sequence[SafetyCheck] | None" = None, *, every: bool = False, json: bool
) -> None:
    """Print the figures of a flight, and its safety checks if it has any, failed ones or `every` one in full; `lines`
    is None for the paper's physics."""
    if json:
        print_json({**result, "safety": [line.json() for line in lines]} if lines else result)
        return
    figures = [(title, measured(name, value)) for title, name, value in _figures(result)]
    width = max(len(title) for title, _ in figures)
    for title, text in figures:
        say(f"{title:{width}}  {text}")
    if lines is not None:
        say_wrapped(
            "Apogee and ejection altitude are as a barometric altimeter shows them; true apogee is above the pad."
        )
    if lines:
        print_safety(lines, every=every)


def _boosters(masses: str | None, cds: str | None, cd: float) -> "tuple[Booster, ...]":
    """The lower stages as typed, lowest first. Raises BadValue, BadParameter."""
    from fieldkit.motors.several import Booster

    mass = [typed("--booster-mass", one, "mass", "g") for one in masses.split("/")] if masses else []
    drag = [typed("--booster-cd", one, "number", "") for one in cds.split("/")] if cds else [cd] * len(mass)
    if len(drag) != len(mass):
        raise typer.BadParameter(f"found {len(drag)} --booster-cd and {len(mass)} --booster-mass, expected as many")
    if not all(value > 0 for value in (*mass, *drag)):
        raise typer.BadParameter("found a booster without mass or Cd, expected numbers above zero")
    return tuple(Booster(one, other / cd) for one, other in zip(mass, drag, strict=True))


def _figures(result: dict[str, float]) -> Iterator[tuple[str, str, float]]:
    """Title, column and value [SI] of each figure of a flight, by its header in the flight table."""
    columns = {column.header: column for column in COLUMNS}
    for header, value in result.items():
        if header in SPEEDS:
            yield SPEEDS[header], "top_speed", value
            continue
        if (column := columns.get(header.removeprefix("true_"))) is None:
            continue
        title = "True apogee" if header.startswith("true_") else column.title
        yield title, column.name, unit(column.quantity, column.unit).to_si(value)


def _dashed(name: str) -> str:
    return name.replace("_", "-")


takes_columns(simulate, ("motor",), (*SETUP, *CONDITIONS), "The flight; a number may have a unit, as in 923ft")
app.command()(simulate)

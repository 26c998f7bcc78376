"""`fieldkit ork`: a design of OpenRocket, RockSim or RASAero as the configuration that a rocket starts with."""

from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, measured, print_json, say, say_wrapped, system
from fieldkit.cli.session import open_ledger
from fieldkit.errors import BadValue
from fieldkit.quantities import ShownUnits, written

if TYPE_CHECKING:
    from collections.abc import Iterator

    from fieldkit.openrocket import Design
    from fieldkit.rocket import Configuration

app = typer.Typer()


@app.command()
def ork(
    context: typer.Context,
    file: Annotated[
        Path, typer.Argument(help="Design of OpenRocket, RockSim or RASAero: .ork, .rkt, .CDX1.", show_default=False)
    ],
    rocket: Annotated[str | None, typer.Option(help="Default: the name in the file.", show_default=False)] = None,
    config: Annotated[str, typer.Option(help="Name of this build, such as A.")] = "",
    look: Annotated[bool, typer.Option("--dry-run", "--look", help="Show the result without saving it.")] = False,
    json: AsJson = False,
) -> None:
    """Read a rocket that has not flown from its design in OpenRocket, RockSim or RASAero: mass without motor, diameter,
    length, stability and, except from RockSim, Cd."""
    from fieldkit.openrocket import MAX_UNPACKED_SIZE, read_design
    from fieldkit.services.imports import read_file

    design = read_design(read_file(file, most=MAX_UNPACKED_SIZE, kind="a design"), file.name)
    name = rocket or design.name
    if not name:
        raise BadValue(f"{file.name}: found no name of the rocket, expected --rocket NAME")
    start = design.start(name, config, file.name)
    saved = False
    if not look:
        with open_ledger(context) as ledger:
            saved = ledger.keep_design(start)
    if json:
        print_json(_document(start, design, saved=saved))
        return
    say(f"{name} {config}".strip())
    for line in _lines(start, design):
        say_wrapped(line, " " * 12)
    for line in _beside(design):
        say_wrapped(line, " " * 12)
    for note in design.notes:
        complain(f"note: {note}")
    if not look:
        complain(_done(start) if saved else "Duplicate: it is already saved")


def _lines(start: "Configuration", design: "Design") -> list[str]:
    lines = []
    if start.dry_mass is not None:
        lines.append(f"  dry mass  {measured('dry_mass', start.dry_mass)}, from {design.mass_by}")
    if start.diameter is not None:
        lines.append(f"  diameter  {measured('diameter', start.diameter)}")
    if start.length is not None:
        lines.append(f"  length    {written(start.length, 'mm', system())}")
    lines.append(f"  Cd        {start.cd:.2f}, from {design.cd_by}" if start.cd else "  Cd        not in the file")
    if start.margin is not None:
        lines.append(f"  stability {start.margin:.1f} calibers with its motor, at small angles")
    elif design.balance is not None:
        cp = written(design.balance.cp, "mm", system())
        lines.append(f"  stability center of pressure {cp} from the nose; a plan has the margin with its own motor")
    margins = {
        f"{motor.maker} {motor.designation}": margin
        for one in design.motors
        if one.count == 1 and (motor := one.found()) and (margin := design.margin(motor)) is not None
    }
    if margins:
        shown = ", ".join(f"{margin:.1f} with {name}" for name, margin in margins.items())
        lines.append(f"  from its parts (Barrowman), on the pad, in calibers: {shown}")
    motors = dict.fromkeys(
        " ".join(filter(None, (f"{one.count} ×" if one.count > 1 else "", one.maker, one.designation)))
        for one in design.motors
    )
    return [*lines, f"  motors    {', '.join(motors)}"] if motors else lines


CLOSE_ENOUGH = 0.05
"""Difference between a stored apogee and our own above which the possible reasons are printed. [1]"""


def _beside(design: "Design") -> "Iterator[str]":
    """Each stored simulation beside our own with the same mass, rod and wind, and why they may differ."""
    shown, far = ShownUnits(system()), False
    for one in design.flown_again:
        wind = ""
        if one.wind:
            wind = f"; {shown.length(one.growing_wind)} in a wind that grows with height from {shown.speed(one.wind)}"
        ours = f"{shown.length(one.level_wind)} here ({one.difference:+.1%})"
        yield f"  {one.name or 'simulation'} on {one.motor}: {shown.length(one.stored)} stored, {ours}{wind}"
        far = far or abs(one.difference) > CLOSE_ENOUGH
    if far:
        yield (
            f"  more than {CLOSE_ENOUGH:.0%} apart: here one Cd stands for all motors, that of {design.cd_by}, while "
            "that of a simulation changes with speed; and its thrust curve may not be that of the catalog, held to the "
            "certified impulse and burn time (`fieldkit motors MOTOR --check`)"
        )
    if any(one.wind for one in design.flown_again):
        yield "  The simulated wind is the same at every height: so is a plan's with --wind-aloft as fast as --wind"


def _done(start: "Configuration") -> str:
    config = f" --config {quote(start.config)}" if start.config else ""
    rocket = quote(start.rocket)
    return f"Saved. Next: `fieldkit predict --rocket {rocket}{config} --motor MOTOR`. `fieldkit undo` to undo."


def _document(start: "Configuration", design: "Design", *, saved: bool) -> dict[str, object]:
    return {
        "rocket": start.rocket,
        "config": start.config,
        "dry_mass_g": None if start.dry_mass is None else start.dry_mass * 1e3,
        "diameter_mm": None if start.diameter is None else start.diameter * 1e3,
        "length_mm": None if start.length is None else start.length * 1e3,
        "cd": start.cd,
        "mass_by": design.mass_by,
        "cd_by": design.cd_by,
        "stability_cal": start.margin,
        "motors": [asdict(one) for one in design.motors],
        "simulations": [
            {
                "name": one.name,
                "up_to_date": one.fresh,
                "dry_mass_g": None if one.dry_mass is None else one.dry_mass * 1e3,
                "cd": one.cd,
                "reference_diameter_mm": one.reference * 1e3,
                "apogee_m": one.apogee,
                "top_speed_mps": one.top_speed,
            }
            for one in design.simulations
        ],
        "flown_again": [asdict(one) | {"difference": one.difference} for one in design.flown_again],
        "notes": list(design.notes),
        "saved": saved,
    }

"""`fieldkit simulate`: one forward flight."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import complain, print_json, say
from fieldkit.cli.session import known_motors

if TYPE_CHECKING:
    from fieldkit.flight import Flight

app = typer.Typer()

CONDITIONS = "Conditions (field physics)"


class Physics(StrEnum):
    """Which simulator flies."""

    paper = "paper"
    field = "field"


def _condition(text: str) -> object:
    return typer.Option(help=text, rich_help_panel=CONDITIONS, show_default=False)


@app.command()
def simulate(
    motor: Annotated[str, typer.Option(help="Such as F24-4W.", show_default=False)],
    dry_mass_g: Annotated[float, typer.Option(help="Without the motor.", show_default=False)],
    diameter_mm: Annotated[float, typer.Option(help="Largest of the body.", show_default=False)],
    cd: Annotated[float, typer.Option(min=0.001, max=50.0, help="Drag coefficient.", show_default=False)],
    alpha: Annotated[float, typer.Option(min=0.01, max=10.0, help="Thrust over declared thrust.")] = 1.0,
    physics: Annotated[Physics, typer.Option(help="The field's, or the reference paper's.")] = Physics.field,
    delay_s: Annotated[float | None, _condition("Ejection delay.")] = None,
    site_elevation_m: Annotated[float | None, _condition("Pad above sea level.")] = None,
    temperature_c: Annotated[float | None, _condition("Air at the pad.")] = None,
    pressure_hpa: Annotated[float | None, _condition("Reduced to sea level.")] = None,
    humidity_pct: Annotated[float | None, _condition("Relative, at the pad.")] = None,
    wind_mps: Annotated[float | None, _condition("At the pad.")] = None,
    rail_length_m: Annotated[float | None, _condition("Of the rod or rail.")] = None,
    rail_angle_deg: Annotated[float | None, _condition("From vertical.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Fly one rocket once, forwards."""
    from fieldkit.errors import BadValue
    from fieldkit.simulator.single import field_flight, paper_flight

    conditions = {
        "delay_s": delay_s,
        "site_elevation_m": site_elevation_m,
        "temperature_c": temperature_c,
        "pressure_hpa": pressure_hpa,
        "humidity_pct": humidity_pct,
        "wind_mps": wind_mps,
        "rail_length_m": rail_length_m,
        "rail_angle_deg": rail_angle_deg,
    }
    given = {name: value for name, value in conditions.items() if value is not None}
    plan = _plan(motor, {"dry_mass_g": dry_mass_g, "diameter_mm": diameter_mm, **given})
    if physics is Physics.paper:
        if given:
            names = ", ".join(f"--{name.replace('_', '-')}" for name in given)
            raise BadValue(f"{names}: found a value, the paper's physics knows no conditions")
        result = paper_flight(plan, cd, alpha)
    else:
        found = known_motors().resolve(motor)
        for note in found.notes:
            complain(note)
        result = field_flight(plan, found, cd, alpha)
    if json:
        print_json(result)
        return
    width = max(map(len, result))
    for name, value in result.items():
        say(f"{name:{width}}  {value:.4g}")


def _plan(motor: str, figures: dict[str, float]) -> "Flight":
    """A planned flight from figures by column, unit and all. Raises BadValue for one that no flight can have."""
    from fieldkit.errors import BadValue
    from fieldkit.flight import COLUMNS, Flight
    from fieldkit.sanity import check

    values = {}
    for column in COLUMNS:
        if column.header in figures:
            try:
                values[column.name] = check(column, column.parse(repr(figures[column.header])))
            except BadValue as error:
                raise BadValue(f"--{column.header.replace('_', '-')}: {error}") from error
    return Flight(motor=motor).with_changes(**values)

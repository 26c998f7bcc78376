"""`fieldkit simulate`: one forward flight."""

from enum import Enum
from typing import Annotated

import typer

from fieldkit.cli.screen import print_json, say

app = typer.Typer()

CONDITIONS = "Conditions (field physics)"


class Physics(str, Enum):
    """Which simulator flies."""

    paper = "paper"
    field = "field"


def _condition(text: str) -> object:
    return typer.Option(help=text, rich_help_panel=CONDITIONS, show_default=False)


@app.command()
def simulate(
    motor: Annotated[str, typer.Option(help="Such as F24-4W.", show_default=False)],
    dry_mass_g: Annotated[float, typer.Option(min=1.0, help="Without the motor.", show_default=False)],
    diameter_mm: Annotated[float, typer.Option(min=1.0, help="Largest of the body.", show_default=False)],
    cd: Annotated[float, typer.Option(min=0.0, help="Drag coefficient.", show_default=False)],
    alpha: Annotated[float, typer.Option(min=0.0, help="Thrust over certified thrust.")] = 1.0,
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
    from fieldkit.errors import BadValue, FieldkitError
    from fieldkit.simulator.single import paper_flight

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
    given = [f"--{name.replace('_', '-')}" for name, value in conditions.items() if value is not None]
    if physics is Physics.field:
        raise FieldkitError("the field's physics cannot be flown by this command yet, try --physics paper")
    if given:
        raise BadValue(f"{', '.join(given)}: found a value, the paper's physics knows no conditions")
    result = paper_flight(motor, dry_mass_g / 1e3, diameter_mm / 1e3, cd, alpha)
    if json:
        print_json(result)
        return
    width = max(map(len, result))
    for name, value in result.items():
        say(f"{name:{width}}  {value:.4g}")

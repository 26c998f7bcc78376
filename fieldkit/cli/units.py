"""`fieldkit units`: the units in which numbers are shown."""

from typing import Annotated

import typer

from fieldkit.cli.screen import AsJson, print_json, say
from fieldkit.flight import BY_NAME
from fieldkit.quantities import unit_of
from fieldkit.settings import UNITS, change_settings, read_settings
from fieldkit.spelled_units import spelled

app = typer.Typer()
EXAMPLES = ("apogee", "top_speed", "dry_mass", "diameter", "temperature", "pressure")
"""Columns whose units are listed."""


@app.command()
def units(
    system: Annotated[
        str | None,
        typer.Argument(metavar="[SI|US|mixed]", help="The units to use from now on.", show_default=False),
    ] = None,
    json: AsJson = False,
) -> None:
    """Show or set the units of every command and of the app; mixed is feet, with grams and millimeters."""
    if system is not None:
        named = {one.casefold(): one for one in UNITS}
        if system.casefold() not in named:
            raise typer.BadParameter(f"found {system!r}, expected one of {', '.join(UNITS)}")
        change_settings({"units": named[system.casefold()]})
    chosen = read_settings().units
    shown = {name: spelled(unit_of(BY_NAME[name], chosen)) for name in EXAMPLES}
    if json:
        print_json({"units": chosen, "shown": shown})
        return
    say(f"{chosen}: " + ", ".join(f"{BY_NAME[name].title.lower()} in {unit}" for name, unit in shown.items()))

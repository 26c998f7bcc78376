"""`fieldkit units`: the units in which numbers are shown, and how they are chosen at the first start."""

import os
import sys
from collections.abc import Mapping
from typing import Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, say
from fieldkit.flight import BY_NAME
from fieldkit.paths import settings_file
from fieldkit.quantities import unit_of
from fieldkit.settings import UNITS, change_settings, read_settings
from fieldkit.spelled_units import spelled

app = typer.Typer()
EXAMPLES = ("apogee", "top_speed", "dry_mass", "diameter", "temperature", "pressure")
"""Columns whose units are listed."""
LOCALES = ("LC_ALL", "LC_MEASUREMENT", "LANG")
"""Variables of the environment that name a country, in the order in which they count."""


@app.command()
def units(
    system: Annotated[
        str | None,
        typer.Argument(metavar="[SI|US|mixed]", help="The units to use from now on.", show_default=False),
    ] = None,
    json: AsJson = False,
) -> None:
    """Show or set the units of every command and of the app; mixed is feet, with grams and millimeters.

    A number typed after an option without its unit stays in the unit that the option's help names.
    """
    if system is not None:
        change_settings({"units": system_named(system)})
    chosen = read_settings().units
    if json:
        print_json({"units": chosen, "shown": _shown(chosen)})
        return
    say(_in_words(chosen))


def ask_units_once() -> None:
    """At the first start in a terminal, ask for the units and save the answer; Enter accepts the country's."""
    if not in_terminal() or settings_file().exists():
        return
    complain("Numbers can be shown in")
    for name in UNITS:
        complain(f"  {_in_words(name)}")
    chosen = None
    while chosen is None:
        typed = typer.prompt("Which?", default=usual_units(os.environ), err=True)
        if (chosen := _named(typed)) is None:
            complain(f"found {typed!r}, expected one of {', '.join(UNITS)}")
    change_settings({"units": chosen})
    complain("To change them: fieldkit units, or N in the app")


def in_terminal() -> bool:
    """Whether somebody reads the output and can answer."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def usual_units(environment: Mapping[str, str]) -> str:
    """The units of the country that a user's environment names."""
    country = next((environment[name] for name in LOCALES if environment.get(name)), "")
    return "US" if "_US" in country else "SI"


def system_named(typed: str) -> str:
    """The system of units that was typed. Raises BadParameter."""
    if (named := _named(typed)) is None:
        raise typer.BadParameter(f"found {typed!r}, expected one of {', '.join(UNITS)}")
    return named


def _named(typed: str) -> str | None:
    """The system of units that was typed, in any case; None for another word."""
    return {one.casefold(): one for one in UNITS}.get(typed.strip().casefold())


def _shown(system: str) -> dict[str, str]:
    """The units of a system by column."""
    return {name: spelled(unit_of(BY_NAME[name], system)) for name in EXAMPLES}


def _in_words(system: str) -> str:
    """A system with its units: `US: apogee in ft, ...`."""
    return f"{system}: " + ", ".join(
        f"{BY_NAME[name].title.lower()} in {unit}" for name, unit in _shown(system).items()
    )

"""Options that stand for columns of a flight, with and without their unit in the name."""

import inspect
from collections.abc import Callable, Iterable
from typing import Annotated, Any

import typer

from fieldkit import flight
from fieldkit.cli.completing import config_names, motor_names, rocket_names
from fieldkit.flight.recovery import RECOVERY_COLUMNS, RECOVERY_TEXTS
from fieldkit.quantities import spelled

TEXTS = tuple(name for name in flight.TEXT_COLUMNS if name != "log")
SETUP, CONDITIONS, READOUTS = (
    tuple(column.header for column in columns) for columns in (flight.SETUP, flight.CONDITIONS, flight.READOUTS)
)
"""Columns of the flight table that are options of commands."""
OPTION_HELP = {
    "flight_id": "Its number or name; the next free number by itself.",
    "date_time": "Of lift-off, 2026-05-01T10:30; now by itself.",
    "rocket": "Its name.",
    "config": "The build of it, such as A or ballast.",
    "motor": "As printed on it: F24-4W.",
    "site": "Name of the field.",
    "tags": "Apart by ;, such as off_axis; weak_launch.",
    "notes": "Anything else.",
}
"""What the texts of a flight are."""
COMPLETIONS = {"rocket": rocket_names, "config": config_names, "motor": motor_names}
"""Completion function of each option."""


def takes_columns(command: Callable[..., None], texts: Iterable[str], numbers: Iterable[str], panel: str) -> None:
    """Give a command an option for each column, which arrives as text (or None) among its `**given`."""
    signature = inspect.signature(command)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    own += [_option(name, [f"--{name.replace('_', '-')}"], OPTION_HELP[name], panel) for name in texts]
    for header in numbers:
        name = header.rpartition("_")[0]
        flags = [f"--{header.replace('_', '-')}", f"--{name.replace('_', '-')}"]
        column = flight.BY_NAME[name]
        own.append(_option(name, flags, f"{column.help[:-1]}; in {spelled(column.unit)}.", panel))
    keyword = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]
    command.__signature__ = inspect.Signature(keyword)  # type: ignore[attr-defined]  # read by typer
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in keyword}


PLAN_TEXTS = ("motor", "config", "rocket", "site")
"""Texts of a plan that are options of the commands that plan."""
PLAN = "The plan; numbers may be typed with their unit, as 8mph"
"""Over the options of a plan in a command's help."""
RECOVERY = "The way down; numbers may be typed with their unit, as 500ft"
"""Over the options of a recovery in a command's help."""
FIELD = (
    ("motor_temperature", "Of the motor as it is loaded; in °C."),
    ("waiver", "Ceiling above the pad: 500m. That saved with the site, where not said."),
    ("field_size", "The field's shorter side: 300m. That saved with the site, where not said."),
    ("lift_off_mass", "As weighed on the pad with the motor in it: 620g; in place of the dry mass."),
    ("kit", "A kit of yours in kits.toml, for mass, diameter and mount."),
    ("people", "From the pad to the people at the launch: 30m. That of the site, where not said."),
    ("bystanders", "To persons and property that have no part in it: 500m. That of the site, where not said."),
    ("rules", "Whose rules govern the launch: NAR,FAA or UKRA. Those of the site, where not said."),
)
"""Options of a plan that no column of a flight stands for; safety lines are told by them."""


def takes_plan(command: Callable[..., None], texts: Iterable[str] = PLAN_TEXTS) -> None:
    """Give a command the options of a planned flight, which arrive among its `**given`; see `takes_columns`."""
    takes_columns(command, texts, (*SETUP, *CONDITIONS), PLAN)
    signature: inspect.Signature = command.__signature__  # type: ignore[attr-defined]
    parameters = [*signature.parameters.values()]
    parameters += [_option(name, [f"--{name.replace('_', '-')}"], text, PLAN) for name, text in FIELD]
    recovery = {name: column[2] for name, column in RECOVERY_COLUMNS.items()} | RECOVERY_TEXTS
    parameters += [_option(name, [f"--{name.replace('_', '-')}"], text, RECOVERY) for name, text in recovery.items()]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # read by typer
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}


def _option(name: str, flags: list[str], text: str, panel: str) -> inspect.Parameter:
    option: Any = typer.Option(
        *flags, help=text, rich_help_panel=panel, show_default=False, autocompletion=COMPLETIONS.get(name)
    )
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[str | None, option]
    )

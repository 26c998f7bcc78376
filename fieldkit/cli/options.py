"""Options for columns of a flight, with and without the unit in the name, and those of the motor guide."""

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
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
    "flight_id": "Number or name of the flight; default: the next free number.",
    "date_time": "Date and time of lift-off, 2026-05-01T10:30; default: now.",
    "rocket": "Name of the rocket.",
    "config": "Name of the build, such as A or ballast.",
    "motor": "Motor as printed on it: F24-4W.",
    "site": "Name of the launch site.",
    "tags": "Tags separated by ;, such as off_axis; weak_launch.",
    "notes": "Free text.",
}
"""Help of the text columns of a flight."""
SHORTER = {"date_time": ("date",)}
"""Other names of the options of columns."""
OTHER_OPTIONS = (
    ("lift_off_mass", ["--lift-off-mass"], "Mass ready to fly with the motor: 620g, 22oz; replaces the dry mass."),
    ("timer_1_s", ["--timer-1-s", "--timer-1"], "What a watch showed: 38.42."),
    ("timer_2_s", ["--timer-2-s", "--timer-2"], "What another one showed."),
    ("eggs", ["--eggs"], "2 intact, 1 cracked."),
)
"""Options of a flight that are not among its columns: its name, the flags and the help."""
TYPED_EXAMPLES = {
    "dry_mass": "11.4oz",
    "diameter": "2.6in",
    "site_elevation": "700ft",
    "temperature": "68F",
    "pressure": "30.1inHg",
    "wind": "8mph",
    "rail_length": "3ft",
    "apogee": "923ft",
    "top_speed": "150mph",
    "eject_altitude": "910ft",
    "descent_speed": "15mph",
}
"""A number with a unit other than the default, for the help of an option."""
COMPLETIONS = {"rocket": rocket_names, "config": config_names, "motor": motor_names}
"""Completion function of each option."""


def takes_columns(
    command: Callable[..., None], texts: Iterable[str], numbers: Iterable[str], panel: str, *, hidden: bool = False
) -> None:
    """Give a command an option for each column, which arrives as text (or None) among its `**given`."""
    signature = inspect.signature(command)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    for name in texts:
        flags = [f"--{one.replace('_', '-')}" for one in (name, *SHORTER.get(name, ()))]
        own.append(_option(name, flags, OPTION_HELP[name], panel, hidden=hidden))
    for header in numbers:
        name = header.rpartition("_")[0]
        flags = [f"--{header.replace('_', '-')}", f"--{name.replace('_', '-')}"]
        column = flight.BY_NAME[name]
        typed = f", or with a unit: {TYPED_EXAMPLES[name]}" if name in TYPED_EXAMPLES else ""
        text = f"{column.help[:-1]}; in {_unit(column.unit)}{typed}."
        own.append(_option(name, flags, text, panel, hidden=hidden))
    _take(command, [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own])


LACKING = "What the files lack, for every flight in them; other columns with --set"
"""Heading of the options of `takes_lacking` in a command's help."""


def takes_flight(command: Callable[..., None], panel: str = "", *, hidden: bool = False) -> None:
    """Give a command the options of a whole flight, which arrive among its `**given`, see `takes_columns`; its help
    lists them unless they are `hidden`."""
    takes_columns(command, TEXTS, (*SETUP, *CONDITIONS, *READOUTS), panel, hidden=hidden)
    signature: inspect.Signature = command.__signature__  # type: ignore[attr-defined]
    judged = [_option(name, flags, text, panel, hidden=hidden) for name, flags, text in OTHER_OPTIONS]
    _take(command, [*signature.parameters.values(), *judged])


def takes_lacking(command: Callable[..., None]) -> None:
    """Give a command options for what logs do not contain, which arrive among its `**named`; see `takes_columns`."""
    takes_columns(command, ("rocket", "config", "motor", "site"), ("dry_mass_g", "diameter_mm"), LACKING)


PLAN_TEXTS = ("motor", "config", "rocket", "site")
"""Text columns of a plan that are options of the planning commands."""
PLAN = "The plan; a number may have a unit, as in 8mph"
"""Heading of the plan options in a command's help."""
RECOVERY = "Descent; a number may have a unit, as in 500ft"
"""Heading of the recovery options in a command's help."""
FIELD = (
    ("motor_temperature", "Temperature of the motor when loaded; in °C, or with a unit: 68F."),
    ("waiver", "Ceiling above the pad: 500m, 1600ft. Default: saved with the site."),
    ("field_size", "Shorter side of the field: 300m, 1000ft. Default: saved with the site."),
    ("lift_off_mass", "Mass on the pad with the motor: 620g, 22oz; replaces the dry mass."),
    ("kit", "One of your kits in kits.toml: sets mass, diameter, and motor mount."),
    ("people", "Distance from the pad to the people at the launch: 30m, 100ft. Default: saved with the site."),
    (
        "bystanders",
        "Distance to people and property not involved in the launch: 500m, 1500ft. Default: saved with the site.",
    ),
    ("rules", "Rules that govern the launch: NAR,FAA or UKRA. Default: saved with the site."),
)
"""Options of a plan that are not columns of a flight; the safety checks use them."""


def _unit(unit: str) -> str:
    """A unit as the help of an option names it."""
    return "degrees" if unit == "deg" else "percent" if unit == "pct" else spelled(unit)


def takes_plan(command: Callable[..., None], texts: Iterable[str] = PLAN_TEXTS) -> None:
    """Give a command the options of a planned flight, which arrive among its `**given`; see `takes_columns`."""
    takes_columns(command, texts, (*SETUP, *CONDITIONS), PLAN)
    signature: inspect.Signature = command.__signature__  # type: ignore[attr-defined]
    parameters = [*signature.parameters.values()]
    parameters += [_option(name, [f"--{name.replace('_', '-')}"], text, PLAN) for name, text in FIELD]
    recovery = {name: column[2] for name, column in RECOVERY_COLUMNS.items()} | RECOVERY_TEXTS
    parameters += [_option(name, [f"--{name.replace('_', '-')}"], text, RECOVERY) for name, text in recovery.items()]
    _take(command, parameters)


def _take(command: Callable[..., None], parameters: Sequence[inspect.Parameter]) -> None:
    """Give a command these parameters."""
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # read by typer
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}


def dashed(given: Mapping[str, str | None]) -> dict[str, str]:
    """The options that were given, named as they are typed: `--dry-mass`."""
    return {f"--{name.replace('_', '-')}": text for name, text in given.items() if text is not None}


def _option(name: str, flags: list[str], text: str, panel: str, *, hidden: bool = False) -> inspect.Parameter:
    complete = COMPLETIONS.get(name)
    option: Any = typer.Option(
        *flags, help=text, rich_help_panel=panel, show_default=False, autocompletion=complete, hidden=hidden
    )
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[str | None, option]
    )


@dataclass(frozen=True, slots=True)
class GuideOptions:
    """The options of the motor guide, as typed, by their names on the command line."""

    target: str | None
    class_: str
    mount: str | None
    adapter: bool
    season: int | None
    max_length: str | None
    max_impulse: float | None
    retired: bool
    shortlist: bool
    box: bool
    in_stock: Path | None
    all_: bool
    quick: bool

    def given(self) -> list[str]:
        """The names of those that were given."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return [f"--{name.rstrip('_').replace('_', '-')}" for name, value in values.items() if value not in UNSET]


UNSET = (None, "", False)
"""Values of options that were not given."""

"""Placeholders of values in the help: `--dry-mass MASS` says what to type, a type such as `str` does not."""

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from functools import partial
from typing import Any

import typer

from fieldkit.flight import BY_NAME
from fieldkit.flight.recovery import RECOVERY_COLUMNS

BY_QUANTITY = {
    "length": "LENGTH",
    "mass": "MASS",
    "speed": "SPEED",
    "time": "SECONDS",
    "temperature": "TEMPERATURE",
    "pressure": "PRESSURE",
    "fraction": "PERCENT",
    "angle": "DEGREES",
    "acceleration": "G",
}
"""Placeholder of a number of each quantity."""
OPTIONS = """
    LENGTH: bystanders ceiling elevation field_size max_length mount people rocket_length size target waiver within
    MASS: heaviest lift_off_mass lightest
    MASSES: booster_mass
    SPEED: limit
    TEMPERATURE: motor_temperature
    FILE: compare file files flights import_ plans
    FOLDER: out
    ROCKET: fit rocket shortlist_for
    FLIGHTS: declared
    FLIGHT: flight
    NAME: config device format kit name site
    MOTOR: motor search
    TEXT: notes title
    TAG: tag
    TAGS: tags
    ID: flight_id
    DATE: date_time since
    EFFECTS: decline effect
    YEAR: season
    RULES: rules
    RANGE: targets
    SECONDS: cuts timer_1_s timer_2_s window
    POINTS: cut
    PERCENT: parachute reef
    DEGREES: wind_from
    LAT,LON: pad
    CD: booster_cd cd
    FACTOR: alpha
    DIRECTION: rail_direction
    DEVICE: recovery
    DIAMETERS: stability_cal
    CLASS: class_
    NS: max_impulse
    BAUD: baud
    COUNT: count last n_train
    NUMBER: number port seed use
    ADDRESS: cluster host
    EXPORT: exports
    LEVEL: certification
    DATE: born
    LENGTHS: rails
    LOT: lot
    EGGS: eggs
"""
"""Placeholders of the options and arguments that are not numbers of a flight's columns."""
MILLIMETERS = frozenset({"diameter", "parachute_diameter", "max_length", "mount", "rocket_length"})
"""Lengths that are in mm if they are typed without a unit; all others are in m."""
TYPES = {"str": "text", "int": "number", "float": "number"}
"""What the help calls the type of an argument, by its name in the code."""


def placeholders() -> Mapping[str, str]:
    """The placeholder of each option and argument by its name."""
    named = {name: word for line in OPTIONS.split("\n") if line.strip() for word, name in _row(line)}
    quantities = {name: column.quantity for name, column in BY_NAME.items()}
    quantities |= {name: quantity for name, (quantity, _, _) in RECOVERY_COLUMNS.items()}
    return named | {name: BY_QUANTITY[quantity] for name, quantity in quantities.items() if quantity in BY_QUANTITY}


def _row(line: str) -> Iterable[tuple[str, str]]:
    word, names = line.strip().split(": ")
    return ((word, name) for name in names.split())


def name_values(command: Any) -> None:
    """Give each option and argument of a command, and of its subcommands, a placeholder for its value."""
    known = placeholders()
    for parameter in command.params:
        takes_text = not hasattr(parameter.type, "choices") and not getattr(parameter, "is_flag", False)
        if parameter.metavar is None and parameter.name in known and takes_text:
            word = known[parameter.name]
            parameter.metavar = f"{word}..." if parameter.nargs == -1 else word
        if parameter.param_type_name == "argument" and parameter.type.name in TYPES:
            parameter.type = copy(parameter.type)
            parameter.type.name = TYPES[parameter.type.name]
    for inner in getattr(command, "commands", {}).values():
        name_values(inner)


def refuse_empty_paths(command: Any) -> None:
    """Refuse an empty path of a command and its subcommands, such as that of a variable that a script never set:
    pathlib would read it as the current folder."""
    for parameter in command.params:
        if parameter.type.name == "path":
            parameter.type = copy(parameter.type)
            parameter.type.convert = partial(_path, parameter.type.convert)
    for inner in getattr(command, "commands", {}).values():
        refuse_empty_paths(inner)


def _path(convert: Callable[[Any, Any, Any], Any], text: Any, parameter: Any, context: Any) -> Any:
    """The path of an argument."""
    if text == "":
        raise typer.BadParameter("found an empty path, expected the name of a file or folder", context, parameter)
    return convert(text, parameter, context)

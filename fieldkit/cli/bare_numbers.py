"""Notes about numbers typed without a unit by a flyer who reads feet: an option takes them in SI units, whatever the
units of the answers."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from fieldkit import units
from fieldkit.cli.metavars import BY_QUANTITY, MILLIMETERS
from fieldkit.cli.screen import complain, system
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME
from fieldkit.quantities import SYSTEMS, with_unit, written
from fieldkit.typed_amounts import typed_amount

_TAKEN_IN = {"length": "m", "mass": "g", "speed": "m/s", "temperature": "c", "pressure": "hpa"}
"""The unit of a number without one, by quantity; lengths in `MILLIMETERS` are in mm."""
_QUANTITIES = {BY_QUANTITY[quantity]: quantity for quantity in _TAKEN_IN}
"""The quantity of an option's value, by its placeholder in the help."""
_AS_TYPED = {"f": "F", "inhg": "inHg"}
"""Units spelled as a flyer types them, where that differs."""


def note_bare_options(command: Any, arguments: Sequence[str]) -> None:
    """Print a note for each option of a command whose number has no unit, while answers are in others.

    An option with the unit in its name, `--apogee-m`, says which it is.
    """
    if not SYSTEMS[system()]:
        return
    words = [part for one in arguments for part in (one.split("=", 1) if one.startswith("--") else [one])]
    for parameter in command.params:
        if quantity := _QUANTITIES.get(str(parameter.metavar)):
            plain = f"--{parameter.name.replace('_', '-')}"
            for before, text in pairwise(words):
                if before == plain:
                    note_bare_number(f"{plain} ", parameter.name, quantity, text)


def note_bare_column(name: str, text: str) -> None:
    """Print a note for `COLUMN=VALUE` whose number has no unit, while answers are in others."""
    column = BY_NAME.get(name)
    if column is not None and column.quantity in _TAKEN_IN:
        note_bare_number(f"{name}=", name, column.quantity, text)


def note_bare_number(before: str, name: str, quantity: str, text: str) -> None:
    """Print how a number without a unit was read, and how to type it in the user's unit; `before` is what precedes it
    on the command line."""
    unit = "mm" if name in MILLIMETERS else _TAKEN_IN[quantity]
    own = SYSTEMS[system()].get(unit)
    typed = typed_amount(text)
    if own is None or typed is None or typed.unit:
        return
    try:
        value = units.parse(text, quantity, unit)
    except BadValue:
        return  # the command refuses it
    if not value:
        return  # zero in every unit
    own = _AS_TYPED.get(own, own)
    read = f"{with_unit(text.strip(), unit)} ({written(value, unit, system())})"
    complain(f"note: read {before}{text.strip()} as {read}; type {before}{text.strip()}{own} for {own}")

"""The ledger that the options name, and the motors known on this computer."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.bare_numbers import note_bare_column
from fieldkit.cli.screen import complain, remark, system
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, Flight
from fieldkit.messages import marked, message
from fieldkit.paths import motor_folder
from fieldkit.quantities import counted, measure

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue

LIFT_OFF = "lift_off_mass"
"""Typed in place of the dry mass for a rocket weighed with its motor."""
REMARKS = 5
"""Maximum number of remarks on flights that a command prints; the others are counted. [1]"""


@contextmanager
def open_ledger(context: typer.Context) -> "Iterator[Ledger]":
    """The ledger of `--ledger`, FIELDKIT_LEDGER, or the user's data folder.

    Problems with its backups and remarks on its flights are printed, also if the command fails.
    """
    from fieldkit.ledger import Ledger

    with Ledger.open(context.find_root().obj) as ledger:
        try:
            yield ledger
        finally:
            for line in ledger.remarks[:REMARKS]:
                remark(line)
            if more := len(ledger.remarks[REMARKS:]):
                complain(f"note: {counted(more, 'more note')} on what is excluded from every fit")
            if ledger.trouble:
                complain(f"warning: {ledger.trouble}")


def known_motors(*, always: bool = False) -> "Catalogue":
    """The shipped motors and the user's own; a damaged file among those is reported once, or `always`."""
    from fieldkit.motors import own

    folder = motor_folder()
    motors, errors = own.known_motors(folder)
    new = own.unreported(errors, folder)
    for error in errors if always else new:
        complain(str(error))
    return motors


def given_columns(arguments: Sequence[str] | None, named: Mapping[str, str | None]) -> dict[str, str]:
    """Columns and values of `--set COLUMN=VALUE` and of options `named` after columns. Raises BadParameter."""
    return split_settings(arguments or ()) | {name: text for name, text in named.items() if text is not None}


def split_settings(arguments: Sequence[str]) -> dict[str, str]:
    """Columns and values of `COLUMN=VALUE` arguments. Raises BadParameter for one without `=`."""
    for argument in arguments:
        if "=" not in argument:
            raise typer.BadParameter(f"found {argument!r}, expected COLUMN=VALUE")
    settings = dict(argument.split("=", 1) for argument in arguments)
    for name, text in settings.items():
        note_bare_column(name, text)
    return settings


def read_settings(
    settings: Mapping[str, str], check_motor: "MotorCheck", flight: "Flight | None" = None
) -> dict[str, object]:
    """Fields and values for columns and texts, of a flight if it is known; `lift_off_mass` gives the dry mass.

    Raises BadValue.
    """
    from fieldkit.importing.manual_entry import date_order, read_changes
    from fieldkit.motors import is_cluster

    columns = {name: text for name, text in settings.items() if name != LIFT_OFF}
    values = read_changes(flight or Flight(), columns, date_order(system()))
    motor = str(values.get("motor", ""))
    if motor and not is_cluster(motor) and (complaint := check_motor(motor)):
        raise BadValue(f"motor: {complaint}")
    if LIFT_OFF in settings:
        if "dry_mass" in values:
            raise BadValue("found a dry mass and a lift-off mass, expected one of them")
        weighed = (flight or Flight()).with_changes(**values)
        values["dry_mass"] = dry_mass(check_motor.catalogue, weighed, settings[LIFT_OFF])
    return values


def dry_mass(motors: "Catalogue", flight: "Flight", text: str) -> float | None:
    """The dry mass of a rocket weighed with its motor, as typed. Raises BadValue, UnknownMotor. [kg]"""
    from fieldkit.importing.manual_entry import read_lift_off_mass
    from fieldkit.services.manual_entry import weighed

    try:
        return weighed(motors, flight, read_lift_off_mass(text)).dry_mass
    except BadValue as error:
        raise BadValue(message(f"lift-off mass: {marked(error)}")) from error


def note_dry_mass(flight: "Flight") -> None:
    """Print the dry mass that followed from a typed lift-off mass."""
    complain(f"note: dry mass {measure(BY_NAME['dry_mass'], flight.dry_mass, system())}, without {flight.motor}")


class MotorCheck:
    """Checks the names of motors; the catalog is read when the first name is checked."""

    def __init__(self) -> None:
        self._catalogue: Catalogue | None = None

    @property
    def catalogue(self) -> "Catalogue":
        """The motors known here."""
        self._catalogue = self._catalogue or known_motors()
        return self._catalogue

    def __call__(self, name: str) -> str | None:
        """The error in a name in one line, or None if it names a motor, or several."""
        return self.catalogue.complaint(name)

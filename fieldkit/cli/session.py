"""The ledger that the options name, and the motors known on this computer."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from fieldkit.quantities import counted

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue

REMARKS = 5
"""Excluded flights that a command names; the others are counted. [1]"""


@contextmanager
def open_ledger(context: typer.Context) -> "Iterator[Ledger]":
    """The ledger of `--ledger`, FIELDKIT_LEDGER, or the user's data folder.

    Problems with its backups and remarks on its flights are printed, also if the command fails.
    """
    from fieldkit.cli.screen import complain, remark
    from fieldkit.ledger import Ledger

    with Ledger.open(context.find_root().obj) as ledger:
        try:
            yield ledger
        finally:
            for line in ledger.remarks[:REMARKS]:
                remark(line)
            if more := len(ledger.remarks[REMARKS:]):
                complain(f"note: {counted(more, 'more flight')} excluded from every fit")
            if ledger.trouble:
                complain(f"warning: {ledger.trouble}")


def known_motors() -> "Catalogue":
    """The shipped motors and the user's own; a damaged file among those is reported."""
    from fieldkit.cli.screen import complain
    from fieldkit.motors import own
    from fieldkit.paths import motor_folder

    motors, errors = own.known_motors(motor_folder())
    for error in errors:
        complain(str(error))
    return motors


def split_settings(arguments: Sequence[str]) -> dict[str, str]:
    """Columns and values of `COLUMN=VALUE` arguments; one without `=` is wrong usage."""
    for argument in arguments:
        if "=" not in argument:
            raise typer.BadParameter(f"found {argument!r}, expected COLUMN=VALUE")
    return dict(argument.split("=", 1) for argument in arguments)


def read_settings(
    settings: Mapping[str, str], check_motor: "MotorCheck", flight: "Flight | None" = None
) -> dict[str, object]:
    """Fields and values for columns and texts, of a flight if it is known. Raises BadValue."""
    from fieldkit.errors import BadValue
    from fieldkit.flight import Flight
    from fieldkit.importing.manual_entry import read_changes
    from fieldkit.motors import is_cluster

    values = read_changes(flight or Flight(), settings)
    motor = str(values.get("motor", ""))
    if motor and not is_cluster(motor) and (complaint := check_motor(motor)):
        raise BadValue(f"motor: {complaint}")
    return values


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

"""What commands work on: the ledger that the options name, and the motors known on this computer."""

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue


def open_ledger(context: typer.Context) -> "Ledger":
    """The ledger of `--ledger`, FIELDKIT_LEDGER, or the user's data folder."""
    from fieldkit.ledger import Ledger

    return Ledger.open(context.find_root().obj)


def known_motors() -> "Catalogue":
    """The shipped motors and the flyer's own; one of those files that is damaged is complained about."""
    from fieldkit.cli.screen import complain
    from fieldkit.motors import catalogue
    from fieldkit.motors.own import own_motors
    from fieldkit.places import motor_folder

    motors, errors = own_motors(motor_folder())
    for error in errors:
        complain(str(error))
    return catalogue().with_motors(motors) if motors else catalogue()


class MotorCheck:
    """Says what is wrong with a motor's name; the catalogue is read when the first name comes."""

    def __init__(self) -> None:
        self._catalogue: Catalogue | None = None

    @property
    def catalogue(self) -> "Catalogue":
        """The motors known here."""
        self._catalogue = self._catalogue or known_motors()
        return self._catalogue

    def __call__(self, name: str) -> str | None:
        """A complaint in one line, or None where there is such a motor, or several."""
        from fieldkit.errors import UnknownMotor

        try:
            self.catalogue.resolve(name)
        except UnknownMotor as error:
            return str(error)
        return None

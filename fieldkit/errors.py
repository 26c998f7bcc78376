"""Every error raised on purpose: trouble the flyer can fix, in one line.

The message names the file, the row and the column if there are any, what was found, and what
would be right. Anything that is not a `FieldkitError` is a fault of the program and keeps its traceback.
"""


class FieldkitError(Exception):
    """Trouble the flyer can fix; `str()` of it is one complete line."""


class DamagedLog(FieldkitError):
    """A log, or one row of it, is not what its format promises.

    `source`, `row` and `column` say where; a parser knows the row, the caller adds the source.
    """

    def __init__(
        self, found: str, *, row: int | None = None, column: str | None = None, source: str | None = None
    ) -> None:
        super().__init__(found)
        self.found = found
        self.row = row
        self.column = column
        self.source = source

    def __str__(self) -> str:
        place = [self.source, f"row {self.row}" if self.row is not None else None, self.column]
        where = ", ".join(part for part in place if part)
        return f"{where}: {self.found}" if where else self.found


class UnknownFormat(FieldkitError):
    """No parser recognizes a log, or more than one does."""


class BadValue(FieldkitError):
    """A typed or written value cannot be read as its quantity."""


class UnknownMotor(FieldkitError):
    """No motor of the catalog answers to a name; the message suggests the nearest."""


class AmbiguousMotor(FieldkitError):
    """Several motors answer to a name; the message lists them."""


class LedgerError(FieldkitError):
    """The ledger cannot be opened, read or written, or does not hold what was asked for."""


class NoFlights(FieldkitError):
    """A question needs flights that the ledger does not hold."""


class DamagedModel(FieldkitError):
    """A trained ensemble does not match its card, or cannot be run."""


class ImpossibleFlight(FieldkitError):
    """The rocket as described cannot leave the pad, or the description lacks what physics needs."""


class UnknownEffect(FieldkitError):
    """No effect of that name could act on these flights; the message lists those that could."""


class PortTrouble(FieldkitError):
    """A serial port cannot be opened, or what is on it does not answer as it should."""


class PortLost(PortTrouble):
    """A serial port that worked is gone: a pulled cable, or a unit switched off."""


class CaptureTrouble(FieldkitError):
    """A capture cannot be kept, found or read back."""

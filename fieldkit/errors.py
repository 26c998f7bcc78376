"""Every error raised on purpose: a problem that the flyer can fix, in one line.

The message names the file, row and column if there are any, what was found, and what would be right. Any other
exception is a bug and keeps its traceback.
"""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

MAX_NEAREST = 3
"""Number of similar names that a message suggests. [1]"""
MIN_SIMILARITY = 0.6
"""Minimum similarity (`difflib`) of a misspelling to a name. [1]"""
LEAST_BEGINNING = 3
"""Number of letters from which a text counts as the beginning of a name. [characters]"""
LONGEST_LINE = 1000
"""Length of a line of a message above which it loses its middle: messages may quote a file. [characters]"""


def shortened(text: str) -> str:
    """A message without the middle of its overlong lines; one without such lines as it is, with its amounts."""
    if all(len(line) <= LONGEST_LINE for line in text.split("\n")):
        return text
    return "\n".join(
        line if len(line) <= LONGEST_LINE else f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"
        for line in text.split("\n")
    )


def nearest(typed: str, known: Iterable[str], least: float = MIN_SIMILARITY) -> list[str]:
    """Up to `MAX_NEAREST` known names that a typed one may begin or misspell in any case: those that it begins, the
    shortest first, then the most similar; `least` is the minimum similarity. [1]"""
    by_fold = {name.casefold(): name for name in known}
    folded = typed.strip().casefold()
    starting = sorted((one for one in by_fold if len(folded) >= LEAST_BEGINNING and one.startswith(folded)), key=len)
    found = dict.fromkeys([*starting, *get_close_matches(folded, by_fold, MAX_NEAREST, least)])
    return [by_fold[one] for one in found][:MAX_NEAREST]


def unknown(kind: str, typed: str, known: Iterable[str]) -> str:
    """The message about a name that is not known: `no rocket 'Astrra'; did you mean Astra?`, or the known names,
    or `no rocket 'Astra' yet`."""
    names = list(known)
    if near := nearest(typed, names):
        return f"no {kind} {typed!r}; did you mean {' or '.join(near)}?"
    return f"no {kind} {typed!r}, expected one of: {', '.join(names)}" if names else f"no {kind} {typed!r} yet"


def of_rocket(rocket: str, text: str) -> str:
    """A message about a rocket, after its name if it has one."""
    return f"{rocket}: {text}" if rocket else text


class FieldkitError(Exception):
    """A problem that the flyer can fix; its `str()` is the complete message, in one line unless it lists matches."""

    def __init__(self, found: str = "") -> None:
        super().__init__(shortened(found))


class FileTaken(FieldkitError):
    """A file to write already exists; `file` is its path."""

    def __init__(self, file: Path) -> None:
        super().__init__(f"{file}: found an existing file, expected a new name, or --force to replace it")
        self.file = file


class DamagedLog(FieldkitError):
    """A log, or one row of it, does not match its format.

    `source`, `row` and `column` are the position; a parser gives the row, and its caller adds the source.
    """

    def __init__(
        self, found: str, *, row: int | None = None, column: str | None = None, source: str | None = None
    ) -> None:
        super().__init__(found)
        self.found = shortened(found)
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
    """A value cannot be read as its quantity."""


class UnknownMotor(FieldkitError):
    """No motor in the catalog matches a name; the message suggests similar ones."""


class AmbiguousMotor(FieldkitError):
    """Several motors match a name; the message lists them."""


class LedgerError(FieldkitError):
    """The ledger cannot be opened, read or written, or does not have the requested entry."""


class UnusableLedger(LedgerError):
    """The ledger as a whole cannot be read or written, so trying its other entries is pointless."""


class NoFlights(FieldkitError):
    """A request needs flights that the ledger does not have."""


class DamagedModel(FieldkitError):
    """A trained ensemble does not match its card, or cannot be run."""


class ImpossibleFlight(FieldkitError):
    """The rocket as described cannot leave the pad, or the description is incomplete for a simulation."""


class UnknownEffect(FieldkitError):
    """No effect of that name could act on these flights; the message lists those that could."""


class PortTrouble(FieldkitError):
    """A serial port cannot be opened, or its device does not answer as expected."""


class PortLost(PortTrouble):
    """A working serial port is gone: the cable was pulled, or the device was switched off."""


class CaptureTrouble(FieldkitError):
    """A capture cannot be saved, found or read."""

"""Damaged lines of a log, reported in a few lines and stored in little memory regardless of their number."""

from dataclasses import dataclass, field, replace

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import Note, Parsed
from fieldkit.importing.tables.text import is_cut

MAX_REPORTED = 20
"""Maximum number of damaged lines that are reported individually. [1]"""


@dataclass(slots=True)
class Damaged:
    """Damaged lines: their number, the first few, and the last; a log may have millions."""

    first: list[DamagedLog] = field(default_factory=list)
    last: DamagedLog | None = None
    count: int = 0

    def add(self, error: DamagedLog) -> None:
        """Count one more damaged line."""
        self.last = error
        self.first += [error] if len(self.first) < MAX_REPORTED else []
        self.count += 1

    def reported(self, what: str, *, cut: bool = False) -> list[Parsed]:
        """The first errors and the number of further ones; without the last one if it is only `cut` off."""
        reported: list[Parsed] = [error for error in self.first if not (cut and error is self.last)]
        more = self.count - cut - len(reported)
        return [*reported, DamagedLog(f"found {more} more damaged {what}")] if more else reported


def damage(damaged: Damaged, what: str, log: bytes) -> list[Parsed]:
    """Report damaged lines; the last one becomes a note if the file ends within it."""
    row = damaged.last.row if damaged.last else None
    cut = row is not None and is_cut(log) and row == log.count(b"\n") + 1
    reported = damaged.reported(what, cut=cut)
    return [*reported, Note("is cut off at the end of the file, left out", row)] if cut else reported


def below(item: Parsed, rows: int) -> Parsed:
    """A note or an error about a part of a file, with its row counted from the start of the file."""
    if isinstance(item, Note) and item.row is not None:
        return replace(item, row=item.row + rows)
    if isinstance(item, DamagedLog) and item.row is not None:
        return DamagedLog(item.found, row=item.row + rows, column=item.column)
    return item

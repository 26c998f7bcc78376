"""One cell of a table of numbers: when it is a number, and when it may be missing."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from fieldkit.units import Unit

MAX_CELL_VALUE = 1e30
"""Largest magnitude accepted in a log; anything larger would overflow when squared. [any unit]"""
_SPREADSHEET_ERRORS = ("#n/a", "#nv", "#value!", "#div/0!", "#num!", "#ref!", "#null!")
ABSENT_MARKS = frozenset(
    {"", "-", "--", "nan", "none", "null", "n/a", "na", "ovf", "err", "error", "invalid", *_SPREADSHEET_ERRORS}
)
"""Contents of a cell, ignoring case, when the logger or a formula had no number; Arduino prints `ovf` for one too
large."""
SI = Unit(1.0)


@dataclass(frozen=True, slots=True)
class Channel:
    """One column of numbers: its target, and the index of its cells in a row, from 0.

    `name` is a field of `Series` or a name of the parser's own; `header` is the log's name, for messages. A row whose
    `needed` cell is not a number is damaged; any other missing cell is nan. `suffix` ends every cell: `F` in `76.7F`. A
    `clock` is written `1:02:03.5`, in seconds or with a date before it, and is converted to seconds. `becomes` is the
    field of `Series` that a column with a name of the parser's own is used as, for display.
    """

    name: str
    place: int
    unit: Unit = SI
    needed: bool = False
    header: str = ""
    suffix: str = ""
    clock: bool = False
    becomes: str = ""

    @property
    def is_plain(self) -> bool:
        """Whether its cells are bare numbers."""
        return not (self.suffix or self.clock)


_GROUPED_THOUSANDS = re.compile(
    r"[+-]?[1-9][0-9]{0,2}(?:(?:,[0-9]{3})+(?:\.[0-9]*)?|(?:[ \u00a0\u2009\u202f'\u2019][0-9]{3})+(?:\.[0-9]*)?)"
)
"""A number whose thousands a spreadsheet has separated: `1,234.5`, `1 234.5`, `1'234.5`."""
_GROUPING = str.maketrans("", "", ", \u00a0\u2009\u202f'\u2019")
_CLOCK = re.compile(
    r"(?:.*[T ])?([+-])?(?:(\d{1,3}):)?(\d{1,3}):(\d{1,2})(?:[.,](\d{1,9})|:(\d{3}))? ?([AaPp][Mm])?"
    r" ?(?:Z|UTC|GMT|[+-]\d\d:?\d\d)?",
    re.ASCII,
)
_MAX_CLOCK_LENGTH = 80
"""Largest length of a time with its date. [characters]"""


def number_in(cell: str, channel: Channel) -> float | None:
    """The number in a cell, in the unit of its column; nan if it is empty and may be, None if it is not a number."""
    if cell.lower() in ABSENT_MARKS:
        return None if channel.needed else math.nan
    if channel.clock:
        return _seconds(cell)
    number = cell[: len(cell) - len(channel.suffix)].strip()
    number = ungrouped(number)
    if not (cell.endswith(channel.suffix) and number.isascii() and "_" not in number):
        return None
    try:
        value = float(number)
    except ValueError:
        return None
    return value if abs(value) <= MAX_CELL_VALUE else None


def is_grouped(number: str) -> bool:
    """Whether a number has marks between its thousands, as in `1,234.5` or `1 234.5`; its decimal mark is a point."""
    return _GROUPED_THOUSANDS.fullmatch(number) is not None


def ungrouped(number: str) -> str:
    """A number without the marks between its thousands."""
    return number.translate(_GROUPING) if is_grouped(number) else number


def _seconds(cell: str) -> float | None:
    """The seconds of `1:02:03.5`, `02:03.5`, `1:02:03:500`, `T-00:04.0` or `1:02:03 PM`, with or without a date before
    it or an offset from UTC after it; None for anything else. [s]"""
    match = _CLOCK.fullmatch(cell) if len(cell) <= _MAX_CLOCK_LENGTH else None
    if not match:
        return None
    sign, hours, minutes, seconds, fraction, thousandths, half = match.groups()
    whole = int(hours or 0) if half is None else int(hours or 0) % 12 + 12 * (half.lower() == "pm")
    value = 3600.0 * whole + 60.0 * int(minutes) + float(f"{seconds}.{fraction or thousandths or 0}")
    return -value if sign == "-" else value


def converter(channel: Channel) -> Callable[[str], float]:
    """Function that numpy calls for each cell of a channel. The function raises ValueError."""

    def convert(cell: str) -> float:
        value = number_in(cell.strip().strip('"').strip(), channel)
        if value is None:
            raise ValueError(cell)
        return value

    return convert


def gaps(separator: str | None) -> re.Pattern[str]:
    """Pattern that finds the cells without a number in the lines of a table."""
    words = "|".join(re.escape(word) for word in sorted(ABSENT_MARKS - {"", "nan"}, key=len, reverse=True))
    if separator is None:
        return re.compile(rf"(?<=\s)(?:{words})(?!\S)", re.IGNORECASE)
    blank, edge = r"[^\S\n\t]*" if separator == "\t" else r"[^\S\n]*", rf"[{re.escape(separator)}\n]"
    return re.compile(rf"(?<={edge}){blank}(?:(?:{words}){blank})?(?={edge}|$)", re.IGNORECASE)

"""Rows of a table of flights that are not flights: a row of units below the header, and totals and means at the end."""

import re
from collections.abc import Iterable, Iterator, Sequence

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.flight import BY_NAME
from fieldkit.importing.reading import Note, Parsed, Reading
from fieldkit.importing.tables.flight_dates import date_of
from fieldkit.importing.tables.flight_headings import ColumnRole, plain, stated_unit
from fieldkit.importing.tables.text import rows, shown
from fieldkit.quantities import counted
from fieldkit.safe_text import printable

TableRow = tuple[int, list[str] | DamagedLog]
"""A row of a table with its number: its cells, or why they cannot be read."""
_NO_UNIT = frozenset({"", "-", "–", "—", "text", "name", "date", "time", "yyyy-mm-dd", "hh:mm", "n/a"})
"""Cells of a row of units in a column without a unit, in lower case."""
_TIMED, _EGGS = "seconds such as 38.42", "intact or cracked, such as 2 intact"
_EXPECTED = {"timer_1_s": _TIMED, "timer_2_s": _TIMED, "eggs": _EGGS}
"""What a cell of how a contest flight was judged should be, by fieldkit's name of its column."""
_SUMMARIES = frozenset(
    [
        *("subtotal", "sub-total", "best", "worst", "highest", "lowest", "zwischensumme", "sous-total"),
        *("total", "totals", "sum", "average", "averages", "avg", "mean", "median", "max", "maximum", "min", "minimum"),
        *("count", "std", "stdev", "summe", "gesamt", "mittelwert", "durchschnitt", "moyenne", "media"),
    ]
)
"""First words of a row that sums up the others."""
_DESIGNATION = re.compile(r"[A-Z]{1,2}\d", re.IGNORECASE)
"""A class and an average thrust, as in `C6`: a motor, and not a number of motors."""


def units_in(names: Sequence[str], cells: Sequence[str]) -> list[str] | None:
    """Column names with the units of the row below them, or None if that row does not consist of units."""
    bare = [cell.strip().strip("()[]").strip() for cell in cells]
    known = [units.is_unit(cell) for cell in bare]
    if not any(known) or len(bare) > len(names):
        return None
    if not all(one or cell.lower() in _NO_UNIT for one, cell in zip(known, bare, strict=True)):
        return None
    bare += [""] * (len(names) - len(bare))
    known += [False] * (len(names) - len(known))
    return [
        f"{name} ({unit})" if one and not stated_unit(name) else name
        for name, unit, one in zip(names, bare, known, strict=True)
    ]


def is_summary(cells: Sequence[str], headings: Sequence[ColumnRole]) -> bool:
    """Whether a row without a motor, in a table with motors, begins with a word such as `Total` or `Mean`; it may count
    the motors.

    In a table written by fieldkit, every row is a flight.
    """
    if any(plain(heading.spelled) == "flight_id" for heading in headings):
        return False
    motors = [cell.strip() for heading, cell in zip(headings, cells, strict=False) if heading.field == "motor"]
    first = next((cell.strip().lower() for cell in cells if cell.strip()), "").split()
    summed = bool(motors and first) and first[0].rstrip(":.") in _SUMMARIES
    return summed and not any(_DESIGNATION.search(motor) for motor in motors)


def _is_blank(cells: list[str] | DamagedLog) -> bool:
    """Whether all cells of a row are empty."""
    return not isinstance(cells, DamagedLog) and not any(cell.strip() for cell in cells)


class RowsBelow:
    """The rows of a table below one of its rows, without blank ones; the last row of a file that ends within a line is
    an error if it has fewer than `width` cells. They are read again each time, because the cells of a long table take
    several times the memory of its text."""

    def __init__(self, text: str, separator: str, row: int, width: int = 0) -> None:
        self._text, self._separator, self._row = text, separator, row
        self._width = 0 if text.endswith(("\n", "\r")) else width

    def __iter__(self) -> Iterator[TableRow]:
        last: TableRow | None = None
        for row, cells in rows(self._text, self._separator):
            if row > self._row and not _is_blank(cells):
                if last:
                    yield last
                last = row, cells
        if last:
            yield _last_row(*last, self._width)


def _last_row(row: int, cells: list[str] | DamagedLog, width: int) -> TableRow:
    """The last row of a file that ends within a line: an error if cells are missing."""
    if isinstance(cells, DamagedLog) or len(cells) >= width:
        return row, cells
    found = f"found {len(cells)} of {counted(width, 'cell')} where the file ends"
    return row, DamagedLog(f"{found}, expected a whole row", row=row)


def cells_of(field: str, headings: Sequence[ColumnRole], table: Iterable[TableRow]) -> Iterator[str]:
    """All cells of the columns of a field."""
    for _, cells in table:
        if not isinstance(cells, DamagedLog):
            yield from (cell for heading, cell in zip(headings, cells, strict=False) if heading.field == field)


def are_mere_numbers(headings: Sequence[ColumnRole], table: Iterable[TableRow]) -> bool:
    """Whether the names of flights only number them: integers under a name such as `#`, which start at 1 in every file,
    or numbers that two flights of one rocket share. They do not identify a flight."""
    heading = next((one for one in headings if one.field == "flight_id"), None)
    if heading is None or plain(heading.spelled) == "flight_id":
        return False
    named = [list(cells_of(field, headings, [row])) for row in table for field in ("rocket", "flight_id")]
    pairs = [(*rocket, *number) for rocket, number in zip(named[::2], named[1::2], strict=True) if any(number)]
    numbered = all(pair[-1].strip().isdecimal() for pair in pairs)
    return (heading.loose and numbered) or len(set(pairs)) < len(pairs)


def unread_cells(headings: Sequence[ColumnRole], found: Sequence[Parsed]) -> list[Note]:
    """A note for each column of whose cells some are saved as text, because they are not what its name promises."""
    notes = []
    for heading in headings:
        if not (heading.loose and (heading.field or heading.kept_as)):
            continue
        kept = [
            one for one in found if isinstance(one, Reading) and heading.spelled in one.extra and _lacks(one, heading)
        ]
        if kept:
            number = f"a number in {heading.unit}" if heading.unit else _expected_number(heading)
            first = kept[0].extra[heading.spelled]
            of_field = _expected_date(first, heading.spelled) if heading.field == "date_time" else number
            expected, cell = _EXPECTED.get(heading.kept_as, of_field), shown(first)
            times = f", and {counted(len(kept) - 1, 'more cell')}" if len(kept) > 1 else ""
            column = printable(heading.spelled)
            notes.append(Note(f"{column}: found {cell}{times}, expected {expected}: saved as text", kept[0].row))
    return notes


def _expected_number(heading: ColumnRole) -> str:
    """What a cell without a unit should be, and how to state the unit for all of them."""
    column = BY_NAME.get(heading.field)
    map_as = f", or --map '{heading.field}={printable(heading.spelled)} [{column.unit}]'" if column else ""
    return f"a number with its unit{map_as}"


def _expected_date(cell: str, spelled: str) -> str:
    """What a cell with a date should be; for one that lacks only the order of month and day, how to state it."""
    map_as = f", or --map 'date_time={printable(spelled)} [month/day]' or [day/month]"
    return "a date such as 2026-05-01" + (map_as if date_of(cell, day_first=True) else "")


def _lacks(one: Reading, heading: ColumnRole) -> bool:
    """Whether a flight lacks what a column promises."""
    return heading.kept_as not in one.extra and one.stated.get(heading.field) is None


def left_out(row: int, cells: Sequence[str], headings: Sequence[ColumnRole]) -> Note | None:
    """A note for a row that is no flight, because it sums up the others or repeats the header; else None."""
    names = [heading.spelled for heading in headings]
    if any(names) and [cell.strip() for cell in cells] == names:  # where two tables were joined
        return Note("repeats the header, left out", row)
    return Note("sums up the others, left out", row) if is_summary(cells, headings) else None

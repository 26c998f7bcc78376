"""Numbers in a flight table: their decimal marks, units and written precision."""

import re
from collections.abc import Iterable, Sequence

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, Column
from fieldkit.importing.tables.flight_headings import ColumnRole, is_mass, plain
from fieldkit.importing.tables.text import shown
from fieldkit.safe_text import printable

NOT_RECORDED = ("", "-", "–", "—", "n/a", "na", "none", "?", "unknown", "null")
"""Cells of a column of numbers without a value."""
_FRACTION = re.compile(r"\s*[+-]?\d*([.,])\d+(?![\d.,])")
"""A number with one mark, which may be a decimal mark."""
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}([.,])\d{3}(?![\d.,eE])")
"""`1,148` and `1.148`: a number with three decimals, or a number above a thousand."""
_MINUTES = re.compile(r"(\d{1,2}):([0-5]\d(?:[.,]\d{1,3})?)")
"""Minutes and seconds of a duration. With hours in front, `0:43:00` may be a spreadsheet's idea of `0:43`."""


def decimal_mark(numbers: Iterable[str], separator: str) -> str:
    """The decimal mark of a table, `.` or `,`; empty if no number has a mark, or if it is ambiguous, as in `1,148`.

    A single unambiguous number (`281,3`) determines it for the table. Without one, points are decimal points, and
    commas are decimal commas if the cells are separated by semicolons, which is what programs write when the comma is
    the decimal mark. Otherwise a comma may separate thousands. A table with unambiguous numbers of both kinds is
    ambiguous.
    """
    cells = list(numbers)
    used = {match[1] for cell in cells if (match := _FRACTION.match(cell))}
    certain = {m[1] for cell in cells if (m := _FRACTION.match(cell)) and not _THOUSANDS.match(cell)}
    if len(certain) == 1:
        return certain.pop()
    if used == {","}:
        return "," if separator == ";" else ""
    return "." if used == {"."} else ""


def precision(cell: str, column: Column, unit: str) -> float:
    """One unit of the last digit of a number in a cell, in SI; `unit` is that of its header, or "".

    Raises BadValue for an unknown unit.
    """
    digits = re.match(r"\s*[+-]?\d*(?:[.,](\d+))?", cell)
    scale = units.unit(column.quantity, unit or units.typed_unit(cell, column.unit))
    return abs(scale.difference_to_si(10.0 ** -len((digits and digits[1]) or "")))


def check_number(cell: str, column: Column, unit: str, mark: str, spelled: str = "its column") -> None:
    """Raise BadValue for a cell with an ambiguous number or unit, below a header that is `spelled` so; `unit` is that
    of the header, or ""."""
    thousands = _THOUSANDS.match(cell)
    if thousands and thousands[1] != mark:
        one, other = cell.replace(",", "").replace(".", ""), cell.replace(",", ".")
        raise BadValue(f"found {shown(cell)}, which may be {one} or {other}, expected an unambiguous number")
    if len(cell) > 40:
        raise BadValue(f"found {shown(cell)}, expected a number of at most 40 characters")
    if not unit and cell[-1].isdigit():
        whole = f"--map '{column.name}={printable(spelled)} [{column.unit}]' for all rows"
        raise BadValue(f"found {shown(cell)} without a unit, expected one as in {cell} {column.unit}, or {whole}")


def number_of(cell: str, column: Column, unit: str, mark: str, spelled: str = "its column") -> float:
    """The value of a cell, below a header that is `spelled` so; `unit` is that of the header, or "". Raises BadValue.
    [SI]

    A duration may be written in minutes and seconds, `0:43.5`, whatever its header says; a time without a unit is in
    seconds, because flyers time flights in nothing else.
    In a customary unit a comma before three digits separates thousands, unless the table has decimal commas: those who
    write decimal commas measure in meters.
    """
    if column.quantity == "time" and (minutes := _MINUTES.fullmatch(cell)):
        return 60.0 * int(minutes[1]) + float(minutes[2].replace(",", "."))
    unit = unit or ("s" if column.quantity == "time" else "")
    thousands = _THOUSANDS.match(cell)
    customary = units.plain(units.typed_unit(cell, unit)) in units.CUSTOMARY_UNITS
    if thousands and thousands[1] == "," != mark and customary:
        cell = cell.replace(",", "")
    check_number(cell, column, unit, mark, spelled)
    decimal = cell.replace(",", ".") if thousands and thousands[1] == "," else cell
    try:
        return units.parse(decimal, column.quantity, unit)
    except BadValue:
        known = f"{unit}, or with a unit of {column.quantity}" if unit else column.unit
        raise BadValue(f"found {shown(cell)}, expected a number in {known}") from None


def mass_in(cells: Sequence[str], headings: Sequence[ColumnRole], words: frozenset[str], mark: str) -> float | None:
    """A mass that is not a field of a flight, from the column named with one of these words and a unit. Raises
    BadValue. [kg]"""
    for heading, cell in zip(headings, cells, strict=False):
        if is_mass(heading, words) and cell.strip().lower() not in NOT_RECORDED:
            unit = plain(heading.spelled).rpartition("_")[2]
            return number_of(cell.strip(), BY_NAME["dry_mass"], unit, mark)
    return None

"""Decimal marks and written precision of the numbers in a flight table."""

import re
from collections.abc import Iterable

from fieldkit import units
from fieldkit.flight import Column

_FRACTION = re.compile(r"\s*[+-]?\d*([.,])\d+(?![\d.,])")
THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}([.,])\d{3}(?![\d.,eE])")
"""`1,148` and `1.148`: a number with three decimals, or a number above a thousand."""


def decimal_mark(numbers: Iterable[str], separator: str) -> str:
    """The decimal mark of a table, `.` or `,`; empty if `1,148` is ambiguous.

    A single unambiguous number (`281,3`) determines it for the table. Without one, points are decimal points, and
    commas are decimal commas if the cells are separated by semicolons, which is what programs write when the comma is
    the decimal mark. Otherwise a comma may separate thousands.
    """
    cells = list(numbers)
    used = {match[1] for cell in cells if (match := _FRACTION.match(cell))}
    certain = {m[1] for cell in cells if (m := _FRACTION.match(cell)) and not THOUSANDS.match(cell)}
    if len(certain) == 1:
        return certain.pop()
    if used == {","}:
        return "," if separator == ";" else ""
    return "." if used == {"."} else ""


def precision(cell: str, column: Column, unit: str) -> float:
    """One unit of the last digit of a number in a cell, in SI; `unit` is that of its header, or ""."""
    digits = re.match(r"\s*[+-]?\d*(?:[.,](\d+))?", cell)
    named = unit or cell.strip().lstrip("+-0123456789.,").strip()
    scale = units.unit(column.quantity, named or column.unit)
    return abs(scale.difference_to_si(10.0 ** -len((digits and digits[1]) or "")))

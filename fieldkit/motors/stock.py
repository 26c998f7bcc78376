"""A shop's list of motors in stock, from a saved file: a motor in each line, or a table with a column of motors."""

import csv
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.errors import FieldkitError, UnknownMotor

if TYPE_CHECKING:
    from fieldkit.motors import Catalogue, Motor

MOST_STOCK_LINES = 20_000
"""Largest number of lines of a list that are read. [1]"""
COUNTS = ("qty", "quantity", "count", "stock", "in stock", "available", "inventory")
"""Headings of a column of counts or of words such as `sold out`."""
NOT_IN_STOCK = re.compile(
    r"0+(\.0+)?|no|false|(out of|not in) stock|sold out|backorder(ed)?|discontinued|unavailable", re.I
)
NAMES = ("motor", "name", "designation", "product", "title", "item", "description")
"""Headings of a column of motors, without which the first cell that names one is used."""
_WITH_DELAY = re.compile(r"(?<!\w)(?:\d{2,5}|1/[248])?[A-O]\d[\d.]*[A-Z]*-\d+[A-Z]*", re.I)
"""A motor with its delay within the name of a product: `Estes C6-5 Rocket Engines (3 pack)`."""


@dataclass(frozen=True, slots=True)
class InStock:
    """The motors in stock, and the numbers and texts of lines that name none."""

    motors: "tuple[Motor, ...]"
    unread: tuple[tuple[int, str], ...]


def read_stock(text: str, catalogue: "Catalogue", source: str) -> InStock:
    """The motors of a list that are in stock. Raises UnknownMotor that names the file if no line names one."""
    lines = text.splitlines()[:MOST_STOCK_LINES]
    separator = max(",;\t", key=(lines[0] if lines else "").count)
    rows = [next(csv.reader([line], delimiter=separator), []) for line in lines]
    heading = [cell.strip().casefold() for cell in rows[0]] if rows else []
    counts = [place for place, name in enumerate(heading) if name in COUNTS]
    named = [place for place, name in enumerate(heading) if name in NAMES]
    found, unread = dict[str, "Motor"](), list[tuple[int, str]]()
    for number, row in enumerate(rows, start=1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or cells[0].startswith("#") or (number == 1 and (counts or named)):
            continue
        if any(place < len(cells) and NOT_IN_STOCK.fullmatch(cells[place]) for place in counts):
            continue
        motor = _motor([cells[place] for place in named if place < len(cells)] or cells, catalogue)
        if motor is None:
            unread.append((number, separator.join(row)[:60]))
        else:
            found[f"{motor.maker} {motor.designation}"] = motor
    if not found:
        raise UnknownMotor(
            f"{source}: found no motor of the catalog, expected one in each line, such as AeroTech F24W-4"
        )
    return InStock(tuple(found.values()), tuple(unread))


def _motor(cells: Sequence[str], catalogue: "Catalogue") -> "Motor | None":
    """The motor that one of the cells names."""
    for cell in cells:
        if any(letter.isalpha() for letter in cell) and any(letter.isdigit() for letter in cell):
            for name in _names(cell):
                with suppress(FieldkitError):
                    return catalogue.resolve(name).motor
    return None


def _names(cell: str) -> Iterator[str]:
    """The texts of a cell that may name a motor: all of it, and its motor with a delay, after its first word, which is
    often the maker, or alone."""
    yield cell
    if found := _WITH_DELAY.search(cell):
        yield f"{cell.split()[0]} {found[0]}"
        yield found[0]

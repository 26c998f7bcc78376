"""Sheets of an OpenDocument spreadsheet (`.ods`).

A cell has its value as attributes and what it shows as text; equal cells and rows are stored once with a count. Source:
OASIS OpenDocument 1.3, part 3, sections 9.1 and 19.384 to 19.389.
"""

import re
import zipfile
from collections.abc import Iterator
from datetime import datetime

from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.sheet_cells import duration_text, moment_text, number_text
from fieldkit.importing.tables.sheet_xml import Attributes, Budget, SheetWriter, Text, parse
from fieldkit.safe_text import whole_number

CONTENT = "content.xml"
_CELLS = ("table-cell", "covered-table-cell")
_DURATION = re.compile(r"PT(?:(\d{1,9})H)?(?:(\d{1,9})M)?(?:(\d{1,9}(?:\.\d{1,12})?)S)?", re.ASCII)


def sheets(archive: zipfile.ZipFile) -> Iterator[tuple[str, bytes]]:
    """Each sheet, as its name and CSV. Raises DamagedLog."""
    reader = _Content()
    parse(archive, CONTENT, reader.budget, reader.start, reader.end, reader.text)
    yield from reader.sheets


class _Content:
    """The sheets of `content.xml` while it is parsed."""

    def __init__(self) -> None:
        self.budget = Budget()
        self.sheets: list[tuple[str, bytes]] = []
        self._writer: SheetWriter | None = None
        self._name = ""
        self._row = self._rows = self._times = 1
        self._cells: list[str] = []
        self._empty = 0
        self._given: Attributes = {}
        self._in_cell = self._in_text = False
        self._aside = 0
        self._text = Text()

    def start(self, element: str, given: Attributes) -> None:
        """A sheet, a row, a cell, or a paragraph in it; notes and pictures of a cell are passed over."""
        if self._aside or (self._in_cell and element in ("annotation", "frame", "table")):
            self._aside += 1
        elif element in _CELLS:
            self._in_cell, self._given = True, given
            self._times = _count(given, "number-columns-repeated")
            self._text.take()
        elif element == "p" and self._in_cell:
            if self._text:
                self._text.add("\n")
            self._in_text = True
        elif element == "s" and self._in_text:
            count = _count(given, "c")
            self._text.expect(count)
            self._text.add(" " * count)
        elif element == "table-row":
            self._rows = _count(given, "number-rows-repeated")
            self._cells, self._empty = [], 0
        elif element == "table":
            self._writer, self._row, self._name = SheetWriter(self.budget), 1, given.get("name", "")

    def end(self, element: str) -> None:
        """The end of what `start` began."""
        if self._aside:
            self._aside -= 1
        elif element == "p":
            self._in_text = False
        elif element in _CELLS:
            self._in_cell = False
            self._finish_cell(_value(self._given, self._text.take()))
        elif element == "table-row":
            self._finish_row()
        elif element == "table" and self._writer:
            self.sheets.append((self._name, self._writer.content()))
            self._writer = None

    def text(self, piece: str) -> None:
        """A piece of a paragraph."""
        if self._in_text and not self._aside:
            self._text.add(piece)

    def _finish_cell(self, value: str) -> None:
        if not value:
            self._empty += self._times
            return
        self.budget.sheet(self._row, len(self._cells) + self._empty + self._times)
        self._cells += [""] * self._empty + [value] * self._times
        self._empty = 0

    def _finish_row(self) -> None:
        if self._cells and self._writer:
            self.budget.sheet(self._row + self._rows - 1, len(self._cells))
            for number in range(self._row, self._row + self._rows):
                self._writer.row(number, self._cells)
        self._row += self._rows


def _count(given: Attributes, name: str) -> int:
    """How often something is repeated, once by default. Raises DamagedLog."""
    number = whole_number(given.get(name, "1"))
    if number is None:
        raise DamagedLog(f"found {name} {given[name][:20]!r} in a sheet, expected a number")
    return number


def _value(given: Attributes, shown: str) -> str:
    """A cell as text: see `sheet_cells`; without a value, the text it shows."""
    kind = given.get("value-type", "")
    if kind in ("float", "percentage", "currency"):
        try:
            return number_text(float(given.get("value", shown)))
        except ValueError:
            return shown
    if kind == "date":
        try:
            return moment_text(datetime.fromisoformat(given.get("date-value", "")))
        except (ValueError, OverflowError):
            return shown
    if kind == "time":
        stated = _DURATION.fullmatch(given.get("time-value", ""))
        if stated is None:
            return shown
        hours, minutes, seconds = (float(part or 0) for part in stated.groups())
        return duration_text(3600 * hours + 60 * minutes + seconds)
    if kind == "boolean":
        return given.get("boolean-value", shown).capitalize()
    return given.get("string-value", shown)

"""The XML of a spreadsheet, read once by one parser within a budget.

A few bytes can stand for any number of cells: two cells in opposite corners, a repeated row, a shared text, a count of
spaces, many sheets with the same part. What is counted here is therefore what is written, cell by cell, and a part that
is not well-formed is refused where the parser is: no second reader with other rules sees it.
"""

import csv
import zipfile
from array import array
from collections.abc import Callable, Mapping
from xml.parsers.expat import ExpatError, ParserCreate

from fieldkit.errors import DamagedLog
from fieldkit.quantities import counted

MAX_CELLS = 4_000_000
"""Largest number of cells in all sheets, from the first corner of each to its last used cell. [1]"""
MAX_SHEETS = 1000
"""Largest number of sheets, each of which every parser is asked about. [1]"""
MAX_TEXT = 32 << 20
"""Largest number of characters in all cells. [1]"""
MAX_CELL_TEXT = 100_000
"""Largest number of characters in a cell; Excel stores 32,767. [1]"""
MAX_ELEMENTS = 3 * MAX_CELLS
"""Largest number of elements in the parts that are read; a cell has two or three. [1]"""
MAX_TOKEN = 1 << 20
"""Longest tag or comment, which the parser scans again with each chunk until it ends. [bytes]"""
MAX_DEPTH = 100
"""Largest depth of elements; a cell is about eight deep. [1]"""
_CHUNK = 1 << 16

Attributes = Mapping[str, str]


class Budget:
    """What may still be read and written, over all parts and sheets of a spreadsheet."""

    def __init__(self) -> None:
        self._elements = self._cells = self._text = self._sheets = 0

    def element(self) -> None:
        """Count an element. Raises DamagedLog."""
        self._elements += 1
        if self._elements > MAX_ELEMENTS:
            raise DamagedLog(f"found more than {MAX_ELEMENTS // 10**6} million elements in a spreadsheet")

    def text(self, length: int) -> None:
        """Count the characters of a text that is kept or written. Raises DamagedLog."""
        self._text += length
        if self._text > MAX_TEXT:
            raise DamagedLog(f"found more than {MAX_TEXT >> 20} million characters in a spreadsheet, expected fewer")

    def another_sheet(self) -> None:
        """Count a sheet that begins. Raises DamagedLog for too many."""
        self._sheets += 1
        if self._sheets > MAX_SHEETS:
            raise DamagedLog(f"found more than {MAX_SHEETS} tables in a spreadsheet or a page, expected fewer")

    def sheet(self, rows: int, columns: int) -> None:
        """Check the size that a sheet is about to have, on top of the sheets before. Raises DamagedLog."""
        if rows * columns + self._cells > MAX_CELLS:
            others = f" after {counted(self._cells, 'cell')} in other sheets" if self._cells else ""
            size = f"{counted(rows, 'row')} of {counted(columns, 'cell')}"
            raise DamagedLog(f"found {size} in a sheet{others}, expected at most {MAX_CELLS} cells")

    def finished(self, rows: int, columns: int) -> None:
        """Count a whole sheet."""
        self._cells += rows * columns


def parse(
    archive: zipfile.ZipFile,
    part: str,
    budget: Budget,
    start: Callable[[str, Attributes], None],
    end: Callable[[str], None] = lambda element: None,
    text: Callable[[str], None] = lambda characters: None,
) -> None:
    """Parse a part of a spreadsheet, whose elements and attributes are passed without their prefixes.

    Raises DamagedLog for XML that is not well-formed or has a document type, which could declare entities.
    """

    depth = 0

    def started(element: str, given: Attributes) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise DamagedLog(f"found elements more than {MAX_DEPTH} deep in a spreadsheet, expected fewer")
        budget.element()
        start(element.rpartition(":")[2], {key.rpartition(":")[2]: value for key, value in given.items()})

    def ended(element: str) -> None:
        nonlocal depth
        depth -= 1
        end(element.rpartition(":")[2])

    def declared(*_: object) -> None:
        raise DamagedLog("found a document type in a spreadsheet, expected plain sheets")

    parser = ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = started
    parser.EndElementHandler = ended
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = declared
    fed = 0
    try:
        with archive.open(part) as file:
            while chunk := file.read(_CHUNK):
                parser.Parse(chunk)
                fed += len(chunk)
                if fed - max(parser.CurrentByteIndex, 0) > MAX_TOKEN:
                    raise DamagedLog(f"found a tag of more than {MAX_TOKEN >> 20} MB in a spreadsheet")
            parser.Parse(b"", True)
    except (ExpatError, ValueError, KeyError) as error:
        raise DamagedLog(f"found a spreadsheet that cannot be read ({part}: {error}); save it again") from error


class Text:
    """The text of an element, collected piece by piece within the limit of a cell."""

    def __init__(self) -> None:
        self._pieces: list[str] = []
        self._length = 0

    def __bool__(self) -> bool:
        return bool(self._length)

    def add(self, piece: str) -> None:
        """Add a piece. Raises DamagedLog."""
        self.expect(len(piece))
        self._pieces.append(piece)

    def expect(self, length: int) -> None:
        """Count a piece before it is made. Raises DamagedLog."""
        self._length += length
        if self._length > MAX_CELL_TEXT:
            raise DamagedLog(f"found more than {MAX_CELL_TEXT} characters in a cell of a spreadsheet, expected fewer")

    def take(self) -> str:
        """The text so far; it is empty afterward."""
        text = "".join(self._pieces)
        self._pieces, self._length = [], 0
        return text


class SheetWriter:
    """A sheet written as CSV, row by row, all rows as wide as the widest; empty rows below the last are dropped.

    Raises DamagedLog beyond the budget.
    """

    def __init__(self, budget: Budget) -> None:
        budget.another_sheet()
        self._budget = budget
        self._out = bytearray()
        self._ends, self._widths = array("Q"), array("L")
        self._columns = 0
        self._csv = csv.writer(self, lineterminator="\n")

    def write(self, line: str) -> None:
        """Take a line of the CSV writer, whose end follows when the width of the sheet is known."""
        self._out += line[:-1].encode("utf-8", "replace")

    def row(self, number: int, cells: list[str]) -> None:
        """Write the row of this number, counted from 1, after empty ones for those skipped; one without cells is not
        written. Raises DamagedLog beyond the budget, and for a row that is not below the last."""
        while cells and not cells[-1]:
            cells.pop()
        if not cells:
            return
        if number <= len(self._ends):
            raise DamagedLog(f"found row {number} after row {len(self._ends)} in a sheet; save the spreadsheet again")
        self._columns = max(self._columns, len(cells))
        self._budget.sheet(number, self._columns)
        self._budget.text(sum(map(len, cells)))
        skipped = number - 1 - len(self._ends)
        self._ends.extend([len(self._out)] * skipped)
        self._widths.extend([1] * skipped)
        self._csv.writerow(cells)
        self._ends.append(len(self._out))
        self._widths.append(len(cells))

    def content(self) -> bytes:
        """The whole sheet, after which nothing more can be written; empty if it has no cells."""
        self._budget.finished(len(self._ends), self._columns)
        out, begin = bytearray(), 0
        for end, width in zip(self._ends, self._widths, strict=True):
            out += self._out[begin:end] + b"," * (self._columns - width) + b"\n"
            begin = end
        self._out = bytearray()
        return bytes(out)

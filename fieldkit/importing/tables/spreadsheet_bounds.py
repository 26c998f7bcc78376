"""Limits of what a spreadsheet expands to, checked before it is read.

A few bytes can stand for any number of cells: two cells in opposite corners, a repeated row, a shared text, or a count
of spaces. The reader allocates all of them at once, so they are counted here first, element by element.
"""

import zipfile
from collections.abc import Mapping
from xml.parsers.expat import ExpatError, ParserCreate

from fieldkit.errors import DamagedLog
from fieldkit.quantities import counted

MAX_CELLS = 4_000_000
"""Largest number of cells in all sheets, from the first corner of each to its last used cell; one takes about 100 bytes
while it is read. [1]"""
MAX_TEXT = 128 << 20
"""Largest number of characters in all cells. [1]"""
_CHUNK = 1 << 16


def check_bounds(archive: zipfile.ZipFile) -> None:
    """Raise DamagedLog for a spreadsheet with more cells or text than the limits, or with damaged sheets."""
    texts: list[int] = []
    cells = characters = 0
    for name in sorted(archive.namelist(), key=lambda one: "sharedStrings" not in one):
        counted = _Counted(texts, cells, characters)
        counted.read(archive, name)
        cells, characters = counted.cells, counted.characters


class _Counted:
    """The counts of one file of a spreadsheet, on top of the cells and characters of others; `texts` are the lengths of
    the texts that its cells share."""

    def __init__(self, texts: list[int], cells: int, characters: int) -> None:
        self._texts = texts
        self._before, self.characters = cells, characters
        self._row = self._column = self._last_row = self._last_column = 0
        self._rows = self._times = 1
        self._length = 0
        self._shared = self._filled = False
        self._index = ""
        self._found = False

    @property
    def cells(self) -> int:
        """The number of cells so far, with those of other files."""
        return self._before + self._last_row * self._last_column

    def read(self, archive: zipfile.ZipFile, name: str) -> None:
        """Count the elements of a file. Files that are not XML, such as pictures, have none."""
        parser = ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.EntityDeclHandler = self._entity
        try:
            with archive.open(name) as file:
                while part := file.read(_CHUNK):
                    parser.Parse(part)
                parser.Parse(b"", True)
        except (ExpatError, ValueError) as error:
            if self._found:
                raise DamagedLog(f"found a sheet that cannot be read ({error}); save the spreadsheet again") from error

    def _entity(self, *_: object) -> None:
        raise DamagedLog("found an entity in a spreadsheet, expected plain sheets")

    def _start(self, element: str, given: Mapping[str, str]) -> None:
        kind = element.rpartition(":")[2]
        about = {key.rpartition(":")[2]: value for key, value in given.items()} if given else {}
        if kind == "row":
            self._found, self._column = True, 0
            self._row = int(about.get("r", self._row + 1))
        elif kind == "table-row":
            self._found, self._column = True, 0
            self._rows = int(about.get("number-rows-repeated", 1))
        elif kind == "c":
            self._found = True
            self._at(about.get("r", ""))
            self._shared = about.get("t") == "s"
            self._length, self._index = 0, ""
        elif kind in ("table-cell", "covered-table-cell"):
            self._times = int(about.get("number-columns-repeated", 1))
            self._filled, self._length = "value-type" in about, 0
        elif kind == "si":
            self._found, self._length = True, 0
        elif kind == "s" and "c" in about:
            self._length += int(about["c"])
            self._filled = True

    def _at(self, place: str) -> None:
        """Move to a cell named such as `XFD1048576`, or to the one after the last."""
        letters = place.rstrip("0123456789")
        self._column += 1
        if letters:
            self._column = 0
            for letter in letters[:4]:
                self._column = 26 * self._column + ord(letter.upper()) - ord("A") + 1
            self._row = int(place[len(letters) :] or self._row)
        self._use(self._row, self._column)

    def _characters(self, text: str) -> None:
        self._length += len(text)
        if self._shared:
            self._index += text
        if text.strip():
            self._filled = True

    def _end(self, element: str) -> None:
        kind = element.rpartition(":")[2]
        if kind == "table-row":
            self._row += self._rows
        elif kind in ("table-cell", "covered-table-cell"):
            self._column += self._times
            if self._filled:
                self._use(self._row + self._rows, self._column)
                self._add(self._length * self._times * self._rows)
        elif kind == "si":
            self._texts.append(self._length)
        elif kind == "c":
            at = int(self._index) if self._shared and self._index.strip().isdecimal() else -1
            self._add(self._texts[at] if 0 <= at < len(self._texts) else self._length)
            self._shared = False

    def _use(self, row: int, column: int) -> None:
        """Include a cell, counted from 1, in the sheet."""
        self._last_row, self._last_column = max(self._last_row, row), max(self._last_column, column)
        if self.cells > MAX_CELLS:
            cells = f"{self._last_row} rows of {self._last_column} cells"
            others = f" after {counted(self._before, 'cell')} in other sheets" if self._before else ""
            raise DamagedLog(f"found {cells} in a sheet{others}, expected at most {MAX_CELLS} cells")

    def _add(self, length: int) -> None:
        self.characters += length
        if self.characters > MAX_TEXT:
            raise DamagedLog(f"found more than {MAX_TEXT >> 20} million characters in a spreadsheet, expected fewer")

"""Sheets of an Excel workbook (`.xlsx`).

Numbers, texts and dates are stored apart: a cell has a number whose style says that it is a date, or the position of a
text that cells share. Source: ECMA-376, Office Open XML, part 1, sections 18.2 to 18.8.
"""

import posixpath
import re
import zipfile
from collections.abc import Iterator
from datetime import datetime, timedelta

from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.sheet_cells import clock_text, duration_text, moment_text, number_text
from fieldkit.importing.tables.sheet_xml import Attributes, Budget, SheetWriter, Text, parse
from fieldkit.safe_text import whole_number

WORKBOOK = "xl/workbook.xml"
_BUILT_IN_DATES, _BUILT_IN_DURATION = {*range(14, 23), 45, 47}, 46
"""Numbers of the formats for dates and times that are not declared."""
_EPOCH, _EPOCH_1904 = datetime(1899, 12, 30), datetime(1904, 1, 1)
_LEAP_DAY = 60
"""Serial number of 29 February 1900, a day that Excel counts although there was none. [days]"""
_LAST_DAY = 2_950_000
"""Serial number of a day in 9976; later ones are numbers. [days]"""
_LONGEST_FORMAT = 255
"""Excel's limit of a number format. [characters]"""
_ELAPSED = re.compile(r"\[(?:h+|m+|s+)\]", re.IGNORECASE)
_LITERAL = re.compile(r'"[^"]*"|\\.|[_*].|\[[^\]]*\]')


def sheets(archive: zipfile.ZipFile) -> Iterator[tuple[str, bytes]]:
    """Each sheet of a workbook, as its name and CSV. Raises DamagedLog."""
    budget = Budget()
    names: dict[str, str] = {}
    epoch = _EPOCH
    parts: dict[str, str] = {}

    def in_workbook(element: str, given: Attributes) -> None:
        nonlocal epoch
        if element == "workbookPr" and given.get("date1904") in ("1", "true"):
            epoch = _EPOCH_1904
        elif element == "sheet" and "id" in given:
            if given["id"] in names:
                raise DamagedLog("found two sheets with the same cells in a spreadsheet; save it again")
            names[given["id"]] = given.get("name", "")

    def in_relations(element: str, given: Attributes) -> None:
        if element == "Relationship" and given.get("Type", "").endswith("/worksheet"):
            parts[given.get("Id", "")] = posixpath.normpath(posixpath.join("/xl", given.get("Target", "")))[1:]

    parse(archive, WORKBOOK, budget, in_workbook)
    parse(archive, "xl/_rels/workbook.xml.rels", budget, in_relations)
    if len({parts[key] for key in names if key in parts}) < len(names.keys() & parts.keys()):
        raise DamagedLog("found two sheets with the same cells in a spreadsheet; save it again")
    present = set(archive.namelist())
    texts = _shared_texts(archive, budget) if "xl/sharedStrings.xml" in present else []
    formats = _formats(archive, budget) if "xl/styles.xml" in present else []
    for key, name in names.items():
        if key in parts:
            sheet = _Sheet(budget, texts, formats, epoch)
            parse(archive, parts[key], budget, sheet.start, sheet.end, sheet.text)
            yield name, sheet.writer.content()


def _shared_texts(archive: zipfile.ZipFile, budget: Budget) -> list[str]:
    """The texts that cells share, without the pronunciation of East Asian ones."""
    texts: list[str] = []
    text = Text()
    reading = phonetic = False

    def start(element: str, _: Attributes) -> None:
        nonlocal reading, phonetic
        phonetic = phonetic or element == "rPh"
        reading = element == "t" and not phonetic

    def end(element: str) -> None:
        nonlocal reading, phonetic
        reading = False
        phonetic = phonetic and element != "rPh"
        if element == "si":
            texts.append(text.take())
            budget.text(len(texts[-1]))

    parse(archive, "xl/sharedStrings.xml", budget, start, end, lambda piece: text.add(piece) if reading else None)
    return texts


def _formats(archive: zipfile.ZipFile, budget: Budget) -> list[str]:
    """For each style of a cell: `date`, `duration`, or empty for any other number."""
    kinds: dict[int | None, str] = {**dict.fromkeys(_BUILT_IN_DATES, "date"), _BUILT_IN_DURATION: "duration"}
    styles: list[str] = []
    in_cells = False

    def start(element: str, given: Attributes) -> None:
        nonlocal in_cells
        in_cells = in_cells or element == "cellXfs"
        if element == "numFmt":
            kinds[whole_number(given.get("numFmtId", ""))] = kind_of_format(given.get("formatCode", ""))
        elif element == "xf" and in_cells:
            styles.append(kinds.get(whole_number(given.get("numFmtId", "0")), ""))

    def end(element: str) -> None:
        nonlocal in_cells
        in_cells = in_cells and element != "cellXfs"

    parse(archive, "xl/styles.xml", budget, start, end)
    return styles


def kind_of_format(code: str) -> str:
    """Whether a number format such as `[h]:mm:ss` or `d/m/yy` shows a `duration` or a `date`; empty for neither."""
    first = code[:_LONGEST_FORMAT].partition(";")[0]
    if _ELAPSED.search(first):
        return "duration"
    return "date" if set(_LITERAL.sub("", first).lower()) & set("dmyhs") else ""


class _Sheet:
    """A sheet while its part is parsed."""

    def __init__(self, budget: Budget, texts: list[str], formats: list[str], epoch: datetime) -> None:
        self.writer = SheetWriter(budget)
        self._budget, self._texts, self._formats, self._epoch = budget, texts, formats, epoch
        self._row, self._cells = 0, list[str]()
        self._column = 0
        self._type = self._style = ""
        self._text = Text()
        self._reading = self._phonetic = False

    def start(self, element: str, given: Attributes) -> None:
        """A row, a cell, or its value."""
        if element == "c":
            self._column = _column(given["r"]) if "r" in given else self._column + 1
            self._type, self._style = given.get("t", "n"), given.get("s", "")
        elif element == "row":
            number = whole_number(given.get("r", str(self._row + 1)))
            if number is None:
                raise DamagedLog(f"found the row {given['r'][:20]!r} in a sheet, expected a number")
            self._row = number
            self._column = 0
        else:
            self._phonetic = self._phonetic or element == "rPh"
            self._reading = element == "v" or (element == "t" and not self._phonetic)

    def end(self, element: str) -> None:
        """The value of a cell is complete, or a row is."""
        self._reading = False
        if element == "c":
            if value := self._value(self._text.take()):
                self._budget.sheet(self._row, self._column)
                self._cells.extend([""] * (self._column - len(self._cells)))
                self._cells[self._column - 1] = value
        elif element == "row":
            self.writer.row(self._row, self._cells)
            self._cells = []
        elif element == "rPh":
            self._phonetic = False

    def text(self, piece: str) -> None:
        """A piece of the value of a cell."""
        if self._reading:
            self._text.add(piece)

    def _value(self, text: str) -> str:
        """A cell as text: see `sheet_cells`. An error such as #N/A is an empty cell."""
        if self._type == "s":
            at = whole_number(text.strip())
            if text and (at is None or at >= len(self._texts)):
                raise DamagedLog(f"found a cell with the shared text {text[:20]!r}, which its spreadsheet lacks")
            return "" if at is None else self._texts[at]
        if self._type == "b":
            return {"1": "True", "0": "False"}.get(text.strip(), text)
        if self._type == "e":
            return ""
        if self._type != "n" or not text.strip():
            return text
        style = whole_number(self._style)
        kind = self._formats[style] if style is not None and style < len(self._formats) else ""
        try:
            number = float(text)
        except ValueError:
            return text
        if not kind or not 0 <= number < _LAST_DAY:
            return number_text(number)
        if kind == "duration":
            return duration_text(number * 86_400)
        days = number + (self._epoch == _EPOCH and number < _LEAP_DAY)
        return (clock_text if number < 1 else moment_text)(self._epoch + timedelta(days=days))


def _column(place: str) -> int:
    """The column of a cell named such as `XFD1048576`, counted from 1. Raises DamagedLog."""
    number = 0
    letters = place.rstrip("0123456789")
    if not (1 <= len(letters) <= 3 and letters.isascii() and letters.isalpha()):
        raise DamagedLog(f"found the cell {place[:20]!r} in a sheet, expected a name such as B7")
    for letter in letters.upper():
        number = 26 * number + ord(letter) - ord("A") + 1
    return number

"""Tables of a web page, and of the XML that Excel 2003 wrote: programs save both under names that end in `.xls`.

Only the tags of tables, rows and cells count, whatever stands between them. A cell that spans several columns, or that
states its number, leaves the columns between empty; where a page states the number that a cell rounds, that is used.

Source: HTML Living Standard, section 4.9; the XML Spreadsheet Reference of Office 2003.
"""

import html
import re
from collections.abc import Iterator

from fieldkit.importing.tables.sheet_xml import Budget, SheetWriter, Text
from fieldkit.importing.tables.text import decode_whole

_BEGINS = re.compile(
    rb"\s*(?:<\?[^>]{0,200}>\s*){0,4}<(?:!doctype html|html|head|meta|body|div|style|table|(?:ss:)?workbook)\b",
    re.IGNORECASE,
)
_LOOKED_AT = 4096
"""Size of the beginning that shows what a file is. [bytes]"""
_TAG = re.compile(r"<(/?)(?:ss:)?(table|tr|row|td|th|cell)\b([^<>]{0,2000})>", re.IGNORECASE)
_ANY_TAG = re.compile(r"<[^<>]{0,2000}>")
_SPAN = re.compile(r"\b(?:colspan|ss:MergeAcross)\s?=\s?[\"']?(\d{1,3})", re.IGNORECASE)
_INDEX = re.compile(r"\bss:Index\s?=\s?[\"'](\d{1,5})[\"']", re.IGNORECASE)
_STATED_NUMBER = re.compile(r"\bx:num\s?=\s?[\"']([\d.eE+-]{1,30})[\"']", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?")


def is_markup(log: bytes) -> bool:
    """Whether a file is a web page or an XML workbook."""
    head = log[:_LOOKED_AT].replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe")
    return _BEGINS.match(head) is not None


def sheets(log: bytes) -> Iterator[tuple[str, bytes]]:
    """Each table, as its name and CSV. Raises DamagedLog."""
    text, budget = decode_whole(log), Budget()
    opened: list[_MarkupTable] = []
    number, after = 0, 0
    for tag in _TAG.finditer(text):
        budget.element()
        closes, kind, given = bool(tag[1]), tag[2].lower(), tag[3]
        if opened:
            opened[-1].add(text[after : tag.start()])
        after = tag.end()
        if kind == "table" and not closes:
            number += 1
            opened.append(_MarkupTable(f"table {number}", budget))
        elif kind == "table" and opened:
            yield opened[-1].name, opened.pop().content()
        elif opened and kind in ("tr", "row"):
            opened[-1].row()
        elif opened:
            opened[-1].cell(given, closes=closes)
    yield from ((table.name, table.content()) for table in reversed(opened))  # a page that was cut off


class _MarkupTable:
    """The rows of a table while its tags are read."""

    def __init__(self, name: str, budget: Budget) -> None:
        self.name = name
        self._writer, self._rows = SheetWriter(budget), 0
        self._cells: list[str] = []
        self._text, self._in_cell, self._stated, self._span = Text(), False, "", 0

    def add(self, text: str) -> None:
        """Text up to the next tag of a table; that of a cell has several pieces if another table is in it."""
        if self._in_cell:
            self._text.add(text)

    def cell(self, given: str, *, closes: bool) -> None:
        """The beginning of a cell, with the attributes of its tag, or the end of one."""
        self._end()
        if closes:
            return
        index, span, stated = _INDEX.search(given), _SPAN.search(given), _STATED_NUMBER.search(given)
        self._cells += [""] * max(self._span, int(index[1]) - 1 - len(self._cells) if index else 0)
        self._span = max(int(span[1]) - ("colspan" in span[0].lower()), 0) if span else 0
        self._stated = stated[1] if stated else ""
        self._in_cell = True

    def row(self) -> None:
        """The end of a row, or the beginning of one, which need not follow an end."""
        self._end()
        if self._cells:
            self._rows += 1
            self._writer.row(self._rows, self._cells)
        self._cells, self._span = [], 0

    def content(self) -> bytes:
        """The table as CSV."""
        self.row()
        return self._writer.content()

    def _end(self) -> None:
        """The end of a cell, if one is open. A date shows as such what is stated as a number of days."""
        if self._in_cell:
            shown = " ".join(html.unescape(_ANY_TAG.sub(" ", self._text.take())).split())
            self._cells.append(self._stated if self._stated and _NUMBER.fullmatch(shown) else shown)
        self._in_cell = False

"""Read the numbers of a log's table: block by block in C, and cell by cell only if a row is damaged.

A parser specifies the columns it needs, by their index in a row, and their units; it receives SI arrays. A row that
does not fit the table is skipped and reported in one line; a few hundred are reported together. Memory use is that of
the requested columns plus one block of text.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldkit.importing.tables.cell import SI, Channel
from fieldkit.importing.tables.columns_read import note_table
from fieldkit.importing.tables.large_tables import byte_blocks, can_be_plain, plain_numbers
from fieldkit.importing.tables.layout import decimal_mark, groups_thousands, split
from fieldkit.importing.tables.rows import ROWS_TO_MEASURE, Rows
from fieldkit.importing.tables.table import LogTable
from fieldkit.importing.tables.text import blocks, first_lines, is_cut

__all__ = ["SI", "Channel", "LogTable", "read_columns"]

FIRST_ROWS = 100
"""Number of rows from which the decimal mark is determined. [1]"""
HEADER_LINES = 5
"""Lines above a table that may stand again within it. [1]"""
MOST_REMARKS, LONGEST_REMARK = 1000, 1000
"""Largest number of comment lines that are stored, and largest length of each. [1], [characters]"""
LAST_LINES = 1 << 13
"""Size of the end of a block from which the length of the last cells is measured. [bytes]"""
_POINT = re.compile(rb"(?<![\d.,])[1-9]\d{0,2}(?:\.\d{3})+(?![\d.,])")
_DECIMAL_POINT = re.compile(rb"(?<![\d.])(?:0\d*|\d{4,}|)\.\d|\d\.(?:\d{1,2}|\d{4,})(?![\d.])|\.\d{3}[,eE]")
"""A number with points between its thousands, and a number with a decimal point."""
_SWAPPED_MARKS = str.maketrans(",.", ".,")


def read_columns(
    log: bytes,
    channels: Sequence[Channel],
    *,
    after: int,
    separator: str | None = ",",
    decimal: str | None = None,
    widths: Collection[int] | None = None,
    words: Mapping[str, int] | None = None,
    comment: str = "",
) -> LogTable:
    """The rows of a log below row `after` (0: all), as numbers in SI and as words; of a long log every other row, or
    fewer (`Rows`).

    `separator` None is whitespace. `widths` are the numbers of cells that a row may have; None allows any that include
    the needed ones. `words` names columns that are stored as text. Lines that begin with `comment` are stored
    separately. `decimal` None is determined from the first rows, because a spreadsheet may have replaced points by
    commas. Cells may be in quotation marks, and their thousands separated by the mark that is not the decimal one. A
    header that stands again, because the logger was switched on again, is no row. Raises DamagedLog if not a single row
    can be read, or if a comma has two meanings in one column.
    """
    decimal = decimal or decimal_mark([split(line, separator) for line in first_lines(log, after, FIRST_ROWS)])
    if decimal == "." and _points_group(log, after, separator):
        decimal = ","
    source = _Cells(separator, decimal, quoted=separator is not None and b'"' in log)
    reader = Rows(channels, source.joined_by, widths, words or {}, source.spelled)
    header = first_lines(log, most=after)[-HEADER_LINES:] if after else []
    above = {line.strip() for line in header if any(map(str.isalpha, line))}  # numbers above a table may equal a row
    for first, lines in _lines(log, after, reader, source, comment):
        kept = [i for i, line in enumerate(lines) if line and not line.isspace() and line.strip() not in above]
        if comment:
            remarks = [(first + i, lines[i][:LONGEST_REMARK]) for i in kept if lines[i].startswith(comment)]
            reader.remarks += remarks[: MOST_REMARKS - len(reader.remarks)]
            kept = [i for i in kept if not lines[i].startswith(comment)]
        reader.read([first + i for i in kept], source.rewritten([lines[i] for i in kept]))
        if reader.too_much_damaged():
            break
    table = reader.table(cut=is_cut(log))
    note_table(channels, reader.seen, reader.damaged)
    return table


@dataclass(frozen=True, slots=True)
class _Cells:
    """How a log writes its cells, and their spelling for `Rows`: decimal points, and no quotation marks."""

    separator: str | None
    decimal: str
    quoted: bool

    @property
    def joined_by(self) -> str | None:
        """The separator of rewritten lines; cells in quotation marks may contain the log's own."""
        return "\t" if self.quoted else self.separator

    def rewritten(self, lines: list[str]) -> list[str]:
        """Lines for `Rows`."""
        if self.quoted:
            cells = (split(line, self.separator) for line in lines)
            lines = ["\t".join(cell.replace("\t", " ") for cell in row) for row in cells]
        return lines if self.decimal == "." else [line.translate(_SWAPPED_MARKS) for line in lines]

    def spelled(self, cell: str) -> str:
        """A cell of a rewritten line as the log spells it."""
        return cell if self.decimal == "." else cell.translate(_SWAPPED_MARKS)


def _lines(log: bytes, after: int, reader: Rows, source: _Cells, comment: str) -> Iterator[tuple[int, list[str]]]:
    """The lines still to be read, in blocks: all of them, or for a large log those that pandas could not read."""
    separator = source.separator
    if separator is None or not can_be_plain(log, reader.channels, separator, reader.words, comment):
        yield from blocks(log, after)
        return
    for first, block, ends in byte_blocks(log, after):
        numbers = plain_numbers(block, ends, reader.channels, separator, source.decimal, reader.widths)
        if numbers is None:
            yield from ((first + number - 1, lines) for number, lines in blocks(bytes(block)))
        else:
            tail = [line for line in first_lines(bytes(block[-LAST_LINES:]), most=LAST_LINES)[1:] if line]
            reader.take(first, numbers, source.rewritten(tail[-ROWS_TO_MEASURE:]))


def _points_group(log: bytes, after: int, separator: str | None) -> bool:
    """Whether points separate thousands: no number has another count of digits than three behind one, and some columns
    show it."""
    if _POINT.search(log) is None or _DECIMAL_POINT.search(log):
        return False
    lines = (line for _, some in blocks(log, after) for line in some)
    return groups_thousands((split(line, separator) for line in lines), ".")

"""Numbers out of the table of a log: block by block in C, and cell by cell only if a row is damaged.

A parser says which columns it wants, by their place in a row, and in which unit they are; it gets SI arrays.
A row that does not fit the table is skipped and reported in one line; a few hundred of them are reported
together. Memory is that of the columns asked for, and half a megabyte of text.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence

from fieldkit.importing.tables.cell import SI, Channel
from fieldkit.importing.tables.columns_read import note_table
from fieldkit.importing.tables.large_tables import byte_blocks, can_be_plain, plain_numbers
from fieldkit.importing.tables.layout import decimal_mark, split
from fieldkit.importing.tables.rows import ROWS_TO_MEASURE, Rows
from fieldkit.importing.tables.table import LogTable
from fieldkit.importing.tables.text import blocks, first_lines, is_cut

__all__ = ["SI", "Channel", "LogTable", "read_columns"]

FIRST_ROWS = 100
"""So many rows say what the decimal mark is. [1]"""
MOST_REMARKS, LONGEST_REMARK = 1000, 1000
"""So many comment lines are kept apart, and so much of each. [1], [characters]"""
LAST_LINES = 1 << 13
"""So much of a block is looked at for how long its last cells are. [bytes]"""
_POINT = re.compile(r"\s*[+-]?\d*\.\d+([eE][+-]?\d+)?\s*")


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
    """The rows of a log below row `after` (0: all), as numbers in SI and as words.

    `separator` None is any blank space. `widths` are the numbers of cells that a row may have, any that hold the
    needed ones if None. `words` names columns that are kept as text. Lines that begin with `comment` are
    kept apart. `decimal` None is found in the first rows: a spreadsheet may have made commas of points. Raises
    DamagedLog if not one row can be read.
    """
    decimal = decimal or _decimal(log, after, separator)
    reader = Rows(channels, separator, widths, words or {})
    for first, lines in _lines(log, after, reader, decimal, comment):
        kept = [i for i, line in enumerate(lines) if line and not line.isspace()]
        if comment:
            remarks = [(first + i, lines[i][:LONGEST_REMARK]) for i in kept if lines[i].startswith(comment)]
            reader.remarks += remarks[: MOST_REMARKS - len(reader.remarks)]
            kept = [i for i in kept if not lines[i].startswith(comment)]
        rows = [lines[i] if decimal == "." else lines[i].replace(decimal, ".") for i in kept]
        reader.read([first + i for i in kept], rows)
        if reader.too_much_damaged():
            break
    table = reader.table(cut=is_cut(log))
    note_table(channels, reader.seen, reader.damaged)
    return table


def _lines(log: bytes, after: int, reader: Rows, decimal: str, comment: str) -> Iterator[tuple[int, list[str]]]:
    """The lines that are left to be read, in blocks: all, or of a large log those that pandas could not take."""
    separator = reader.separator
    if separator is None or not can_be_plain(log, reader.channels, separator, reader.words, comment):
        yield from blocks(log, after)
        return
    for first, block, ends in byte_blocks(log, after):
        numbers = plain_numbers(block, ends, reader.channels, separator, decimal, reader.widths)
        if numbers is None:
            yield from ((first + number - 1, lines) for number, lines in blocks(bytes(block)))
        else:
            tail = first_lines(bytes(block[-LAST_LINES:]), most=ROWS_TO_MEASURE)
            reader.take(first, numbers, [line for line in tail[1:] if line])


def _decimal(log: bytes, after: int, separator: str | None) -> str:
    """The decimal mark of the first rows: a point if any has one. Raises DamagedLog if `1,148` may be two."""
    cells = [cell for line in first_lines(log, after, FIRST_ROWS) for cell in split(line, separator)]
    return "." if any(_POINT.fullmatch(cell) for cell in cells) else decimal_mark(cells, separator)

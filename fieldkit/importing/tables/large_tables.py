"""Read plain blocks of numbers of a large log with pandas; other blocks are read line by line.

A block is read here only if `rows` would give the same result: as many rows as lines, every cell a number or a mark for
a missing one, and nothing beyond the limits for a log. Any other block is returned unread.
"""

import io
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from fieldkit.importing.tables.cell import ABSENT_MARKS, MAX_CELL_VALUE, Channel
from fieldkit.importing.tables.text import encoding_of
from fieldkit.shapes import Array, Float

LARGE_LOG = 4 << 20
"""Size above which pandas saves more time than importing it takes. [bytes]"""
BLOCK = 2 << 20
"""Size of the part of a log that is read at a time. [bytes]"""
_ABSENT_SPELLINGS = sorted({"NaN", *(one for mark in ABSENT_MARKS for one in (mark, mark.upper(), mark.title()))})


def can_be_plain(
    log: bytes, channels: Sequence[Channel], separator: str | None, words: Collection[str], comment: str
) -> bool:
    """Whether pandas may read blocks of a log: a large one, not in UTF-16, of which only plain numbers are needed."""
    return (
        len(log) >= LARGE_LOG
        and separator is not None
        and not words
        and not comment
        and all(channel.is_plain for channel in channels)
        and encoding_of(log[:2]) == "utf-8"
        and b"\n" in log[:BLOCK]
    )


def byte_blocks(log: bytes, after: int) -> Iterator[tuple[int, memoryview, int]]:
    """The lines of a log below row `after` in blocks of complete lines, each with the number of its first line and its
    number of line ends."""
    start, number = 0, 1
    while number <= after:
        start = log.find(b"\n", start) + 1
        if not start:
            return
        number += 1
    view = memoryview(log)
    while start < len(log):
        end = log.rfind(b"\n", start, start + BLOCK) + 1 if start + BLOCK < len(log) else len(log)
        end = end or log.find(b"\n", start) + 1 or len(log)
        ends = log.count(b"\n", start, end)
        yield number, view[start:end], ends
        number += ends
        start = end


def plain_numbers(
    block: memoryview,
    ends: int,
    channels: Sequence[Channel],
    separator: str,
    decimal: str,
    widths: Collection[int] | None,
) -> Float[Array, "row channel"] | None:
    """The numbers of a block with this number of line ends, one row per line, in the units of their columns; None if it
    contains anything else, or a line longer than a block, whose empty cells would each take memory."""
    import pandas  # takes 0.17 s to import

    content = bytes(block)
    lines = ends + (not content.endswith(b"\n"))
    needed = [place for place, channel in enumerate(channels) if channel.needed]
    if not needed or len(content) > BLOCK or b"\0" in content or b'"' in content:
        return None
    if widths is not None and not _has_width(content, lines, separator, widths):
        return None
    places = sorted({channel.place for channel in channels})
    try:
        table: Any = pandas.read_csv(
            io.BytesIO(content),
            sep=separator,
            header=None,
            usecols=places,
            decimal=decimal,
            na_values=_ABSENT_SPELLINGS,
            keep_default_na=False,
            skip_blank_lines=False,
            low_memory=False,
            index_col=False,
            encoding_errors="replace",
        )
    except (ValueError, pandas.errors.ParserError):
        return None
    if len(table) != lines or any(kind.kind not in "if" for kind in table.dtypes):
        return None
    whole: Array = table.to_numpy(float)
    order = [places.index(channel.place) for channel in channels]
    numbers: Array = whole if order == list(range(whole.shape[1])) else whole[:, order]
    if np.isnan(numbers[:, needed]).any() or np.nanmax(np.abs(numbers), initial=0.0) > MAX_CELL_VALUE:
        return None
    return numbers


def _has_width(content: bytes, lines: int, separator: str, widths: Collection[int]) -> bool:
    """Whether all lines of a block have the one allowed width.

    None is wider than the first, because pandas would report it, and together they have the expected number of
    separators.
    """
    return len(widths) == 1 and content.count(separator.encode()) == (max(widths) - 1) * lines

"""Rows of numbers: read block by block in C, and cell by cell only if a row is damaged.

A row that does not fit the table is skipped and reported in one line; a few hundred are reported together. A long table
is thinned while it is read.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from operator import length_hint
from typing import Any

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import Note, Parsed
from fieldkit.importing.tables.cell import MAX_CELL_VALUE, Channel, converter, gaps, number_in
from fieldkit.importing.tables.damage import MAX_REPORTED
from fieldkit.importing.tables.table import LogTable
from fieldkit.importing.tables.text import ENDLESS_LINE_MARK, shown
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float, Int, Integers

PATIENCE = 50
"""Number of damaged rows in a block after which the rest of it is read cell by cell. [1]"""
MOST_DAMAGED = 200_000
"""Number of damaged rows after which, if they also outnumber the complete ones, the rest is not a table. [1]"""
MOST_NUMBERS = 750_000
"""Number of values above which a table drops every other row, repeatedly if necessary. [1]"""
ROWS_TO_MEASURE = 100
"""Number of rows from which the length of the last cell is measured. [1]"""
MOST_WORDS = 1000
"""Number of different words in a column of words; later new ones become empty. [1]"""


class Rows:
    """Accepts lines, and stores the numbers of complete ones."""

    def __init__(
        self,
        channels: Sequence[Channel],
        separator: str | None,
        widths: Collection[int] | None,
        words: Mapping[str, int],
        spelled: Callable[[str], str] = str,
    ) -> None:
        self.channels, self.separator, self.widths, self.words = channels, separator, widths, words
        self.spelled = spelled
        self.grouped: dict[str, DamagedLog] = {}
        self.with_commas: set[str] = set()
        self.needed = [i for i, channel in enumerate(channels) if channel.needed]
        self.gaps = gaps(separator)
        self.vocabulary: list[dict[str, int]] = [{"": 0} for _ in words]
        self.columns: list[list[np.ndarray[Any, Any]]] = [[] for _ in range(1 + len(words) + len(channels))]
        self.remarks: list[tuple[int, str]] = []
        self.reported: list[DamagedLog] = []
        self.ends: list[str] = []
        self.damaged, self.last_damaged, self.last, self.kept, self.seen, self.step = 0, 0, 0, 0, 0, 1

    def read(self, rows: list[int], lines: list[str]) -> None:
        """Store the complete rows of a block."""
        if not lines:
            return
        self.last = rows[-1]
        self._measure_ends(lines)
        if self.widths is not None:
            wrong = [i for i, width in enumerate(self._widths(lines)) if width not in self.widths]
            for i in wrong:
                lines[i] = self._without_blanks(lines[i])
            wrong = [i for i in wrong if self._widths([lines[i]])[0] not in self.widths]
            self._one_by_one([rows[i] for i in wrong], [lines[i] for i in wrong])
            for i in reversed(wrong):
                del rows[i], lines[i]
        try:
            self._quickly(rows, lines, iter(lines))
        except ValueError:
            self._around(rows, lines, self.gaps.sub("nan", "\n" + "\n".join(lines))[1:].split("\n"))

    def take(self, first: int, numbers: Float[Array, "row channel"], last_lines: list[str]) -> None:
        """Store a block of complete rows from row `first` on, in the units of the file; `last_lines` are its last
        lines."""
        self.last = first + len(numbers) - 1
        self._measure_ends(last_lines)
        self._keep(np.arange(first, first + len(numbers)), numbers, [])

    def _measure_ends(self, lines: list[str]) -> None:
        """Record the last cells of some lines."""
        ends = [line.rpartition(self.separator or " ")[2] for line in lines[-ROWS_TO_MEASURE:]]
        self.ends = (self.ends + ends)[-ROWS_TO_MEASURE:]

    def too_much_damaged(self) -> bool:
        """Whether so many rows are damaged that the rest is not a table."""
        return self.damaged > max(MOST_DAMAGED, self.seen)

    def _widths(self, lines: Iterable[str]) -> list[int]:
        if self.separator is None:
            return [len(line.split()) for line in lines]
        separator = self.separator
        return [line.count(separator) + 1 for line in lines]

    def _without_blanks(self, line: str) -> str:
        """A line without surplus empty cells at its end, which a spreadsheet adds."""
        separator, widest = self.separator, max(self.widths or [0])
        if separator is None:
            return line
        cells = line.split(separator)
        return separator.join(cells[:widest]) if not any(cell.strip() for cell in cells[widest:]) else line

    def _around(self, rows: list[int], lines: list[str], filled: list[str]) -> None:
        """Store the rows of a block, whose gaps are `filled` with nan, before, between and after damaged rows."""
        start = 0
        for _ in range(PATIENCE):
            coming = iter(filled[start:])
            try:
                self._quickly(rows[start:], lines[start:], coming)
                return
            except ValueError:
                stop = len(filled) - length_hint(coming)
            sound = max(start, stop - 2)  # in case numpy has read past the invalid line
            self._halve(rows[start:sound], lines[start:sound], filled[start:sound])
            self._one_by_one(rows[sound:stop], lines[sound:stop])
            start = stop
        self._one_by_one(rows[start:], lines[start:])

    def _halve(self, rows: list[int], lines: list[str], filled: list[str]) -> None:
        """Store rows that should be complete: all together, or each half separately."""
        try:
            self._quickly(rows, lines, iter(filled))
        except ValueError:
            middle = len(lines) // 2
            if not middle:
                self._one_by_one(rows, lines)
            else:
                self._halve(rows[:middle], lines[:middle], filled[:middle])
                self._halve(rows[middle:], lines[middle:], filled[middle:])

    def _quickly(self, rows: list[int], lines: list[str], coming: Iterator[str]) -> None:
        """Store the rows of lines in which every number is valid. Raises ValueError if one is not."""
        if not any(line.strip('" \t') for line in lines):  # numpy would warn
            return
        converters: dict[int | str, Callable[[str], float]] = {
            c.place: converter(c) for c in self.channels if not c.is_plain
        }
        numbers = self._load(coming, [channel.place for channel in self.channels], "f8", converters or None)
        if len(numbers) != len(lines):
            raise ValueError("a quotation mark spans lines")
        texts = [self._load(lines, [place], "U64")[:, 0].tolist() for place in self.words.values()]
        if [len(cells) for cells in texts] != [len(lines)] * len(texts):
            raise ValueError("a quotation mark spans lines")
        bad = (np.abs(numbers) > MAX_CELL_VALUE).any(axis=1) | np.isnan(numbers[:, self.needed]).any(axis=1)
        if bad.any():
            self._one_by_one([rows[i] for i in np.flatnonzero(bad)], [lines[i] for i in np.flatnonzero(bad)])
            good = np.flatnonzero(~bad)
            rows, numbers, texts = [rows[i] for i in good], numbers[good], [[cells[i] for i in good] for cells in texts]
        self._keep(rows, numbers, texts)

    def _load(
        self,
        lines: Iterable[str],
        places: list[int],
        dtype: str,
        converters: Mapping[int | str, Callable[[str], float]] | None = None,
    ) -> Array:
        loaded: Array = np.loadtxt(
            lines,
            delimiter=self.separator,
            usecols=places,
            comments=None,
            quotechar=None if self.separator == '"' else '"',
            ndmin=2,
            dtype=np.dtype(dtype),
            converters=converters,
        )
        return loaded

    def _one_by_one(self, rows: Sequence[int], lines: Sequence[str]) -> None:
        """Read lines cell by cell: store the complete rows, and record the damaged ones."""
        whole: list[tuple[int, list[float], list[str]]] = []
        for row, line in zip(rows, lines, strict=True):
            cells = [cell.strip().strip('"').strip() for cell in line.split(self.separator)]
            if not any(cells):
                continue
            numbers = self._numbers(row, line, cells)
            if isinstance(numbers, DamagedLog):
                self.reported += [numbers] if len(self.reported) < MAX_REPORTED else []
                self.damaged, self.last_damaged = self.damaged + 1, max(row, self.last_damaged)
            else:
                whole.append((row, numbers, [cells[i] if i < len(cells) else "" for i in self.words.values()]))
        if whole:
            kept, values, texts = zip(*whole, strict=True)
            self._keep(list(kept), np.array(values), [list(column) for column in zip(*texts, strict=True)])

    def _numbers(self, row: int, line: str, cells: list[str]) -> list[float] | DamagedLog:
        """The numbers of a row, or its error; returned, because a raised error would keep a reference to its block."""
        if line.startswith(ENDLESS_LINE_MARK):
            return DamagedLog("found an endless line or a NUL character, expected a row", row=row)
        if self.widths is not None and len(cells) not in self.widths:
            expected = " or ".join(map(str, sorted(self.widths)[:3]))
            return DamagedLog(f"found {counted(len(cells), 'cell')}, expected {expected}", row=row)
        numbers = []
        for channel in self.channels:
            cell = cells[channel.place] if channel.place < len(cells) else ""
            value = number_in(cell, channel)
            if "," in cell:
                self._note_comma(cell, value, channel, row)
            if value is None:
                expected = f"a number with {channel.suffix}" if channel.suffix else "a number"
                expected = "a time of day such as 12:04:05.3" if channel.clock else expected
                place = channel.header or channel.name
                return DamagedLog(f"found {shown(self.spelled(cell))}, expected {expected}", row=row, column=place)
            numbers.append(value)
        return numbers

    def _note_comma(self, cell: str, value: float | None, channel: Channel, row: int) -> None:
        """Record whether a comma in a cell separates thousands; in the same column it must not be a decimal comma."""
        if value is None:
            self.with_commas.add(channel.name)
        elif channel.name not in self.grouped:
            found = f"found {shown(self.spelled(cell))} in a column with other decimal marks, expected one mark"
            self.grouped[channel.name] = DamagedLog(found, row=row, column=channel.header or channel.name)

    def _keep(
        self, rows: Sequence[int] | Integers, numbers: Float[Array, "row channel"], texts: list[list[str]]
    ) -> None:
        """Append rows of numbers and words; for a long table, only some of them."""
        which = [_which(known, cells) for known, cells in zip(self.vocabulary, texts, strict=True)]
        kept = (self.seen + np.arange(len(rows))) % self.step == 0
        for column, codes in zip(self.columns[1:], which, strict=False):
            kept |= np.diff(codes, prepend=column[-1][-1:] if column else np.array([-1])) != 0
        self.seen += len(rows)
        if not kept.any():
            return
        si = [numbers[:, i] * channel.unit.factor + channel.unit.offset for i, channel in enumerate(self.channels)]
        new: list[np.ndarray[Any, Any]] = [np.array(rows, np.int32), *which, *si]
        for column, values in zip(self.columns, new, strict=True):
            column.append(values[kept])
        self.kept += int(kept.sum())
        if self.kept * len(self.columns) > MOST_NUMBERS:
            self._thin()

    def _thin(self) -> None:
        """Drop every other row from now on and among those stored, but none at which a word changes."""
        self.step = min(self.step * 2, 1 << 40)
        every_other = kept = np.arange(self.kept) % 2 == 0
        for column in self.columns[1 : 1 + len(self.words)]:
            kept = kept | (np.diff(np.concatenate(column), prepend=np.array([-1])) != 0)
        kept = kept if kept.mean() < 0.75 else every_other  # words that change in every row mark nothing
        for i, column in enumerate(self.columns):
            self.columns[i] = [self._joined(column)[kept]]
        self.kept = int(kept.sum())

    def table(self, *, cut: bool) -> LogTable:
        """The stored rows as a table. Raises DamagedLog if there are none, or if decimal marks are mixed."""
        for name in self.with_commas & self.grouped.keys():
            raise self.grouped[name]
        if not self.kept:
            raise self.reported[0] if self.reported else DamagedLog("found no samples, expected at least one")
        rows, *columns = [self._joined(column) for column in self.columns]
        short = cut and rows[-1] == self.last and self._ends_short()
        if short:
            rows, *columns = [column[:-1] for column in (rows, *columns)]
        texts, numbers = columns[: len(self.words)], columns[len(self.words) :]
        values = {channel.name: column for channel, column in zip(self.channels, numbers, strict=True)}
        known = zip(self.words, map(list, self.vocabulary), texts, strict=True)
        words = {name: (vocabulary, which.astype(np.int64)) for name, vocabulary, which in known}
        found = tuple(self._found(cut, short))
        return LogTable(values, rows.astype(np.int64), words, tuple(self.remarks), found)

    @staticmethod
    def _joined(column: list[np.ndarray[Any, Any]]) -> np.ndarray[Any, Any]:
        """The pieces of a column joined; the pieces are released, so that those of a long log are not stored twice."""
        whole = np.concatenate(column)
        column.clear()
        return whole

    def _ends_short(self) -> bool:
        """Whether the very last cell has fewer decimals or characters than all of many cells before it."""
        if min(self.kept, len(self.ends)) < ROWS_TO_MEASURE // 2:
            return False
        *usual, last = [(len(cell.partition(".")[2]), len(cell)) for cell in self.ends]
        return last[0] < min(decimals for decimals, _ in usual) or last[1] < min(size for _, size in usual)

    def _found(self, cut: bool, short: bool) -> Iterator[Parsed]:
        torn = cut and self.damaged and self.last_damaged == self.last
        reported = [error for error in self.reported if not (torn and error.row == self.last)]
        yield from sorted(reported, key=lambda error: error.row or 0)
        if more := self.damaged - len(reported) - bool(torn):
            yield DamagedLog(f"found {more} more damaged rows")
        if torn or short:
            yield Note("is cut off at the end of the file, left out", row=self.last)
        if self.too_much_damaged():
            yield Note("is not a table from here on, left out", row=self.last)
        if self.step > 1:
            yield Note(f"found more than {MOST_NUMBERS} numbers, used one row in {self.step}")


def _which(known: dict[str, int], cells: list[str]) -> Int[Integers, "row"]:
    """The index of each cell among the known words, to which new ones are added."""
    for cell in dict.fromkeys(cells):
        if len(known) < MOST_WORDS:
            known.setdefault(cell, len(known))
    return np.array([known.get(cell, 0) for cell in cells], np.int16)

"""Find the header of a logger's table: its row, its column names, and its separator."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import HEAD
from fieldkit.importing.tables.cell import Channel
from fieldkit.importing.tables.text import decode, lines_of
from fieldkit.units import Unit

SEPARATORS = (",", ";", "\t")
_LETTER = re.compile(r"[^\W\d_]")


@dataclass(frozen=True, slots=True)
class Header:
    """The header of a table: its row, counted from 1, its names in lower case, and the separator."""

    row: int
    names: tuple[str, ...]
    separator: str

    def place(self, *names: str) -> int | None:
        """Index of the first column with one of these names, or None."""
        places = (self.names.index(name) for name in names if name in self.names)
        return next(places, None)

    def channels(self, wanted: Mapping[str, tuple[str, Unit]]) -> list[Channel]:
        """The columns present among those wanted, given as header to a channel's name and unit; of several headers of
        one channel the first wanted."""
        places = {name: self.names.index(name) for name in wanted if name in self.names}
        named = {wanted[name][0]: (name, place) for name, place in reversed(places.items())}
        return [
            Channel(channel, place, wanted[name][1], channel == "time", name)
            for channel, (name, place) in reversed(named.items())
        ]


def find_header(log: bytes, fits: Callable[[Sequence[str]], bool]) -> Header | None:
    """The first row near the start of a log whose names, in lower case and single-spaced, fit. Raises DamagedLog."""
    for row, ways in _first_rows(log[:HEAD]):
        for separator, names in ways:
            if fits(names):
                return Header(row, names, separator)
    return None


@lru_cache(maxsize=2)
def _first_rows(head: bytes) -> list[tuple[int, list[tuple[str, tuple[str, ...]]]]]:
    """The lines with letters, which names have: their rows, and the names of their cells for each separator.

    Cached, because every parser examines the same few lines.
    """
    lines = enumerate(lines_of(decode(head)), start=1)
    return [(row, list(_ways(line))) for row, line in lines if _LETTER.search(line)]


def _ways(line: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The names of a line for each separator, without the empty ones that a spreadsheet appends."""
    for separator in SEPARATORS:
        names = [_plain(cell) for cell in line.split(separator)]
        while len(names) > 1 and not names[-1]:
            names.pop()
        yield separator, tuple(names)


def header_in(line: str, row: int, fits: Callable[[Sequence[str]], bool]) -> Header | None:
    """A line as the header of a table, if its names fit."""
    for separator, names in _ways(line):
        if fits(names):
            return Header(row, names, separator)
    return None


def header_or_damage(log: bytes, fits: Callable[[Sequence[str]], bool], expected: str) -> Header:
    """The header of a table, as `find_header` finds it. Raises DamagedLog that states what was expected."""
    found = find_header(log, fits)
    if found is None:
        raise DamagedLog(f"found no header, expected {expected}")
    return found


def _plain(cell: str) -> str:
    return re.sub(r"\s+", " ", cell.strip().strip('"').strip()).lower()

"""Where the table of a log begins, what its columns are called, and what its flags and its rest on the pad say."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.columns import Channel
from fieldkit.errors import DamagedLog
from fieldkit.logtext import decode
from fieldkit.parsing import HEAD
from fieldkit.shapes import Array, Flags, Float
from fieldkit.units import STANDARD_GRAVITY, Unit

SEPARATORS = (",", ";", "\t")
LATEST = 1e11
"""No logger counts so far, not from 1970 either. [s]"""
REST = (0.8, 1.15)
"""How much of gravity an accelerometer at rest may show: tilted with its rail, or badly calibrated. [g]"""


@dataclass(frozen=True, slots=True)
class Heading:
    """The header of a table: its row, counted from 1, its names in lower case, and what parts the cells."""

    row: int
    names: tuple[str, ...]
    separator: str

    def place(self, *names: str) -> int | None:
        """The first column that bears one of these names, or None."""
        places = (self.names.index(name) for name in names if name in self.names)
        return next(places, None)

    def channels(self, wanted: Mapping[str, tuple[str, Unit]], needed: Iterable[str] = ("time",)) -> list[Channel]:
        """The columns there are of those wanted: header to a channel's name and unit."""
        places = {name: self.names.index(name) for name in wanted if name in self.names}
        named = {wanted[name][0]: (name, place) for name, place in reversed(places.items())}
        return [
            Channel(channel, place, wanted[name][1], channel in needed, name)
            for channel, (name, place) in reversed(named.items())
        ]


def heading(
    log: bytes, fits: Callable[[Sequence[str]], bool], separators: Sequence[str] = SEPARATORS
) -> Heading | None:
    """The first row near the start of a log whose names, in lower case and single-spaced, fit. Raises DamagedLog."""
    for row, line in enumerate(re.split(r"\r\n|\n|\r", decode(log[:HEAD])), start=1):
        if found := heading_of(line, row, fits, separators):
            return found
    return None


def heading_of(
    line: str, row: int, fits: Callable[[Sequence[str]], bool], separators: Sequence[str] = SEPARATORS
) -> Heading | None:
    """A line as the header of a table, if its names fit."""
    for separator in separators:
        names = [_plain(cell) for cell in line.lstrip("\ufeff").split(separator)]
        if fits(names):
            return Heading(row, tuple(names), separator)
    return None


def heading_or_damage(
    log: bytes, fits: Callable[[Sequence[str]], bool], expected: str, separators: Sequence[str] = SEPARATORS
) -> Heading:
    """The header of a table, as `heading` finds it. Raises DamagedLog that says what was expected."""
    found = heading(log, fits, separators)
    if found is None:
        raise DamagedLog(f"found no header, expected {expected}")
    return found


def _plain(cell: str) -> str:
    return re.sub(r"\s+", " ", cell.strip().strip('"').strip()).lower()


def first_time(time: Float[Array, "row"], marked: Flags) -> float | None:
    """When a flag is first set, or None if it never is. [s]"""
    rows = np.flatnonzero(marked)
    return float(time[rows[0]]) if len(rows) else None


def marks(time: Float[Array, "row"], flags: Mapping[str, Float[Array, "row"] | None]) -> dict[str, float]:
    """The events whose flag is ever set, each with the time of its first row. [s]"""
    found = {name: first_time(time, flag > 0) for name, flag in flags.items() if flag is not None}
    return {name: when for name, when in found.items() if when is not None}


def scale_at_rest(magnitude: Float[Array, "row"], scales: Sequence[float]) -> float | None:
    """The one of some scales that makes a magnitude at rest about one g, or None. [m/s^2 per unit]"""
    if not np.isfinite(magnitude).any():
        return None
    level = float(np.nanmedian(magnitude))
    fitting = [s for s in scales if REST[0] <= level * s / STANDARD_GRAVITY <= REST[1]]
    return fitting[0] if len(fitting) == 1 else None


def upright(axes: Float[Array, "axis row"], rest: Flags) -> Float[Array, "row"] | None:
    """Of three axes the one that carries gravity while the rocket stands on its pad, nose up positive, or None."""
    if not rest.any() or not np.isfinite(axes[:, rest]).any(axis=1).all():
        return None
    levels = np.nanmedian(axes[:, rest], axis=1) / STANDARD_GRAVITY
    axis = int(np.argmax(np.abs(levels)))
    if not REST[0] <= abs(levels[axis]) <= REST[1]:
        return None
    felt: Float[Array, "row"] = axes[axis] * np.sign(levels[axis])
    return felt


def in_order(*columns: Float[Array, "row"]) -> tuple[Float[Array, "row"], ...]:
    """Columns of which the first is a clock, with its rows in order; of rows at the same time the first counts.

    Rows without a time, or at one of no logger, are left out.
    """
    time = columns[0]
    known = np.flatnonzero(np.abs(time) < LATEST)
    _, first = np.unique(time[known], return_index=True)
    return tuple(column[known[first]] for column in columns)


def line_end(log: bytes) -> bytes:
    """What ends the lines of a log, if not a carriage return alone then a line feed with or without one."""
    return b"\n" if b"\n" in log[: 1 << 21] or b"\r" not in log[: 1 << 21] else b"\r"


def lines(log: bytes, longest: int = 1 << 20) -> Iterator[bytes]:
    """The lines of a log, one at a time; of a line without end its last part."""
    start, mark = 0, line_end(log)
    while start <= len(log):
        end = log.find(mark, start)
        end = len(log) if end < 0 else end
        yield log[max(start, end - longest) : end]
        start = end + 1

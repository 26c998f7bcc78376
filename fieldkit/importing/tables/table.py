"""The table of a log as it was read: SI arrays by channel, and the flights into which its clock splits it."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing.reading import MOST_FLIGHTS, Note, Parsed
from fieldkit.importing.tables.clocks import COMPARED_TIMES, MOST_SAMPLES, continues, credible, restarts
from fieldkit.importing.tables.damage import MAX_REPORTED
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Bool, Flags, Float, Int, Integers

_HEIGHTS = ("altitude", "altitude_msl", "gps_altitude_msl")
"""Channels that show whether a rocket moves, besides the pressure."""
_PAUSE = 3.0
"""Time that a rocket cannot spend between two rows if its heights continue. [s]"""
_LEAST_DOUBLED = 3
"""Fewest rows that are a block written twice. [1]"""
_UNIQUE, _LONGEST_STEP, _MIXED_STEPS = 0.99, 5.0, 0.2
"""Rows that were shuffled have this fraction of unique times, and no longer gap between them, in long steps of the log;
if each was shuffled by itself, at least this fraction of steps runs backward. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class LogTable:
    """The rows of a log: SI arrays by channel, and each row's number in the file, counted from 1.

    `words` contains the columns of words: the different words, and for every row the index of its word. `remarks` are
    the comment lines with their rows; `found` is what a parser passes on: damaged rows, and a note about a truncated
    last row.
    """

    values: Mapping[str, Float[Array, "row"]]
    rows: Int[Integers, "row"]
    words: Mapping[str, tuple[list[str], Int[Integers, "row"]]] = field(default_factory=dict)
    remarks: tuple[tuple[int, str], ...] = ()
    found: tuple[Parsed, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def get(self, name: str) -> Float[Array, "row"] | None:
        """The values of a channel in SI; None if the log does not have it, or has no number in it."""
        values = self.values.get(name)
        return None if values is None or np.isnan(values).all() else values

    def where(self, name: str, word: str) -> Int[Integers, "match"]:
        """The indices of the rows with `word` in a column of words."""
        known, which = self.words[name]
        return np.flatnonzero(which == known.index(word)) if word in known else np.empty(0, np.int64)

    def pick(self, rows: slice | Flags | Integers) -> "LogTable":
        """The table with some of its rows; what was found in the file is unchanged."""
        words = {name: (known, which[rows]) for name, (known, which) in self.words.items()}
        return replace(self, values={n: v[rows] for n, v in self.values.items()}, rows=self.rows[rows], words=words)

    def series(self) -> Series:
        """The channels that are fields of `Series`. Raises DamagedLog without `time`."""
        time = self._clock("time")
        names = {f.name for f in fields(Series)} & self.values.keys()
        channels = {name: self.get(name) for name in names - {"time"}}
        return Series(time, **channels)

    def _clock(self, name: str) -> Array:
        if name not in self.values:
            raise DamagedLog(f"found no column of {name}, expected one", row=int(self.rows[0]) if len(self) else 1)
        return self.values[name]

    def flights(self, clock: str = "time") -> tuple[list["LogTable"], list[Parsed]]:
        """Split the table where its clock restarts. Returns the parts, without rows out of order, and everything found.
        A recording whose pieces were written in another order is put in order.

        A part that equals an earlier one is a duplicate and is dropped. Raises DamagedLog without the clock, and for
        one that restarts `MOST_FLIGHTS` times or more: those are not flights.
        """
        found = list(self.found)
        parts: dict[bytes, LogTable] = {}
        repeated: list[int] = []
        restarted = restarts(self._clock(clock)).tolist()
        if 0 < len(restarted) < MOST_FLIGHTS and (doubled := _doubled(self, restarted)).any():
            found.append(Note(f"repeats {counted(int(doubled.sum()), 'row')}, read once", int(self.rows[doubled][0])))
            return replace(self.pick(~doubled), found=tuple(found)).flights(clock)
        if 0 < len(restarted) < MOST_FLIGHTS and (set_back := self._set_back(clock, restarted)) is not None:
            row, shift = set_back
            when = int(self.rows[row])
            found.append(Note(f"the clock is set back by {shift:.1f} s, which no height shows: it runs on", when))
            later = np.arange(len(self)) >= row
            values = {**self.values, clock: self.values[clock] + np.where(later, shift, 0.0)}
            return replace(self, values=values, found=tuple(found)).flights(clock)
        if restarted and (order := _shuffled(self.values[clock])) is not None:
            found.append(Note("has rows out of order, sorted by its clock", int(self.rows[restarted[0]])))
            whole, restarted = self.pick(order), []
        else:
            whole = self
        if len(restarted) >= MOST_FLIGHTS:
            expected = f"expected at most {MOST_FLIGHTS} flights in a log"
            raise DamagedLog(
                f"found {clock} restarting {len(restarted)} times, {expected}", row=int(self.rows[restarted[0]])
            )
        starts = [0, *restarted, len(self)]
        for start, stop in pairwise(starts):
            part = whole.pick(slice(start, stop))
            content = _digest(part)
            if content in parts:
                repeated.append(int(part.rows[0]))
                continue
            kept = credible(part.values[clock])
            found += _strays(part.rows[~kept], part.values[clock][~kept], clock)
            parts[content] = part if kept.all() else part.pick(kept)
        if repeated:
            times = f" {len(repeated)} times from here on" if len(repeated) > 1 else ""
            found.append(Note(f"repeats an earlier flight of this file{times}, imported once", repeated[0]))
        return list(parts.values()), found

    def _set_back(self, clock: str, restarted: Sequence[int]) -> tuple[int, float] | None:
        """The first row at which a clock is set back while its rocket moves on through the air, and by how much [s];
        None if there is none: a flight begins at rest."""
        pressure = self.get("pressure")
        height = next((found for name in _HEIGHTS if (found := self.get(name)) is not None), None)
        if height is None and pressure is not None:
            height = np.where(pressure > 0, pressure_height(np.abs(pressure)), np.nan)
        if height is None:
            return None
        for row in restarted:
            begin, time = max(row - MOST_SAMPLES, 0), self.values[clock]
            step = float(np.median(np.diff(time[begin:row])))
            shift = float(time[row - 1] - time[row]) + step
            near = time[begin : row + MOST_SAMPLES] + np.where(
                np.arange(begin, min(row + MOST_SAMPLES, len(self))) >= row, shift + _PAUSE, 0.0
            )
            if any(
                continues(near, height[begin : row + MOST_SAMPLES], row - 1 - begin, step, one)
                for one in COMPARED_TIMES
            ):
                return row, shift
        return None


def _shuffled(clock: Float[Array, "row"]) -> Int[Integers, "row"] | None:
    """The order of rows by their clock if that is one recording written in pieces, which share no time and together
    have no gap; None for flights one after the other, whose clocks begin again."""
    order = np.argsort(clock, kind="stable")
    steps = np.diff(clock[order])
    longest = _LONGEST_STEP * float(np.quantile(steps, 0.95))
    if steps.max() > longest or (steps > 0).mean() < _UNIQUE:
        return None
    jumps = np.diff(clock)
    if (jumps < 0).mean() > _MIXED_STEPS:
        return order
    pieces = np.split(clock, np.flatnonzero((jumps < 0) | (jumps > longest)) + 1)
    ends = sorted((float(piece[0]), float(piece[-1])) for piece in pieces)
    return order if all(before[1] <= after[0] for before, after in pairwise(ends)) else None


def _doubled(table: LogTable, restarted: Sequence[int]) -> Bool[Flags, "row"]:
    """Rows with which a clock restarts that equal earlier ones, before it runs on: a block that was written twice."""
    cells = np.ascontiguousarray(np.column_stack(list(table.values.values())))
    _, first = np.unique(cells.view(np.dtype((np.void, cells.itemsize * cells.shape[1]))).ravel(), return_index=True)
    known = np.ones(len(table), bool)
    known[first] = False
    doubled = np.zeros(len(table), bool)
    for start, stop in pairwise([*restarted, len(table)]):
        again = int(np.argmin(known[start:stop]))  # 0 if all of them are known: that is a flight written twice
        doubled[start : start + again] = again >= _LEAST_DOUBLED
    return doubled


def _digest(table: LogTable) -> bytes:
    """A digest that is equal for equal numbers."""
    content = hashlib.blake2b()
    for values in table.values.values():
        content.update(np.ascontiguousarray(values).data)
    return content.digest()


def _strays(rows: Int[Integers, "row"], clock: Float[Array, "row"], name: str) -> Iterator[DamagedLog]:
    for row, value in zip(rows[:MAX_REPORTED].tolist(), clock.tolist(), strict=False):
        yield DamagedLog(f"found {name} {value:.10g} out of order, expected it to increase", row=row)
    if len(rows) > MAX_REPORTED:
        yield DamagedLog(f"found {counted(len(rows) - MAX_REPORTED, 'more row')} out of order")

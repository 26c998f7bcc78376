"""Close the gap of a clock that jumped forward between two samples: a write that hung, or a reset of the time.

Derivation: a rocket is elsewhere after a gap in which time passed. If the heights, their slope and
their bend continue at the next step instead, no time passed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.flight import Series
from fieldkit.importing.reading import Note, Reading
from fieldkit.importing.tables.clocks import COMPARED_TIMES, LEAST_SAMPLES, continues
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.shapes import Array, Float

LEAST_GAP, MANY_STEPS, MOST_GAPS = 0.5, 10.0, 20
"""Shortest gap that is examined [s], also in median steps of the clock, and the largest number of them [1]."""


def with_even_clock(reading: Reading) -> tuple[Reading, list[Note]]:
    """A reading without the jumps of its clock, and a note on each."""
    clocks, events, notes = reading.clocks, dict(reading.events), list[Note]()
    for _ in range(MOST_GAPS):
        jump = next((found for series in clocks if (found := _jump(series, clocks)) is not None), None)
        if jump is None:
            break
        last, lasts = jump
        start = min(float(series.time[0]) for series in clocks if series.time.size)
        notes.append(
            Note(
                f"the clock jumps by {lasts:.1f} s, {last - start:.1f} s after the log begins, as no time passed "
                "for the heights: the times after it are that much earlier",
                reading.row,
            )
        )
        clocks = tuple(replace(one, time=one.time - np.where(one.time > last, lasts, 0.0)) for one in clocks)
        events = {name: when - lasts * (when > last) for name, when in events.items()}
    return (replace(reading, series=clocks, events=events), notes) if notes else (reading, notes)


def _jump(series: Series, clocks: Sequence[Series]) -> tuple[float, float] | None:
    """The last time before the first jump of a clock, and by how much it jumped [s]; None if it did not, or if another
    clock of the log has samples meanwhile."""
    height = _heights(series)
    if height is None or series.time.size < 2 * LEAST_SAMPLES:
        return None
    steps = np.diff(series.time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > max(LEAST_GAP, MANY_STEPS * usual))
    for gap in gaps[:MOST_GAPS].tolist():
        begin, end = float(series.time[gap]), float(series.time[gap + 1])
        silent = not any(((one.time > begin) & (one.time < end)).any() for one in clocks)
        if silent and any(continues(series.time, height, gap, usual, around) for around in COMPARED_TIMES):
            return begin, end - begin - usual
    return None


def _heights(series: Series) -> Float[Array, "row"] | None:
    """The heights of a clock, above any level, or None. [m]"""
    names: Mapping[str, Float[Array, "row"] | None] = {
        name: getattr(series, name) for name in ("pressure", "altitude", "altitude_msl", "gps_altitude_msl")
    }
    for name, values in names.items():
        if values is not None and np.isfinite(values).sum() >= 2 * LEAST_SAMPLES:
            return np.where(values > 0, pressure_height(np.abs(values)), np.nan) if name == "pressure" else values
    return None

"""The mapping to write for a table of several columns without names, as their numbers show it."""

from collections.abc import Sequence

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import HEAD
from fieldkit.importing.tables.column_choice import falls_first
from fieldkit.importing.tables.columns import Channel, read_columns
from fieldkit.importing.tables.layout import Layout, clock_steps, layout_of
from fieldkit.importing.tables.unit_inference import settle_pressure, settle_time_heights
from fieldkit.shapes import Array, Float

_MOST_COLUMNS = 20
"""Largest number of columns among which heights are looked for. [1]"""


def offered_mapping(log: bytes) -> tuple[str, ...]:
    """What to write after `--map` for the samples of a table without names: its clock, and the first column that is a
    flight in one unit only, of heights or otherwise of pressures; empty if none is or the table has names."""
    try:
        layout = layout_of(log[:HEAD])
        places = [i for i in range(len(layout.headers)) if not layout.says(i)][:_MOST_COLUMNS]
        clock = None if layout.named else _clock(log[:HEAD], layout, places)
        if clock is None:
            return ()
        others = [Channel(f"{i}", i, suffix=layout.suffix(i)) for i in places if i != clock]
        channels = [Channel("time", clock, needed=True), *others]
        table = read_columns(log, channels, after=layout.above, separator=layout.separator, decimal=layout.decimal)
    except DamagedLog:
        return ()
    time = table.values["time"]
    found = [(i, units) for i in places if i != clock and (units := _units(time, table.values[f"{i}"]))]
    for name in ("altitude", "pressure"):
        for place, units in found:
            if name in units:
                return f"time=#{clock + 1} [{units['time']}]", f"{name}=#{place + 1} [{units[name]}]"
    return ()


def _clock(head: bytes, layout: Layout, places: Sequence[int]) -> int | None:
    """The first column that increases in even steps, or the next one that does if the first one counts the rows."""
    clocks = {place: steps for place in places if (steps := clock_steps(head, layout, place))}
    first, *others = *clocks, None
    counts = first is not None and clocks[first][0] == clocks[first][-1] == 1.0
    return others[0] if counts and others[0] is not None else first


def _units(time: Float[Array, "row"], values: Float[Array, "row"]) -> dict[str, str]:
    """The units of a clock and of heights or pressures, if they are those of a flight in one unit only."""
    there = np.isfinite(values) & np.isfinite(time)
    raw, name = {"time": time[there], "altitude": values[there]}, "altitude"
    if falls_first(values):
        raw, name = {"time": time[there]}, "pressure"
    settled = {channel: one.unit for channel, one in settle_time_heights(raw, {}).items()}
    if name == "pressure" and (pressure := settle_pressure(values)):
        settled["pressure"] = pressure.unit
    return settled if {"time", name} <= settled.keys() else {}

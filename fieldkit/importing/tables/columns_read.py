"""Record which columns of a log were read as which channels while a parser reads, for display to the flyer.

A parser returns readings in SI, without the names and units of the log. `watched` records them: every table that is
read inside its context is noted here, by `read_columns` or by a parser that determines units itself.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields, replace

import numpy as np

from fieldkit.flight import Series
from fieldkit.importing.tables.cell import Channel
from fieldkit.importing.tables.headings import QUANTITIES
from fieldkit.units import UNITS, Unit

_SENSORS = {
    "baro": ("altitude", "altitude_msl", "pressure"),
    "accel": ("acceleration", "felt", "felt_x", "felt_y", "felt_z", "felt_total", "tilt"),
    "gps": ("gps_altitude_msl", "gps_speed", "latitude", "longitude"),
    "device": ("speed", "inertial_altitude", "inertial_speed", "temperature", "voltage"),
    "simulation": ("thrust", "drag", "mass"),
    "clock": ("time",),
}
SENSOR_OF = {channel: sensor for sensor, channels in _SENSORS.items() for channel in channels}
"""The sensor that measures a channel of `Series`; `device` if a logger derived it or reports its own state."""
_SI = {
    "time": "s",
    "length": "m",
    "pressure": "Pa",
    "speed": "m/s",
    "acceleration": "m/s2",
    "angle": "rad",
    "temperature": "K",
    "voltage": "V",
    "force": "N",
    "mass": "kg",
    "degree": "deg",
}
"""Spelling of the SI unit of a quantity."""


@dataclass(frozen=True, slots=True)
class ColumnRead:
    """A column of a log as it was read: its name in the log, its channel ("" for none), its unit, and its sensor."""

    name: str
    channel: str
    unit: str
    source: str


@dataclass(frozen=True, slots=True)
class TableRead:
    """A table as it was read: its columns, and how many rows were used and how many were dropped as damaged."""

    columns: tuple[ColumnRead, ...]
    rows: int
    dropped: int


_WATCH: ContextVar[list[TableRead] | None] = ContextVar("tables read", default=None)


@contextmanager
def watched() -> Iterator[list[TableRead]]:
    """Context manager with a list to which every table read inside it is added."""
    tables: list[TableRead] = []
    token = _WATCH.set(tables)
    try:
        yield tables
    finally:
        _WATCH.reset(token)


def note_table(channels: Sequence[Channel], rows: int, dropped: int) -> None:
    """Report to `watched` that a table was read."""
    tables = _WATCH.get()
    if tables is not None:
        tables.append(TableRead(tuple(map(_column, channels)), rows, dropped))


def note_columns(columns: Sequence[ColumnRead]) -> None:
    """Set the columns of the table that was read last, if its parser identified them later."""
    tables = _WATCH.get()
    if tables:
        tables[-1] = replace(tables[-1], columns=tuple(columns))


def column_read(name: str, channel: str, unit: str) -> ColumnRead:
    """A column and the sensor that measures its channel."""
    return ColumnRead(name, channel, unit, SENSOR_OF.get(channel, "device"))


def of_series(clocks: Sequence[Series]) -> tuple[ColumnRead, ...]:
    """The channels of samples as columns, for a log without columns: in SI, with their own names."""
    there = [f.name for f in fields(Series) if any(getattr(series, f.name) is not None for series in clocks)]
    return tuple(column_read(name, name, _si(name)) for name in there)


def samples_in(clocks: Sequence[Series]) -> int:
    """Total number of rows on all clocks."""
    return sum(int(np.size(series.time)) for series in clocks)


def _column(channel: Channel) -> ColumnRead:
    name = channel.becomes or (channel.name if channel.name in QUANTITIES else "")
    return column_read(channel.header or channel.name, name, _unit(name, channel.unit))


def _unit(channel: str, unit: Unit) -> str:
    """Spelling of the unit of a channel's column; "" if it has none or no usual name."""
    quantity = QUANTITIES.get(channel, "")
    if unit == Unit(1.0):
        return _si(channel)
    return next((name for name, one in UNITS.get(quantity, {}).items() if one == unit), "")


def _si(channel: str) -> str:
    return _SI.get(QUANTITIES.get(channel, ""), "")

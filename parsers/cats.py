"""CATS flight computer: one CSV file for each kind of record of a flight, with the clock `ts` in the first column.

Names are in camel case (`filteredAltitudeAGL`) or have underscores (`filtered_altitude_AGL`); sensors are numbered or
named (`BARO0`). `flightInfo` is the computer's state estimate (height, velocity, acceleration), `filteredDataInfo` its
filtered barometer and accelerometer, `baro` and `imu` raw samples of several sensors, numbered by `id`, `gnssInfo`
positions. The files contain neither a date nor a serial number; files read together are one flight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.importing.tables.pad_state import scale_at_rest
from fieldkit.units import STANDARD_GRAVITY, Unit

SI = Unit(1.0)
CHANNELS: Mapping[str, tuple[str, Unit]] = {
    "ts": ("time", SI),
    "height": ("altitude", SI),
    "velocity": ("speed", SI),
    "acceleration": ("acceleration", SI),
    "filteredaltitudeagl": ("altitude", SI),
    "filteredacceleration": ("acceleration", SI),
    "latitude": ("latitude", SI),
    "longitude": ("longitude", SI),
    "satellites": ("satellites", SI),
    "p": ("raw pressure", SI),
}
KINDS: Mapping[str, tuple[str, ...]] = {
    "flightInfo": ("height", "velocity"),
    "filteredDataInfo": ("filteredaltitudeagl",),
    "gnssInfo": ("latitude", "longitude", "satellites"),
    "baro": ("id", "t", "p"),
    "imu": ("id", "ax", "ay", "az"),
}
"""Each kind of file, identified by columns beside `ts`."""
MOST_ABOVE = 5
"""Largest number of lines above the header. [1]"""
MOST_SENSORS = 16
"""Largest number of sensors of one kind. [1]"""
PASCAL = (1_000.0, 115_000.0)
"""Plausible range of air pressures in a flight. [Pa]"""


def kind_of(names: Sequence[str]) -> str:
    """The kind of file that a header belongs to; empty if none."""
    if "ts" not in names:
        return ""
    return next((kind for kind, columns in KINDS.items() if set(columns) <= set(map(_joined, names))), "")


def _joined(name: str) -> str:
    return name.replace("_", "")


def recognises(head: bytes) -> bool:
    found = find_header(head, lambda names: bool(kind_of(names)))
    return found is not None and found.row <= MOST_ABOVE


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, lambda names: bool(kind_of(names)), "a header with ts")
    head = replace(head, names=tuple(map(_joined, head.names)))
    axes = [Channel(name, head.names.index(name)) for name in ("ax", "ay", "az") if name in head.names]
    wanted = head.channels(CHANNELS) + axes
    place = head.place("id")
    words = {} if place is None else {"id": place}
    parts, found = read_columns(
        log, wanted, after=head.row, separator=head.separator, widths={len(head.names)}, words=words
    ).flights()
    clocks = [tuple(one for sensor in _sensors(part) for one in _series(sensor, found)) for part in parts]
    if not any(clocks):
        raise DamagedLog("found no channel whose unit is certain, expected pressure in Pa or acceleration")
    return [*(Reading(series=series, device="CATS", part=kind_of(head.names)) for series in clocks if series), *found]


def _sensors(table: LogTable) -> list[LogTable]:
    """The rows of each sensor separately, because a file of raw samples contains several."""
    if "id" not in table.words:
        return [table]
    names, which = table.words["id"]
    there = sorted((name, number) for number, name in enumerate(names) if name and (which == number).any())
    return [table.pick(which == number) for _, number in there[:MOST_SENSORS]]


def _series(table: LogTable, notes: list[Parsed]) -> list[Series]:
    """The samples of one sensor; empty if their meaning is uncertain."""
    time, values = table.values["time"], dict(table.values)
    if (pressure := table.get("raw pressure")) is not None:
        if not PASCAL[0] <= np.nanmedian(pressure) <= PASCAL[1]:
            notes.append(Note("holds pressures that are not in Pa, left out"))
            return []
        return [Series(time=time, pressure=pressure)]
    if "ax" in values:
        felt = np.sqrt(values["ax"] ** 2 + values["ay"] ** 2 + values["az"] ** 2)
        scale = scale_at_rest(felt[time < 0], (1.0, STANDARD_GRAVITY))
        if scale is None:
            notes.append(Note("holds accelerations before launch that are not one g in any unit; left out"))
            return []
        return [Series(time=time, felt_total=felt * scale)]
    if (satellites := table.get("satellites")) is not None:
        for name in ("latitude", "longitude"):
            values[name] = np.where(satellites > 0, values[name], np.nan)
    return [LogTable(values, table.rows).series()]


PARSER = Parser(
    "CATS",
    recognises,
    read,
    signs=(
        "ts",
        "height|filteredAltitudeAGL|filtered_altitude_AGL|latitude|id",
        "velocity|filteredAcceleration|filtered_acceleration|longitude|P|ax",
    ),
)

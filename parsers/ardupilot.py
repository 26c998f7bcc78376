"""ArduPilot: the log of a flight controller as text, `FMT` lines that name the columns of each kind of line.

`FMT, 163, 37, BARO, QBffcf, TimeUS,I,Alt,Press,Temp,CRt` means that in `BARO, 1200000, 0, 1.2, 98021.4, 21.5, 0.3` the
fourth cell is a height. Of several sensors the first is used. The controller corrects its heights for the temperature
that its barometer had on the ground, other altimeters do not, so heights are computed from its pressures. The axes of
its accelerometer are those of the board, which may be mounted in any direction; vertical speed by GPS is positive
downward.

Source: ArduPilot's LogStructure.h (AP_Logger, AP_Baro, AP_InertialSensor, AP_GPS) and AP_Baro.cpp.
"""

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Parsed, Parser, Reading
from fieldkit.importing.tables.cell import MAX_CELL_VALUE
from fieldkit.importing.tables.clocks import in_order
from fieldkit.importing.tables.damage import Damaged, damage
from fieldkit.importing.tables.pad_state import along_thrust
from fieldkit.importing.tables.text import blocks, shown
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float

MAX_LOG_SIZE = 512 << 20
"""Largest file size: an hour of everything that a controller logs. [bytes]"""
MARK = "FMT"
CLOCKS: Mapping[str, float] = {"TimeUS": 1e-6, "TimeMS": 1e-3}
"""Names of the clock, and its unit. [s]"""
INSTANCE = "I"
"""The column with the number of the sensor, counted from 0; older versions have a kind of line for each instead."""
WANTED: Mapping[str, tuple[str, ...]] = {
    "BARO": ("Press", "Alt", "Temp"),
    "IMU": ("AccX", "AccY", "AccZ"),
    "GPS": ("Status", "Lat", "Lng", "Alt", "VZ"),
}
"""Columns by the kind of line; those that a version does not have are left out."""
FIX = 3
"""Least status of a receiver that knows its height. [1]"""
MAX_FORMATS = 1000
"""Largest number of kinds of lines; there are at most 256. [1]"""
ZERO_CELSIUS = 273.15


@dataclass(slots=True)
class LineSamples:
    """The wanted cells of one kind of line, in the order of its columns."""

    names: tuple[str, ...]
    places: tuple[int, ...]
    scale: float
    instance: int | None
    width: int
    values: "array[float]" = field(default_factory=lambda: array("d"))

    def columns(self) -> dict[str, Array]:
        """The clock `time` [s], and the other columns as they are, in order of time."""
        table = np.array(self.values).reshape(-1, len(self.places)).T
        ordered = in_order(table[0] * self.scale, *table[1:])
        return dict(zip(("time", *self.names), ordered, strict=True))


def recognises(head: bytes) -> bool:
    lines = [line for _, block in blocks(head) for line in block]
    return sum(_is_format(line) for line in lines) >= 2


def _is_format(line: str) -> bool:
    return line.startswith(f"{MARK},") and len(line.split(",")) >= 6


def read(log: bytes) -> list[Parsed]:
    if len(log) > MAX_LOG_SIZE:
        raise DamagedLog(f"found {len(log)} bytes, expected at most {MAX_LOG_SIZE}")
    kinds, damaged = _kinds(log)
    found = {name: rows.columns() for name, rows in kinds.items() if rows.values}
    clocks = [_barometer(found.get("BARO")), _accelerometer(found.get("IMU")), _receiver(found.get("GPS"))]
    series = tuple(one for one in clocks if one is not None)
    if not series:
        raise DamagedLog("found no line of BARO, IMU or GPS with a clock, expected one for each sample", row=1)
    return [Reading(series=series, device="ArduPilot"), *damage(damaged, "lines", log)]


def _kinds(log: bytes) -> tuple[dict[str, LineSamples], Damaged]:
    """The samples of each wanted kind of line, and the damaged lines."""
    kinds: dict[str, LineSamples] = {}
    damaged, formats = Damaged(), 0
    for first, lines in blocks(log):
        for row, line in enumerate(lines, start=first):
            name, _, rest = line.partition(",")
            if name == MARK and formats < MAX_FORMATS:
                formats += 1
                kind, rows = _format(rest)
                if rows is not None:
                    kinds.setdefault(kind, rows)
            elif name in kinds and not _add(kinds[name], rest.split(",")):
                damaged.add(
                    DamagedLog(f"found {shown(line)}, expected {counted(kinds[name].width, 'number')}", row=row)
                )
    return kinds, damaged


def _format(text: str) -> tuple[str, LineSamples | None]:
    """The kind of line that a format describes, and where its wanted columns are; None for another kind."""
    cells = [cell.strip() for cell in text.split(",")]
    kind, names = (cells[2], cells[4:]) if len(cells) > 4 else ("", [])
    clock = next((name for name in CLOCKS if name in names), None)
    if kind not in WANTED or clock is None:
        return kind, None
    wanted = tuple(name for name in WANTED[kind] if name in names)
    instance = names.index(INSTANCE) if INSTANCE in names else None
    places = tuple(names.index(name) for name in (clock, *wanted))
    return kind, LineSamples(wanted, places, CLOCKS[clock], instance, len(names))


def _add(rows: LineSamples, cells: list[str]) -> bool:
    """Add a line of the first sensor; False for a damaged one."""
    if len(cells) != rows.width:
        return False
    try:
        if rows.instance is None or int(cells[rows.instance]) == 0:
            numbers = [float(cells[place]) for place in rows.places]
            if not all(abs(number) <= MAX_CELL_VALUE for number in numbers):
                return False
            rows.values.extend(numbers)
    except ValueError:
        return False
    return True


def _barometer(found: Mapping[str, Float[Array, "row"]] | None) -> Series | None:
    """Pressures [Pa], or heights above the pad if there are none [m]."""
    if found is None or not {"Press", "Alt"} & {*found}:
        return None
    temperature = found["Temp"] + ZERO_CELSIUS if "Temp" in found else None
    if "Press" not in found:
        return Series(found["time"], altitude=found["Alt"], temperature=temperature)
    pressure = np.where(found["Press"] > 0, found["Press"], np.nan)
    return Series(found["time"], pressure=pressure, temperature=temperature)


def _accelerometer(found: Mapping[str, Float[Array, "row"]] | None) -> Series | None:
    """Specific force along the rocket [m/s^2]; None without three axes or without a thrust that all of them show."""
    if found is None or not {*WANTED["IMU"]} <= {*found}:
        return None
    axes = np.stack([found[name] for name in WANTED["IMU"]])
    felt = along_thrust(found["time"], axes)
    return None if felt is None else Series(found["time"], felt=felt)


def _receiver(found: Mapping[str, Float[Array, "row"]] | None) -> Series | None:
    """Positions and heights while the receiver has a fix. [deg, m, m/s]"""
    if found is None or not {"Lat", "Lng", "Alt"} <= {*found}:
        return None
    fixed = found["Status"] >= FIX if "Status" in found else np.ones(found["time"].size, bool)
    latitude, longitude, altitude = (np.where(fixed, found[name], np.nan) for name in ("Lat", "Lng", "Alt"))
    speed = np.where(fixed, -found["VZ"], np.nan) if "VZ" in found else None
    return Series(found["time"], latitude=latitude, longitude=longitude, gps_altitude_msl=altitude, gps_speed=speed)


PARSER = Parser("ArduPilot log (text)", recognises, read, signs=("FMT", "BARO", "TimeUS|TimeMS", "IMU|GPS"))

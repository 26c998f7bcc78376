"""Missile Works RRC3, exported by mDACS: `Time,Altitude,Pressure,Velocity,Temperature,Events,Voltages`, 20 per second.

The header has no units. Pressure is in mbar, and the height from it by the standard atmosphere determines whether
altitude and velocity are in feet or in meters; if the result is ambiguous they are dropped. Temperature is in the
corresponding unit (degrees Fahrenheit or Celsius) and is recorded once per second. Cells are separated by comma, TAB or
semicolon (with decimal commas), and the text is UTF-8 or UTF-16. The last rows can be garbage, and a log may stop at
apogee.
"""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.columns_read import column_read, note_columns
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.shapes import Array, Float
from fieldkit.units import UNITS, Unit

NAMES = ("time", "altitude", "pressure", "velocity", "temperature", "events", "voltages")
NEEDED_COLUMNS = {"time", "altitude", "pressure", "velocity", "events"}
"""Columns without which a table is not from this program; others may be missing, or additional."""
WORDS = ("temperature", "events")
"""Columns read as words, because without a temperature the event takes its place."""
CHANNELS_WITHOUT_UNITS = {"time": ("time", "s"), "pressure": ("pressure", "mbar"), "voltages": ("voltage", "V")}
"""Columns with the same unit in every export, with their channel."""
MOST_WORDS = 300
"""Number of different words that are searched for events. [1]"""
AIR = (100.0, 115_000.0)
"""Range of pressures that an altimeter can measure. [Pa]"""
CLIMB = 20.0
"""Smallest height that determines units; noise is as large as smaller ones. [m]"""
HEIGHT_RATIO_TOLERANCE = 0.08
"""Tolerance of the ratio of two heights for a unit: real air differs from standard air. [1]"""
TAIL, JUMP = 3, 5_000.0
"""Number of last rows that may be garbage [1], and the smallest jump from the previous row that is garbage [Pa]."""


def _fits(names: Sequence[str]) -> bool:
    return set(names) >= NEEDED_COLUMNS


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, ",".join(name.capitalize() for name in NAMES))
    places = {name: head.names.index(name) for name in NAMES if name in head.names}
    channels = [Channel(name, place, needed=name == "time") for name, place in places.items() if name not in WORDS]
    parts, found = read_columns(
        log,
        [replace(c, unit=UNITS["pressure"]["mbar"]) if c.name == "pressure" else c for c in channels],
        after=head.row,
        separator=head.separator,
        words={name: places[name] for name in WORDS if name in places},
    ).flights()
    note_columns([column_read(name.capitalize(), *CHANNELS_WITHOUT_UNITS.get(name, ("", ""))) for name in places])
    readings = [_reading(part, found) for part in parts]
    if not any(readings):
        raise DamagedLog("found pressures that are not in mbar, expected 1 to 1150", row=head.row, column="pressure")
    return [*(reading for reading in readings if reading), *found]


def _reading(table: LogTable, found: list[Parsed]) -> Reading | None:
    """The flight of a table, or None if its pressures are impossible."""
    events = _events(table)
    table, garbage = _without_garbage(table)
    pressure = table.get("pressure")
    if pressure is None or not AIR[0] <= np.nanmedian(pressure) <= AIR[1]:
        return None
    series, note = _settled(table)
    found += [note, *garbage]
    return Reading(series=series, events=events, device="RRC3")


def _events(table: LogTable) -> dict[str, float]:
    """The words in the samples, each with the time of its first row. [s]"""
    events: dict[str, float] = {}
    for known, which in table.words.values():
        for i, word in enumerate(known[:MOST_WORDS]):
            if re.fullmatch(r"[A-Za-z][A-Za-z ]*", word.strip()) and (which == i).any():
                when = float(table.values["time"][int(np.argmax(which == i))])
                events[word.strip().lower()] = min(when, events.get(word.strip().lower(), when))
    return events


def _temperature(table: LogTable) -> Float[Array, "row"] | None:
    """The temperature in the log's own unit, or None."""
    if "temperature" not in table.words:
        return None
    known, which = table.words["temperature"]
    degrees = np.array([float(word) if re.fullmatch(r"\s*-?\d{1,3}([.]\d*)?\s*", word) else np.nan for word in known])
    return None if np.isnan(degrees[which]).all() else degrees[which]


def _without_garbage(table: LogTable) -> tuple[LogTable, list[Parsed]]:
    """The table up to the first of its last rows whose pressure cannot follow the previous one."""
    pressure = table.values["pressure"]
    jumps = np.flatnonzero(np.abs(np.diff(pressure)) > JUMP) + 1
    bad = [int(row) for row in jumps if row >= len(table) - TAIL]
    if not bad:
        return table, []
    damaged = [
        DamagedLog(
            f"found {pressure[row] / 100:.2f} after {pressure[row - 1] / 100:.2f} mbar, expected no such jump",
            row=int(table.rows[row]),
            column="pressure",
        )
        for row in range(bad[0], len(table))
    ]
    return table.pick(slice(0, bad[0])), list(damaged)


def _settled(table: LogTable) -> tuple[Series, Note]:
    """The samples in SI, and a note on how the units were determined."""
    time, pressure, printed = (table.values[name] for name in ("time", "pressure", "altitude"))
    series = Series(time=time, pressure=pressure, voltage=table.get("voltages"))
    height = pressure_height(np.clip(pressure, *AIR))
    start = slice(0, 40)
    if np.isnan(printed[start]).all() or np.isnan(height[start]).all():
        return series, Note("begins without a pressure or an altitude: units cannot be determined, altitude left out")
    ground = int(np.nanargmin(np.abs(np.where(np.isnan(height[start]), np.nan, printed[start]))))
    climbed = height - height[ground]
    far = np.abs(climbed) > CLIMB
    ratio = float(np.nanmedian((printed - printed[ground])[far] / climbed[far])) if far.sum() >= 10 else np.nan
    for length, degrees in (("m", "c"), ("ft", "f")):
        unit = UNITS["length"][length]
        if abs(ratio * unit.factor - 1) < HEIGHT_RATIO_TOLERANCE:
            known = {
                "altitude": ("altitude", length),
                "velocity": ("speed", f"{length}/s"),
                "temperature": ("temperature", degrees),
            }
            names = CHANNELS_WITHOUT_UNITS | known
            present = [name for name in NAMES if name in table.values or name in table.words]
            note_columns([column_read(name.capitalize(), *names.get(name, ("", ""))) for name in present])
            return _in_units(series, table, unit, UNITS["temperature"][degrees]), Note(
                f"has no units; its pressures prove that altitude is in {length} and temperature in °{degrees.upper()}"
            )
    return series, Note("has no units and its pressures confirm neither feet nor meters: altitude left out")


def _in_units(series: Series, table: LogTable, length: Unit, degrees: Unit) -> Series:
    altitude, velocity, temperature = table.get("altitude"), table.get("velocity"), _temperature(table)
    return replace(
        series,
        altitude=None if altitude is None else altitude * length.factor,
        speed=None if velocity is None else velocity * length.factor,
        temperature=None if temperature is None else temperature * degrees.factor + degrees.offset,
    )


PARSER = Parser(
    "RRC3 (mDACS)",
    recognises,
    read,
    signs=("Time", "Altitude", "Pressure", "Velocity", "Temperature", "Events", "Voltages"),
)

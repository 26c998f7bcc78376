"""AltOS CSV, all generations: the export of a log or a radio flight by Altus Metrum's software, in SI.

The file has comment lines, a header that begins `#version,serial,flight`, and padded cells; `time` is 0 at boost. The
second column called `altitude` is from the satellites. Version 5 (2012-2013) has headers that do not match their rows:
only the columns up to `main_voltage` are in the stated positions. The radio form begins `serial,tick,ptype`.
Source: altoslib/AltosCSV.java of AltOS; five files of two generations.
"""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.altos import MAX_RADIO_GAP, NO_VALUE, TICK, entered
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import SEPARATORS
from fieldkit.importing.tables.layout import split
from fieldkit.importing.tables.text import first_lines
from fieldkit.quantities import counted
from fieldkit.units import UNITS, Unit

VERSION_5 = frozenset({"accel_speed", "baro_speed"})
"""Column names that occur only in a header of version 5."""
LAST_RELIABLE_COLUMN = "main_voltage"
"""The last column of a version 5 header in its stated position."""
MOST_HEADER, MOST_TITLES = 200, 3
"""Number of lines searched for the header, and largest number of lines above it that are not comments. [1]"""
FIRST_ROWS = MOST_CELLS = 200
"""Number of rows from which the number of cells in a row is determined, and upper limit on the cells in a row of
version 5. [1]"""
BAROMETER = {
    "height": "altitude",
    "altitude": "altitude_msl",
    "pressure": "pressure",
    "speed": "speed",
    "baro_speed": "speed",
    "accel_speed": "inertial_speed",
    "acceleration": "acceleration",
    "temperature": "temperature",
    "battery_voltage": "voltage",
    "tilt": "tilt",
}
SATELLITES = {"nsat": "nsat", "latitude": "latitude", "longitude": "longitude"}
"""Columns by name, with their channels: those of the barometer and the flight computer, and those of the satellites."""
NOT_IN_SI: dict[str, Unit] = {"temperature": UNITS["temperature"]["c"], "tilt": UNITS["angle"]["deg"]}
"""Units of the columns that are not in SI."""
WRAP = 65536 * TICK
"""Period after which the clock of the radio form wraps around. [s]"""


def recognises(head: bytes) -> bool:
    return _header(head) is not None


def read(log: bytes) -> list[Parsed]:
    header = _header(log)
    if header is None:
        raise DamagedLog("found no header, expected one that begins #version,serial,flight", row=1)
    row, names, separator = header
    widths = _widths(log, row, names, separator)
    common = widths.most_common(1)[0][0] if widths else len(names)
    remarks: list[Parsed] = []
    allowed: Collection[int] = {common}
    if common != len(names):
        _refuse_commas(log, row, separator)
        names = _certain(names, row)
        allowed = range(len(names), MOST_CELLS)
        remarks.append(
            Note(f"header does not match its rows of {counted(common, 'cell')}, read up to {LAST_RELIABLE_COLUMN}", row)
        )
    channels = _channels(names, row)
    table = _present(read_columns(log, channels, after=row, separator=separator, comment="#", widths=allowed))
    about = _about(log, row)
    found: list[Parsed] = []
    for flight in _by_flight(table):
        parts, more = _unwrapped(flight).flights() if "tick" in names else flight.flights()
        found += [_reading(part, about) for part in parts]
        remarks += more
    return [*found, *remarks, *table.found]


def _header(log: bytes) -> tuple[int, list[str], str] | None:
    """The row, the names and the separator of the header; None if it is not from AltOS."""
    titles = 0
    for row, line in enumerate(first_lines(log, most=MOST_HEADER), start=1):
        for separator in SEPARATORS:
            names = [name.strip().strip('"# ').lower() for name in line.rstrip(f"{separator} ").split(separator)]
            if {"version", "serial", "flight"} <= {*names} or ({"serial", "tick", "ptype", "height"} <= {*names}):
                return row, names, separator
        titles += bool(line.strip()) and not line.lstrip('"').startswith("#")
        if titles > MOST_TITLES:
            return None
    return None


def _widths(log: bytes, header_row: int, names: Sequence[str], separator: str) -> Counter[int]:
    """Number of cells in the first rows, ignoring blank ones that a spreadsheet appended."""
    lines = first_lines(log, after=header_row, most=FIRST_ROWS)
    widths = Counter[int]()
    for line in lines:
        if line.strip() and not line.startswith("#"):
            whole, padded = (len(split(one, separator)) for one in (line.rstrip(f'{separator}" '), line))
            fits = whole <= len(names) <= padded and not set(names) >= VERSION_5
            widths[len(names) if fits else whole] += 1
    return widths


def _refuse_commas(log: bytes, header_row: int, separator: str) -> None:
    """Raise DamagedLog for rows without a decimal point, in which a comma may separate cells or decimals."""
    rows = [line for line in first_lines(log, after=header_row, most=FIRST_ROWS) if not line.startswith("#")]
    if separator == "," and not any(re.search(r"\d\.\d", line) for line in rows):
        expected = "expected decimal points, or semicolons between cells"
        raise DamagedLog(f"found commas both between cells and in decimals, {expected}", row=header_row + 1)


def _certain(names: Sequence[str], row: int) -> list[str]:
    """The names up to the last one whose position is certain; a comma may be missing right after it."""
    for place, name in enumerate(names):
        if name.startswith(LAST_RELIABLE_COLUMN):
            return [*names[:place], LAST_RELIABLE_COLUMN]
    raise DamagedLog(f"found a header that does not match its rows, expected {LAST_RELIABLE_COLUMN} in it", row=row)


def _channels(names: Sequence[str], row: int) -> list[Channel]:
    """The columns to read. Of several with one name the first is used, but the second altitude is from the
    satellites."""
    clock = "time" if "time" in names else "tick"
    if clock not in names or not {"height", "pressure", "altitude"} & {*names}:
        raise DamagedLog("found no time and no height, expected both", row=row)
    channels = [
        Channel("time", names.index(clock), Unit(TICK) if clock == "tick" else Unit(1.0), needed=True, header=clock)
    ]
    for name, channel in (BAROMETER | SATELLITES).items():
        if name in names and not (name == "baro_speed" and "speed" in names):
            channels.append(Channel(channel, names.index(name), NOT_IN_SI.get(name, Unit(1.0)), header=name))
    if "longitude" in names and "altitude" in names[names.index("longitude") :]:
        place = names.index("altitude", names.index("longitude"))
        channels = [c for c in channels if c.place != place] + [Channel("gps_altitude_msl", place, header="altitude")]
    channels += [Channel(name, names.index(name)) for name in ("state", "serial", "flight") if name in names]
    return channels


def _present(table: LogTable) -> LogTable:
    """The table with nan for values that were not measured, and without repeated fixes while there are no
    satellites."""
    for name, values in table.values.items():
        if name != "time":
            values[np.abs(values) >= NO_VALUE] = np.nan
    if "nsat" in table.values:
        lost = table.values["nsat"] == 0
        for name in ("latitude", "longitude", "gps_altitude_msl"):
            if name in table.values:
                table.values[name][lost] = np.nan
    return table


def _by_flight(table: LogTable) -> list[LogTable]:
    """A table for each serial number and flight, in order of appearance."""
    keys = [table.values[name] for name in ("serial", "flight") if name in table.values]
    marks = np.nan_to_num(np.column_stack(keys), nan=-1.0) if keys else np.zeros((len(table), 1))
    _, first, which = np.unique(marks, axis=0, return_index=True, return_inverse=True)
    which = which.reshape(-1)
    return [replace(table.pick(which == which[start]), found=()) for start in sorted(first.tolist())]


def _unwrapped(table: LogTable) -> LogTable:
    """The table with a continuous clock across 16-bit wraparounds."""
    time = table.values["time"]
    fallen = np.diff(time, prepend=time[:1]) < -WRAP / 2
    table.values["time"][:] = time + WRAP * np.cumsum(fallen)
    return table


def _about(log: bytes, header_row: int) -> dict[str, str]:
    """The comment lines as values by name in lower case."""
    lines = first_lines(log, most=header_row - 1)
    pairs = (re.match(r"#\s*([^:]{1,40}):\s*(.*)", line) for line in lines)
    return {pair[1].strip().lower(): pair[2].strip() for pair in pairs if pair}


def _reading(part: LogTable, about: dict[str, str]) -> Reading:
    serial, flight = (_number(part, name) for name in ("serial", "flight"))
    return Reading(
        extra={"flight": flight} if flight else {},
        series=part.series(),
        events=_events(part),
        serial=serial or about.get("serial number", ""),
        device=about.get("product", ""),
        firmware=about.get("software version", ""),
    )


def _number(part: LogTable, name: str) -> str:
    """An integer that every row of a flight repeats, as text."""
    values = part.get(name)
    return "" if values is None or not abs(values[0]) < NO_VALUE else f"{values[0]:.0f}"


def _events(part: LogTable) -> dict[str, float]:
    """When each state was first entered [s]. The state at the start of the log only shows that time 0 is boost."""
    states = part.get("state")
    if states is None:
        return {}
    time = part.values["time"]
    events = {name: when for name, when in entered(states, time, blind=MAX_RADIO_GAP).items() if when > time[0]}
    return {"liftoff": 0.0, **events} if "liftoff" not in events and time[0] < 0 < time[-1] else events


PARSER = Parser(
    "AltOS CSV",
    recognises,
    read,
    signs=("serial", "flight|tick", "time|ptype", "state", "state_name", "height", "pressure"),
)

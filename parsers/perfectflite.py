"""PerfectFlite .pf2, regardless of the name: Pnut, StratoLogger SL100 and StratoLoggerCF, 20 samples per second.

A block of `Name: value` lines, a line of column names, and rows. Heights are in feet unless the apogee above them or
the line of column names is in meters; temperatures are in the unit given in that line. The stated apogee is the
device's own and may differ from the highest row. If power was lost the rest of the log is filled with 25.50 V; the
heights in these rows were never measured. A spreadsheet may have added quotation marks and commas.
Source: files of nine flights, listed with the format.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME
from fieldkit.flight.limits import check
from fieldkit.importing import MOST_FLIGHTS, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.damage import below
from fieldkit.importing.tables.text import first_lines, shown
from fieldkit.quantities import counted

MOST_ABOVE = 5
"""Number of lines among which the one with the device's name must be, after blank lines or a title. [1]"""
NEXT_FLIGHT = re.compile(rb"^[\" ]{0,9}PerfectFlite [A-Za-z]", re.MULTILINE)
MOST_HEADER = 100
"""Number of lines that are searched for the column names. [1]"""
ERASED_VOLTAGE = 25.50
"""Battery voltage of an erased byte: no sample was written here. [V]"""
DATA = re.compile(r"[\s\"]*Data\s*:(?=.*Time)(?=.*Altitude)", re.IGNORECASE)
COLUMNS = {
    "time": ("time", "time", "s"),
    "altitude": ("altitude", "length", "{length}"),
    "velocity": ("speed", "speed", "{length}/s"),
    "voltage": ("voltage", "voltage", "v"),
}
"""Channel, quantity and usual unit of each column by name; the name of the temperature includes its unit."""
COLUMN = re.compile(r"[\s(]*([a-z]+)(?:\s*\(\s*([^()\s]{1,8})\s*\))?[\s)]*", re.IGNORECASE)
"""The name of a column, and its unit if the name is followed by one."""
LENGTH = re.compile(r"\s*(-?\d{1,6}(?:\.\d{1,3})?)\s*('|ft\b|m\b)")
"""A height in the lines above the samples, and its unit."""
LEAST_WIDTH = 3
"""Smallest number of cells in a row: some rows have neither temperature nor voltage. [1]"""
STATED_READOUTS = {"apogee": "Apogee", "site_elevation": "Ground Elevation"}
"""Fields of `Flight` that the lines above the samples state, with the names of the lines."""
COPIED_FIELDS = (
    *("Software", "Flight Number", "Main Setting", "Apogee Delay", "Drogue At", "Main At"),
    *("Max Drogue Current", "Max Main Current"),
)
OUTPUTS = {"drogue at": "drogue", "main at": "main"}
"""Lines that state when an output fired, with the names of the events."""


def recognises(head: bytes) -> bool:
    return any(line.lstrip(' "').startswith("PerfectFlite ") for line in first_lines(head, most=MOST_ABOVE))


def read(log: bytes) -> list[Parsed]:
    starts = [0, *(match.start() for match in islice(NEXT_FLIGHT.finditer(log), 1, MOST_FLIGHTS + 1)), len(log)]
    found: list[Parsed] = []
    for start, end in pairwise(starts):
        above = log.count(b"\n", 0, start)
        try:
            found += [below(item, above) for item in _flight(log[start:end])]
        except DamagedLog as error:
            found.append(below(error, above))
    if not any(isinstance(item, Reading) for item in found):
        raise next(item for item in found if isinstance(item, DamagedLog))
    return found


def _flight(log: bytes) -> list[Parsed]:
    """What was found in one file, or in one of several that somebody put together. Raises DamagedLog."""
    header, data_row, data = _header(log)
    table = _table(log, data_row, data, _length(header))
    remarks: list[Parsed] = []
    written = table.pick(slice(_written(table)))
    if len(written) < len(table):
        remarks.append(Note("has no power from here on, left out", int(table.rows[len(written)])))
    stated_count = header.get("NumSamps", "")
    if stated_count.isdecimal() and stated_count.lstrip("0") != str(len(table)):
        remarks.append(Note(f"found {counted(len(table), 'sample')}, expected {stated_count[:9]} as NumSamps says"))
    parts, found = written.flights()
    first = Reading(
        stated=_stated(header, remarks),
        extra={name: header[name] for name in COPIED_FIELDS if header.get(name)},
        columns=STATED_READOUTS,
        series=parts[0].series(),
        events=_events(header),
        device=header.get("PerfectFlite", ""),
        firmware=header.get("Firmware", ""),
        serial=header.get("Serial Number", ""),
    )
    others = [replace(first, stated={}, events={}, series=part.series()) for part in parts[1:]]
    return [first, *others, *remarks, *found]


def _header(log: bytes) -> tuple[Mapping[str, str], int, str]:
    """The lines above the samples by name, and the row and text of the line of column names."""
    header: dict[str, str] = {}
    for row, line in enumerate(first_lines(log, most=MOST_HEADER), start=1):
        if DATA.match(line):
            return header, row, line
        line = line.rstrip(",;\t ").strip(' "')
        if line.startswith("PerfectFlite "):
            header["PerfectFlite"] = line.strip()
        elif line.strip().upper().endswith("PWRLOSS"):
            header["Apogee"] = ""
        elif ":" in line:
            name, _, value = line.partition(":")
            header[name.strip()] = value.strip()
    raise DamagedLog("found no line of columns, expected one such as Data: (Time, Altitude, Velocity", row=1)


def _length(header: Mapping[str, str]) -> str:
    """The unit of heights: meters if a height above the samples is in meters."""
    stated = (LENGTH.match(header.get(name, "")) for name in STATED_READOUTS.values())
    return "m" if any(one and one[2] == "m" for one in stated) else "ft"


def _table(log: bytes, data_row: int, data: str, length: str) -> LogTable:
    separator = max(",;\t", key=data.count)
    names = data.replace('"', "").replace("_", " ").rstrip(f"{separator} ").split(separator)
    channels = [channel for place, name in enumerate(names) if (channel := _channel(place, name, length))]
    return read_columns(log, channels, after=data_row, separator=separator, widths=range(LEAST_WIDTH, len(names) + 1))


def _channel(place: int, name: str, length: str) -> Channel | None:
    """A column by its name, such as `Data: (Time` or `Temperature (F)`; None if it is not read."""
    if unit := re.search(r"Temp\w{0,12}\.?\s?\(\s?°?\s?([FC])\s?\)", name, re.IGNORECASE):
        return Channel("temperature", place, units.unit("temperature", unit[1]), header="Temperature")
    match = COLUMN.fullmatch(re.sub(r"^\s*Data\s*:", "", name, flags=re.IGNORECASE))
    word = match[1].lower() if match else ""
    if match is None or word not in COLUMNS:
        return None
    channel, quantity, usual = COLUMNS[word]
    try:
        unit_of = units.unit(quantity, match[2] or usual.format(length=length))
    except BadValue:
        return None
    return Channel(channel, place, unit_of, needed=word in ("time", "altitude"), header=word.capitalize())


def _written(table: LogTable) -> int:
    """Number of rows before those that were never written, up to the end of the log.

    The last row is ignored, because it may be truncated within its voltage.
    """
    if "voltage" not in table.values:
        return len(table)
    written = np.flatnonzero(table.values["voltage"][:-1] != ERASED_VOLTAGE)
    last = int(written[-1]) + 1 if len(written) else 0
    return last if 0 < last < len(table) - 1 else len(table)


def _stated(header: Mapping[str, str], found: list[Parsed]) -> dict[str, object]:
    """The device's own apogee and pad height; impossible values are dropped and reported."""
    stated: dict[str, object] = {"notes": header["Comments"]} if header.get("Comments") else {}
    if "Apogee" in header and not header["Apogee"]:
        found.append(Note("says PWRLOSS where the apogee should be"))
    for field, name in STATED_READOUTS.items():
        text = header.get(name, "")
        height = LENGTH.match(text)
        if height:
            unit_of = units.unit("length", "m" if height[2] == "m" else "ft")
            try:
                stated[field] = check(BY_NAME[field], unit_of.to_si(float(height[1])))
            except BadValue as error:
                found.append(Note(f"{name}: {error}, left out"))
        elif text:
            found.append(Note(f"{name}: found {shown(text)}, expected feet such as 1009', left out"))
    return stated


def _events(header: Mapping[str, str]) -> dict[str, float]:
    """When the outputs fired; empty if the header has no time after launch. [s]"""
    events = {}
    for name, value in header.items():
        seconds = re.match(r"\s*(\d{1,4}(?:\.\d{1,3})?)", value)
        if name.lower() in OUTPUTS and seconds and float(seconds[1]) > 0:
            events[OUTPUTS[name.lower()]] = float(seconds[1])
    return events


PARSER = Parser(
    "PerfectFlite .pf2",
    recognises,
    read,
    signs=("PerfectFlite", "Firmware", "Serial Number", "NumSamps", "Data: (Time|Data:"),
)

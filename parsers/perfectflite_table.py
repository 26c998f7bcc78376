"""Other exports of PerfectFlite's program: `Time,Altitude,Temp,Voltage` with commas or tabs, or no header.

A spreadsheet may have used semicolons between cells, and decimal commas. Each cell of temperature includes its unit,
`14.2C` or `76.7F`. Heights have none and are in feet, as everywhere in this program, unless somebody renamed the column
with another unit.
Source: exports of four flights, listed with the format.
"""

import re
from collections import Counter
from dataclasses import dataclass

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, read_columns
from fieldkit.importing.tables.text import first_lines, shown

TEMPERATURE_WORDS = re.compile(r"-?\d{1,3}(?:[.,]\d*)?\s*([CF])$")
NUMBER = re.compile(r"-?\d{1,6}(?:[.,]\d*)?$")
FIRST_ROWS = 20
"""Number of lines from which the layout is determined. [1]"""


@dataclass(frozen=True, slots=True)
class ExportLayout:
    """The layout of an export; `header_row` 0 means no header, `voltage_suffix` ends every cell of voltage."""

    header_row: int
    separator: str
    altitude_unit: str
    temperature_unit: str
    voltage_suffix: str


def recognises(head: bytes) -> bool:
    return _layout(head) is not None


def read(log: bytes) -> list[Parsed]:
    layout = _layout(log)
    if layout is None:
        raise DamagedLog("found no rows of time, altitude, temperature such as 76.7F, and voltage", row=1)
    channels = [
        Channel("time", 0, needed=True),
        Channel("altitude", 1, units.unit("length", layout.altitude_unit or "ft"), needed=True),
        Channel(
            "temperature",
            2,
            units.unit("temperature", layout.temperature_unit),
            suffix=layout.temperature_unit,
        ),
        Channel("voltage", 3, suffix=layout.voltage_suffix),
    ]
    table = read_columns(log, channels, after=layout.header_row, separator=layout.separator, widths={4})
    parts, remarks = table.flights()
    found: list[Parsed] = [*(Reading(series=part.series(), device="PerfectFlite") for part in parts), *remarks]
    if not layout.altitude_unit:
        found.append(Note("has no unit for altitude, read in feet as PerfectFlite's program writes it"))
    return found


def _layout(log: bytes) -> ExportLayout | None:
    """The layout of a log; None if it is not such an export."""
    lines = enumerate((line.rstrip(",;\t ") for line in first_lines(log, most=FIRST_ROWS)), start=1)
    rows = [(row, line) for row, line in lines if line and not line.startswith(("sep=", "#"))]
    if not rows:
        return None
    row, first = rows[0]
    separator = next((mark for mark in "\t;" if mark in first), ",")
    unit = ""
    cells = _cells(first, separator)
    names = [re.sub(r"[^a-z]+", "_", name.lower()).strip("_") for name in cells]
    if not NUMBER.match(cells[0]):
        heading = re.fullmatch(
            r"time(?:_s)?\|alt(?:itude)?(?:_(\w+))?\|temp(?:erature)?\|volt(?:age|s)?", "|".join(names)
        )
        if not heading:
            return None
        unit = heading[1] or ""
        rows = rows[1:]
    else:
        row = 0
    seen = Counter(kind for _, line in rows if (kind := _kind(line, separator)))
    if not seen:
        return None
    temperature, voltage = seen.most_common(1)[0][0]
    return ExportLayout(row, separator, _length(unit, row), temperature, voltage)


def _kind(line: str, separator: str) -> tuple[str, str] | None:
    """The suffixes of the temperature and voltage cells in a row; None if it is not a row of an export."""
    cells = _cells(line, separator)
    temperature = TEMPERATURE_WORDS.match(cells[2]) if len(cells) == 4 else None
    if not temperature or not NUMBER.match(cells[0]) or not NUMBER.match(cells[1]):
        return None
    return temperature[1], "V" if cells[3].endswith("V") else ""


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in line.split(separator)]


def _length(unit: str, row: int) -> str:
    try:
        return unit if not unit else (units.unit("length", unit), unit)[1]
    except BadValue as error:
        raise DamagedLog(f"found {shown(unit)}: {error}", row=row, column="altitude") from error


PARSER = Parser(
    "PerfectFlite exports (CSV, TAB)",
    recognises,
    read,
    signs=("Time|time_s", "Altitude|altitude_ft", "Temp|Temp.|Temperature", "Voltage"),
)

"""Other exports of PerfectFlite's program: `Time,Altitude,Temp,Voltage` with commas or tabs, or no header.

A spreadsheet may have used semicolons between cells, and decimal commas; there may be a column of velocity, and titles
above the rows. Each cell of temperature includes its unit, `14.2C` or `76.7F`; without one a table without a header is
such an export only below a title that names a PerfectFlite altimeter. Heights have no unit and are in feet, as
everywhere in this program, unless somebody renamed the column with another unit.
Source: exports of four flights, listed with the format.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, read_columns
from fieldkit.importing.tables.text import first_lines, shown

TEMPERATURE_WORDS = re.compile(r"-?\d{1,3}(?:[.,]\d*)?\s*([CF]?)$")
NUMBER = re.compile(r"-?\d{1,6}(?:[.,]\d*)?$")
VOLTAGE = re.compile(r"\d{1,2}(?:[.,]\d*)?\s*(V?)$")
HEADER = re.compile(r"time(?:_s)?\|alt(?:itude)?(?:_(\w+))?(?:\|vel(?:ocity)?)?\|temp(?:erature)?\|volt(?:age|s)?")
MAKER = re.compile(r"perfectflite|stratologger|\bpnut\b", re.IGNORECASE)
"""Names in a title of an export without a header."""
FIRST_ROWS, MOST_TITLES = 20, 20
"""Number of lines from which the layout is determined, and the largest number of lines above them. [1]"""
STEP = 0.05
"""Time between two samples of every PerfectFlite altimeter that stores temperatures. [s]"""


@dataclass(frozen=True, slots=True)
class ExportLayout:
    """The layout of an export, whose rows begin below `above`; `voltage_suffix` ends every cell of voltage. A
    temperature without a unit is not read."""

    above: int
    separator: str
    width: int
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
        Channel("voltage", layout.width - 1, suffix=layout.voltage_suffix),
    ]
    if layout.width == 5:
        channels.append(Channel("speed", 2, units.unit("speed", f"{layout.altitude_unit or 'ft'}/s")))
    if unit := layout.temperature_unit:
        channels.append(Channel("temperature", layout.width - 2, units.unit("temperature", unit), suffix=unit))
    table = read_columns(log, channels, after=layout.above, separator=layout.separator, widths={layout.width})
    parts, remarks = table.flights()
    found: list[Parsed] = [*(Reading(series=part.series(), device="PerfectFlite") for part in parts), *remarks]
    if not layout.altitude_unit:
        feet = "has no unit for altitude, read in feet as PerfectFlite's program writes it"
        found.append(Note(f"{feet}; if they are meters, heights are {1 / units.FOOT:.1f} times too low"))
    return found


def _layout(log: bytes) -> ExportLayout | None:
    """The layout of a log; None if it is not such an export."""
    lines = [line.rstrip(",;\t ") for line in first_lines(log, most=MOST_TITLES + FIRST_ROWS)]
    separator = next((mark for mark in "\t;," if any(_kind(line, mark) for line in lines)), ",")
    kinds = [_kind(line, separator) for line in lines]
    start = next((i for i, kind in enumerate(kinds) if kind), MOST_TITLES)
    seen = Counter(kind for kind in kinds[start : start + FIRST_ROWS] if kind)
    if not seen:
        return None
    (width, temperature, voltage), _ = seen.most_common(1)[0]
    above = [line for line in lines[:start] if line and not line.startswith(("sep=", "#"))]
    names = [re.sub(r"[^a-z]+", "_", name.lower()).strip("_") for name in _cells(above[-1], separator)] if above else []
    heading = HEADER.fullmatch("|".join(names)) if len(names) == width else None
    if (len(names) > 1 and not heading) or not (temperature or _is_named(above, lines[start:], separator)):
        return None
    unit = _length(heading[1] or "", start) if heading else ""
    return ExportLayout(start, separator, width, unit, temperature, voltage)


def _is_named(titles: Sequence[str], rows: Sequence[str], separator: str) -> bool:
    """Whether a title names a PerfectFlite altimeter, and the rows below it have the step of one."""
    times = [float(_cells(row, separator)[0].replace(",", ".")) for row in rows if _kind(row, separator)]
    steps = {round(after - before, 6) for before, after in pairwise(times)}
    return steps == {STEP} and any(MAKER.search(title) for title in titles)


def _kind(line: str, separator: str) -> tuple[int, str, str] | None:
    """The number of cells and the suffixes of temperature and voltage in a row; None if it is not one of an export."""
    cells = _cells(line, separator)
    if len(cells) not in (4, 5) or not all(map(NUMBER.match, cells[:-2])):
        return None
    temperature, voltage = TEMPERATURE_WORDS.match(cells[-2]), VOLTAGE.match(cells[-1])
    return (len(cells), temperature[1], voltage[1]) if temperature and voltage else None


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

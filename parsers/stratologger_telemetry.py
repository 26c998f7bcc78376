"""StratoLogger live telemetry: a table of seconds and feet, captured from the lines that the unit sends.

The unit sends one altitude in feet per line without a time; the seconds are times of reception. If it already transmits
on the pad, its first line is the pad's elevation above sea level and the others are above the pad. If it transmits from
launch on, all are above the pad. The first case is recognized by a drop to about zero after the first line.

Source: docs/telem.md (UND-ARC/StratoLogger).
"""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import HEAD, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, read_columns
from fieldkit.importing.tables.header import Header, find_header, header_or_damage
from fieldkit.importing.tables.text import decode, first_lines, lines_of, shown
from fieldkit.quantities import counted
from fieldkit.units import FOOT, UNITS

TITLE = "StratoLogger live telemetry, captured by fieldkit"
ON_PAD = 30 * FOOT
"""Largest height of a rocket that is still on its pad, by its own barometer. [m]"""
CHANNELS = (
    Channel("time", 0, needed=True, header="seconds"),
    Channel("altitude", 1, UNITS["length"]["ft"], header="feet"),
)


def recognises(head: bytes) -> bool:
    return TITLE.partition(",")[0] in decode(head) and find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "seconds,feet before the samples")
    decimal = None if head.separator == "," else _decimal(log, head)
    table = read_columns(log, CHANNELS, after=head.row, separator=head.separator, decimal=decimal, widths={2})
    notes = list(table.found)
    is_number = ~np.isnan(table.values["altitude"])
    time, height = table.values["time"], table.values["altitude"]
    if not is_number.all():
        time, height = time[is_number], height[is_number]
        lost = table.rows[~is_number]
        notes.append(Note(f"is not a number, left out; {counted(len(lost), 'such line')} in all", int(lost[0])))
    stated: dict[str, object] = {}
    began, row = _began(log, head)
    try:
        stated["date_time"] = datetime.fromisoformat(began).replace(tzinfo=None) if began else None
    except ValueError:
        notes.append(DamagedLog(f"found {shown(began)}, expected a date and time", row=row))
    if len(height) > 1 and abs(height[0]) > ON_PAD >= abs(height[1]):
        stated["site_elevation"] = float(height[0])
        time, height = time[1:], height[1:]
    if not len(height):
        raise DamagedLog("found no sample, expected rows of seconds,feet", row=head.row)
    del table
    if (time[1:] < time[:-1]).any():
        order = np.argsort(time, kind="stable")
        time, height = time[order], height[order]
    series = Series(time=time - time[0], altitude=height)
    return [Reading(stated, series=series, device="PerfectFlite StratoLogger"), *notes]


def _fits(names: Sequence[str]) -> bool:
    return tuple(names) == ("seconds", "feet")


def _decimal(log: bytes, head: Header) -> str:
    """The decimal mark of the first seconds, which always have decimals."""
    return "," if "," in "".join(first_lines(log, after=head.row, most=1)) else "."


def _began(log: bytes, head: Header) -> tuple[str, int]:
    """When the capture began according to the lines above the table, empty if they do not state it, and its row."""
    above = lines_of(decode(log[:HEAD]))[: head.row - 1]
    split = (line.replace('"', "").partition(head.separator) for line in above)
    rows = enumerate(split, start=1)
    return next(((value.strip(head.separator), row) for row, (name, _, value) in rows if name == "began"), ("", 0))


PARSER = Parser(
    "PerfectFlite StratoLogger live telemetry",
    recognises,
    read,
    signs=("StratoLogger live telemetry", "seconds", "feet"),
)

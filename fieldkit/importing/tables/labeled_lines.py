"""Lines of labeled values as a table: the text of a serial monitor, or JSON with an object for each sample.

`Alt: 123.4 m, Vel: 12.3 m/s, Time: 4200 ms`, `t=4.2 alt=123.4` and `{"time_ms": 4200, "altitude_m": 123.4}` become the
rows of a CSV table whose headers are the labels with their units. A record ends before a label that it already has, so
that its values may also be on several lines. A serial monitor or a logging library may write the time of day, or the
time since the start, in front of each line; it is the clock if no label is.
"""

import io
import re
from collections.abc import Iterator, Mapping
from functools import lru_cache

from fieldkit.importing.tables.headings import CLOCK_UNITS, QUANTITIES, channel, heading, unit_named
from fieldkit.importing.tables.text import MAX_TABLE_SIZE, blocks, first_lines

_PAIR = re.compile(
    r"([^\W\d_][\w .()/°²%\[\]-]{0,30}?)[\"']?[ \t]{0,3}[:=][ \t]{0,5}[\"']?"
    r"((?:\d{4}-\d\d-\d\d[T ])?\d{1,2}:\d\d:\d\d(?:[.,]\d{1,9})?Z?"
    r"|[+-]?(?:\d{1,20}(?:\.\d{0,20}|,\d{1,20})?|\.\d{1,20})(?:[eE][+-]?\d{1,3})?)(?![\d:.])"
    r"(?=[ \t]{0,2}([A-Za-zµμ°%²³/0-9]{0,8}))"
)
"""A label, a number or a time of day, and what may be its unit."""
_STAMP = re.compile(r"[\[(\s]{0,3}((?:\d{4}-\d\d-\d\d[T ])?\d{1,2}:\d\d:\d\d(?:[.,]\d{1,9})?)")
"""The time that a serial monitor writes in front of a line."""
_COUNTER_STAMP = re.compile(
    r"(?:\x1b\[[\d;]{0,8}m)?(?:[EWIDV] \((\d{1,12})\) [^\s:]{1,40}:"
    r"|\[[ \t]{0,12}(\d{1,12})\]\[[EWIDV]\](?:\[[^\]]{0,80}\])?(?:[ \t]\w{1,40}\(\):)?"
    r"|\[[ \t]{0,12}(\d{1,9}(?:\.\d{1,6})?)\])[ \t]{0,4}"
)
"""What a logging library writes in front of a line: the first two, of the ESP32, count milliseconds. Source: Logging
library, in the ESP-IDF Programming Guide; `esp32-hal-log.h` of Arduino-ESP32."""
_STAMP_NAME = "time of line"
_MIN_RECORDS, _LOOKED_AT = 10, 60
"""Fewest records that form a table, and the number of first lines that show whether there are any. [1]"""
_MIN_LABELED = 0.5
"""Smallest fraction of these lines that have a label, and of the records that have a time. [1]"""
_HEAD_SIZE, _MAX_LABELS = 65_536, 60
"""Size of the beginning, which has all labels [bytes], and most labels [1]."""

_Record = Mapping[str, str]


def labeled_table(log: bytes) -> bytes | None:
    """The labeled values of a text as CSV, a header and a row for each record; None if the text has too few, or
    is too large."""
    if len(log) > MAX_TABLE_SIZE or not _is_labeled(first_lines(log, most=_LOOKED_AT)):
        return None
    units: dict[str, str] = {}
    head = log[:_HEAD_SIZE]
    whole = head.rpartition(b"\n")[0] if len(log) > _HEAD_SIZE else head  # half a label may look like a unit
    first = list(_records(whole or head, units))
    timed = [name for name in units if channel(heading(name)) == "time"]
    timed = timed or [name for name in list(units)[:1] if heading(name).words in CLOCK_UNITS]
    names = [name for name in units if name != _STAMP_NAME or timed == [_STAMP_NAME]]
    with_time = sum(any(name in record for name in timed) for record in first)
    if len(first) < _MIN_RECORDS or len(names) < 2 or with_time < _MIN_LABELED * len(first):
        return None
    table = io.BytesIO()
    header = ",".join(f"{name} [{units[name]}]" if units[name] else name for name in names)
    table.write(f"{header}\n".encode())
    for record in _records(log, units):
        table.write(",".join([record.get(name, "") for name in names]).encode() + b"\n")
    return table.getvalue()


def _is_labeled(lines: list[str]) -> bool:
    """Whether most of the lines that are not empty have a label with a value."""
    filled = [line[:4096] for line in lines if line.strip()]
    return sum(_PAIR.search(line) is not None for line in filled) >= max(1.0, _MIN_LABELED * len(filled))


def _records(log: bytes, units: dict[str, str]) -> Iterator[_Record]:
    """The records of a text; `units` receives the unit of each label."""
    record: dict[str, str] = {}
    for _, lines in blocks(log):
        for line in lines:
            for name, value, unit in _pairs(line):
                if name in record:
                    yield record
                    record = {}
                if name in units or len(units) < _MAX_LABELS:
                    units[name] = units.get(name) or unit
                    record[name] = value
    if record:
        yield record


def _pairs(line: str) -> Iterator[tuple[str, str, str]]:
    """Labels, values and units in a line, after the time in front of it."""
    begin, stamp, before = *_stamp(line), ""
    for pair in _PAIR.finditer(line, begin):
        if stamp:
            yield _STAMP_NAME, *stamp
            stamp = None
        label, value, unit = pair.groups()
        name = " ".join(label.removeprefix(before).split())
        before = unit if _is_unit(unit) else ""
        if name:
            yield name, value.replace(",", "."), before


def _stamp(line: str) -> tuple[int, tuple[str, str] | None]:
    """Where a line begins after the time in front of it, and that time with its unit; None if there is none."""
    if day := _STAMP.match(line):
        return day.end(), (day[1].replace(",", "."), "")
    if counted := _COUNTER_STAMP.match(line):
        milliseconds, seconds = counted[1] or counted[2], counted[3]
        return counted.end(), (milliseconds or seconds, "ms" if milliseconds else "")
    return 0, None


@lru_cache(maxsize=1024)
def _is_unit(text: str) -> bool:
    return bool(text) and any(unit_named(quantity, text) is not None for quantity in set(QUANTITIES.values()))

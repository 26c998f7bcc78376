"""Flights in other shapes, as CSV: a flight per column, a table in Markdown, or the lines that an app mails of one."""

import csv
import io
import re
from collections.abc import Iterable, Sequence

from fieldkit.errors import DamagedLog
from fieldkit.flight import READOUTS
from fieldkit.importing.tables.flight_headings import beside_a_motor, role_of
from fieldkit.importing.tables.text import MAX_TABLE_SIZE, decode, first_lines, lines_of

_MOST_FIELDS, _MOST_FLIGHTS = 100, 500
"""Largest number of rows of a table with a flight per column, and of its flights. [1]"""
_RULE = re.compile(r"\s*\|?(?:\s*:?-{2,}:?\s*\|)+\s*(?::?-{2,}:?\s*)?")
"""The line below the header of a table in Markdown."""
_LINE = re.compile(
    r"\s{0,8}([^\W\d_][\w /-]{2,40}?)\s?[:=]\s{0,4}([+-]?(?:\d{1,3},\d{3}|\d{0,6})(?:\.\d{1,6})?)(?<=\d)"
    r"\s?([A-Za-z/]{1,8}\.?)\s*"
)
"""A label, a number and its unit on a line of their own."""
_DAY = re.compile(r"\s{0,8}date\s?:\s{0,4}(\S.{5,40})", re.IGNORECASE)
_LEAST_READOUTS = 3
"""Fewest labels of readouts that make a text the summary of a flight. [1]"""
_READOUT_NAMES = frozenset(column.name for column in READOUTS)


def reshaped(log: bytes) -> bytes | None:
    """A table of another shape as CSV; None if a text is none. Raises DamagedLog for bytes that are not text."""
    if len(log) > MAX_TABLE_SIZE:
        return None
    if any(_RULE.fullmatch(line[:4096]) for line in first_lines(log) if "|" in line):
        return _from_markdown(lines_of(decode(log)))
    return _turned(log) or _from_labels(log)


def _from_labels(log: bytes) -> bytes | None:
    """The flight of a mail or a page with a readout on each line, `Top Speed: 142 mph`; None if there are few."""
    text = first_lines(log, most=_MOST_FIELDS + 1)
    found = [match for line in text if (match := _LINE.fullmatch(line[:100]))]
    names = [f"{match[1]} ({match[3].rstrip('.')})" for match in found]
    fields = [role_of(name, strict=False).field for name in names]
    if len(text) > _MOST_FIELDS or len(set(fields) & _READOUT_NAMES) < _LEAST_READOUTS or len(set(names)) < len(names):
        return None
    names = [f"{field}_{match[3]}" if field else name for field, name, match in zip(fields, names, found, strict=True)]
    days = [match[1].strip() for line in text if (match := _DAY.fullmatch(line[:100]))]
    if len(days) == 1:
        return _csv([[*names, "date_time"], [*(match[2] for match in found), days[0]]])
    return _csv([names, [match[2] for match in found]])


def _from_markdown(lines: Sequence[str]) -> bytes | None:
    """The first table of a page: a header, a rule and the rows down to a line without a bar."""
    rule = next(place for place, line in enumerate(lines) if "|" in line and _RULE.fullmatch(line[:4096]))
    end = next((place for place in range(rule, len(lines)) if "|" not in lines[place]), len(lines))
    if not rule or "|" not in lines[rule - 1]:
        return None
    return _csv(_bars(line) for line in (lines[rule - 1], *lines[rule + 1 : end]))


def _bars(line: str) -> list[str]:
    """The cells between the bars of a line."""
    inner = line.strip().removeprefix("|").removesuffix("|")
    return [cell.replace("\\|", "|").strip(" *") for cell in re.split(r"(?<!\\)\|", inner)]


def _turned(log: bytes) -> bytes | None:
    """A table with a flight per column, whose first column has the names: a motor and a readout among them."""
    text = first_lines(log, most=_MOST_FIELDS + 1)
    if len(text) > _MOST_FIELDS or len(log) > _MOST_FIELDS * 4096:
        return None
    for separator in (",", ";", "\t"):
        try:
            rows = [row for row in csv.reader(text, delimiter=separator) if any(cell.strip() for cell in row)]
        except csv.Error:
            continue
        width = max(map(len, rows), default=0)
        rows = [row for row in rows if sum(bool(cell.strip()) for cell in row) > 1]
        if 2 < width <= _MOST_FLIGHTS and _names_flights([row[0] for row in rows]) and not _names_flights(rows[0]):
            columns = zip(*([*row, *[""] * (width - len(row))] for row in rows), strict=True)
            return _csv(row for row in columns if any(cell.strip() for cell in row))
    return None


def _names_flights(names: Sequence[str]) -> bool:
    """Whether names are those of a table of flights: a motor and a readout are among them."""
    try:
        known = {role_of(name, strict=False).field for name in beside_a_motor(names)}
    except DamagedLog:
        return False
    return "motor" in known and bool(known & _READOUT_NAMES)


def _csv(rows: Iterable[Sequence[str]]) -> bytes:
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(rows)
    return table.getvalue().encode()

"""Flights in fieldkit's own JSON: the output of `export` to a `.json` file and of `flights --json`.

One document, `{"flights": [{...}, ...]}`, with the columns of the flight table. Numbers are in the unit in the column's
name, `null` is "not recorded"; unknown columns are kept. Standard deviations of readouts are numbers, or text in files
from older versions of fieldkit. A flight's row is its position in the list, counted from 1.
"""

import json
import re
import sys
from collections.abc import Mapping
from math import isfinite

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import COLUMNS, LOGGED, MEASURED, TEXT_COLUMNS, Column, read_date, read_tags
from fieldkit.flight.readout import read_sd, read_source
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.text import check_count, decode, decode_whole, shown

_LIST = re.compile(r'"flights"\s*:\s*\[')
HEADERS = {column.header: column for column in COLUMNS + LOGGED}
SDS = {column.sd_header: column for column in MEASURED}
SOURCES = {column.source_header: column for column in MEASURED}


def recognises(head: bytes) -> bool:
    text = decode(head).lstrip()
    return text.startswith("{") and _LIST.search(text) is not None


def read(log: bytes) -> list[Parsed]:
    try:
        document = json.loads(decode_whole(log), parse_float=_finite)
    except (ValueError, RecursionError) as error:
        line = error.lineno if isinstance(error, json.JSONDecodeError) else None
        raise DamagedLog("found no complete JSON document, expected one that export wrote", row=line) from error
    flights = document.get("flights") if isinstance(document, dict) else None
    if not isinstance(flights, list):
        raise DamagedLog('found no list of flights, expected {"flights": [...]}')
    check_count(len(flights))
    found = [_reading(row, flight) for row, flight in enumerate(flights, start=1)]
    return found or [Note("found a list without flights")]


def _finite(text: str) -> float | str:
    """A number, or its text if no float is as large: the message then shows what the file has."""
    return number if isfinite(number := float(text)) else text


def _reading(row: int, flight: object) -> Parsed:
    """The flight of one entry, or its error."""
    if not isinstance(flight, dict):
        return DamagedLog(f"found {shown(str(flight))}, expected a flight in braces", row=row)
    stated: dict[str, object] = {}
    extra: dict[str, str] = {}
    sd: dict[str, float] = {}
    source: dict[str, str] = {}
    for name, value in flight.items():
        try:
            if name in HEADERS:
                stated[HEADERS[name].name] = _number(name, value)
            elif name in SDS or name in SOURCES:
                if value not in (None, ""):
                    _beside(name, value, flight, sd, source)
            elif name in TEXT_COLUMNS:
                stated[name] = _text(name, value)
            elif value not in (None, ""):
                extra[name] = value if isinstance(value, str) else json.dumps(value)
        except BadValue as error:
            return DamagedLog(str(error), row=row, column=name)
    columns = {column.name: header for header, column in HEADERS.items()}
    annotations = {part: values for part, values in (("sd", sd), ("source", source)) if values}
    return Reading(stated | annotations, extra, columns, row)


def _beside(
    name: str, value: object, flight: Mapping[str, object], sd: dict[str, float], source: dict[str, str]
) -> None:
    """Record the standard deviation or the source of a readout. Raises BadValue."""
    column: Column = SDS.get(name) or SOURCES[name]
    if flight.get(column.header) is None:
        raise BadValue(f"found {shown(str(value))} beside an empty {column.header}, expected none")
    if name in SOURCES:
        source[column.name] = read_source(str(value))
    elif isinstance(value, bool) or not isinstance(value, int | float | str):
        raise BadValue(f"found {shown(str(value))}, expected a number or null")
    else:
        sd[column.name] = read_sd(column.name, str(value))


def _number(name: str, value: object) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise BadValue(f"found {shown(str(value))}, expected a number or null")
    column = HEADERS[name]
    return units.unit(column.quantity, column.unit).to_si(float(value))


def _text(name: str, value: object) -> object:
    if value is None:
        value = ""
    if not isinstance(value, str):
        raise BadValue(f"found {shown(str(value))}, expected text")
    if name == "tags":
        return read_tags(value)
    return read_date(value) if name == "date_time" else value


PARSER = Parser("fieldkit's own flights (JSON)", recognises, read, signs=('"flights":', "flight_id"))

"""Convert flights to rows and back; no other package sees a row."""

import math
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, datetime
from types import MappingProxyType
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, COLUMNS, FIELDS, LOGGED, MEASURED, SOURCES, Flight
from fieldkit.flight.further_units import amounts
from fieldkit.flight.storable import check_texts
from fieldkit.ledger.records import FlightSummary

Row = dict[str, Any]
"""Column name to a JSON-compatible value."""


class DamagedRow(ValueError):
    """A row that fieldkit did not write: the file was changed or damaged."""


def known_names(names: Iterable[Any]) -> list[str]:
    """The names that a query selects without their rows. Raises DamagedRow if one is not text."""
    found = list(names)
    for name in found:
        if not isinstance(name, str):
            raise DamagedRow(f"found the name {str(name)[:40]!r}, expected text")
    return found


READOUT_COLUMNS: Mapping[str, str] = MappingProxyType({"sd": "readout_sd", "source": "readout_source"})
"""The fields that accompany each readout, and their columns; the row's own `source` is a file."""
DIRECT_FIELDS = tuple(name for name in FIELDS if name not in (*READOUT_COLUMNS, "tags"))
"""Fields of a flight that a row stores under the same name."""


def row_of(flight: Flight) -> Row:
    """A flight as one JSON-compatible row, tags included. Raises BadValue for values that a ledger cannot store."""
    check_texts(flight)
    row: Row = {name: getattr(flight, name) for name in DIRECT_FIELDS}
    row["date_time"] = flight.date_time.isoformat() if flight.date_time else None
    row["tags"] = list(flight.tags)
    row["extra"] = flight.extra if isinstance(flight.extra, dict) else dict(flight.extra)
    for column in COLUMNS + LOGGED:
        row[column.name] = _finite(column.header, flight.number(column.name))
    _check_beside(flight)
    return row | {column: dict(getattr(flight, part)) or None for part, column in READOUT_COLUMNS.items()}


def without_empty_numbers(row: Row) -> Row:
    """A flight's row without the numbers that it lacks, which are most, and their uncertainties: a quarter of the
    memory and of the journal."""
    numbers = {column.name for column in COLUMNS + LOGGED} | {*READOUT_COLUMNS.values()}
    return {name: value for name, value in row.items() if value is not None or name not in numbers}


def flight_of(row: Mapping[str, Any], tags: Sequence[str]) -> Flight:
    """The flight in a row of `flights` and its tags; columns newer than the row count as not recorded."""
    values = {name: row[name] for name in DIRECT_FIELDS if name in row}
    moment = values.pop("date_time")
    for part, column in READOUT_COLUMNS.items():
        annotated = row.get(column) or {}
        values[part] = {name: value for name, value in annotated.items() if values.get(name) is not None}
    return Flight(**values, tags=tuple(tags), date_time=datetime.fromisoformat(moment) if moment else None)


def summary_of(name: str, row: Mapping[str, Any]) -> FlightSummary:
    """The list entry of the flight in a row of `flights` and its tags, with this id."""
    day = date.fromisoformat(row["date_time"][:10]) if row["date_time"] else None
    return FlightSummary(name, day, row["rocket"], row["config"], row["motor"], row["apogee"], tuple(row["tags"]))


def same(one: Flight, other: Flight) -> bool:
    """Whether two records are equal up to rounding in unit conversions."""
    return not differences(one, other)


def differences(one: Flight, other: Flight) -> list[str]:
    """Names of the fields in which two records differ by more than rounding."""
    return [name for name in FIELDS if not _equal(_value(one, name), _value(other, name))]


def merged(now: Flight, was: Flight, new: Flight) -> Flight:
    """A flight with the changes from `was` to `new`, except in fields that differ from `was` already."""
    changed = {name for name in FIELDS if getattr(now, name) != getattr(was, name)}
    changes: dict[str, Any] = {}
    for name in FIELDS:
        stored, before, after = (getattr(one, name) for one in (now, was, new))
        if isinstance(stored, Mapping):
            free = {key for key in {**before, **after} if stored.get(key) == before.get(key)} - changed
            kept = {key: value for key, value in stored.items() if key not in free}
            changes[name] = kept | {key: value for key, value in after.items() if key in free}
        elif name not in changed:
            changes[name] = after
    return now.with_changes(**changes)


def agrees(flight: Flight, given: Mapping[str, object]) -> bool:
    """Whether a record has the given values, by field; it may have further extra columns, standard deviations and
    sources."""
    return all(
        _holds(_value(flight, name), amounts(value) if isinstance(value, Mapping) and name == "extra" else value)
        for name, value in given.items()
    )


def _value(flight: Flight, name: str) -> Any:
    """A field to be compared; further columns whatever their unit."""
    return amounts(flight.extra) if name == "extra" else getattr(flight, name)


def _holds(one: Any, given: Any) -> bool:
    if isinstance(one, Mapping) and isinstance(given, Mapping):
        return all(name in one and _equal(one[name], value) for name, value in given.items())
    return _equal(one, given)


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_equal(one[name], other[name]) for name in one)
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)
    return bool(one == other)


def _finite(name: str, value: float | None) -> float | None:
    if value is None:
        return None
    if not math.isfinite(value):
        raise BadValue(f"{name}: found {value}, expected a finite number or nothing")
    return float(value)


def _check_beside(flight: Flight) -> None:
    """Raise BadValue for a standard deviation or a source that no readout of the flight can have."""
    known = flight.readouts()
    for name in (*flight.sd, *flight.source):
        if name not in known:
            header = BY_NAME[name].header if name in BY_NAME else name
            raise BadValue(f"{header}: found a standard deviation or a source without a readout")
    for column in MEASURED:
        sd, source = flight.sd.get(column.name, 1.0), flight.source.get(column.name, "typed")
        if not (math.isfinite(sd) and sd > 0):
            raise BadValue(f"{column.sd_header}: found {sd}, expected a number above 0 or nothing")
        if source not in SOURCES:
            raise BadValue(f"{column.source_header}: found {source!r}, expected one of {', '.join(SOURCES)}")

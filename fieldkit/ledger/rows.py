"""Flights as rows and rows as flights; nothing above this package sees a row."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight import COLUMNS, FIELDS, Flight

Row = dict[str, Any]
"""Column name to a value that JSON can hold."""


class DamagedRow(ValueError):
    """A row that no fieldkit wrote: what is on the disc has changed."""


TEXTS = ("rocket", "flight_id", "config", "motor", "site", "notes", "log")


def row_of(flight: Flight) -> Row:
    """A flight as one JSON-ready row, tags included. Raises BadValue for what a ledger cannot keep."""
    for name in TEXTS:
        _storable(name, getattr(flight, name))
    for text in (*flight.tags, *flight.extra, *flight.extra.values()):
        _storable("tags and extra columns", text)
    row: Row = {name: getattr(flight, name) for name in FIELDS}
    row["date_time"] = flight.date_time.isoformat() if flight.date_time else None
    row["tags"] = list(flight.tags)
    row["extra"] = dict(flight.extra)
    for column in COLUMNS:
        row[column.name] = _finite(column.header, flight.number(column.name))
    return row


def flight_of(row: Mapping[str, Any], tags: Sequence[str]) -> Flight:
    """The flight that a row of `flights` and its tags hold; a column younger than the row is not recorded."""
    values = {name: row[name] for name in FIELDS if name != "tags" and name in row}
    moment = values.pop("date_time")
    return Flight(**values, tags=tuple(tags), date_time=datetime.fromisoformat(moment) if moment else None)


def same(one: Flight, other: Flight) -> bool:
    """Whether two records tell of the same flight, up to the rounding of units there and back."""
    return all(_alike(getattr(one, name), getattr(other, name)) for name in FIELDS)


def differences(one: Flight, other: Flight) -> list[str]:
    """Names of the fields in which two records differ by more than rounding."""
    return [name for name in FIELDS if not _alike(getattr(one, name), getattr(other, name))]


def agrees(flight: Flight, given: Mapping[str, object]) -> bool:
    """Whether a record holds what is given, by field; of extra columns it may hold more."""
    extra = given.get("extra", {})
    columns = extra.items() if isinstance(extra, Mapping) else ()
    fields = all(_alike(getattr(flight, name), value) for name, value in given.items() if name != "extra")
    return fields and all(flight.extra.get(name) == value for name, value in columns)


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)
    return bool(one == other)


def _finite(name: str, value: float | None) -> float | None:
    if value is None:
        return None
    if not math.isfinite(value):
        raise BadValue(f"{name}: found {value}, expected a finite number or nothing")
    return float(value)


def _storable(name: str, text: str) -> None:
    if "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise BadValue(f"{name}: found {text!r}, expected text without NUL and broken characters")

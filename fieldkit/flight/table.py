"""Convert a flight to a row of the flight table, and parse its texts."""

from collections.abc import Iterable
from datetime import datetime

from fieldkit.errors import BadValue
from fieldkit.flight.columns import COLUMNS, CONDITIONS, LOGGED, MEASURED, READOUTS, SETUP
from fieldkit.flight.flight import Flight
from fieldkit.flight.readout import render_sd

TEXT_COLUMNS = ("flight_id", "date_time", "rocket", "config", "motor", "site", "tags", "notes", "log")
"""The columns of a flight table that are not numbers."""


def read_date(text: str) -> datetime | None:
    """Parse local lift-off time, None for an empty text. Raises BadValue.

    An offset from UTC is dropped, because local time at the field is meant.
    """
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None) if text else None
    except ValueError:
        found = f"found {text[:40]!r}, expected a date such as 2026-05-01 or 2026-05-01T10:30"
        raise BadValue(found) from None


def table_row(flight: Flight) -> dict[str, str]:
    """A flight as a row of the flight table: header to text, an empty text for "not recorded".

    Standard deviations and sources of readouts, and quantities computed from a log, have a cell if recorded.
    """
    row = {name: str(getattr(flight, name)) for name in TEXT_COLUMNS if name not in ("date_time", "tags")}
    row["date_time"] = flight.date_time.isoformat() if flight.date_time else ""
    row["tags"] = ";".join(flight.tags)
    for column in COLUMNS:
        value = flight.number(column.name)
        row[column.header] = "" if value is None else column.render(value)
    for column in LOGGED:
        if (value := flight.number(column.name)) is not None:
            row[column.header] = column.render(value)
    for column in MEASURED:
        if column.name in flight.sd:
            row[column.sd_header] = render_sd(column.name, flight.sd[column.name])
        if column.name in flight.source:
            row[column.source_header] = flight.source[column.name]
    return row | dict(flight.extra)


def table_headers(flights: Iterable[Flight]) -> list[str]:
    """The headers of a flight table with all of these flights, extra columns last.

    Standard deviations and sources follow their readouts if any flight has them; so do quantities computed from a log.
    """
    flights = list(flights)
    extra = dict.fromkeys(name for flight in flights for name in flight.extra)
    known = [*TEXT_COLUMNS[:5], *(c.header for c in SETUP), "site", *(c.header for c in CONDITIONS)]
    for column in MEASURED:
        known += [column.header] * (
            column in READOUTS or any(flight.number(column.name) is not None for flight in flights)
        )
        known += [column.sd_header] * any(column.name in flight.sd for flight in flights)
        known += [column.source_header] * any(column.name in flight.source for flight in flights)
    return list(dict.fromkeys([*known, "tags", "notes", "log", *extra]))

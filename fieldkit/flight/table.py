"""A flight as a row of the flight table, and what is read back out of its texts."""

from collections.abc import Iterable
from datetime import datetime

from fieldkit.errors import BadValue
from fieldkit.flight.columns import COLUMNS, CONDITIONS, LOGGED, MEASURED, READOUTS, SETUP
from fieldkit.flight.flight import Flight
from fieldkit.flight.readout import render_sd

MOTOR_TEMPERATURE = "motor_temperature_c"
"""Extra column of a planned flight: how warm the motor is, for a safety check alone."""
TEXT_COLUMNS = ("flight_id", "date_time", "rocket", "config", "motor", "site", "tags", "notes", "log")
"""The columns of a flight table that are not numbers."""


def read_date(text: str) -> datetime | None:
    """Local lift-off time, None for an empty text. Raises BadValue.

    An offset from UTC is left off, for the clock at the field is what is meant.
    """
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None) if text else None
    except ValueError:
        found = f"found {text[:40]!r}, expected a date such as 2026-05-01 or 2026-05-01T10:30"
        raise BadValue(found) from None


def table_row(flight: Flight) -> dict[str, str]:
    """A flight as a row of the flight table: header to text, an empty text for "not recorded".

    Standard deviations and sources of readouts, and what only a log shows, have a cell if they are recorded.
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
    """The headers of a flight table that holds all of these flights, extra columns last.

    Beside a readout stand its standard deviation and its source, if they are recorded of any flight; so do the
    figures that only a log shows.
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

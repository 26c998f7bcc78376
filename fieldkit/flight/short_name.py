"""What a flight is called in a text."""

import re

from fieldkit.flight.flight import Flight

_DERIVED_ID = re.compile(r"(?:flight|\d{4}-\d\d-\d\d)-[0-9a-f]{10}")
"""A flight_id made by `fieldkit.importing.to_flights.derived_id`."""


def has_derived_id(flight: Flight) -> bool:
    """Whether the flight_id was derived from the flight, so that it names nothing to a person."""
    return _DERIVED_ID.fullmatch(flight.flight_id) is not None


def short_name(flight: Flight) -> str:
    """What a person calls a flight: its flight_id, or the date, time and motor if the flight_id was derived. Midnight
    means that the time is unknown."""
    if not has_derived_id(flight):
        return flight.flight_id
    when = "" if flight.date_time is None else f"{flight.date_time:%Y-%m-%d %H:%M}".removesuffix(" 00:00")
    return " ".join(part for part in (when, flight.motor) if part) or flight.flight_id


def flight_label(id: str, noun: str = "flight") -> str:
    """A flight in a sentence: `flight 13`, or `flight-4f3b09c1d2` alone if its id was derived without a date."""
    return id if id.startswith("flight-") and _DERIVED_ID.fullmatch(id) else f"{noun} {id}"

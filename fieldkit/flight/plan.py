"""What a planned flight takes from earlier flights."""

from dataclasses import replace
from datetime import timedelta

from fieldkit.flight.flight import Flight

STAGED_TAG = "staged"
"""The tag of a flight on several stages, whose dry mass may include boosters that another plan does not carry."""


def repeated(flight: Flight) -> Flight:
    """A plan to repeat the flight a week later, or at the same time if there is no later date."""
    name = f"{flight.flight_id} again"  # a plan needs an id of its own
    plan = flight.unflown(flight_id=name, sd={}, source={}, tags=())
    try:
        return replace(plan, date_time=flight.date_time + timedelta(days=7) if flight.date_time else None)
    except OverflowError:
        return replace(plan, date_time=flight.date_time)

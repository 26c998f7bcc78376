"""A planned flight: the check of its further columns, and what it takes from an earlier flight."""

from dataclasses import replace
from datetime import timedelta

from fieldkit.flight.flight import Flight

STAGED_TAG = "staged"
"""The tag of a flight on several stages, whose dry mass may include boosters that another plan does not carry."""


def check_plan(plan: Flight) -> None:
    """Raise BadValue for a further column of a plan that has a meaning and cannot be read, or is beyond its limits."""
    plan.columns.check()


def repeated(flight: Flight) -> Flight:
    """A plan to repeat the flight a week later, or at the same time if there is no later date."""
    name = f"{flight.flight_id} again"  # a plan needs an id of its own
    plan = flight.unflown(flight_id=name, sd={}, source={}, tags=())
    try:
        return replace(plan, date_time=flight.date_time + timedelta(days=7) if flight.date_time else None)
    except OverflowError:
        return replace(plan, date_time=flight.date_time)

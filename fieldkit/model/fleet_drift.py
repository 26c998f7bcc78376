"""The drift of a flyer's fleet: how the mean of a quantity over all rockets changes from year to year.

It is continuous, with a rate for each year, and the rates of different years are independent: a random walk, known best
where many flights were flown. Real flights show one for the ratio of flown to recorded mass: rockets get heavier by
repairs, paint and fittings, and the recorded mass stays.
"""

from collections.abc import Iterable, Sequence
from datetime import date, datetime

import numpy as np

from fieldkit.flight import Flight
from fieldkit.shapes import Array, Float

Period = tuple[date, date]
"""The first and the last day of a fleet's flights."""
DAYS_PER_YEAR = 365.2425
"""Mean length of a year of the Gregorian calendar. [d]"""
MAX_YEARS = 30
"""Years for which a drift is followed, so that a wrong date adds no thousand terms; later flights count as flown then.
[year]"""


def period_of(flights: Iterable[Flight]) -> Period | None:
    """The first and the last day of some flights; None without a dated one."""
    return _period([flight.date_time for flight in flights])


def _period(times: Sequence[datetime | None]) -> Period | None:
    days = [time.date() for time in times if time]
    return (min(days), max(days)) if days else None


def years(times: Sequence[datetime | None], flown: int, period: Period | None) -> Float[Array, "flight"]:
    """Time of each flight since the first one of the fleet, from the times of lift-off, None if unknown. [year]

    `period` is the fleet's, by default that of these flights. A flight without a date has that of the flight before it;
    a planned one, after the first `flown`, is at the end of the period at the earliest. Zero if no flight has a date;
    between 0 and `MAX_YEARS`.

    Derivation: days in years of the Gregorian calendar.
    """
    first, last = period or _period(times[:flown]) or _period(times) or (date.min, date.min)
    days, before = [], first
    for time in times[:flown]:
        before = time.date() if time else before
        days.append(before)
    days += [time.date() if time else max(before, last) for time in times[flown:]]
    return np.clip([(day - first).days / DAYS_PER_YEAR for day in days], 0.0, MAX_YEARS)


def years_passed(time: Float[Array, "flight"]) -> Float[Array, "year flight"]:
    """How much of each year of the fleet had passed at some times since its first flight [year]: 0 before it, 1 after
    it. [1]

    Derivation: the integral, until each time, of a function that is 1 in one year and 0 in all others.
    """
    return np.clip(time - np.arange(np.ceil(time.max(initial=0.0)))[:, None], 0.0, 1.0)

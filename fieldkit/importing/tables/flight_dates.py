"""Dates in tables of flights by others, in any usual spelling; a column proves whether day or month comes first."""

import re
from collections.abc import Iterable
from datetime import datetime, time

from fieldkit.importing.tables.flight_headings import plain

TIME_NAMES = ("time", "launch_time", "time_of_day", "liftoff_time", "time_of_launch", "uhrzeit", "hora", "heure")
"""Names of a column with the time of day of a launch, beside one with its date."""
_NUMBERS = re.compile(r"(\d{1,2})([./-])(\d{1,2})\2(\d{4}|\d{2})(?:,?[ T]+(\S.*))?")
_YEAR_FIRST = re.compile(r"(\d{4})([./-])(\d{1,2})\2(\d{1,2})\.?(?:,?[ T]+(\S.*))?")
_CENTURY_ENDS = 70
"""Years of two digits from here on are of the 20th century, as in most programs. [1]"""
_WITH_TIME = re.compile(r"(.*\d{4}),?(?: at)? (\d{1,2}[: ].*)")
_NAMED_MONTH = ("%d %B %Y", "%d %b %Y", "%d %b %y", "%B %d %Y", "%b %d %Y", "%d-%b-%Y", "%d-%b-%y")
_TIMES = ("%H:%M", "%H:%M:%S", "%H:%M:%S.%f", "%H:%M UHR", "%I:%M %p", "%I:%M:%S %p", "%I:%M%p", "%I %p")


def time_of_day(text: str) -> time | None:
    """A time such as `14:05`, `2:05 PM` or `14:05:30`, or None."""
    return next((moment.time() for form in _TIMES if (moment := _parsed(text.strip().upper(), form))), None)


def is_own_date(spelled: str) -> bool:
    """Whether a header is fieldkit's own name for a date."""
    return plain(spelled).startswith("date_time")


def is_day_first(texts: Iterable[str]) -> bool | None:
    """Whether the day precedes the month in a column of dates such as `13/6/2024`; None if no date proves it, or two
    prove the opposite."""
    pairs = [(int(m[1]), int(m[3])) for text in texts if (m := _NUMBERS.fullmatch(text.strip())) and m[2] != "."]
    orders = {first > 12 for first, second in pairs if (first > 12) != (second > 12)}
    return orders.pop() if len(orders) == 1 else None


def add_time_of_day(stated: dict[str, object], extra: dict[str, str]) -> None:
    """Complete a date by the time in a column of its own."""
    day = stated.get("date_time")
    name = next((name for name in extra if plain(name) in TIME_NAMES), "")
    if isinstance(day, datetime) and day.time() == time() and (moment := time_of_day(extra.get(name, ""))):
        stated["date_time"] = datetime.combine(day, moment)
        del extra[name]


def date_of(text: str, day_first: bool | None) -> datetime | None:
    """The date and time of a cell in ISO 8601, as numbers or with the month's name; None if it is not unambiguous."""
    text = " ".join(text.split())
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        pass
    if match := _NUMBERS.fullmatch(text):
        return _from_numbers(match, day_first)
    if match := _YEAR_FIRST.fullmatch(text):
        return _at(int(match[1]), int(match[3]), int(match[4]), match[5])
    if match := _WITH_TIME.fullmatch(text):
        return _at_named(match[1], match[2])
    return _at_named(text, "")


def _at_named(text: str, moment: str) -> datetime | None:
    """A date such as `Sat, June 13th, 2024` with its time of day."""
    plain = re.sub(r"^(?:mon|tues?|wed(?:nes)?|thu(?:rs)?|fri|sat(?:ur)?|sun)(?:day)?,? ", "", text.lower())
    plain = re.sub(r"(?<=\d)(?:st|nd|rd|th)\b", "", plain.replace(",", "").replace(".", " ").replace("sept ", "sep "))
    plain = " ".join(plain.split())
    day = next((day for form in _NAMED_MONTH if (day := _parsed(plain, form))), None)
    return day and _at(day.year, day.month, day.day, moment)


def _at(year: int, month: int, day: int, moment: str | None) -> datetime | None:
    """A date and a time of day, which may be empty; None if either is not one."""
    of_day = time_of_day(moment) if moment else time()
    try:
        return None if of_day is None else datetime.combine(datetime(year, month, day), of_day)
    except ValueError:
        return None


def _from_numbers(match: re.Match[str], day_first: bool | None) -> datetime | None:
    """A date such as `13.6.2024 9:30`: points follow the day; around a slash only the numbers or the column decide."""
    first, second, year = int(match[1]), int(match[3]), int(match[4])
    ordered = _precedes(first, second, match[2], day_first)
    if ordered is None:
        return None
    day, month = (first, second) if ordered else (second, first)
    century = 2000 if year < _CENTURY_ENDS else 1900 if year < 100 else 0
    return _at(century + year, month, day, match[5])


def _precedes(first: int, second: int, mark: str, day_first: bool | None) -> bool | None:
    """Whether the first of two numbers is the day; None if that is unknown."""
    if first > 12 or second > 12:
        return first > 12
    return True if mark == "." or first == second else day_first


def _parsed(text: str, form: str) -> datetime | None:
    try:
        return datetime.strptime(text, form)
    except ValueError:
        return None

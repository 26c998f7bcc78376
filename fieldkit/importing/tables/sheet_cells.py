"""Cells of a spreadsheet as CSV text: numbers with a point and all digits, dates and times in ISO 8601.

Times have milliseconds if they have any, because a log may have several rows in a second.
"""

import math
from datetime import datetime, time, timedelta


def number_text(number: float) -> str:
    """A number of any unit, integers without decimals; empty for NaN. [unit of the cell]"""
    if math.isnan(number):
        return ""
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else str(number)


def duration_text(seconds: float) -> str:
    """A duration as `H:MM:SS`. `seconds` is in [s]."""
    whole, thousandths = divmod(round(seconds * 1000), 1000)
    minutes, second = divmod(whole, 60)
    return f"{minutes // 60}:{minutes % 60:02}:{second:02}" + (f".{thousandths:03}" if thousandths else "")


def moment_text(moment: datetime) -> str:
    """A date and time, to the nearest millisecond; at midnight a date."""
    moment += timedelta(microseconds=500)
    return (
        moment.date().isoformat()
        if _to_milliseconds(moment.time()) == "00:00:00"
        else (f"{moment.date().isoformat()}T{_to_milliseconds(moment.time())}")
    )


def clock_text(moment: datetime) -> str:
    """The time of day of a moment, to the nearest millisecond."""
    return _to_milliseconds((moment + timedelta(microseconds=500)).time())


def _to_milliseconds(time_of_day: time) -> str:
    return time_of_day.isoformat(timespec="milliseconds" if time_of_day.microsecond >= 1000 else "seconds")

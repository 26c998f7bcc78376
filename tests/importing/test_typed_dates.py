"""Dates and times as they are typed at the field."""

from datetime import date, datetime, timedelta

import pytest

from fieldkit.errors import BadValue
from fieldkit.importing.manual_entry import read_answer


@pytest.mark.parametrize(
    ("text", "ago", "time"),
    [
        ("10:30", 0, "10:30"),
        ("9:05", 0, "09:05"),
        ("Today 14:00", 0, "14:00"),
        ("yesterday", 1, "00:00"),
        ("yesterday  9:05", 1, "09:05"),
    ],
)
def test_a_time_is_of_today_unless_a_day_is_typed(text: str, ago: int, time: str) -> None:
    before = date.today()
    read = read_answer("date_time", text)
    days = {day - timedelta(days=ago) for day in (before, date.today())}  # midnight may have passed
    assert read in [datetime.fromisoformat(f"{day}T{time}") for day in days]


def test_a_day_that_is_typed_is_taken() -> None:
    assert read_answer("date_time", "2026-05-01 10:30") == datetime(2026, 5, 1, 10, 30)


@pytest.mark.parametrize("text", ["25:00", "10:3", "10:60", "today10:30", "5/1/2026", "yesterday 24:00"])
def test_an_unreadable_date_is_quoted_as_typed(text: str) -> None:
    with pytest.raises(BadValue, match=f"found '{text}'"):
        read_answer("date_time", text)

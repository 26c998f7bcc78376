"""Dates and times as they are typed at the field."""

from datetime import date, datetime, timedelta

import pytest

from fieldkit.errors import BadValue
from fieldkit.importing.manual_entry import read_answer

TODAY = date.today()


@pytest.mark.parametrize(
    ("text", "day", "time"),
    [
        ("10:30", TODAY, "10:30"),
        ("9:05", TODAY, "09:05"),
        ("Today 14:00", TODAY, "14:00"),
        ("yesterday", TODAY - timedelta(days=1), "00:00"),
        ("yesterday  9:05", TODAY - timedelta(days=1), "09:05"),
        ("2026-05-01 10:30", date(2026, 5, 1), "10:30"),
    ],
)
def test_a_time_is_of_today_unless_a_day_is_typed(text: str, day: date, time: str) -> None:
    assert read_answer("date_time", text) == datetime.fromisoformat(f"{day}T{time}")


@pytest.mark.parametrize("text", ["25:00", "10:3", "10:60", "today10:30", "5/1/2026", "yesterday 24:00"])
def test_an_unreadable_date_is_quoted_as_typed(text: str) -> None:
    with pytest.raises(BadValue, match=f"found '{text}'"):
        read_answer("date_time", text)

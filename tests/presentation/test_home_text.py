"""The last flight on the Home page is named as a person would name it."""

from datetime import datetime

import pytest

from fieldkit.flight import Flight
from fieldkit.presentation.home_text import flown_title
from fieldkit.services.listed_flights import ListedFlight

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("id", "title"),
    [
        ("12", "12 · Astra B · F39 · 04-18 14:35"),
        ("2026-04-18-4b624ccb9a", "Astra B · F39 · 04-18 14:35"),
        ("flight-dd2afbb08f", "Astra B · F39 · 04-18 14:35"),
    ],
)
def test_an_id_derived_from_a_flight_is_not_part_of_its_title(id: str, title: str) -> None:
    flight = Flight(id, "Astra", "B", "F39", datetime(2026, 4, 18, 14, 35))
    assert flown_title(ListedFlight(id, flight, None)) == title

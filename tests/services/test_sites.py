"""Launch sites have the elevation of their latest flights, and the rockets flown latest are known, without reading them
all."""

from datetime import datetime
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.ledger.records import Contents
from fieldkit.services.sites import sites
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.setting_card import of_setting

pytestmark = pytest.mark.fast
FLOWN = [
    ("1", "Lark", datetime(2026, 5, 2), "Moor", 440.0),
    ("2", "Wren", datetime(2026, 5, 1), "Moor", 430.0),
    ("3", "Kite", None, "Fen", 3.0),
    ("4", "Wren", datetime(2026, 5, 3), "Moor", None),
    ("5", "Lark", None, "Heath", None),
]


def test_a_site_has_the_elevation_of_its_latest_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(
            [Flight(id, rocket, date_time=at, site=site, site_elevation=up) for id, rocket, at, site, up in FLOWN]
        )
        flights = ledger.flights()
        monkeypatch.setattr(Ledger, "flights", None)
        assert {one.name: one.elevation for one in sites(ledger)} == {"Heath": None, "Moor": 440.0, "Fen": 3.0}
        latest = {one.site: one.site_elevation for one in flights if one.site_elevation is not None}
        assert ledger.elevations() == latest
        assert ledger.rockets_flown() == ["Wren", "Lark", "Kite"]


def test_a_ledger_counts_its_flights_without_reading_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    days = [datetime(2026, 5, day, 23) for day in (3, 2, 1)]
    flown = [
        Flight("1", "Lark", date_time=days[0], log="a.csv"),
        Flight("2", "Lark", date_time=days[2]),
        Flight("1", "Wren", date_time=days[1]),
        Flight("2", "Wren", log="b.csv"),
    ]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert ledger.contents() == Contents(0, 0, None, 0)
        ledger.add(flown)
        monkeypatch.setattr(Ledger, "flights", None)
        assert ledger.contents() == Contents(4, 2, (days[2].date(), days[0].date()), 2)
        card = of_setting("ledger", cast(Resources, SimpleNamespace(ledger=ledger, settings=None, where="")), ())
    assert "4 of 2 rockets" in str(card.blocks)


def test_the_first_day_is_that_of_a_flight_with_an_apogee(tmp_path: Path) -> None:
    days = [datetime(2026, 5, day, 10) for day in (3, 2, 1)]
    whole = Flight("1", "Lark", motor="F24-4W", dry_mass=0.3, apogee=200.0)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert ledger.first_day() is None
        ledger.add([whole.with_changes(flight_id="undated")])
        assert ledger.first_day() is None
        ledger.add([whole.with_changes(flight_id=f"{at:%d}", date_time=at) for at in days[:2]])
        ledger.add([whole.with_changes(flight_id="planned", date_time=days[2], apogee=None, notes="rained off")])
        assert ledger.first_day() == days[1].date()

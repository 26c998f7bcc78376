"""What a flyer needs on the way to a contest or a certification flight, in the app, by keys alone."""

import shutil
from datetime import datetime
from pathlib import Path
from typing import cast

import pytest

from fieldkit.ledger import Ledger
from fieldkit.services.imports import bring_in
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.widgets.table import Table
from tests.pressing import ROOT, at_home, opened, press, text_of, typed

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "field"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return at_home(tmp_path, monkeypatch)


async def test_saved_weather_fills_in_flights_on_the_import_page_and_is_undone(file: Path) -> None:
    shutil.copy(ROOT / "docs" / "example-weather.csv", ".")
    with Ledger.open(file) as ledger:
        first = ledger.flights()[0]
        (id,) = ledger.ids([first])
        ledger.edit_each(
            {id: {"date_time": datetime(2026, 5, 16, 14, 30), "site": "Moor", "temperature": None}}, "test", ""
        )
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down", "_")
        seen = text_of(pilot, "#preview")
        assert "Open-Meteo" in seen
        assert "Enter to fill in the weather of flights" in seen
        await press(pilot, "enter", "_", *typed("Moor"), "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            flight = ledger.flight(id)
        assert flight.temperature is not None
        assert flight.extra["temperature_sd_c"] == "1.6"
        await press(pilot, "u", "_")
    with Ledger.open(file) as ledger:
        assert ledger.flight(id).temperature is None


@pytest.mark.thorough
async def test_the_range_box_is_entered_by_the_palette_and_limits_the_motors(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "B", "_")
        assert "Your range box is empty" in text_of(pilot, "NoticeBar")
        await press(pilot, "ctrl+p", "_")
        await press(pilot, *typed("your card"), "_", "_")
        await press(pilot, "enter", "_")
        await press(pilot, *["down"] * 4, *typed("3 x F24-4W, 2 x E35"), "ctrl+s", "_")
        box = cast(FieldkitApp, pilot.app).resources.settings.flyer.box
        assert [one.count for one in box] == [3, 2]
        await press(pilot, "B", "_")
        table = pilot.app.screen.query_one("#motors", Table)
        rows = [table.cells(motor)[0] for motor in table.keys]
        assert len(rows) == 2
        assert {row.split("×")[0].split()[-1] for row in rows} == {"3", "2"}
        assert "your box" in text_of(pilot, "#count")
        await press(pilot, "B", "_")
        assert len(table.keys) > 2


@pytest.mark.thorough
async def test_the_pages_of_a_plan_are_written_by_keys_and_by_the_palette(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "d", *["right"] * 3, "_")
        assert "w to write the range safety sheet" in text_of(pilot, "#answer")
        await press(pilot, "w", "enter", "_")
        assert Path("range_safety_sheet.pdf").read_bytes().startswith(b"%PDF")
        assert "Wrote the range safety sheet" in text_of(pilot, "NoticeBar")
        await press(pilot, "w", "enter", "_", "n", "_")  # it exists: not replaced
        await press(pilot, "escape", "_", "ctrl+p", "_")
        await press(pilot, *typed("write the range card"), "_", "_")
        await press(pilot, "enter", "_", "enter", "_")
        assert Path("range_card.pdf").read_bytes().startswith(b"%PDF")
        assert pilot.app.screen.TITLE == "Decide"


@pytest.mark.thorough
async def test_the_card_of_finals_is_written_by_a_key(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "d", "left", "_", "w", "enter", "_")
        assert Path("finals_card.pdf").read_bytes().startswith(b"%PDF")
        assert not pilot.app.errors  # type: ignore[attr-defined]


async def test_the_track_of_a_flight_is_written_by_a_key(file: Path) -> None:
    log = ROOT / "sample_logs" / "altos_csv__with_satellites.csv"
    with Ledger.open(file) as ledger:
        (id,) = bring_in(ledger, [log], lambda name: None, defaults={"rocket": "Comet"}).ids
    async with opened(file) as pilot:
        await cast(FieldkitApp, pilot.app).open_flight(id)
        await press(pilot, "_", "G", "enter", "_")
        assert b"<trkpt" in Path(f"{id}.gpx").read_bytes()
        await press(pilot, "escape", "_")
        await cast(FieldkitApp, pilot.app).open_flight("1")
        await press(pilot, "_", "G", "enter", "_")
        assert "found no GPS positions" in text_of(pilot, "NoticeBar")

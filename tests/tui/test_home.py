"""The first page: the next flight, the first steps with an empty ledger, and the weather of the day."""

import asyncio
import shutil
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from textual.events import AppFocus
from textual.pilot import Pilot

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.services.imports import bring_in
from fieldkit.services.manual_entry import PLAN
from fieldkit.settings import change_settings, read_settings
from fieldkit.tui.add.add_page import AddScreen
from fieldkit.tui.finder import MAX_HITS, Finder
from fieldkit.tui.home.home_page import HomeScreen
from fieldkit.tui.setup.rocket_strip import RocketStrip
from fieldkit.tui.widgets.bars import NoticeBar
from fieldkit.tui.widgets.big import large
from fieldkit.tui.widgets.table import Table
from tests.pressing import ROOT, at_home, calm, hurry, opened, press, shown, text_of, typed, words

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)  # made at a frozen time in the past
    return at_home(tmp_path, monkeypatch)


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    return tmp_path / "new.db"


async def test_the_app_opens_on_the_next_flight(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        assert isinstance(pilot.app.screen, HomeScreen)
        seen = words(pilot)
        for text in ("f Fly", "a Add", "p Plan", "Astra B", "No open forecast"):
            assert text in seen
        assert "4.1 high, inside" in text_of(pilot, "#last .words")
        assert "▸12" in shown(pilot)
        await press(pilot, "down", "enter")
        assert "11 · Astra B" in words(pilot)
        await press(pilot, "escape", "1", "0")
        assert isinstance(pilot.app.screen, HomeScreen)


async def resized(pilot: Pilot[None], width: int, height: int) -> None:
    """Change the size of the terminal, and wait until the screen has it."""
    was = pilot.app.screen.classes
    await pilot.resize_terminal(width, height)
    while pilot.app.screen.classes == was:
        await asyncio.sleep(0.01)
    await press(pilot)


async def test_a_tall_screen_shows_the_rocket_of_the_selected_flight(file: Path) -> None:
    async with opened(file, (120, 44), page="home") as pilot:
        strip = pilot.app.screen.query_one(RocketStrip)
        assert "Astra B" in text_of(pilot, "RocketStrip Static")
        await press(pilot, *["down"] * 3)
        assert "Astra A" in text_of(pilot, "RocketStrip Static")
        assert strip.display
        await resized(pilot, 120, 30)
        assert not strip.display
        assert "▸9 " in shown(pilot), "the flights have the room"
    async with opened(file, (120, 30), page="home") as pilot:
        assert not pilot.app.screen.query_one(RocketStrip).display
        await resized(pilot, 120, 44)
        assert "Astra B" in text_of(pilot, "RocketStrip Static")


async def test_keys_typed_before_the_first_steps_are_shown_move_among_them(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        page = pilot.app.screen
        assert isinstance(page, HomeScreen)
        page.query_one(Table).show((), (), lambda _: ())
        page._have_read = False  # as when the app opens
        page.reload()
        await hurry(pilot, "down", "enter")
        assert "Loaded 12 flights" in words(pilot)


@pytest.mark.parametrize(("key", "page"), [("f", "next_flight"), ("a", "add")])
async def test_a_choice_is_one_key_or_one_click(file: Path, key: str, page: str) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, key)
        assert pilot.app.current_mode == page
    async with opened(file, page="home") as pilot:
        await pilot.click(offset=(10 if key == "f" else 40, 2))
        await press(pilot, "_")
        assert pilot.app.current_mode == page


@pytest.mark.thorough
async def test_a_saved_forecast_is_on_the_first_page_until_it_is_flown(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "f", "_", "slash", *typed("aerotech f39"), "enter", "_", "enter", "_", "escape", "0")
        assert "Astra B on AeroTech F39T" in text_of(pilot, "#next .heading")
        assert "Flown? a to add it" in shown(pilot)
        await press(pilot, "u", "_")
        assert "No open forecast" in words(pilot)


async def test_a_first_rocket_takes_four_fields_and_has_a_forecast_at_once(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        assert "Describe your rocket" in words(pilot)
        assert "f Fly every motor that fits" in words(pilot), "a launch day"
        assert "? explains the current page" in words(pilot), "all of it"
        await press(pilot, "enter")
        assert "✗" not in words(pilot)
        await press(pilot, "ctrl+s")
        assert "✗ expected a name such as Astra" in words(pilot)
        await press(pilot, *typed("Lark"), "enter", *typed("33og"), "enter", *typed("2.6in"), "enter")
        assert "in = 66 mm" in words(pilot)
        await press(pilot, *typed("F24-W4"), "ctrl+s")
        assert "✗ found the unit 'og'" in words(pilot)
        await press(pilot, "ctrl+u", *typed("330g"), "ctrl+s")
        assert "did you mean F24-4W" in words(pilot)
        await press(pilot, "ctrl+u", *typed("f24w-4"), "down", "enter", "_")
        assert "Lark on AeroTech F24W" in text_of(pilot, "#next .heading")
        assert "Flown? a to add it" in shown(pilot)
        assert "A launch day" not in words(pilot)
    with Ledger.open(empty) as ledger:
        (kept,) = [one for one in ledger.predictions() if PLAN in one.payload]
        assert kept.payload["apogee_m"]["p50"] == pytest.approx(257, abs=40)
        ledger.undo()
        ledger.undo()
        assert not ledger.predictions()
        assert not ledger.draft("plan")


async def test_the_demo_rocket_is_loaded_and_removed_again(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        await press(pilot, "down", "enter", "_")
        assert "Loaded 12 flights of the demo rocket. u to undo" in words(pilot)
        assert "▸12" in shown(pilot)
        await press(pilot, "u", "_", "y", "_")
        assert "Load the demo rocket" in words(pilot)


@pytest.mark.parametrize("page", ["flights", "next_flight", "loop"])
async def test_no_page_is_empty_except_for_one_line(empty: Path, page: str) -> None:
    async with opened(empty, page=page) as pilot:
        seen = words(pilot)
        for text in ("No flights yet", "0 Home", "describe a rocket or load the demo rocket", "3 Import"):
            assert text in seen


async def test_weather_entered_once_is_in_every_plan_and_flight_of_the_day(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "e", *typed("8mph"), "enter", *typed("72f"), "ctrl+s", "_")
        assert "Weather saved for today. u to undo" in words(pilot)
        assert text_of(pilot, "#next .last").endswith("Today: wind 3.6 m/s, 22 °C")
        await press(pilot, "escape", "a")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("wind").line.value == "3.6 m/s"
        await press(pilot, "escape", "4", "_")
        assert "wind 3.6 m/s" in text_of(pilot, "#plan")
        await press(pilot, "u", "0", "_")
        assert text_of(pilot, "#next .last").endswith("Weather today: e to enter it")


async def test_a_date_is_today_unless_another_is_typed(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("650ft"))
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("date_time").line.value == "today"
        screen.field("date_time").line.focus()
        await press(pilot, "ctrl+u", *typed("2026-05-0x"))
        assert "✗ found '2026-05-0x', expected a date" in words(pilot)
        await press(pilot, "ctrl+u", *typed("2026-05-02"), "ctrl+s")
    with Ledger.open(file) as ledger:
        assert ledger.flight("13").date_time == datetime(2026, 5, 2)


@pytest.mark.thorough
async def test_an_unknown_rocket_is_questioned_before_it_is_saved(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("rocket").line.focus()
        await press(pilot, "ctrl+u", *typed("Astar"), "enter", "enter", "enter", "enter", *typed("650ft"), "ctrl+s")
        assert "No rocket Astar yet; did you mean Astra?" in words(pilot)
        await press(pilot, "n")
        with Ledger.open(file) as ledger:
            assert len(ledger.flights()) == 12
        screen.field("rocket").line.focus()
        await press(pilot, "ctrl+u", *typed("ast"), "down", "enter")
        assert screen.field("rocket").line.value == "Astra"
        await press(pilot, "ctrl+s", "_")
        assert "Saved flight 13" in words(pilot)


async def test_a_motor_can_be_picked_while_typing(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("motor").line.focus()
        await press(pilot, "ctrl+u", *typed("e35"))
        assert "Quest E35W-5" in words(pilot)
        await press(pilot, "escape")
        assert "Quest E35W-5" not in words(pilot)
        assert pilot.app.focused is screen.field("motor").line
        await press(pilot, "backspace", "5", "down", "down", "up", "enter")
        assert screen.field("motor").line.value == "E35-5W"


async def test_the_palette_finds_a_flight_a_rocket_a_motor_a_setting_and_help(file: Path) -> None:
    async with opened(file, (120, 36), page="home") as pilot:
        await press(pilot, "ctrl+p", *typed("flight 9"), "_", "enter", "_")
        assert "9 · Astra A · F24-4W" in words(pilot)
        await press(pilot, "escape", "0", "ctrl+p", *typed("rocket astra"), "_", "enter", "_")
        assert pilot.app.current_mode == "flights"
        assert "12 of 12" in shown(pilot)
        await press(pilot, "ctrl+p", *typed("motor aerotech f39t"), "_", "enter", "_")
        assert "The catalog data of this motor" in words(pilot)
        await press(pilot, "escape", "ctrl+p", *typed("setting: target"), "_", "enter", *typed("800ft"), "enter")
        assert read_settings(file.with_name("settings.json")).target == pytest.approx(243.84)
        await press(pilot, "escape", "ctrl+p", *typed("help: top speed (fly)"), "_", "enter", "_")
        assert "Top speed, at about" in words(pilot)
        await press(pilot, "escape", "ctrl+p", *typed("help: ballast"), "_", "enter", "_")
        assert "best chance of an apogee" in words(pilot)


async def test_many_flights_leave_room_for_motors_in_the_palette(empty: Path) -> None:
    with Ledger.open(empty) as ledger:
        ledger.add(Flight(str(n), "Bird", motor="F24-4W", apogee=120.0 + n) for n in range(60))
    async with opened(empty, page="home") as pilot:
        finder = Finder(pilot.app.screen)
        await finder.startup()
        hits = [hit async for hit in finder.search("f24")]
        assert all("\n" not in str(hit.prompt) for hit in hits), "one line for each"
        found = [str(hit.text) for hit in hits]
        assert sum(text.startswith("Flight ") for text in found) == MAX_HITS
        assert "Motor AeroTech F24W" in found


async def test_a_notice_of_success_stays_until_another_page_opens_and_an_error_longer(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "N")
        assert "units" in text_of(pilot, "NoticeBar")
        await press(pilot, "1")
        assert not pilot.app.screen.query_one(NoticeBar).display
        pilot.app.show_notice("a problem", error=True)
        await press(pilot, "0")
        assert "a problem" in text_of(pilot, "NoticeBar")


async def test_the_demo_rocket_can_be_loaded_from_the_palette_after_the_first_steps(empty: Path) -> None:
    """Once a rocket was described, nothing in the app loaded the demo rocket."""
    with Ledger.open(empty) as ledger:
        ledger.add([Flight(rocket="Bird", motor="C6-5", apogee=120.0)])
    async with opened(empty, page="home") as pilot:
        await press(pilot, "ctrl+p", *typed("demo rocket"), "_", "enter", "_")
        assert "Loaded 12 flights of the demo rocket" in words(pilot)


async def test_settings_of_two_open_apps_do_not_overwrite_each_other(file: Path) -> None:
    async with opened(file) as pilot:
        change_settings({"units": "US"}, file.with_name("settings.json"))
        await press(pilot, "T", "_")
        kept = read_settings(file.with_name("settings.json"))
        assert (kept.units, kept.theme) == ("US", "sun")
        assert "apogee in ft" in words(pilot), "what the other chose is shown from now on"


def test_large_digits_are_solid_and_differ() -> None:
    drawn = {figure: large(figure) for figure in "0123456789"}
    assert len(set(drawn.values())) == 10
    assert set("".join(drawn.values())) <= set("█▀ \n")
    assert [len(line) for line in large("281.3").splitlines()] == [17, 17, 17]


async def test_the_whole_cycle_from_an_empty_ledger_takes_few_keys(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        await press(pilot, "enter", *typed("Lark"), "enter", *typed("330g"), "enter", *typed("66mm"), "enter")
        await press(pilot, *typed("f24w-4"), "down", "enter", "_", "escape", "a")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert pilot.app.focused is screen.field("apogee").line
        for text in ("235m", "80", "2.1x", "7.9", "3.9", "5.6", "0.3", "230", "5", "45"):
            await press(pilot, *typed(text), "enter")
        await press(pilot, "ctrl+s")
        assert "Burn time: found the unit 'x'" in words(pilot)
        await press(pilot, "ctrl+u", *typed("2.1"), "ctrl+s", "_")
        seen = words(pilot)
        for text in (
            "Saved flight 1. u to undo",
            "Flown 235.0 m",
            "inside the 90% interval",
            "on AeroTech F24W-4",
            "One more flight on AeroTech F24W-4 narrows the interval by",
        ):
            assert text in seen
        assert "Burn time: found" not in seen, "a corrected error is no longer shown"
        await press(pilot, "0", "_")
        assert "1 flight today, to 235.0 m" in text_of(pilot, "#last .last")
        assert "low, inside" in text_of(pilot, "#last .words")
        await press(pilot, "u", "_")
        assert "Flown? a to add it" in shown(pilot), "the saved forecast waits again"
    with Ledger.open(empty) as ledger:
        assert not ledger.flights()


async def test_the_profile_of_a_flight_is_not_that_of_another_with_its_former_id(tmp_path: Path) -> None:
    log = "perfectflite__drogue_and_main.pf2"
    shutil.copy(ROOT / "sample_logs" / log, tmp_path)
    (tmp_path / "table.csv").write_text(f"flight_id,rocket,apogee_m,log\n1,Comet,,{log}\n")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        bring_in(ledger, [tmp_path / "table.csv"], lambda name: None)
    async with opened(tmp_path / "ledger.db", page="home") as pilot:
        assert "▃▆███" in shown(pilot)
        with Ledger.open(tmp_path / "ledger.db") as ledger:
            ledger.remove("1")
            ledger.add([Flight("1", "Vega", apogee=90.0)])
        pilot.app.post_message(AppFocus())
        await calm(pilot)
        assert "Vega" in shown(pilot)
        assert "▃▆███" not in shown(pilot)

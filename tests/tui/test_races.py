"""Keys that arrive before an answer, and answers that arrive after the page has changed."""

import asyncio
from datetime import datetime
from pathlib import Path
from threading import Event
from unittest.mock import patch

import pytest
from textual.app import ComposeResult
from textual.events import Key
from textual.widgets import Button, Input, Static

from fieldkit import capture
from fieldkit.errors import NoFlights
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services import close_loop
from fieldkit.services.manual_entry import DRAFT
from fieldkit.tui.add.add_page import AddScreen
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.asking import AskingScreen
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.flights.flights_page import FlightsScreen
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.dialogs import AskYes
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, calm, hurry, looked_at, opened, press, text_of, typed, words

CHECK_SHAPES = False


class Lingering(AskingScreen):
    """A screen that takes a while to close after its input is gone."""

    def __init__(self) -> None:
        super().__init__()
        self.bare, self.closes = Event(), asyncio.Event()

    def compose(self) -> ComposeResult:
        """An input, by which an answer would be shown."""
        yield Input()

    async def on_unmount(self) -> None:
        """Wait without widgets."""
        self.bare.set()
        await self.closes.wait()


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


def flown(file: Path) -> list[str]:
    with Ledger.open(file) as ledger:
        return [flight.flight_id for flight in ledger.flights()]


@pytest.mark.sampled
@pytest.mark.parametrize("save", [("ctrl+s", "ctrl+s"), ("ctrl+s", "ctrl+s", "ctrl+s", "8")])
async def test_pressing_save_twice_quickly_saves_one_flight_and_shows_its_card(
    file: Path, save: tuple[str, ...]
) -> None:
    async with opened(file) as pilot:
        await press(pilot, "a", *typed("200"), "enter")
        await hurry(pilot, *save)
        assert flown(file)[12:] == ["13"]
        assert "Saved flight 13" in words(pilot)
        assert "Flown 200.0 m" in words(pilot)


async def test_a_double_click_on_save_saves_one_flight(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "a", *typed("200"), "enter")
        button = pilot.app.screen.query_one("#save", Button)
        for _ in range(2):
            button.post_message(Button.Pressed(button))
        await calm(pilot)
        assert flown(file)[12:] == ["13"]
        assert "error" not in words(pilot)


async def test_a_change_of_units_reaches_a_partly_filled_form_and_the_following_card(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "a", *typed("200"), "enter", "escape", "N")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        notes = [str(screen.field(name).query_one(".note", Static).content) for name in ("apogee", "top_speed")]
        assert notes == ["m  = 656 ft", "mph"]
        await press(pilot, "ctrl+s", "_")
        assert "Flown 656 ft" in words(pilot)
        await press(pilot, "N", "N", "_")
        assert "Flown 200.0 m" in words(pilot)


@pytest.mark.parametrize("interrupted_by", ["a removed flight", "another rocket"])
async def test_a_search_is_canceled_when_the_page_has_other_flights(file: Path, interrupted_by: str) -> None:
    with Ledger.open(file) as ledger:
        made = datetime(2026, 3, 1)
        ledger.add([Flight("b", "Bee", motor="F39", dry_mass=0.4, apogee=100.0, date_time=made)])
    began, go = Event(), Event()

    def look(*rest: object, **_: object) -> object:
        rest[-1]("half of it", 0.5)  # type: ignore[operator]
        began.set()
        go.wait(10)
        rest[-1]("the rest of it", 0.9)  # type: ignore[operator]
        return looked_at()

    async with opened(file, page="loop") as pilot:
        pilot.app.look_round()  # type: ignore[attr-defined]
        with patch.object(close_loop, "look", look):
            await press(pilot, "_", *["b"] * ("Bee" in text_of(pilot, "#what")))
            assert "Astra" in text_of(pilot, "#what")
            await pilot.app._press_keys(["S"])
            await asyncio.to_thread(began.wait, 10)
            if interrupted_by == "another rocket":
                await pilot.app._press_keys(["b"])
            else:
                with Ledger.open(file) as ledger:
                    ledger.remove("12")
                pilot.app.look_round()  # type: ignore[attr-defined]
            while "searching" in text_of(pilot, "#verdict"):
                await asyncio.sleep(0.01)
            go.set()
            await calm(pilot)
        verdict = text_of(pilot, "#verdict")
        assert "search" in verdict, "what a search would do, or why none can be made"
        assert "searching" not in verdict
        assert ("have changed" in verdict) == (interrupted_by == "a removed flight")
        assert pilot.app.screen.query_one("#panels").found is None  # type: ignore[attr-defined]


def test_a_search_whose_flights_are_removed_reports_it(tmp_path: Path) -> None:
    diagnosis = looked_at().diagnosis
    with Ledger.open(tmp_path / "empty.db") as empty, pytest.raises(NoFlights, match="removed during the search"):
        close_loop.findings_of(empty, catalogue(), "Astra", diagnosis)


@pytest.mark.thorough
async def test_the_screen_of_a_flight_closes_when_the_flight_is_gone(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "a", *typed("200"), "ctrl+s", "1", "enter")
        assert isinstance(pilot.app.screen, FlightScreen)
        await press(pilot, "u", "_")
        assert isinstance(pilot.app.screen, FlightsScreen)
        assert "Flight 13 is no longer in the ledger" in words(pilot)
        assert "error" not in words(pilot)


@pytest.mark.sampled
@pytest.mark.parametrize("key", ["question_mark", "e", "ctrl+p"])
async def test_a_dialog_above_a_removed_flight_stays_open(file: Path, key: str) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter", key)
        flight, dialog = pilot.app.screen_stack[-2:]
        assert isinstance(flight, FlightScreen)
        with Ledger.open(file) as ledger:
            ledger.remove(flight._flight_id)
        flight.reload()  # its answer arrives while the dialog is open
        await press(pilot, "_")
        assert pilot.app.screen is dialog
        await press(pilot, *["escape"] * 3)
        assert isinstance(pilot.app.screen, FlightsScreen)
        assert "error" not in words(pilot)


async def test_keys_after_a_key_that_opens_a_form_are_typed_into_it(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "d")
        await hurry(pilot, "e", *"785", "f", "t", "ctrl+s")
        from fieldkit.services.contest_day import day_of

        with Ledger.open(file) as ledger:
            assert day_of(ledger, 2027).target == pytest.approx(239.268)


async def test_a_capture_that_ends_in_the_background_does_not_take_keys_of_another_page(file: Path) -> None:
    log, go = file.parent / "flight.pf2", Event()
    log.write_bytes(b"kept")

    def events(*_: object, **__: object) -> object:
        yield capture.PortOpened("/dev/ttyUSB0", "stratologger", log)
        go.wait(10)
        yield capture.Ended(log, "stratologger", 4, 200, 0, "complete", True)

    here = [capture.Port("/dev/ttyUSB0", 0x0403, 0x6015, "A1", "adapter")]
    with patch("fieldkit.capture.ports", lambda: here), patch("fieldkit.capture.capture", events):
        async with opened(file) as pilot:
            await press(pilot, "7")
            await pilot.app._press_keys(["enter", "2"])
            while not isinstance(pilot.app.screen, AddScreen):
                await asyncio.sleep(0.01)
            go.set()
            await calm(pilot)
            await press(pilot, *typed("281"))
            screen = pilot.app.screen
            assert isinstance(screen, AddScreen)
            assert screen.field("apogee").line.value == "281"
            assert "The capture has ended, complete. 7 to import its flights" in words(pilot)
            await press(pilot, "escape", "escape", "7", "_")
            assert isinstance(pilot.app.screen, AskYes)
            assert "Import its flights?" in words(pilot)


async def test_after_an_unexpected_error_the_next_capture_can_start(file: Path) -> None:
    def broken(*_: object, **__: object) -> object:
        raise RuntimeError("not expected")

    here = [capture.Port("/dev/ttyUSB0", 0x0403, 0x6015, "A1", "adapter")]
    with patch("fieldkit.capture.ports", lambda: here), patch("fieldkit.capture.capture", broken):
        async with opened(file) as pilot:
            await press(pilot, "7", "enter", "_")
            assert "error in fieldkit itself" in words(pilot)
            await press(pilot, "escape", "enter", "_")
            assert "a capture is running" not in words(pilot)
            pilot.app.errors.clear()  # type: ignore[attr-defined]


@pytest.mark.parametrize(("page", "key"), [("import_files", "o"), ("flights", "w")])
async def test_an_impossible_file_name_is_refused_below_it(file: Path, page: str, key: str) -> None:
    async with opened(file, page=page) as pilot:
        await press(pilot, key, "ctrl+u", *typed("a" * 300), "enter", "_")
        assert "✗" in text_of(pilot, "#wrong")


async def test_cd_appears_for_flights_that_a_filter_finds_far_down_the_list(file: Path) -> None:
    with patch("fieldkit.tui.flights.flights_page.MAX_INFERRED", 2):
        async with opened(file) as pilot:
            screen = pilot.app.screen
            assert isinstance(screen, FlightsScreen)
            assert screen._rows["2"].drag is None
            await press(pilot, "slash", *typed("2026-04-18 10:25"), "_")
            assert screen._rows["2"].drag is not None


async def test_tagging_a_flight_without_a_motor_needs_no_forecast(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([Flight("b", "Bee", apogee=100.0, date_time=datetime(2026, 9, 1))])
    async with opened(file) as pilot:
        await press(pilot, "t", "space", "_")
        assert "[x] weak_launch" in words(pilot)
        assert "its motor is not known" in words(pilot)
        assert "error" not in words(pilot)


async def test_the_curves_of_a_log_are_plotted_in_a_terminal_with_24_lines(file: Path) -> None:
    async with opened(file, page="import_files") as pilot:
        log = Path(__file__).parents[2] / "sample_logs" / "perfectflite__drogue_and_main.pf2"
        await press(pilot, "o", "ctrl+u")
        pilot.app.screen.query_one(Input).value = str(log)
        await press(pilot, "enter", "_", "l", "_")
        assert "burnout" in words(pilot)
        assert "Readouts" not in words(pilot)
        await press(pilot, "tab")
        assert "Readouts" in words(pilot)
        assert "burnout apogee" not in words(pilot)


async def test_a_motor_beyond_the_first_ones_is_forecast_when_the_cursor_reaches_it(file: Path) -> None:
    with patch("fieldkit.tui.next.motor_list.MAX_FORECAST_MOTORS", 3), patch("fieldkit.tui.next.motor_list.AT_ONCE", 2):
        async with opened(file, page="next_flight") as pilot:
            table = pilot.app.screen.query_one(Table)
            that_fit = [motor for motor in table.keys if not table.cells(motor)[0].startswith("✗")]
            assert table.cells(that_fit[-1])[1] == "…"
            table.move_to(that_fit[-1])
            await press(pilot, "_")
            assert table.current == that_fit[-1]
            assert table.cells(table.current)[1] != "…"
            await press(pilot, "enter", "_")
            assert "Saved forecast" in words(pilot)


async def test_a_key_whose_message_a_closing_app_does_not_handle_is_in_the_draft(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, "9", "2")
        field = pilot.app.focused
        assert isinstance(field, Input)
        with field.prevent(Input.Changed), patch("fieldkit.tui.app.gone", lambda _: True):
            field.value += "3"
            pilot.app._leave_if_gone(0)  # type: ignore[attr-defined]
    with Ledger.open(file) as ledger:
        assert (ledger.draft(DRAFT) or {})["apogee"].startswith("923")


async def test_keys_typed_after_q_open_no_page_of_the_closing_app(file: Path) -> None:
    app = FieldkitApp(file, file.with_name("settings.json"))
    running = asyncio.create_task(app.run_async(headless=True, size=(80, 24)))
    while not (app.screen_stack and isinstance(app.screen, PageScreen) and app.screen.ready):
        await asyncio.sleep(0.01)
    with patch.object(FieldkitApp, "action_page_number") as turned:
        for key in "q53":
            app.post_message(Key(key, key))
        await asyncio.wait_for(running, 20)
    assert not turned.called
    assert app.errors == []


async def test_an_answer_that_reaches_a_closing_screen_is_dropped(file: Path) -> None:
    async with opened(file) as pilot:
        screen = Lingering()
        await pilot.app.push_screen(screen)
        answers: list[bool] = []
        screen.ask(lambda: screen.bare.wait(10), answers.append)
        closing = screen.dismiss()
        while not screen.bare.is_set() or screen.is_asking("ask"):
            await asyncio.sleep(0.005)
        screen.closes.set()
        await closing
        assert answers == []

"""Keys act on what is shown: after another plan, another page, a removed row, an undone or repeated change."""

import re
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from threading import Event
from unittest.mock import patch

import pytest
from textual.events import Key
from textual.widgets import Input

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, models
from fieldkit.motors.catalogue import catalogue
from fieldkit.services import close_loop
from fieldkit.services.findings import Findings
from fieldkit.services.manual_entry import STARTED_DRAFT
from fieldkit.tui.add.add_page import AddScreen
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.flights.flights_page import FlightsScreen
from fieldkit.tui.next import contest_form
from fieldkit.tui.widgets.dialogs import AskYes
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, hurry, looked_at, opened, press, shown, text_of, typed, words

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


def changes(file: Path) -> list[str]:
    with Ledger.open(file) as ledger:
        return [change.command for change in ledger.history()]


def another_rocket(file: Path, name: str = "Bee", when: datetime = datetime(2026, 3, 1)) -> None:
    bee = Flight("b", name, "Z", "F39", dry_mass=0.4, diameter=0.066, apogee=100.0, date_time=when)
    with Ledger.open(file) as ledger:
        ledger.add([bee])


async def test_enter_behind_another_rocket_does_not_save_a_forecast_of_the_former(file: Path) -> None:
    another_rocket(file)
    async with opened(file, page="next_flight") as pilot:
        before = text_of(pilot, "#plan")
        await hurry(pilot, "b", "enter")
        assert text_of(pilot, "#plan") != before
        assert changes(file)[-1] == "plan"
        assert "Enter again" in words(pilot)
        await press(pilot, "enter", "_")
        assert changes(file)[-1] == "forecast"


@pytest.mark.thorough
async def test_a_plan_for_a_rocket_of_unknown_mass_is_shown_and_can_be_completed(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "p", "ctrl+u", *typed("Nova"), "ctrl+s", "y", "_")
        assert "Nova B: no dry mass known; p to enter one" in text_of(pilot, "#plan")
        assert not pilot.app.screen.query_one(Table).keys
        await press(pilot, "enter", "_")
        assert "forecast" not in changes(file)
        await press(pilot, "p")
        assert pilot.app.screen.query_one("#in-rocket", Input).value == "Nova"
        await press(pilot, "down", "down", *typed("400"), "ctrl+s", "_")
        assert "Nova B · 400 g" in text_of(pilot, "#plan")
        assert pilot.app.screen.query_one(Table).keys
        await press(pilot, "u", "_", "b", "_")
        assert "Astra" in text_of(pilot, "#plan")


async def test_the_palette_opens_another_flight_while_one_is_open(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter", "0")
        await press(pilot, "ctrl+p", *typed("Flight 3 "), "_", "enter", "_")
        assert isinstance(pilot.app.screen, FlightScreen)
        assert "3 · Astra A" in words(pilot)


@pytest.mark.parametrize(("page", "key", "back"), [("flights", "enter", "1"), ("next_flight", "d", "f")])
async def test_the_key_of_a_page_closes_what_is_open_over_it(file: Path, page: str, key: str, back: str) -> None:
    async with opened(file, page=page) as pilot:
        first = pilot.app.screen
        await press(pilot, key)
        assert pilot.app.screen is not first
        await press(pilot, back)
        assert pilot.app.screen is first


async def test_an_unknown_motor_is_refused_in_the_form_and_no_edit_is_lost(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter", "e", *["down"] * 2, "ctrl+u")
        await hurry(pilot, *"F24W999", "ctrl+s")
        assert "✗ no motor 'F24W999'" in words(pilot)
        assert pilot.app.focused is pilot.app.screen.query_one("#in-motor")
        await press(pilot, "ctrl+u", *typed("F24-4W"), "ctrl+s", "_")
        assert "Saved flight 12: motor" in words(pilot)


async def test_a_motor_typed_in_small_letters_is_shown_as_on_the_motor(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter", "e", *["down"] * 2, "ctrl+u")
        await hurry(pilot, *"aerotech f24w-4", "ctrl+s", "_")
        assert "12 · Astra B · AeroTech F24W-4" in words(pilot)


RENAMED = {"averaged": [{"probability": 1.0, "places": [{"effect": "wind", "since": "2"}]}]}


async def test_the_correction_of_a_rocket_goes_with_it_when_a_form_renames_it(file: Path) -> None:
    another_rocket(file, "Cat", datetime(2026, 9, 1))
    with Ledger.open(file) as ledger:
        ledger.keep_version("Cat", RENAMED)
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right", "enter", "ctrl+u", *typed("Lion"), "ctrl+s", "_")
        assert in_use(file, "Cat", "Lion") == [None, RENAMED]
        await press(pilot, "u", "_")
        assert in_use(file, "Cat", "Lion") == [RENAMED, None]
        await press(pilot, "1", "_", "enter", "_", "e", "_", "ctrl+u", *typed("Astra"), "ctrl+s", "_")
        assert "the correction of Cat is now used for every flight of Astra; the loop checks it" in words(pilot)
    assert in_use(file, "Cat", "Astra")[0] is None


def in_use(file: Path, *rockets: str) -> list[object]:
    """The correction in use of each of some rockets."""
    with Ledger.open(file) as ledger:
        found = [ledger.active_version(rocket) for rocket in rockets]
    return [version.payload if version else None for version in found]


async def test_a_flight_that_is_redone_leaves_no_draft_behind(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("200"), "ctrl+s", "_", "u", "_")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("apogee").line.value == "200m"
        await press(pilot, "U", "_")
        assert screen.field("apogee").line.value == ""
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 13


async def test_a_tag_of_ones_own_that_was_cleared_can_be_set_again(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.tag("12", "windy")
    async with opened(file) as pilot:
        await press(pilot, "t")
        pilot.app.screen.query_one(Table).move_to("windy")
        await press(pilot, "space", "_")
        assert "▸[ ] windy" in shown(pilot)
        await press(pilot, "space", "_")
    with Ledger.open(file) as ledger:
        assert ledger.flight("12").tags == ("windy",)


async def test_the_cursor_stays_where_a_flight_was_removed(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, *["down"] * 3, "x", "_")
        assert pilot.app.screen.query_one(Table).current == "8"
        await press(pilot, "end", "x", "_")
        assert pilot.app.screen.query_one(Table).current == "2"


async def test_the_cursor_stays_on_a_rocket_that_was_edited_or_renamed(file: Path) -> None:
    for number, name in enumerate(("Cat", "Dog", "Elk")):
        another_rocket(file, name, datetime(2026, 9, 1 + number))
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right", "down")
        table = pilot.app.screen.query_one(Table)
        await press(pilot, "enter", "down", "down", *typed("390"), "ctrl+s", "_")
        assert "390 g" in table.current_text()
        assert table.current.names == ("Dog", "Z")
        await press(pilot, "enter", "ctrl+u", *typed("Duck"), "ctrl+s", "_")
        assert table.current.names == ("Duck", "Z")


async def test_a_change_is_shown_although_its_screen_was_closed_at_once(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "t")
        await hurry(pilot, "space", "escape")
        assert isinstance(pilot.app.screen, FlightsScreen)
        assert "+4.1 weak_laun" in words(pilot)


@pytest.fixture
def today(file: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The ledger, with forecasts saved now."""
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    return file


@pytest.mark.thorough
async def test_add_offers_the_open_forecast_that_home_shows(today: Path) -> None:
    another_rocket(today)
    async with opened(today, page="next_flight") as pilot:
        while "Astra B" not in text_of(pilot, "#plan"):
            await press(pilot, "b", "_")
        await press(pilot, "enter", "_", "b", "_")
        while "Bee" not in text_of(pilot, "#plan"):
            await press(pilot, "b", "_")
        await press(pilot, "enter", "_", "a", "_", *typed("140"), "ctrl+s", "_")
        if isinstance(pilot.app.screen, AskYes):
            await press(pilot, "y", "_")
        await press(pilot, "0", "_")
        assert "Astra B on" in text_of(pilot, "#next .heading")
        await press(pilot, "a", "_")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert (screen.field("rocket").answer, screen.field("config").answer) == ("Astra", "B")


async def test_add_offers_a_saved_forecast_although_an_old_flight_has_no_mass(today: Path) -> None:
    old = Flight("x", "Astra", "A", "F24-4W", apogee=150.0, date_time=datetime(2026, 4, 1))
    with Ledger.open(today) as ledger:
        ledger.add([old])
    async with opened(today, page="next_flight") as pilot:
        await press(pilot, "down", "enter", "_")
        motor = pilot.app.screen.query_one(Table).current.designation
        await press(pilot, "a", "_")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert f"AeroTech {motor}" in screen.field("motor").answer


async def test_the_form_of_a_contest_day_is_one_change(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "d", "e", *typed("785ft"))
        form, before = pilot.app.screen, changes(file)
        for name, text in (("size", "400 m"), ("lift_off_mass", "500 g")):
            form.query_one(f"#in-{name}", Input).value = text
        await press(pilot, "ctrl+s", "_")
        assert changes(file) == [*before, "day"]
        assert "Saved the day. u to undo" in words(pilot)
        await press(pilot, "u", "_")
    with Ledger.open(file) as ledger:
        assert [ledger.draft(name) for name in ("contest", "sites", "plan")] == [None, None, None]


def test_a_lift_off_mass_below_the_motors_is_reported_in_the_flyers_units() -> None:
    motor = catalogue().resolve("F24-4W").motor
    for system, message in (("US", r"mass of 0.71 oz, .* 2.22 oz"), ("SI", r"mass of 20.0 g, .* 62.9 g")):
        with pytest.raises(BadValue, match=message):
            contest_form.read(motor, system, "lift_off_mass", "20g", "oz")


async def test_a_model_in_use_is_not_said_to_be_declined(file: Path) -> None:
    with patch.object(close_loop, "look", lambda *_, **__: looked_at()):
        async with opened(file, page="loop") as pilot:
            await press(pilot, "S", "_", "D", "_")
            assert "Declined: the model is unchanged" in words(pilot)
            await press(pilot, "A", "_", "D", "_")
            assert "Already accepted: forecasts use it. u to undo" in words(pilot)
        async with opened(file, page="loop") as pilot:
            await press(pilot, "S", "_")
            assert "Accepted: forecasts use it. u to undo" in text_of(pilot, "#step"), "by an earlier app"


async def test_the_order_of_flights_does_not_change_when_other_columns_fit(file: Path) -> None:
    async with opened(file, (170, 50)) as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, FlightsScreen)
        while "miss▼" not in shown(pilot):
            await press(pilot, "s")
        order = list(screen.query_one(Table).keys)
        await pilot.resize_terminal(122, 40)
        while "thrust" in shown(pilot):
            await press(pilot, "_")
        assert "miss▼" in shown(pilot)
        assert screen.query_one(Table).keys == order


@pytest.mark.thorough
async def test_a_draft_of_yesterday_is_a_flight_of_yesterday(file: Path) -> None:
    yesterday = f"{date.today() - timedelta(days=1)}"
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("200"))
    with Ledger.open(file) as ledger:
        assert ledger.draft(STARTED_DRAFT) == {"date_time": f"{date.today()}"}
        ledger.keep_draft(STARTED_DRAFT, {"date_time": yesterday})
    async with opened(file, page="add") as pilot:
        await press(pilot, "ctrl+s", "_")
        assert "Saved flight 13" in words(pilot)
    with Ledger.open(file) as ledger:
        assert f"{ledger.flight('13').date_time:%Y-%m-%d}" == yesterday


async def test_a_flight_stays_open_when_another_rocket_has_one_with_its_number(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter")
        with Ledger.open(file) as ledger:
            ledger.add([Flight("12", "Bee", "Z", "F39", dry_mass=0.4, apogee=100.0)])
        pilot.app.look_round()  # type: ignore[attr-defined]
        await press(pilot, "_")
        assert "12 · Astra B" in words(pilot)
        await press(pilot, "x", "_")
    with Ledger.open(file) as ledger:
        assert [flight.rocket for flight in ledger.flights() if flight.flight_id == "12"] == ["Bee"]


@pytest.mark.thorough
async def test_two_open_apps_have_separate_drafts_and_the_next_app_continues_what_is_left(file: Path) -> None:
    async with opened(file, page="add") as first:
        await press(first, *typed("923"))
        async with opened(file, page="add") as second:
            assert "923" not in shown(second)
            await press(second, *typed("811"))
        assert "811" not in shown(first)
    offered = []
    for _ in range(3):  # apps that stay open together: each unfinished flight is offered once
        offered.append(opened(file, page="add"))
    async with offered[0] as one, offered[1] as two, offered[2] as three:
        assert ["923" in shown(app) for app in (one, two, three)] == [True, False, False]
        assert ["811" in shown(app) for app in (one, two, three)] == [False, True, False]


async def test_a_search_that_ends_leaves_the_panel_in_front(file: Path) -> None:
    found, waiting = looked_at(), Event()

    def look(*_: object, **__: object) -> Findings:
        waiting.wait(30)
        return found

    with patch.object(close_loop, "look", look):
        async with opened(file, page="loop") as pilot:
            pilot.app.post_message(Key("S", "S"))
            while not pilot.app.screen.is_asking("look"):
                await pilot.pause(0.01)
            for _ in range(2):
                pilot.app.post_message(Key("right", None))
            await pilot.pause(0.2)
            waiting.set()
            await press(pilot)
            assert "held-out error" in words(pilot), "a heading of Versions"
            assert "The search of Astra has ended." in words(pilot)


@pytest.mark.parametrize("size", [(80, 24), (120, 36), (160, 50)])
async def test_a_fingerprint_fits_its_panel(size: tuple[int, int], file: Path) -> None:
    with patch.object(close_loop, "look", lambda *_, **__: looked_at()):
        async with opened(file, size, page="loop") as pilot:
            await press(pilot, "S", "_", "n")
            compared = [line for line in shown(pilot).splitlines() if "similar" in line or "differs" in line]
            assert len(compared) > 2
            assert all(re.search(r"[+-]\d\.\d\d.*[+-]\d\.\d\d.* (similar|differs)", line) for line in compared)


async def test_the_ranking_lists_before_a_search_what_it_looks_for(file: Path) -> None:
    async with opened(file, page="loop") as pilot:
        await press(pilot, "left", "down")
        assert "an altimeter that reads high or low 10% of the height" in words(pilot)
        assert "test fly a second altimeter next to it" in words(pilot)
        await press(pilot, "enter")
        assert "No fingerprint yet" in words(pilot)


async def test_the_loop_says_before_a_search_what_it_would_compare(file: Path) -> None:
    async with opened(file, page="loop") as pilot:
        assert "flights 8 of 12: with readouts, without an anomaly tag" in words(pilot)
        assert "not recorded pressure" in words(pilot)
        await press(pilot, "A")  # nothing was found yet
        assert "Press S" in words(pilot)


async def test_a_first_rocket_replaces_the_note_that_there_are_no_flights(tmp_path: Path) -> None:
    async with opened(tmp_path / "ledger.db", page="loop") as pilot:
        await press(pilot, "_")
        assert "No flights yet" in words(pilot)
        with Ledger.open(tmp_path / "ledger.db") as ledger:
            ledger.add([Flight(str(n), "Lark", motor="F24-4W", dry_mass=0.3, apogee=200.0 + n) for n in range(4)])
        pilot.app.changed()
        await press(pilot, "_")
        assert "What would be compared" in words(pilot)
        assert "No flights yet" not in words(pilot)

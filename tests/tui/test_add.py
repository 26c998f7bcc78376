"""Entering a flight on the screen: few keys, nothing is lost, nothing is refused before saving."""

import asyncio
from datetime import UTC, datetime, timedelta, tzinfo
from itertools import count
from pathlib import Path
from threading import Event
from unittest.mock import patch

import pytest
from textual.widgets import Input

from fieldkit.flight import READOUTS
from fieldkit.ledger import Ledger, models
from fieldkit.planning.contest_flight import judged_duration, why_no_score
from fieldkit.services.manual_entry import DRAFT
from fieldkit.tui.add.add_form import Draft
from fieldkit.tui.add.add_page import AddScreen
from fieldkit.tui.add.add_sheet import SaveButton
from fieldkit.tui.add.fields import brief
from fieldkit.tui.next.motor_list import MotorList
from fieldkit.tui.next.next_plan import NextPlan
from tests.pressing import frozen, opened, press, season, shown, text_of, typed, words

CHECK_SHAPES = False

SHORT = ("198", "80", "2.1", "7.9", "4", "5.6", ".3", "195", "5", "45")
"""Ten readouts as short as they come."""
CYCLE = ["f", "enter", "a", *(key for text in SHORT for key in (*typed(text), "enter")), "enter"]
"""A whole cycle from Home: forecast, readouts, saved, the next forecast."""
MAX_KEYS = 44
"""Maximum number of keys of a cycle. [1]"""
READ_OFF = ("923ft", "140mph", "2.14", "7.9", "2.98", "5.6", "-.4", "905", "14mph", "48.3")


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    return tmp_path / "ledger.db"


@pytest.mark.thorough
async def test_ten_readouts_take_fewer_than_45_keys_besides_their_digits(file: Path) -> None:
    keys = ["a"]
    for text in READ_OFF:
        keys += [*typed(text), "enter"]
    keys.append("enter")
    besides = [key for key in keys if not key.isdigit()]
    async with opened(file) as pilot:
        await press(pilot, *keys)
        assert "Saved flight 13" in words(pilot)
    with Ledger.open(file) as ledger:
        flight = ledger.flight("13")
    assert len(besides) < 45
    assert len(flight.readouts()) == 10
    assert (flight.rocket, flight.config, flight.motor, flight.site) == ("Astra", "B", "F39", "North field")
    assert flight.apogee == pytest.approx(281.33, abs=0.01)
    assert flight.eject_altitude == pytest.approx(275.84, abs=0.01)
    assert flight.apogee_to_eject == -0.4
    assert flight.dry_mass == pytest.approx(0.448)


async def test_the_whole_cycle_on_a_known_rocket_takes_44_keys_and_every_step_can_be_undone(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    assert len(CYCLE) <= MAX_KEYS
    async with opened(file, page="home") as pilot:
        for key in CYCLE:
            await press(pilot, key, *(["_"] if key in ("f", "a") else []))
        seen = words(pilot)
        for text in ("Saved flight 13", "Flown 198.0 m", "inside the 90% interval", "Cd 0.", "Next", "Suggested"):
            assert text in seen
        with Ledger.open(file) as ledger:
            assert [change.command for change in ledger.history()[-2:]] == ["forecast", "add"]
        await press(pilot, "u", "_", "u", "_")
        assert "Undone: forecast Astra" in words(pilot)
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 12


async def test_a_forecast_saved_while_a_flight_is_typed_fills_what_was_not_typed(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened(file, (160, 50), page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        await press(pilot, *typed("200"))
        planned = {"rocket": "Astra", "config": "A", "motor": "F24-4W"}
        monkeypatch.setattr("fieldkit.tui.add.add_form.planned_answers", lambda ledger: planned)
        screen.field_app.changed()
        await press(pilot, "_")
        assert [screen.field(name).answer for name in ("config", "motor", "apogee")] == ["A", "F24-4W", "200"]


async def test_the_fields_are_in_the_order_of_the_altimeter(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "2")
        places = [shown(pilot).index(f"{column.title} ") for column in READOUTS]
        assert places == sorted(places)


async def test_a_typo_in_the_third_field_gives_a_note_and_does_not_block(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("923ft"), "enter", *typed("140mph"), "enter", *typed("2.x"), "enter")
        assert "✗ unit 'x'" in shown(pilot)
        await press(pilot, *typed("7.9"), "ctrl+s")
        assert "✗ error Burn time: found" in words(pilot)
        assert pilot.app.focused is not None
        assert pilot.app.focused.id == "in-burn_time"
        await press(pilot, "escape", "ctrl+u", *typed("2.14"), "ctrl+s")
        assert "Saved flight 13" in words(pilot)
    with Ledger.open(file) as ledger:
        assert ledger.flight("13").burn_time == 2.14


@pytest.mark.thorough
async def test_contradictory_figures_are_noted_and_accepted(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("100m"), "enter", *typed("100"), "enter", *typed("2"), "enter", "enter")
        await press(pilot, *typed("2"))
        assert "top speed looks 155% high for " in words(pilot)
        await press(pilot, "enter", "enter", "enter", *typed("150m"))
        assert "! ejection altitude 150 m is above apogee 100 m" in words(pilot)
        await press(pilot, "ctrl+s", "_")
        assert "Save it as it is?" in words(pilot)
        await press(pilot, "y", "_")
        assert "Saved flight 13" in words(pilot)


@pytest.mark.thorough
async def test_every_key_is_saved_and_a_dead_battery_loses_nothing(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("923ft"), "enter", *typed("14"))
        with Ledger.open(file) as ledger:
            assert ledger.draft(DRAFT) == {"apogee": "923ft", "top_speed": "14m/s"}
    async with opened(file, page="add") as pilot:
        assert "Unfinished flight" in words(pilot)
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("apogee").line.value == "923ft"
        assert pilot.app.focused is screen.field("burn_time").line
        await press(pilot, "escape", "ctrl+n")
        assert screen.field("apogee").line.value == ""
        assert screen.field("rocket").line.value == "Astra"
        with Ledger.open(file) as ledger:
            assert ledger.draft(DRAFT) is None
        await press(pilot, "ctrl+z", "_")
        assert screen.field("apogee").line.value == "923ft", "started over by a slip"


async def test_enter_begins_the_next_flight_and_undo_corrects_the_last_one(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("932ft"), "enter", *typed("140"), "ctrl+s")
        assert "Saved flight 13" in words(pilot)
        assert "Enter to add the next flight" in shown(pilot)
        keys = words(pilot).partition("Saved flight 13. u to undo.")[2]
        assert "Enter Add another" in keys
        assert "f Fly" in keys, "as suggested"
        await press(pilot, "u", "_")
        assert "Undone: add 13" in words(pilot)
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("apogee").line.value == "932ft"
        await press(pilot, "1", "2")
        assert pilot.app.focused is screen.field("burn_time").line, "digits are not pages where one comes to type"
        await press(pilot, "up", "up", "ctrl+u", *typed("923ft"), "ctrl+s", "enter", *typed("9"))
        assert screen.field("apogee").line.value == "9"
    with Ledger.open(file) as ledger:
        assert [flight.apogee for flight in ledger.flights()[12:]] == [pytest.approx(281.33, abs=0.01)]


async def test_input_typed_before_the_ledger_is_read_is_added_to_the_draft(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.keep_draft(DRAFT, {"top_speed": "140mph"})
    held, begin = Event(), Draft.begin
    with patch.object(Draft, "begin", lambda self: (held.wait(), begin(self))[1]):
        async with opened(file) as pilot:
            for key in ("a", *typed("92")):
                await pilot.app._press_keys([key])
            for _ in range(1000):
                with Ledger.open(file) as ledger:
                    kept = ledger.draft(DRAFT) or {}
                if kept.get("apogee") == "92m":
                    break
                await asyncio.sleep(0.005)
            held.set()
            assert kept == {"top_speed": "140mph", "apogee": "92m"}
            await press(pilot, *typed("3ft"))
    with Ledger.open(file) as ledger:
        assert ledger.draft(DRAFT) == {"top_speed": "140mph", "apogee": "923ft"}


async def test_another_rocket_has_other_suggestions(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("config").line.focus()
        await press(pilot, *typed("A"), "enter")
        assert screen.field("dry_mass").line.value == "322 g"


async def test_a_digit_too_few_or_too_many_is_noted_from_earlier_flights_on_this_motor(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("19"))
        assert "apogee 19 m is 9.7% of the usual 196 m of this rocket and motor" in text_of(pilot, "#says")
        await press(pilot, *typed("40"))
        assert "apogee 1940 m is 9.9 times the usual 196 m of this rocket and motor" in text_of(pilot, "#says")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("motor").line.focus()
        await press(pilot, "ctrl+u", *typed("E35"), "enter", "_")
        screen.field("apogee").line.focus()
        await press(pilot, "_")
        assert "times the usual" in text_of(pilot, "#says")
        screen.field("motor").line.focus()
        await press(pilot, "ctrl+u", *typed("G80"), "enter", "_")
        screen.field("apogee").line.focus()
        assert "times the usual" not in text_of(pilot, "#says")


async def test_an_unknown_motor_is_reported_with_similar_names(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("motor").line.focus()
        await press(pilot, *typed("F2555"), "enter")
        assert "no motor 'F2555'; did" in words(pilot)


@pytest.mark.thorough
async def test_a_flight_without_a_dry_mass_is_saved_with_a_note(tmp_path: Path) -> None:
    async with opened(tmp_path / "new.db") as pilot:
        await press(
            pilot, "a", *typed("Comet"), "enter", "enter", *typed("C6-5"), "enter", "enter", *typed("104"), "ctrl+s"
        )
        assert "Saved flight 1. u to undo. Without its dry mass it does not constrain Cd." in words(pilot)
        await press(pilot, "u", "_", "down", "down", *typed("90"), "ctrl+s")
        assert "Saved flight 1. u to undo." in words(pilot)


@pytest.mark.thorough
async def test_the_dry_mass_follows_from_the_mass_weighed_with_the_motor(tmp_path: Path) -> None:
    async with opened(tmp_path / "new.db") as pilot:
        await press(
            pilot, "a", *typed("Comet"), "enter", "enter", *typed("F24-4W"), "enter", "enter", *typed("250"), "enter"
        )
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("lift_off_mass").line.focus()
        await press(pilot, *typed("60"), "ctrl+s")
        assert "of AeroTech F24W" in words(pilot)
        assert pilot.app.focused is screen.field("lift_off_mass").line
        screen.field("lift_off_mass").line.value = ""
        await press(pilot, *typed("18oz"), "ctrl+s")
        assert "Saved flight 1. u to undo." in words(pilot)
    with Ledger.open(tmp_path / "new.db") as ledger:
        assert ledger.flight("1").dry_mass == pytest.approx(18 * 0.028349523 - 0.0629, abs=1e-4)


async def test_a_contest_flight_has_its_two_timers_and_its_eggs(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "a", *typed("790ft"))
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("timer_1_s").line.focus()
        await press(pilot, *typed("38.4l"), "ctrl+s")
        assert screen.field("timer_1_s").line.has_focus
        await press(pilot, "backspace", "2", "enter", *typed("38.5"), "enter", *typed("craked"), "ctrl+s")
        assert "Eggs: found 'craked'; did you mean cracked?" in words(pilot)
        assert screen.field("eggs").line.has_focus
        await press(pilot, "ctrl+u", *typed("cracked"), "ctrl+s")
        assert "Saved flight 13" in words(pilot)
        await press(pilot, "1", "e", "end", *["down"] * 40, "ctrl+u", *typed("intact"), "ctrl+s", "_")
        assert "Saved flight 13: eggs" in words(pilot)
        await press(pilot, "u", "_")
    with Ledger.open(file) as ledger:
        flight = ledger.flight("13")
    assert dict(flight.extra) == {"timer_1_s": "38.42", "timer_2_s": "38.5", "eggs": "cracked"}
    assert judged_duration(flight) == 38.46
    assert why_no_score(flight, 1) == "eggs: cracked"


async def test_an_empty_form_is_not_saved(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, "ctrl+s")
        assert "expected at least one; nothing was saved" in words(pilot)
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 12


async def test_help_explains_a_field_and_a_question_mark_is_a_letter_in_the_notes(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, "question_mark")
        assert "Help: Add a flight" in shown(pilot)
        await press(pilot, "escape")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        screen.field("notes").line.focus()
        await press(pilot, "question_mark")
        assert screen.field("notes").line.value == "?"


async def test_an_apogee_far_from_the_forecast_is_questioned_before_it_is_saved(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("65ft"), "ctrl+s")
        assert "The apogee is 65 ft. This flight was expected to reach" in words(pilot), "in the unit that was typed"
        assert "Save it as it is?" in words(pilot)
        await press(pilot, "n")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert pilot.app.focused is screen.field("apogee").line
        with Ledger.open(file) as ledger:
            assert len(ledger.flights()) == 12
        await press(pilot, "ctrl+s", "y")
        assert "Saved flight 13" in words(pilot)
    with Ledger.open(file) as ledger:
        assert ledger.flight("13").apogee == pytest.approx(19.812)


@pytest.mark.thorough
async def test_a_second_flight_like_one_of_today_is_questioned_before_it_is_saved(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, calls = datetime.now().replace(second=0, microsecond=0), count()

    class Clock(datetime):
        """The two flights are entered minutes apart."""

        @classmethod
        def now(cls, tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            return start + timedelta(minutes=next(calls))

    for module in ("fieldkit.services.manual_entry", "fieldkit.importing.manual_entry"):
        monkeypatch.setattr(f"{module}.datetime", Clock)
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("281m"), "ctrl+s", "_", "enter", *typed("281m"), "ctrl+s")
        assert "has the same values" in words(pilot)
        await press(pilot, "n")
        with Ledger.open(file) as ledger:
            assert len(ledger.flights()) == 13
        await press(pilot, "ctrl+s", "y")
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 14


@pytest.mark.thorough
async def test_a_saved_plan_is_the_next_default_and_is_compared_with_its_flight(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    async with opened(file) as pilot:
        await press(pilot, "4", "b", "slash", *typed("f24"), "enter", "_", "enter")
        assert "Saved forecast: AeroTech F24W-4 to" in words(pilot)
        await press(pilot, "2")
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        assert screen.field("config").line.value == "A"
        assert screen.field("motor").answer.startswith("AeroTech F24W-")
        assert screen.field("motor").line.value.startswith("F24W-"), "complete on a short line"
        await press(pilot, *typed("830ft"), "ctrl+s", "_")
        screen_words = words(pilot)
        assert "Saved flight 13. u to undo." in screen_words
        for text in ("Flown 253.0 m", "the 90% interval", "Cd 0.", "on AeroTech F24W-", "Suggested"):
            assert text in screen_words
        await press(pilot, "y", "_")
        assert "Copied: Astra A" in words(pilot)
        await press(pilot, "enter")
        assert pilot.app.focused is screen.field("apogee").line


async def test_undoing_a_saved_forecast_keeps_the_forecasts_of_all_motors(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = []

    def turn_to(motors: MotorList, plan: NextPlan | None) -> None:
        turned(motors, plan)
        kept.append(len(motors.known))

    turned = MotorList.turn_to
    monkeypatch.setattr(MotorList, "turn_to", turn_to)
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("f24"), "enter", "_", "enter", "_", "u", "_")
        assert "Undone: forecast Astra B on AeroTech F24W-4" in words(pilot)
        assert kept[-1] > 0
        await press(pilot, "p", "down", "down", *typed("400g"), "ctrl+s", "_")
        assert kept[-1] == 0, "the forecasts are of another plan"


@pytest.mark.thorough
async def test_saving_a_forecast_can_be_undone_separately(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4", "slash", *typed("f24"), "enter", "_", "enter", "u", "_")
        assert "Undone: forecast Astra" in words(pilot)
    with Ledger.open(file) as ledger:
        assert len(ledger.predictions("Astra")) == 1
        assert len(ledger.flights()) == 12


@pytest.mark.thorough
async def test_a_unit_typed_in_one_field_does_not_change_numbers_typed_earlier(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("281"), *["enter"] * 7, *typed("900ft"), "enter", "ctrl+s", "_")
        assert "Saved flight 13" in words(pilot)
    with Ledger.open(file) as ledger:
        flight = ledger.flight("13")
    assert (flight.apogee, flight.eject_altitude) == (281.0, pytest.approx(274.32))


def test_a_note_without_room_says_only_what_its_field_does_not_show() -> None:
    assert brief("! duration 45 s is 2 times the usual 22.5 s", 36) == "! 2 times the usual 22.5 s"
    assert brief("! duration 45 s is 2 times the usual 22.5 s", 60) == "! duration 45 s is 2 times the usual 22.5 s"
    speed = "! top speed looks 14% low for 5.6 g over 1.15 s; check all three"
    assert brief(speed, 30) == "! top speed looks 14% low"
    assert brief("✗ found the unit 'O', expected mph, such as 180 mph", 36) == "✗ unit 'O'"


async def test_the_unit_beside_a_default_is_the_one_it_is_shown_in(file: Path) -> None:
    async with opened(file, (120, 36), page="add") as pilot:
        await press(pilot, "escape", "N")
        seen = words(pilot)
        assert "Dry mass 15.80 oz Diameter 2.60 in" in seen, seen  # and not the unit again beside it
        await press(pilot, "N", "N")
        assert "Dry mass 448 g Diameter 66 mm" in words(pilot)


@pytest.mark.parametrize("rocket", ["Astra", "Zephyr"])
async def test_an_unknown_mass_and_diameter_are_asked_for_before_the_flight_is_saved(file: Path, rocket: str) -> None:
    async with opened(file, page="add") as pilot:
        screen = pilot.app.screen
        assert isinstance(screen, AddScreen)
        if rocket == "Zephyr":
            screen.field("rocket").line.focus()
            await press(pilot, "ctrl+u", *typed("Zephyr"), "enter", "_")
        screen.field("duration").line.focus()
        await press(pilot, *typed("45"), "enter")
        if rocket == "Zephyr":
            assert pilot.app.focused is screen.field("dry_mass").line
            await press(pilot, *typed("100g"), "enter", *typed("25mm"), "enter")
        assert isinstance(pilot.app.focused, SaveButton)
        seen = words(pilot)
        assert seen.index("Dry mass") < seen.index("Save this flight")


async def test_a_text_longer_than_its_line_shows_its_beginning_after_it_is_left(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        line = pilot.app.screen.query_one("#in-site", Input)
        line.focus()
        await press(pilot, "ctrl+u", *typed("the soccer park by the river"))
        assert line.scroll_offset.x > 0
        await press(pilot, "up")
        assert line.scroll_offset.x == 0


async def test_the_rocket_and_its_flights_fill_the_rest_of_the_form_at_120x36(file: Path) -> None:
    async with opened(file, (120, 36), page="add") as pilot:
        await press(pilot, "_")
        assert "apogee [m], flight by flight" in words(pilot)

"""The decisions for a motor on the Fly page: delay, ballast and contest points, by keys, with every safety line."""

import re
from datetime import datetime, timedelta
from pathlib import Path
from unittest.mock import patch

import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fieldkit.errors import NoFlights
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.services.contest_day import keep_day
from fieldkit.services.launch_day import planned_mass
from fieldkit.services.sites import site_of
from fieldkit.tui.setup import site_form
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.tabs import TabLine
from tests.pressing import at_home, calm, opened, press, shown, text_of, typed, words

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


def screen_text(pilot: Pilot[None]) -> str:
    """The current answer and the text next to it."""
    return f"{text_of(pilot, '#answer')} {text_of(pilot, '#beside')}"


async def front(pilot: Pilot[None], name: str) -> None:
    """Click on the name of an answer, skipping those between."""
    tabs = pilot.app.screen.query_one(TabLine)
    await pilot.click(TabLine, offset=(str(tabs.content).index(name) + 1, 0))
    await calm(pilot)


async def test_a_tall_or_wide_screen_shows_the_coast_below_the_delays(file: Path) -> None:
    async with opened(file, (120, 50), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "_")
        assert "Coast to apogee; lines are the delays" in words(pilot)
        await press(pilot, "right", "_")
        assert "Coast to apogee" not in words(pilot)
        assert pilot.app.screen.query_one("#first").display, "the apogee"
    async with opened(file, (100, 30), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "_")
        assert "When each delay fires" in words(pilot)
        assert not pilot.app.screen.query_one("#first").display


@pytest.mark.thorough
async def test_delay_ballast_and_contest_of_a_motor_by_keys(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d")
        assert "Astra B on AeroTech F39T: coasts" in screen_text(pilot)
        await press(pilot, "exclamation_mark")
        assert "field size: unknown" in screen_text(pilot)
        await press(pilot, "right")
        assert "No target yet" in screen_text(pilot)
        assert "Apogee on the altimeter; filled 90%" in text_of(pilot, "#title"), "the forecast as the rocket is"
        await press(pilot, "right")
        assert "season 2027" in words(pilot)
        assert "fitted to 1 flight" in screen_text(pilot)
        assert "contest mass: ok" in screen_text(pilot)
        await press(pilot, "comma")
        assert "season 2026" in words(pilot)
        await press(pilot, "left", "g", *typed("800ft"), "enter")
        assert "target 244 m" in screen_text(pilot)
        assert "the range safety officer decides" in screen_text(pilot)


@pytest.mark.thorough
async def test_the_accuracy_of_the_rockets_forecasts_is_shown_with_decisions(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", *["left"] * 3)
        about = text_of(pilot, "#about")
        for text in ("the mean miss of forecasts", "7 flights of Astra, each from the earlier ones", "6 of 7 inside"):
            assert text in about
        seen = screen_text(pilot)
        for text in ("these forecasts", "its last apogee on the motor", "Clearly nearer than a simulation as it is"):
            assert text in seen
        assert "CRPS" not in seen


async def test_a_rocket_with_one_flight_shows_it_and_its_next_forecast_in_place_of_a_score(file: Path) -> None:
    one = Flight(flight_id="1", rocket="Lark", motor="F39-6T", dry_mass=0.4, diameter=0.066, apogee=190.0)
    with Ledger.open(file) as ledger:
        ledger.add([one.with_changes(date_time=datetime(2026, 9, 1))])
    async with opened(file, (160, 50), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", *["left"] * 3)
        seen = screen_text(pilot)
        assert "A score needs two normal flights with an apogee; Lark has 1." in seen
        assert "Flights so far 1 2026-09-01 F39-6T 190.0 m The next flight Lark on AeroTech F39T" in seen
        assert "Apogee of the next flight on F39T" in text_of(pilot, "#title")
        assert "◆" in shown(pilot)
        await press(pilot, "left")
        assert "No saved forecasts of this rocket yet" in screen_text(pilot)
        assert "Flights so far 1 2026-09-01" in screen_text(pilot)


@pytest.mark.thorough
async def test_ballast_has_three_goals_and_the_parachute_is_part_of_the_plan(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "j")
        assert "No target yet" in screen_text(pilot)
        await press(pilot, "j", "j", "exclamation_mark")
        assert "per flight, with duration" in screen_text(pilot)
        assert "contest mass: ok" in screen_text(pilot)
        await press(pilot, "left_square_bracket")
        assert "parachute 95% of the area flown" in screen_text(pilot)
        assert "by this rule" in screen_text(pilot)


@pytest.mark.thorough
async def test_the_contest_day_its_cut_and_its_field_are_entered_where_they_are_used(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "e")
        await press(pilot, *typed("640ft"), "enter", *typed("40-37"), "enter", "ctrl+s")  # to the typo
        assert "expected seconds" in words(pilot)
        await press(pilot, "ctrl+u", *typed("30-50"), "enter", *typed("60"), "enter", *typed("1,9,12"), "enter")
        await press(pilot, *typed("700mm"), "enter", *typed("400m"), "enter", *typed("300"), "ctrl+s")
        await press(pilot, "exclamation_mark")
        seen = screen_text(pilot)
        assert "target 640 ft" in seen
        assert "window 30 to 50 s" in seen
        assert "sum to 60 or less" in seen
        assert "best 2 of 1, 9, 12" in seen
        assert "contest length: ok" in seen
        assert "wind not given; drifts" in seen  # what it requires, beside it
        assert "ceiling: ok" in seen
        await press(pilot, "e", "ctrl+u", "ctrl+s")
        assert "target 800 ft" in screen_text(pilot)  # the season's own again
        await press(pilot, "u", "_")
        assert "target 640 ft" in screen_text(pilot)
    with Ledger.open(file) as ledger:
        assert (site_of(ledger, "North field").size, site_of(ledger, "North field").ceiling) == (400.0, 300.0)


@pytest.mark.thorough
async def test_flights_timed_by_stopwatch_or_without_a_score_are_marked(file: Path) -> None:
    with Ledger.open(file) as ledger:
        flown = ledger.flight("12")
        timed = flown.with_changes(flight_id="13", extra={"timer_1_s": "38.21"})
        ledger.add([timed, flown.with_changes(flight_id="14", extra={"eggs": "cracked"})])
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "_")
        await front(pilot, "Contest")
        seen = screen_text(pilot)
        assert "fitted to 2 flights" in seen
        assert "no score, count as attempts: 14 (eggs: cracked)" in seen
        alone = re.split(r"[^\d, ]", seen.partition("altitude only, no duration:")[2])[0].replace(",", " ").split()
        assert "12" in alone
        assert "13" not in alone


@pytest.mark.thorough
async def test_a_rocket_can_be_entered_as_weighed_with_its_motor(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "e")
        await press(pilot, *["down"] * 7, *typed("50g"))
        await press(pilot, "ctrl+s")
        assert "expected more than the mass of 60.6 g" in words(pilot)
        await press(pilot, "ctrl+u", *typed("520g"), "ctrl+s", "_")
        await front(pilot, "Contest")
        await press(pilot, "exclamation_mark")
        assert "contest mass: ok: 520 g" in screen_text(pilot)
        await press(pilot, "escape", "escape", "_")
        assert "459 g dry" in words(pilot)
        await press(pilot, "u", "_", "d", "_")
        await front(pilot, "Contest")
        await press(pilot, "exclamation_mark")
        assert "contest mass: ok: 508.6 g" in screen_text(pilot)


async def test_a_site_is_edited_in_place_with_the_fields_of_its_safety_checks(file: Path) -> None:
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right", "right", "enter", "ctrl+u", *typed("South field"), "enter", "down")
        await press(pilot, *typed("400 m"), "enter", *typed("-3"), "ctrl+s")
        assert "above zero" in words(pilot)
        await press(pilot, "ctrl+u", *typed("3000ft"), "ctrl+s", "_")
        assert "South field 210.0 m 400.0 m 914.4 m 12" in words(pilot)
        with Ledger.open(file) as ledger:
            assert site_of(ledger, "South field").ceiling == pytest.approx(914.4)
        await press(pilot, "u", "_")  # the name in twelve flights, size and ceiling: one change
        assert "North field 210.0 m 12" in words(pilot)
        assert "South field" not in words(pilot)
        await press(pilot, "escape", "U", "_")
        assert "South field 210.0 m 400.0 m 914.4 m 12" in words(pilot)


@pytest.mark.thorough
async def test_saved_forecasts_are_listed_and_stale_ones_have_a_reason(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d")
        await front(pilot, "Saved")
        assert "flown: F39 B" in screen_text(pilot)
        await press(pilot, "escape", "enter", "_", "d")
        await front(pilot, "Saved")
        assert "open: AeroTech F39T" in screen_text(pilot)
        with Ledger.open(file) as ledger:
            ledger.add([Flight(flight_id="13", rocket="Astra", config="B", motor="F39-6T", dry_mass=0.4, apogee=200.0)])
        await press(pilot, "escape", "escape", "d")  # the first reads the notice
        await front(pilot, "Saved")
        assert "stale now: flight 13 added since" in screen_text(pilot)


@pytest.mark.sampled
@pytest.mark.parametrize("keys", [(), ("enter", "_")], ids=["day", "flight"])
async def test_a_report_is_written_to_the_flyers_file(
    file: Path, keys: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(file.parent)
    monkeypatch.setattr("fieldkit.presentation.report.write.picture", lambda *_: b"a picture")
    with patch("fieldkit.presentation.report.book.look", side_effect=NoFlights("too few")):
        async with opened(file) as pilot:
            await press(pilot, "1", *keys, "w", "ctrl+u", *typed("card.doc"), "enter", "_")
            assert "expected a name that ends in .html" in words(pilot)
            await press(pilot, "escape", "w", "ctrl+u", *typed("card.md"), "enter", "_")
            assert "Wrote the report to card.md" in words(pilot)
            file.with_name("card.md").rename(file.with_name("old.md"))  # its pictures stay
            await press(pilot, "w", "ctrl+u", *typed("card.md"), "enter", "_")
            assert "exists. Replace it?" in words(pilot)
            await press(pilot, "y", "_")
            assert "Wrote the report to card.md" in words(pilot)
    assert (
        file.with_name("card.md").read_text().startswith("# Astra B · flight 12" if keys else "# Launch day 2026-04-18")
    )


async def test_safety_is_shown_on_the_next_page_at_any_size(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("f24"), "enter")
        assert "not given" in words(pilot)
        await press(pilot, "exclamation_mark")
        for name in ("rail exit speed", "ejection speed", "ground wind", "ceiling", "thrust to weight", "class"):
            assert name in text_of(pilot, "#safety")
        await press(pilot, "p", *["down"] * 13, *typed("warm"), "ctrl+s")
        assert "motor temperature: found 'warm'" in words(pilot)


@pytest.mark.thorough
async def test_a_landing_is_drawn_from_the_side_and_on_the_field(file: Path) -> None:
    with Ledger.open(file) as ledger:
        keep_day(ledger, 2027, site=Site("North field", size=400.0))
    async with opened(file, (160, 50), page="home") as pilot:
        await press(pilot, "4", "_", "d", "_", "right", "right", "right", "_")
        assert "not given: press p on the Fly page to enter it" in text_of(pilot, "#answer")
        assert not pilot.app.screen.query_one("#second").display, "where it lands is not known without a wind"
        assert "Drift on the way down by the wind at the pad" in text_of(pilot, "#title")
        assert "edge of the field 200 m" in text_of(pilot, "#intervals")
        await press(pilot, "escape", "0", "e", *typed("3m/s"), "ctrl+s", "_", "4", "_", "d", "_", *["left"] * 5)
        answer = text_of(pilot, "#answer")
        assert "ellipse 90% of landings" in answer
        assert "400 m" in answer
        caption = text_of(pilot, "#title")
        assert "circle the field" in caption
        assert "from the side" in caption
        assert "from above" in caption
        assert "left" not in caption, "the plots may be stacked"
        for name in ("#first", "#second"):
            drawn = str(pilot.app.screen.query_one(name, Plot).render())
            assert "▲" in drawn
            assert len(set(drawn)) > 20, "lines of Braille"


def test_unedited_lengths_of_a_site_keep_their_precision() -> None:
    site = Site("North field", elevation=210.44, size=400.44)
    texts = {"site": site.name, "site_elevation": "210.4 m"} | site_form.room(site, "SI")
    values = {name: site_form.read(name, text, site_form.units("SI").get(name, "")) for name, text in texts.items()}
    assert site_form.answered(site, values, texts, "SI") == site
    assert site_form.answered(site, values | {"size": 400.41}, texts, "SI").size == 400.41


@pytest.mark.thorough
async def test_a_mass_typed_for_one_configuration_is_not_used_for_another(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "p", "down", "down", "ctrl+u", *typed("450.4g"), "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            assert planned_mass(ledger) == pytest.approx(0.4504)
        await press(pilot, "p", *["down"] * 3, "ctrl+u", *typed("70mm"), "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            assert planned_mass(ledger) == pytest.approx(0.4504)
        await press(pilot, "p", "down", "ctrl+u", *typed("A"), "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            assert planned_mass(ledger) is None


async def test_a_plan_shows_the_mass_and_diameter_that_its_forecast_uses(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "p")
        assert pilot.app.screen.query_one("#in-dry_mass", Input).value == "448 g"
        await press(pilot, "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            assert planned_mass(ledger) is None, "still that of the last flight"
        await press(pilot, "p", "down", "ctrl+u", *typed("A"), "ctrl+s", "_", "p")
        assert pilot.app.screen.query_one("#in-dry_mass", Input).value == "322 g", "as configuration A flew last"


async def test_a_site_is_added_before_anything_flies_there(file: Path) -> None:
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right", "right", "i", "ctrl+s")
        assert "found no name" in words(pilot)
        await press(
            pilot, "escape", "i", *typed("Hill"), "enter", *typed("300m"), "enter", *typed("1200ft"), "ctrl+s", "_"
        )
        assert "Hill 300.0 m 365.8 m 0" in words(pilot)
        await press(pilot, "u", "_")
        assert "Hill 300.0 m" not in words(pilot)


async def test_a_flight_added_by_another_program_is_used_in_an_open_decision(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldkit.tui.app.LOOK_INTERVAL", 0.05)
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "_")
        before = screen_text(pilot)
        with Ledger.open(file) as ledger:
            flown = ledger.flight("12")
            ledger.add([flown.with_changes(flight_id="13", apogee=flown.apogee and flown.apogee + 30)])
        await pilot.pause(0.2)
        await press(pilot, "_")
        assert screen_text(pilot) != before, "terminals side by side report no focus"


def test_an_elevation_typed_for_a_site_without_one_is_saved() -> None:
    texts = {"site_elevation": "", **site_form.room(Site("Field"), "SI")}
    values = {"site": "Field", "site_elevation": 210.0, "size": None, "ceiling": None}
    assert site_form.answered(Site("Field"), values, texts, "SI").elevation == 210.0

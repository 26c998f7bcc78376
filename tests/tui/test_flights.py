"""The table of flights, one flight in full, and tags with their effects."""

import asyncio
import re
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from rich.color import Color as RichColor
from textual.events import AppFocus
from textual.pilot import Pilot
from textual.widgets import Input

from fieldkit.flight import TAGS, Flight
from fieldkit.ledger import Ledger
from fieldkit.services.imports import bring_in
from fieldkit.settings import change_settings
from fieldkit.tui.flights.flight_rows import columns
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.flights.flights_page import FlightsScreen
from fieldkit.tui.next.intervals import HeightScale
from fieldkit.tui.setup.rocket_strip import RocketStrip
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.plots import Ink, Plot, below_line, filled_columns, label_flights
from fieldkit.tui.widgets.scrollbar import SpacedBar
from fieldkit.tui.widgets.table import Table
from tests.pressing import ROOT, calm, frozen, hurry, opened, press, season, shown, text_of, typed, words

CHECK_SHAPES = False
LOG = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    return tmp_path / "ledger.db"


def table_keys(pilot: Pilot[None]) -> list[str]:
    return list(pilot.app.screen.query_one(Table).keys)


async def test_flights_are_listed_newest_first_with_their_figures(file: Path) -> None:
    async with opened(file) as pilot:
        assert table_keys(pilot) == [str(number) for number in range(12, 0, -1)]
        line = next(line for line in shown(pilot).splitlines() if line.startswith("▸12"))
        assert line.split()[1:7] == ["2026-04-18", "Astra", "B", "F39", "198.1", line.split()[6]]
        assert 0.4 < float(line.split()[6]) < 1.6
        assert "+4.1" in line


async def test_a_flight_without_a_diameter_has_an_empty_cd(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(flight_id="1", rocket="Lark", motor="F24-4W", dry_mass=0.322, apogee=281.3)])
    async with opened(tmp_path / "ledger.db", (160, 50)) as pilot:
        await press(pilot, "_")
        line = next(line for line in shown(pilot).splitlines() if line.startswith("▸1"))
        assert 0.8 < float(line.split()[4]) < 1.2, "alpha"
        assert "nan" not in shown(pilot)


async def test_forecast_flown_and_target_are_drawn_from_100_columns(file: Path) -> None:
    change_settings({"target": 243.84}, file.with_name("settings.json"))
    for page in ("flights", "home"):
        async with opened(file, (100, 30), page=page) as pilot:
            lines = shown(pilot).splitlines()
            assert next(line for line in lines if line.startswith(("▸12", " ▸12"))).count("├─") == 1
            assert sum("◎" in line and "◆" in line for line in lines) > 8
            await press(pilot, *["s"] * 9)
            assert ("ast ◆ ◎▲" in shown(pilot)) == (page == "flights"), "sorted by forecasts"
            await pilot.resize_terminal(80, 24)
            while pilot.app.screen.query_one(Table).size.width > 80:
                await pilot.pause()
            await press(pilot, "_")
            assert "├─" not in "".join(
                line for line in shown(pilot).splitlines() if "Astra" in line and "198.1" in line
            )


async def test_a_filter_narrows_while_typed_and_accepts_any_words(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "slash", *typed("weak"))
        assert table_keys(pilot) == ["6", "5"]
        await press(pilot, *typed(" e35 2026-04"))
        assert table_keys(pilot) == ["6", "5"]
        await press(pilot, *typed("x"))
        assert table_keys(pilot) == []
        assert "0 of 12" in shown(pilot)


async def test_in_a_filter_letters_and_the_slash_are_text(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "slash", *typed("a/b"), "left", "backspace", "slash")
        assert pilot.app.screen.query_one(Input).value == "a/b"


async def test_the_line_of_keys_keeps_its_height_when_a_search_is_typed(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4")
        table, keys = pilot.app.screen.query_one(Table), pilot.app.screen.query_one(KeyBar)
        before = (table.region, keys.region)
        await press(pilot, "slash")
        assert (table.region, keys.region) == before
        assert "Enter Done" in str(keys.content)


async def test_any_column_can_be_sorted_by_key_and_by_mouse(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "s", "s", "s", "s")
        assert "apogee▼" in shown(pilot)
        assert table_keys(pilot)[0] == "2"
        await press(pilot, "z")
        assert table_keys(pilot)[0] == "6"
        await pilot.click(Table, offset=(2, 0))
        await press(pilot)
        assert table_keys(pilot)[0] == "1"


async def test_a_second_click_opens_the_flight(file: Path) -> None:
    async with opened(file) as pilot:
        await pilot.click("Table", offset=(10, 3))
        await pilot.click("Table", offset=(10, 3))
        await press(pilot)
        assert "10 · Astra B · F39" in shown(pilot)


async def test_a_flight_opens_with_readouts_posterior_and_forecast(file: Path) -> None:
    async with opened(file, (160, 50)) as pilot:
        await press(pilot, "end", "up", "enter")
        seen = words(pilot)
        assert "2 · Astra A · F24-4W · 2026-04-18 10:25" in seen
        assert "Apogee 281.3 m" in seen
        assert "Top speed 83.4 m/s" in seen
        assert "what the other flights lead to expect" in seen
        assert "no log with samples" in seen
        await press(pilot, "escape", "home", "enter")
        assert "forecast of 2026-04-17 18:00, without a correction" in words(pilot)
        assert "flown 198.1 m: 4.1 m higher, inside the interval" in words(pilot)
        assert "◆" in shown(pilot)


async def test_a_flight_that_no_fit_can_use_says_why(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(flight_id="1", rocket="Kestrel", motor="F24-4W", apogee=200.0)])
        ledger.add([Flight(flight_id="2", rocket="Kestrel", motor="F24-4W", apogee=200.0, dry_mass=0.322)])
    async with opened(tmp_path / "ledger.db", (120, 36)) as pilot:
        await press(pilot, "1", "home", "enter")
        assert "Used in the model" in words(pilot)
        await press(pilot, "escape", "end", "enter")
        assert "Not used in the model: no dry mass" in words(pilot)


async def test_a_tall_terminal_shows_the_rocket_below_a_flight_without_a_log(file: Path) -> None:
    async with opened(file, (250, 60)) as pilot:
        await press(pilot, "enter")
        assert pilot.app.screen.query_one(RocketStrip).display
        assert "Astra B" in text_of(pilot, "RocketStrip Static")
    async with opened(file, (250, 30)) as pilot:
        await press(pilot, "enter")
        assert not pilot.app.screen.query_one(RocketStrip).display


async def test_a_plot_fills_its_area_after_the_terminal_has_grown(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter")
        plot = pilot.app.screen.query_one("#drag", Plot)
        await pilot.resize_terminal(250, 40)
        while plot.size.width <= 80:  # Textual arranges a page again some time after its terminal has grown
            await calm(pilot)
            await asyncio.sleep(0.01)
        assert max(map(len, str(plot.render()).splitlines())) == plot.size.width


async def test_a_flight_opened_after_another_shows_nothing_of_it(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "end", "up", "enter", "y", "escape", "escape")
        second = pilot.app.clipboard
        await hurry(pilot, "down", "enter", "escape", "up", "up", "enter")
        await press(pilot, "y", "escape")
        third, screen_words = pilot.app.clipboard, words(pilot)
        assert second.startswith("2 · Astra")
        assert third.startswith("3 · Astra")
        assert "83.4" in second
        assert "83.4" not in third
        assert third.count("Cd  ") == third.count("thrust  ") == 1
        assert "3 · Astra" in screen_words
        assert "2 · Astra" not in screen_words


async def test_enter_typed_twice_opens_a_flight_once(file: Path) -> None:
    async with opened(file) as pilot:
        table = pilot.app.screen.query_one(Table)
        await table.action_choose()
        await table.action_choose()
        await press(pilot, "_")
        assert "12 · Astra" in words(pilot)
        await press(pilot, "escape")
        assert table_keys(pilot)


async def test_a_flight_opens_in_the_newly_chosen_colors(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter", "escape", "T", "enter")
        assert pilot.app.theme == "sun"
        assert pilot.app.screen.styles.background.rgb == (255, 255, 255)


async def test_a_log_is_plotted_with_its_events(tmp_path: Path) -> None:
    from fieldkit.services.imports import bring_in
    from fieldkit.tui.flights.log_plot import POINTS, Drawn, drawn
    from tests.pressing import ROOT

    log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        (id,) = bring_in(ledger, [log], lambda name: None, defaults={"rocket": "Comet"}).ids
        plotted = drawn(ledger, id, "SI")
        assert isinstance(plotted, Drawn)
        assert POINTS / 2 < max(len(trace.time) for trace in plotted.traces.values()) <= POINTS
    async with opened(tmp_path / "ledger.db", (160, 90)) as pilot:
        await press(pilot, "enter")
        seen = words(pilot)
        assert "PerfectFlite" in seen
        for what in ("altitude [m]", "speed [m/s]", "acceleration [g]", "lift-off", "burnout", "apogee"):
            assert what in seen
        assert "liftoff" not in seen
        await press(pilot, "l", "end")
        assert "T+" in text_of(pilot, "#cursor")
        assert "m/s" in text_of(pilot, "#cursor")
        assert "device: 161.5" in text_of(pilot, "#facts")
        await press(pilot, "escape")
        assert "PerfectFlite" in words(pilot)


async def test_the_effect_of_a_tag_is_shown_at_once_and_can_be_undone(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "end", "up", "t")
        assert "2 · Astra A" in shown(pilot)
        assert "based on 8 normal flights" in words(pilot)
        for tag in list(TAGS)[:5]:
            assert tag in shown(pilot)
        await press(pilot, "down", "enter")
        assert "now 7 normal flights" in words(pilot)
        assert "[x] off_axis" in shown(pilot)
        with Ledger.open(file) as ledger:
            assert ledger.flight("2").tags == ("off_axis",)
        await hurry(pilot, "space", "space", "u", "u", "u")
        assert "based on 8 normal flights now" not in words(pilot)
        with Ledger.open(file) as ledger:
            assert ledger.flight("2").tags == ()


@pytest.mark.parametrize("keys", [("x",), ("enter", "delete")], ids=["table", "flight"])
async def test_a_flight_is_removed_and_restored(file: Path, keys: tuple[str, ...]) -> None:
    async with opened(file) as pilot:
        await press(pilot, *keys, "_")
        assert "Removed flight 12. u to undo" in words(pilot)
        assert "11 of 11" in shown(pilot)
        await press(pilot, "u", "_")
        assert "12 of 12" in shown(pilot)


async def test_changes_of_the_ledger_by_another_program_are_shown(file: Path) -> None:
    async with opened(file) as pilot:
        with Ledger.open(file) as ledger:
            ledger.remove("12")
        await press(pilot, "6", "1")
        assert "11 of 11" in shown(pilot)
        with Ledger.open(file) as ledger:
            ledger.undo()
        pilot.app.post_message(AppFocus())
        await calm(pilot)
        assert "12 of 12" in shown(pilot)


async def test_a_user_can_type_a_new_tag(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "t", "end", "enter", *typed("windy"), "enter")
        assert "[x] windy" in shown(pilot)


async def test_a_flight_is_edited_in_the_form_of_the_add_page_and_typos_are_questioned(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "end", "up", "enter", "e", *["down"] * 4, *typed("2o2"), "ctrl+s")
        assert "✗ found '2o2', expected a number" in words(pilot)
        await press(pilot, "ctrl+u", *typed("900ft"), "up", *typed("2026-13-40"), "ctrl+s")
        assert "expected a date" in words(pilot)
        await press(pilot, "ctrl+u", *typed("2026-05-02"), "up", *typed("F24-W4"), "ctrl+s")
        assert "did you mean F24-4W" in words(pilot)
        await press(pilot, "n", "ctrl+u", *typed("f24"), "down", "enter", "ctrl+s")
        assert "Saved flight 2: date, apogee. u to undo" in words(pilot)
        with Ledger.open(file) as ledger:
            flight = ledger.flight("2")
            assert flight.apogee == pytest.approx(274.32)
            assert f"{flight.date_time}" == "2026-05-02 00:00:00"
            assert flight.motor == "F24-4W"
        await press(pilot, "escape", "u", "_")
        with Ledger.open(file) as ledger:
            assert ledger.flight("2").apogee == pytest.approx(281.3)


async def test_a_flight_is_edited_from_the_list_and_escape_leaves_at_once_what_is_over_it(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "e", *["down"] * 4, "ctrl+u", *typed("201m"), "ctrl+s", "_")
        assert "Saved flight 12: apogee" in words(pilot)
        await press(pilot, "t", "enter")
        await press(pilot, "u")
        assert "Undone: tag" in words(pilot)
        await press(pilot, "escape")
        assert table_keys(pilot)[0] == "12"
        assert "201.0" in words(pilot)


async def test_an_arrow_held_down_in_a_form_stays_on_its_last_or_first_field(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "e", *["down"] * 40)
        assert pilot.app.focused is pilot.app.screen.query(Input).last()
        await press(pilot, *["up"] * 40)
        assert pilot.app.focused is pilot.app.screen.query(Input).first()
        await press(pilot, "escape", "a", *["down"] * 40)
        assert pilot.app.focused is pilot.app.screen.query(Input).last()


async def test_keys_typed_before_the_flights_are_read_act_on_the_first_one(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await hurry(pilot, "1", "e", *["down"] * 4, *typed("201m"), "ctrl+s")
        assert "Saved flight 12: apogee" in words(pilot)
    async with opened(file, page="home") as pilot:
        await hurry(pilot, "1", "enter", "t")
        assert "weak_launch" in words(pilot)
        await press(pilot, "escape")
        assert isinstance(pilot.app.screen, FlightScreen)
    async with opened(file, page="home") as pilot:
        await hurry(pilot, "1", "down", "down", "enter")
        assert "10 · Astra B" in words(pilot)


async def test_y_copies_the_row_and_the_card(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "y")
        assert pilot.app.clipboard.startswith("id 12  date 2026-04-18  rocket Astra  cfg B  motor F39  apogee 198.1")
        await press(pilot, "question_mark", "y", "escape")
        assert "fieldkit remove FLIGHT" in pilot.app.clipboard
        await press(pilot, "enter", "y")
        assert "Apogee" in pilot.app.clipboard
        assert "thrust" in pilot.app.clipboard


async def test_text_from_files_is_shown_without_markup_and_escapes(tmp_path: Path) -> None:
    bad = "[red]Nasty[/] \x1b[31m$x \u202e"
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(flight_id="1", rocket=bad, motor=bad, apogee=100.0, notes=bad, tags=(bad,), site="[b]x")])
    async with opened(tmp_path / "ledger.db", (160, 50)) as pilot:
        for keys in ([], ["enter"], ["t"], ["escape", "escape", "6", "right"], ["right"], ["2"]):
            await press(pilot, *keys)
            assert "\x1b" not in shown(pilot)
            assert "\u202e" not in shown(pilot)
            if keys != ["right"]:
                assert "[red]N" in shown(pilot), keys


async def test_a_damaged_ledger_gives_a_notice_and_not_a_crash(tmp_path: Path) -> None:
    (tmp_path / "ledger.db").write_bytes(b"not a ledger at all, " * 100)
    async with opened(tmp_path / "ledger.db") as pilot:
        assert "this file is not a ledger" in words(pilot)
        for page in ("0", "1", "5"):
            await press(pilot, page, "_")
            assert "not available because of an error" in words(pilot)
            assert " ..." not in words(pilot).replace("tag, month ...", "")
        await press(pilot, "4", "_", "6")
        assert "error" in words(pilot)


LOSSES = {
    "removed": lambda file: file.unlink(),
    "emptied": lambda file: file.write_bytes(b""),
    "overwritten": lambda file: file.write_bytes(b"not a ledger at all, " * 1000),
    "a folder now": lambda file: (file.unlink(), file.mkdir()),
}


@pytest.mark.skipif(sys.platform == "win32", reason="a file that is open cannot be removed")
@pytest.mark.sampled
@pytest.mark.parametrize("loss", LOSSES)
async def test_a_ledger_lost_under_the_app_gives_a_notice_and_not_a_crash(file: Path, loss: str) -> None:
    async with opened(file) as pilot:
        LOSSES[loss](file)
        await press(pilot, "enter", "t", "escape", "escape", "r", "_", "y", "e", "escape", "escape")
        await press(pilot, *"234561", "ctrl+z", "U")
        await press(pilot, "2", *typed("Astra"), "tab", "ctrl+s", "_", "escape", "escape", "1", "ctrl+p")
        await press(pilot, *typed("astra"), "enter", "escape", "6", "1")
        assert pilot.app.is_running
        assert pilot.app.errors == []
    assert loss != "removed" or not file.exists(), "the app makes no ledger in place of a lost one"


async def test_beside_the_table_are_the_cd_of_the_configuration_and_the_climb_from_the_log(file: Path) -> None:
    with Ledger.open(file) as ledger:
        bring_in(ledger, [LOG], lambda name: None, defaults={"rocket": "Comet"})
    async with opened(file) as pilot:
        await press(pilot, "slash", *typed("comet"), "enter")
        assert "Readouts" not in shown(pilot)
        await pilot.resize_terminal(160, 50)  # the terminal grows while the page is open
        for _ in range(100):  # the log is read once the cursor rests
            if "altitude [m]" in shown(pilot):
                break
            await asyncio.sleep(0.05)
        await calm(pilot)
        assert "burnout" in shown(pilot)
        assert "flight by flight" not in shown(pilot), "one flight is no course"
        await press(pilot, "escape", "slash", "ctrl+u", *typed("f39"), "enter")
        assert "Cd of each flight of Astra B" in shown(pilot)
        assert "altitude [m]" not in shown(pilot)
        await press(pilot, "down", "down")
        below = pilot.app.screen.query_one(Table).region.bottom
        assert sum(line.count("●") for line in shown(pilot).splitlines()[below:]) == 4
        for _ in range(600):  # compared once the cursor rests
            if "Flight 10 flew" in words(pilot):
                break
            await asyncio.sleep(0.05)
        assert "Flight 10 flew" in words(pilot), "why it missed"


@pytest.mark.thorough
async def test_an_empty_ledger_shows_how_to_begin(tmp_path: Path) -> None:
    async with opened(tmp_path / "ledger.db") as pilot:
        assert "No flights yet" in words(pilot)
        await press(pilot, "enter", "t", "y", "4")
        assert "No plan yet. p to enter one" in words(pilot)
        await press(pilot, "5")
        assert "describe a rocket or load the demo rocket" in words(pilot)
        assert "error" not in words(pilot)
        await press(pilot, "S", "A", "escape", "4")
        await press(pilot, "p", *typed("Comet"), "enter", "enter", *typed("80g"), "enter", *typed("25mm"), "ctrl+s")
        await press(pilot, "slash", *typed("c6"))
        assert "Comet · 80 g dry" in words(pilot)
        assert "no flights of it, only other rockets" in text_of(pilot, "#more")


@pytest.mark.thorough
async def test_editing_a_flight_keeps_hidden_decimals_and_seconds(file: Path) -> None:
    when = datetime(2026, 5, 1, 10, 30, 15)
    with Ledger.open(file) as ledger:
        ledger.edit("2", date_time=when)
        ledger.add([Flight("2", "Comet", apogee=90.0)])
    async with opened(file) as pilot:
        await press(pilot, "/", *typed("comet"), "enter", "enter", "e", "ctrl+u", *typed("Vega"), "ctrl+s", "y", "_")
        assert "Saved flight Vega/2: rocket" in words(pilot)
        assert "no flight" not in words(pilot)
        await press(pilot, "escape", "escape", "/", "ctrl+u", *typed("Astra/2"), "enter", "enter")
        await press(pilot, "e", *["down"] * 4, "ctrl+u", *typed("281.34"), "ctrl+s", "_")
    with Ledger.open(file) as ledger:
        flight = ledger.flight("Astra/2")
    assert (flight.date_time, flight.apogee) == (when, 281.34)


async def test_a_log_read_while_the_page_closes_is_discarded(file: Path) -> None:
    async with opened(file, (160, 60)) as pilot:
        page = pilot.app.screen
        assert isinstance(page, FlightsScreen)
        await page.query(Table).remove()
        page._have_log("12", "no log")
        assert not pilot.app.errors


async def test_the_latest_error_is_shown_before_older_ones_and_undo_names_the_key_for_redo(file: Path) -> None:
    """An error of minutes ago hid why the flight just typed could not be saved."""
    async with opened(file, page="home") as pilot:
        await press(pilot, "u", "y")
        assert "U to redo" in words(pilot)
        await press(pilot, "U")
        assert "Redone: " in words(pilot)
        assert "u to undo" in words(pilot)
        await press(pilot, "U", "2", *typed("9.9.9"), "ctrl+s")
        assert "✗ error Apogee: found '9.9.9'" in words(pilot)
        assert "(1 more)" in words(pilot)
        await press(pilot, "escape")
        assert "✗ error nothing left to redo" in words(pilot)


@pytest.mark.parametrize(("lines", "plots"), [(24, 1), (36, 1), (50, 3)])
async def test_a_log_has_one_tall_plot_or_three_where_there_is_room(tmp_path: Path, lines: int, plots: int) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        bring_in(ledger, [LOG], lambda name: None, defaults={"rocket": "Comet"})
    async with opened(tmp_path / "ledger.db", (120, lines)) as pilot:
        await press(pilot, "enter", "_", "l", "_")
        heights = [plot.region.height for plot in pilot.app.screen.query(Plot) if plot.display]
        assert len(heights) == plots
        assert min(heights) >= 11


def test_a_line_is_filled_below_it_and_never_beside_it() -> None:
    ink = Ink(80, 23, *["default"] * 5)
    assert below_line(np.array([10.0, 0.2, -10.0]), 20.0, ink).tolist() == pytest.approx([9.5, 0.0, -9.5])


def test_a_line_near_zero_is_not_filled_in_fragments() -> None:
    ink = Ink(80, 23, *["default"] * 5)  # a line of the plot is 10 high
    climb, descent = [0.0, 60.0, 180.0, 90.0, 5.0], [-9.0, -11.0, -12.0, -9.0, -13.0]
    filled = filled_columns(np.array([*climb, *descent]), 200.0, ink)
    assert filled.tolist() == [False, True, True, True, False, *[False] * 5]


class Axis:
    """An axis of plotext that keeps its labels."""

    def xticks(self, _places: list[float], labels: list[str]) -> None:
        self.labels = labels

    def xlim(self, *_ends: float) -> None:
        pass


def test_as_many_flights_are_labeled_as_fit_the_selected_one_first() -> None:
    ids = [f"{number:02}" for number in range(30)]
    broad, narrow = Axis(), Axis()
    label_flights(broad, Ink(200, 20, *["default"] * 5), ids, 7)
    assert sorted(broad.labels) == ids
    label_flights(narrow, Ink(40, 20, *["default"] * 5), ids, 7)
    assert narrow.labels[:2] == ["07", "29"]
    assert 5 < len(narrow.labels) < 15


def test_a_scrollbar_leaves_a_cell_free_beside_text() -> None:
    bar = SpacedBar.render_bar(10, 40, 10, 5, 2, True, RichColor.default(), RichColor.parse("red"))
    lines = "".join(part.text for part in bar.segments).splitlines()
    assert len(lines) == 10
    assert {len(line) for line in lines} == {2}
    first = [part for part, end in zip(bar.segments[::3], bar.segments[2::3], strict=True) if end.text == "\n"]
    assert len(first) == 10
    assert {(part.text, part.style.color if part.style else None) for part in first} == {(" ", None)}
    single = SpacedBar.render_bar(10, 40, 10, 5, 1, True, RichColor.default(), RichColor.parse("red"))
    assert {len(part.text) for part in single.segments} == {1}


async def test_the_pages_have_such_a_scrollbar(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "enter")
        assert pilot.app.screen.query_one("#all").vertical_scrollbar.renderer is SpacedBar


async def test_a_low_strip_shows_whole_blocks_of_the_rocket(file: Path) -> None:
    async with opened(file, (120, 36)) as pilot:
        await press(pilot, "end", "enter", "_")
        while not pilot.app.screen.query_one("RocketStrip Static").content_size:
            await pilot.pause()
        await press(pilot, "_")
        assert "a sketch" in text_of(pilot, "RocketStrip Static")
        assert "Motors it flew on" not in text_of(pilot, "RocketStrip Static"), "it would be cut"
        await pilot.resize_terminal(120, 90)
        while pilot.app.screen.query_one(RocketStrip).size.height < 20:
            await pilot.pause()
        await press(pilot, "_")
        assert "Motors it flew on" in text_of(pilot, "RocketStrip Static")


async def test_thrust_is_shown_beside_the_card_too(file: Path) -> None:
    shown_columns = [one.title for one in columns(78, HeightScale(0.0, 300.0), beside=True, tags=4)]
    assert shown_columns[7] == "α"
    assert len(shown_columns) == 11, "with the forecast"
    assert "α" not in [one.title for one in columns(78, HeightScale(0.0, 300.0), beside=True, tags=11)]
    async with opened(file, (120, 36)) as pilot:
        await press(pilot, "_")
        assert re.search(r"Inferred Cd 0\.\d\d Thrust factor 0\.\d\d", text_of(pilot, "#card"))

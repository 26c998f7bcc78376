"""What a flyer sees without scrolling: the input above its list of answers, bars, large figures, the picture of an
answer, and complete labels."""

import gc
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from textual.widgets import Static

from fieldkit.ledger import Ledger, models
from fieldkit.services.imports import bring_in
from fieldkit.settings import change_settings
from fieldkit.tui.memory import pause_collection
from fieldkit.tui.next.intervals import HeightScale, heading
from fieldkit.tui.widgets.bars import NoticeBar
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import answered, marked
from fieldkit.tui.widgets.picker import Picker
from fieldkit.tui.widgets.plots import Plot, round_ticks
from tests.pressing import ROOT, at_home, opened, press, shown, text_of, typed

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


@pytest.fixture
def collecting() -> Iterator[None]:
    yield
    gc.enable()


@pytest.mark.parametrize("size", [(80, 24), (250, 70)], ids=lambda size: "x".join(map(str, size)))
async def test_a_list_of_answers_opens_below_its_line_and_moves_no_form(
    size: tuple[int, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    async with opened(tmp_path / "new.db", size, page="home") as pilot:
        await press(pilot, "enter", "_", *["down"] * 3)
        line = pilot.app.screen.query_one("#in-motor")
        before = line.region
        await press(pilot, *typed("F24"))
        offered = pilot.app.screen.query_one(Picker)
        assert offered.open
        assert line.region == before
        assert offered.region.y == before.bottom
        assert "▌F24 " in shown(pilot)


@pytest.mark.parametrize(("columns", "column"), [(120, 9), (130, 10), (149, 10), (160, 10)])
async def test_the_flights_page_draws_forecast_flown_and_target_beside_the_card(
    columns: int, column: int, file: Path
) -> None:
    change_settings({"target": 243.84}, file.with_name("settings.json"))
    async with opened(file, (columns, 36)) as pilot:
        rows = [line.partition("│")[0] for line in shown(pilot).splitlines() if line[1:4].strip().isdigit()]
        assert sum("◆" in row for row in rows) == 12
        assert sum("◎" in row for row in rows) > 8, "unless a flight met the target"
        assert re.search("├[─●◆]+┤", next(row for row in rows if row.startswith("▸12")))
        assert "forecast" in shown(pilot).splitlines()[2]
        await press(pilot, *["s"] * (column - 1))
        assert "◎▲" in shown(pilot).splitlines()[2]


async def test_without_a_target_motors_show_their_interval_instead_of_a_distance(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4", "_")
        assert shown(pilot).splitlines()[3].split("│")[0].split() == ["motor", "apogee", "90%", "eject", "s"]
        await press(pilot, "g", *typed("800ft"), "enter", "_")
        assert shown(pilot).splitlines()[3].split("│")[0].split() == ["motor", "apogee", "90%", "off"]


@pytest.mark.thorough
@pytest.mark.parametrize("size", [(120, 36), (160, 50)], ids=lambda size: "x".join(map(str, size)))
async def test_a_decision_shows_its_figure_its_picture_and_the_first_failed_check(
    size: tuple[int, int], file: Path
) -> None:
    change_settings({"target": 243.84}, file.with_name("settings.json"))
    async with opened(file, size) as pilot:
        await press(pilot, "4", "slash", *typed("aerotech f39"), "enter", "_", "d", "right", "_")
        screen = pilot.app.screen
        assert screen.query_one(Big).value
        assert "g dry mass" in text_of(pilot, "#about")
        plot = screen.query_one("#first", Plot)
        assert plot.region.bottom < size[1], "visible without scrolling"
        checks = screen.query_one("#under", Static)
        assert checks.region.right <= plot.region.x, "across the screen: beside the answer and the checks below it"
        marks = [line[0] for line in str(checks.content).splitlines() if line[1:2] == " "]
        assert "⊘" in marks or "!" in marks or "?" in marks
        assert [mark for mark in marks if mark in "⊘!?✓"] == sorted(
            (mark for mark in marks if mark in "⊘!?✓"), key="⊘!?✓".index
        )
        await press(pilot, "right", "right", "right", "_")
        assert not screen.query_one(Big).value


@pytest.mark.thorough
async def test_a_motor_in_little_space_is_shown_without_its_manufacturer_and_saved_with_it(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    async with opened(file) as pilot:
        await press(pilot, "4", "slash", *typed("aerotech f39"), "enter", "_", "enter", "_", "a", "_")
        line = next(line for line in shown(pilot).splitlines() if "Motor" in line)
        assert "▌F39T-" in line
        await press(pilot, *typed("198m"), "ctrl+s", "_")
    with Ledger.open(file) as ledger:
        assert ledger.flight("13").motor.startswith("AeroTech F39T")


async def test_a_success_is_on_one_line_and_an_error_says_how_to_dismiss_it(file: Path) -> None:
    async with opened(file) as pilot:
        forecast = "Lark on F24-4W: 265.4 m (170.0 m to 387.5 m). Each flight narrows it"
        pilot.app.show_notice(forecast)  # type: ignore[attr-defined]
        await press(pilot)
        assert pilot.app.screen.query_one(NoticeBar).size.height == 1
        assert "dismiss" not in text_of(pilot, "NoticeBar")
        pilot.app.show_notice(forecast, error=True)  # type: ignore[attr-defined]
        await press(pilot, "escape")
        assert "Esc dismiss" in text_of(pilot, "NoticeBar")


async def test_profiles_have_a_column_only_if_a_flight_has_a_log(file: Path) -> None:
    async with opened(file, (120, 36), page="home") as pilot:
        assert "profile" not in shown(pilot)
        with Ledger.open(file) as ledger:
            log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
            bring_in(ledger, [log], lambda name: None, defaults={"rocket": "Comet"})
        pilot.app.changed()  # type: ignore[attr-defined]
        await press(pilot, "_")
        assert "profile" in shown(pilot)
        row = next(line for line in shown(pilot).splitlines() if " Comet " in line)
        assert len(set(row) & set("▁▂▃▄▅▆▇█")) > 3, "height against time"


def test_a_scale_shows_its_ends_if_there_is_room() -> None:
    scale = HeightScale(131.1, 297.7, 243.84)
    wide = heading(60, scale, "SI")
    assert len(wide) == 60
    assert wide.startswith("131.1 m ")
    assert wide.endswith(" 297.7 m")
    assert heading(60, scale, "US").endswith(" 977 ft")
    assert "131.1" not in heading(30, scale, "SI")
    assert "0.0" not in heading(60, HeightScale.of([], None), "SI")


def test_one_very_high_flight_does_not_squeeze_the_intervals_of_the_others() -> None:
    usual = [((170.0 + n, 190.0 + n, 215.0 + n), 188.0 + n) for n in range(20)]
    scale = HeightScale.of([*usual, ((2900.0, 3100.0, 3300.0), 3164.0), (None, 3200.0)], None)
    assert (scale.low, scale.high) == (170.0, 234.0)
    assert scale.line((2900.0, 3100.0, 3300.0), 3164.0, 20).strip() == "→"
    assert scale.line(None, 3200.0, 20).strip() == "→"
    assert HeightScale.of([(None, 100.0), (None, 900.0)], 2000.0).high == 2000.0, "a target is always on the scale"


@pytest.mark.parametrize(
    ("low", "high", "most", "ticks"),
    [
        (169.8, 198.1, 4, [170, 180, 190]),
        (120.0, 290.0, 4, [150, 200, 250]),
        (0.21, 0.29, 5, [0.22, 0.24, 0.26, 0.28]),
        (-3.0, 11.0, 3, [0, 5, 10]),
        (5.0, 5.0, 4, [5]),
    ],
)
def test_ticks_are_few_round_numbers(low: float, high: float, most: int, ticks: list[float]) -> None:
    assert round_ticks(low, high, most) == ticks


def test_marks_and_values_stand_out_from_names() -> None:
    line = answered(["Astra on F39", "  apogee    248 m", "            90% interval"]).lines[1][1]
    assert [(str(span.style), line.plain[span.start : span.end]) for span in line.spans] == [
        ("$text-muted", "  apogee    "),
        ("b", "248 m"),
    ]
    assert [str(span.style) for span in marked("⊘ rail exit speed").spans] == ["b $error"]
    assert not marked("!important").spans
    assert not marked("plain").spans


FIRST_ROWS = """
import asyncio, os, sys
from pathlib import Path
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.home.home_page import HomeScreen
listed = HomeScreen._list
def rows(page, flights):
    listed(page, flights)
    sys.stdout = sys.__stdout__
    print(len(flights), *sys.modules, flush=True)
    os._exit(0)
HomeScreen._list = rows
async def opened():
    async with FieldkitApp({!r}, Path({!r})).run_test(size=(80, 24)):
        await asyncio.sleep(60)
asyncio.run(opened())
"""
"""Runs the app until it has its first rows, and prints the modules imported by then."""


LATER = ("widgets.dialogs", "widgets.hanging", "widgets.picker", "flights.log_plot", "palette")
"""Modules that only a key or a worker needs."""


def test_first_rows_are_listed_before_other_pages_and_libraries_are_imported(file: Path) -> None:
    code = FIRST_ROWS.format(str(file), str(file.with_name("settings.json")))
    env = {**os.environ, "FIELDKIT_CHECK_SHAPES": ""}
    ran = subprocess.run([sys.executable, "-c", code], check=True, env=env, stdout=subprocess.PIPE, text=True)
    count, *modules = ran.stdout.split()
    assert int(count) > 5
    assert not {"numpy", "pandas", "sqlalchemy", "typer", "scipy", "fieldkit.importing"}.intersection(modules)
    assert [name for name in modules if name.endswith("_page")] == ["fieldkit.tui.home.home_page"]
    assert not {"tomllib", *(f"fieldkit.tui.{name}" for name in LATER)}.intersection(modules)


async def test_garbage_is_collected_again_once_the_app_has_started(
    file: Path, collecting: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldkit.tui.app.START_TIME", 0.01)
    pause_collection()
    assert not gc.isenabled()
    async with opened(file) as pilot:
        while not gc.isenabled():
            await pilot.pause(0.01)


@pytest.mark.parametrize("keys", [("1",), ("3",), ("4",), ("6", "right")])
async def test_a_framed_region_has_a_heavy_frame_while_it_has_the_focus(keys: tuple[str, ...], file: Path) -> None:
    """Heavy, not only in another color: a theme may have one."""
    async with opened(file, (160, 50)) as pilot:
        await press(pilot, *keys, "_", "tab")
        focused = pilot.app.screen.focused
        assert focused is not None
        assert focused.has_class("framed")
        assert focused.styles.border_top[0] == "heavy"
        assert "┏" in shown(pilot)
        await press(pilot, "tab")
        assert focused.styles.border_top[0] == "round"

"""The next flight, importing, the loop, the setup and capturing, using only keys, with some errors."""

import asyncio
import re
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path
from threading import Event
from typing import cast
from unittest.mock import Mock, patch

import pytest
from textual.events import Key
from textual.widgets import Input, Static

from fieldkit import capture
from fieldkit.errors import DamagedModel
from fieldkit.flight import CONDITIONS, READOUTS, SETUP
from fieldkit.ledger import Ledger, models
from fieldkit.paths import data_file
from fieldkit.physics.effect import effects
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import MotorOrder, guide
from fieldkit.planning.quick_guide import QuickChoice
from fieldkit.settings import read_settings
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.imports.mapping_form import FIRST_FIELDS
from fieldkit.tui.next.motor_list import MAX_FORECAST_MOTORS, MAX_STORED_FORECASTS, MotorList
from fieldkit.tui.next.next_page import ForecastCard
from fieldkit.tui.page import PageScreen, pages
from fieldkit.tui.widgets.bars import KeyBar, shortened
from fieldkit.tui.widgets.dialogs import HelpScreen
from fieldkit.tui.widgets.table import Table
from tests.openrocket.test_design import SIMULATION, design
from tests.pressing import (
    ROOT,
    at_home,
    calm,
    hurry,
    looked_at,
    opened,
    press,
    shown,
    text_of,
    typed,
    words,
)

CHECK_SHAPES = False

SURE = ("y", "_", "enter", "_")
"""A rocket that has not flown must be confirmed; Enter then stores the file."""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "field"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return at_home(tmp_path, monkeypatch)


# Import


async def test_a_file_is_shown_before_anything_is_stored(file: Path) -> None:
    table = "flight_id,rocket,motor,apogee_m\n1,Comet,C6-5,1o4\n2,Comet,ZZ99,100\n3,Comet,C6-5,210\n"
    (file.parent / "field" / "season.csv").write_text(table)
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down")
        seen = words(pilot)
        assert "Flight table" in seen
        assert "1 flight, 0 duplicates, 2 rejected" in seen
        assert "✗ row 2, apogee_m: found '1o4'" in seen
        assert "✗ row 3, motor: no motor 'ZZ99'" in seen
        assert "3 · Comet · C6-5 Apogee 210.0 m" in text_of(pilot, "#more")
        with Ledger.open(file) as ledger:
            assert len(ledger.flights()) == 12
        await press(pilot, "enter")
        assert "Imported 1, 0 duplicates, 2 rejected" in words(pilot)
        await press(pilot, "enter")
        assert "Imported 0, 1 duplicate," in words(pilot)
        await press(pilot, "escape", "u")
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 12


async def test_an_unrecognized_file_is_reported_and_changes_nothing(file: Path) -> None:
    (file.parent / "field" / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0 not a log")
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down")
        assert "no parser recognizes this file" in text_of(pilot, "#preview")
        await press(pilot, "enter", "enter")
        assert "✗ error photo.jpg: no parser recognizes this file" in words(pilot)
        await press(pilot, "escape")
        assert "✗ error" not in words(pilot), "the same is to be read once"
        await press(pilot, "F", *typed("nonsense"), "enter")
        assert "no format 'nonsense'" in words(pilot)


async def test_a_rocket_uses_its_design_until_it_has_flown(file: Path) -> None:
    (file.parent / "field" / "a.ork").write_text(design(rest=SIMULATION.format(status="uptodate")))
    (file.parent / "field" / "b.ork").write_text("<openrocket>")
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down")
        assert "recognized as a design" in words(pilot)
        assert "starts Skylark" in words(pilot)
        assert "66 mm across" in words(pilot)
        await press(pilot, "e", *typed("Lark"), "enter", *typed("A"), "ctrl+s", *SURE)
        assert "Saved as this rocket's starting point. u to undo" in words(pilot)
        await press(pilot, "enter")
        assert "Saved already" in words(pilot)
        await press(pilot, "down", "enter")
        assert "✗ error" in words(pilot)
    with Ledger.open(file) as ledger:
        (start,) = ledger.rocket("Lark").configurations
        assert start.config == "A"
        assert start.source == "a.ork"
        ledger.undo()
        assert not ledger.rocket("Lark").configurations


@pytest.mark.thorough
async def test_values_that_a_file_lacks_can_be_set_and_folders_browsed(file: Path) -> None:
    log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
    inner = file.parent / "field" / "logs"
    inner.mkdir()
    (inner / "flight.pf2").write_bytes(log.read_bytes())
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down", "enter", "down")
        assert "PerfectFlite" in words(pilot)
        await press(pilot, "e", *["down"] * 5, *typed("4o0"), "ctrl+s")
        assert "found '4o0', expected a number" in words(pilot)
        await press(pilot, "escape")
        assert "no rocket, no motor in the file" in text_of(pilot, "#preview")
        await press(pilot, "enter")
        assert "Not in the file" in words(pilot)
        await press(pilot, "escape", "enter", "ctrl+s")
        assert "Imported 1" in words(pilot), "a log may be stored without them"
        await press(pilot, "4")
        assert "Astra B · 448 g" in words(pilot), "a log that names no rocket does not stand in the way of the next"
        await press(pilot, "3", "u", "e", *typed("Comet"), "ctrl+s", *SURE)
        assert "Imported 1" in words(pilot)
        await press(pilot, "backspace")
        assert "logs/" in shown(pilot)
        await press(pilot, "o", "ctrl+u", *typed("nowhere"), "enter")
        assert "no such file or folder" in words(pilot)
        await press(pilot, "escape", "o", "ctrl+u", *typed("logs/flight.pf2"), "enter", "backspace")
        assert "logs/" in shown(pilot), "a path from here leads up as well"
        (inner.parent / "new.pf2").write_bytes(b"put here meanwhile")
        await press(pilot, "r")
        assert "new.pf2" in shown(pilot)
    with Ledger.open(file) as ledger:
        assert ledger.names("rocket")[0] == "Comet"


async def test_several_logs_of_one_flight_can_be_marked_and_read_together(file: Path) -> None:
    folder = file.parent / "field"
    for name, scale in (("a.csv", 1.0), ("b.csv", 1.02)):
        rows = "".join(f"{n / 10:.1f},{scale * max(0.0, 60 - (n / 10 - 4) ** 2 * 3.75):.2f}\n" for n in range(-20, 120))
        (folder / name).write_text("time (s),altitude (m)\n" + rows)
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "space", "down", "space", "down", "space")
        assert "recognized as 2 files together" in text_of(pilot, "#preview")
        assert "+ a.csv" in shown(pilot)
        await press(pilot, "e", *typed("Comet"), "ctrl+s", *SURE)
        brought = text_of(pilot, "#preview")
        assert "+ a.csv" not in shown(pilot)
        assert "Imported" in words(pilot), brought
        await press(pilot, "up")
        assert "1 duplicate," in text_of(pilot, "#preview")
    with Ledger.open(file) as ledger:
        assert len(ledger.flights("Comet")) == len(ledger.flights()) - 12 > 0


async def test_unknown_columns_are_mapped_once_and_remembered(file: Path) -> None:
    rows = "".join(f"{n / 10:.1f};{max(0.0, 60 - (n / 10 - 4) ** 2 * 3.75):.2f}\n" for n in range(-20, 120))
    for name, last in (("one.csv", ""), ("two.csv", "12.0;0.00\n")):
        (file.parent / "field" / name).write_text("quux;frob\n" + rows + last)
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down")
        assert text_of(pilot, "#preview").endswith("F to choose a parser, m to map the columns of a table")
        assert "--map" not in text_of(pilot, "#preview")
        await press(pilot, "m", *typed("quux"), "tab", *typed("frobb"))
        assert "found no column 'frobb'; did you mean 'frob'?" in words(pilot)
        await press(pilot, "backspace", "ctrl+s")
        assert "would add 1 flight" in text_of(pilot, "#preview")
        await press(pilot, "e", *typed("Comet"), "ctrl+s", *SURE)
        assert "Imported 1" in words(pilot)
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down", "down")
        assert "would add 1 flight" in text_of(pilot, "#preview")
        await press(pilot, "M")
        assert "time=quux; altitude=frob" in words(pilot)
        await press(pilot, "x")
        assert "time=quux" not in words(pilot)
        await press(pilot, "escape")
        assert "would add" not in text_of(pilot, "#preview")


@pytest.mark.thorough
async def test_a_table_of_flights_is_mapped_by_the_same_form(file: Path) -> None:
    (file.parent / "field" / "one.csv").write_text("which;what;how high\nComet;C6-5;210\nComet;C6-5;215\n")
    keys, place = list[str](), 0
    for name, column in {"rocket": "which", "motor": "what", "apogee": "how high"}.items():
        at = FIRST_FIELDS.index(name)
        keys += [*["down"] * (at - place), *typed(column)]
        place = at
    async with opened(file, page="import_files") as pilot:
        await press(pilot, "down", "m", "ctrl+t")
        assert "found no table of numbers" in words(pilot)
        await press(pilot, "m", *keys, "backspace")
        assert "found no column 'how hig'" in words(pilot)
        await press(pilot, *typed("h [ft]"), "ctrl+s")
        assert "would add 2 flights" in text_of(pilot, "#preview")


async def test_a_log_is_plotted_before_it_is_stored(file: Path) -> None:
    rows = "".join(f"{n / 10:.1f},{max(0.0, 60 - (n / 10 - 4) ** 2 * 3.75):.2f}\n" for n in range(-20, 120))
    (file.parent / "field" / "one.csv").write_text("time (s),altitude (m)\n" + rows)
    async with opened(file, (100, 40), page="import_files") as pilot:
        await press(pilot, "down", "l")
        seen = words(pilot)
        assert "apogee" in text_of(pilot, "#cursor")
        assert "height [m]" in seen
        before = text_of(pilot, "#cursor")
        await press(pilot, "right")
        assert text_of(pilot, "#cursor") != before
        await press(pilot, "home")
        assert "apogee" in text_of(pilot, "#cursor")
        await press(pilot, "tab")
        facts = text_of(pilot, "#facts")
        for what in ("altitude (m)", "1 flight, 0 rejected", "Apogee", "baro", "format", "140 used"):
            assert what in facts
        assert "liftoff" not in facts
        await press(pilot, "escape")
        assert "would add 1 flight" in text_of(pilot, "#preview")


# Next flight


async def test_the_forecast_follows_the_cursor_through_motors_that_fit(file: Path) -> None:
    async with opened(file, (100, 42), page="next_flight") as pilot:
        assert "Astra B on AeroTech" in shown(pilot)
        card = text_of(pilot, "#title")
        assert "8 normal flights (1, 2, 3, 4, 9, 10, 11, 12), no correction" in text_of(pilot, "#more")
        await press(pilot, *["down"] * 3)
        assert "Astra B on" in shown(pilot)
        assert text_of(pilot, "#title") != card
        for what in ("ejection", "by delay", "off rail", "T:W", "Cd", "thrust", "true"):
            assert what in shown(pilot)
        assert "kg/m³" in text_of(pilot, "#more")  # below the edge of the terminal
        await press(pilot, "b")
        assert "Astra A on" in shown(pilot)


@pytest.mark.thorough
async def test_motors_that_are_not_safe_and_sensible_are_last_with_the_reason(file: Path) -> None:
    async with opened(file, (100, 60), page="next_flight") as pilot:
        await press(pilot, "p", *["down"] * 9, *typed("0.5m"), "ctrl+s", "slash", *typed("e12"), "enter", "_")
        assert "rail exit speed" in text_of(pilot, "#more").partition("ejection")[0]
        table = pilot.app.screen.query_one(Table)
        marks = [table.cells(key)[0].startswith("✗") for key in table.keys]
        assert marks == sorted(marks)
        assert any(marks)


@pytest.mark.thorough
async def test_without_a_target_the_motor_of_the_open_forecast_is_first_and_weak_ones_are_last(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)  # signed in a frozen past
    async with opened(file, page="next_flight") as pilot:
        flown = text_of(pilot, "#title")
        await press(pilot, "slash", *typed("e18"), "enter", "_", "enter", "_")
        assert "Saved forecast" in words(pilot)
    async with opened(file, page="next_flight") as pilot:
        assert "E18" in text_of(pilot, "#title") != flown
        motors = pilot.app.screen._motors  # type: ignore[attr-defined]  # of the page in front
        known = [motors.known[one] for one in pilot.app.screen.query_one(Table).keys if motors.fits(one)]
        weak = [one.weak for one in known if one.motor not in motors.plan.order(None).preferred]
        assert weak == sorted(weak)
        assert any(weak)


async def test_motors_are_sorted_by_their_distance_from_the_target(file: Path) -> None:
    async with opened(file, (160, 40), page="next_flight") as pilot:
        await press(pilot, "g", *typed("800ft"), "enter")
        table = pilot.app.screen.query_one(Table)
        offs = [table.cells(key)[5] for key in table.keys if not table.cells(key)[0].startswith("✗")]
        assert len(offs) > 20
        distances = [abs(float(off.lstrip("◎"))) for off in offs]
        assert distances == sorted(distances)
    assert read_settings(file.with_name("settings.json")).target == pytest.approx(243.84)


async def test_a_forecast_is_saved_and_its_flight_compared_with_it(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("f24"), "enter", "_", "enter")
        assert "Saved forecast: AeroTech F24W-4 to" in words(pilot)
    with Ledger.open(file) as ledger:
        (_, prediction) = ledger.predictions("Astra")
    assert prediction.payload["motor"] == "AeroTech F24W-4"
    assert prediction.payload["flights"] == 8


@pytest.mark.thorough
async def test_a_plan_is_changed_and_saved_and_a_typo_in_it_is_refused(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "p", "down", "down", *typed("4oo"), "ctrl+s")
        assert "✗ found" in shown(pilot)
        await press(pilot, "ctrl+u", *typed("400g"), *["down"] * 6, *typed("20mph"), "ctrl+s")
        assert "Astra B · 400 g dry" in words(pilot)
        assert "wind 8.9 m/s" in words(pilot)
    async with opened(file, page="next_flight") as pilot:
        assert "400 g dry" in words(pilot)
        assert "wind 8.9 m/s" in words(pilot)


async def test_a_search_covers_the_whole_catalog_and_marks_motors_that_do_not_fit(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("qqqq"), "enter", "enter", "y")
        assert "0 fit" in shown(pilot)
        assert "Nothing to copy" in words(pilot)
        await press(pilot, "slash", "ctrl+u", *typed("h128"), "enter")
        assert "0 of 1 fit" in shown(pilot)
        assert "▸✗ H128W" in shown(pilot)
        await press(pilot, "c", "y", "c")
        assert pilot.app.clipboard.startswith("motor ✗ AeroTech H128W")
        assert "29 mm, and the widest flown is 24 mm" in text_of(pilot, "#more")


# Notices


@pytest.mark.thorough
async def test_a_cluster_is_found_forecast_and_saved_with_a_note_on_what_is_not_modeled(file: Path) -> None:
    async with opened(file, (100, 40), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("2 x Estes E12"), "enter", "_")
        assert "on Estes 2 x E12" in text_of(pilot, "#title")
        assert "failed ignitions are not modeled" in text_of(pilot, "#more")
        await press(pilot, "enter")
        assert "Saved forecast: Estes 2 x E12" in words(pilot)
        await press(pilot, "d", "_")
        assert "failed ignitions are not modeled" in words(pilot)
    with Ledger.open(file) as ledger:
        kept = ledger.predictions()[-1]
    assert kept.payload["motor"].startswith("Estes 2 x E12")


def test_a_notice_names_files_by_their_names_and_ports_in_full() -> None:
    assert shortened("/home/anna/my logs/mine.eng: found no motor") == "mine.eng: found no motor"
    assert (
        shortened("cannot read '/home/anna/ledger.db', expected a ledger")
        == "cannot read 'ledger.db', expected a ledger"
    )
    for text in ("/dev/ttyUSB0: cannot be opened", "found 14 m/s, expected km/h", "and/or"):
        assert shortened(text) == text


async def test_one_key_shows_the_whole_path_in_a_notice(file: Path) -> None:
    async with opened(file, (160, 40)) as pilot:
        cast(FieldkitApp, pilot.app).show_notice(f"{file.parent}/none.eng: cannot be read", error=True)
        await press(pilot, "6")
        assert "✗ error none.eng" in words(pilot)
        assert str(file.parent) not in words(pilot)
        await press(pilot, "W")
        assert "/".join(file.parts[:2]).replace("//", "/") in words(pilot)
        await press(pilot, "escape")
        assert "✗ error" not in words(pilot)


# Loop


@pytest.mark.thorough
async def test_the_loop_is_shown_and_earlier_versions_can_be_restored(file: Path) -> None:
    found = looked_at()
    from fieldkit.presentation.loop_headline import headline
    from fieldkit.presentation.loop_text import how_sure, in_next_flight, miss_bars, what_forecasts_become
    from fieldkit.services.close_loop import version_payload
    from fieldkit.services.forecasts import accepted_average

    with Ledger.open(file) as ledger:
        wear = {"effect": "wear", "where": "", "since": "", "mean": 0.03, "sd": 0.01, "unit": "1"}
        certain = [{"probability": 1.0, "places": [wear]}]
        ledger.keep_version("Astra", version_payload(found.diagnosis) | {"effects": [wear], "averaged": certain})
    with patch("fieldkit.tui.loop.loop_page.look", lambda resources, rocket, on_progress: found):
        async with opened(file, page="loop") as pilot:
            await press(pilot, "A")
            assert "Nothing to accept yet" in words(pilot)
            await press(pilot, "escape", "S")
            assert headline(found).sentence in words(pilot)
            assert "A to accept, D to decline" in words(pilot)
            await press(pilot, "D")
            assert "Declined: the model is unchanged" in words(pilot)
            await press(pilot, "escape", "right", "right", "right")
            named = found.diagnosis.effect != "none"
            assert (f"Verdict: {found.diagnosis.effect}" in words(pilot)) == named
            assert (headline(found).sentence in words(pilot)) != named, "no bare none beside a chance that it is wrong"
            for line in ("Effect on the next flight", in_next_flight(found.next_flight), "How sure", how_sure(found)):
                assert line in words(pilot)
            _, before, after = miss_bars(found, 60)
            assert (f"before  {before}" in shown(pilot)) == named
            assert (f"after   {after}" in shown(pilot)) == named
            await press(pilot, "end")
            assert "each from all others, 8 flights" in words(pilot)
            for line in ("What accepting changes", what_forecasts_become(found)):
                assert line in text_of(pilot, "#evidence")
            assert "--decline" not in words(pilot), "an option of the command"
            await press(pilot, "right")
            assert "residual / expected scatter, vs." in words(pilot)
            first = shown(pilot)
            await press(pilot, "v")
            assert shown(pilot) != first
            await press(pilot, "right")
            assert "in expected scatter predicted observed" in words(pilot)
            await press(pilot, "right")
            assert "wear" in shown(pilot)
            await press(pilot, "right", "right", "right")
            assert "▸  0" in shown(pilot)
            await press(pilot, "enter")
            assert "Astra forecasts with no correction. u to undo" in words(pilot)
            with Ledger.open(file) as ledger:
                assert ledger.active_version("Astra") is None
            await press(pilot, "u")
            with Ledger.open(file) as ledger:
                version = ledger.active_version("Astra")
            assert version is not None
            await press(pilot, "A")
            with Ledger.open(file) as ledger:
                kept = accepted_average(ledger, "Astra")
            assert [places for _, places in kept] == [
                places for _, places in found.diagnosis.averaged if places or kept
            ]


async def test_too_few_flights_for_the_loop_give_a_notice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from fieldkit.flight import Flight

    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(flight_id="1", rocket="Comet", motor="C6-5", dry_mass=0.1, apogee=100.0)])
    async with opened(tmp_path / "ledger.db", page="loop") as pilot:
        assert "A search needs 4 normal flights with an apogee; Comet has 1." in words(pilot)
        await press(pilot, "D")
        assert "Nothing to decline yet" in words(pilot)
        await press(pilot, "S")
        assert "expected at least 4 to close the loop" in words(pilot)
        assert "looking:" not in words(pilot)
        await press(pilot, "ctrl+c")
        assert "q quits" in words(pilot)


# Setup


async def test_a_configuration_is_changed_in_all_its_flights_and_undone(file: Path) -> None:
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right", "enter", "ctrl+u", *typed("Comet"), "enter", "enter", *typed("450g"), "ctrl+s")
        assert "4 flights. u to undo" in words(pilot)
        with Ledger.open(file) as ledger:
            assert {f.dry_mass for f in ledger.flights("Comet")} == {0.45}
        await press(pilot, "u")
    with Ledger.open(file) as ledger:
        assert ledger.names("rocket") == ["Astra"]


async def test_settings_are_remembered(file: Path) -> None:
    async with opened(file, page="setup") as pilot:
        await press(pilot, "left", "enter", "down", "enter")
        assert pilot.app.theme == "sun"
        await press(pilot, "1", "N")
    async with opened(file) as pilot:
        assert pilot.app.theme == "sun"
        assert "apogee in ft" in shown(pilot)
        assert "650" in shown(pilot)
    kept = read_settings(file.with_name("settings.json"))
    assert (kept.theme, kept.units) == ("sun", "mixed")


async def test_a_damaged_motor_file_gives_a_notice(file: Path) -> None:
    (file.parent / "field" / "mine.eng").write_text("; nothing\n")
    async with opened(file, page="setup") as pilot:
        await press(pilot, "i", *typed("mine.eng"), "enter")
        assert "✗ error mine.eng" in words(pilot)


# Capture


async def test_a_capture_shows_incoming_data_and_imports_it(file: Path) -> None:
    log = file.parent / "flight.pf2"
    log.write_bytes((ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2").read_bytes())
    end = capture.Ended(log, "stratologger", 4000, 200, 0, "complete", True)
    events = [
        capture.PortOpened("/dev/ttyUSB0", "stratologger", log),
        *(capture.Progress(2000, 100, 1, 0.5, capture.Sample(one, 3.0, 20.0, "boost")) for one in (123.4, 99.0, 98.0)),
        capture.Lost("/dev/ttyUSB0", "the cable was pulled"),
        capture.Back("/dev/ttyUSB1"),
        end,
    ]
    here = [capture.Port("/dev/ttyUSB0", 0x0403, 0x6015, "A1", "adapter")]
    with (
        patch("fieldkit.capture.ports", lambda: here),
        patch("fieldkit.capture.capture", lambda *a, **k: iter(events)),
        patch("fieldkit.tui.imports.capture_page.MAX_DRAWN_ALTITUDES", 2),
    ):
        async with opened(file, page="serial") as pilot:
            assert "0403:6015 FTDI chip" in words(pilot)
            await press(pilot, "enter")
            assert "Import its flights?" in words(pilot)
            await press(pilot, "n")
            seen = words(pilot)
            assert "! the cable was pulled" in seen
            assert "reconnected on /dev/ttyUSB1" in seen
            assert "2,000 bytes 100 samples 1 damaged" in seen
            assert "highest 123.4 m" in seen
            await press(pilot, "enter", "y", "_")
            assert "Not in the file" in words(pilot)
            assert "Astra" in words(pilot), "what the last flight had is filled in"
            await press(pilot, "ctrl+s", "_")
            assert "Imported 1" in words(pilot)
            events[1:1] = [capture.Instruction(f"page {number} is read") for number in range(20)]
            events[-1] = capture.Ended(log, "stratologger", 0, 0, 0, "it went silent", False)
            events[:] = [event for event in events if not isinstance(event, capture.Progress)]
            await press(pilot, "enter")
            seen = words(pilot)
            assert "nothing received" in seen, "the newest is in sight, however much was said before"
            assert "highest" not in seen, "of the capture before"


async def test_a_port_that_cannot_be_opened_gives_a_notice(file: Path) -> None:
    here = [capture.Port("/dev/nowhere", 0x0403, 0x6001, "", "")]
    with patch("fieldkit.capture.ports", lambda: here):
        async with opened(file, page="serial") as pilot:
            await press(pilot, "h", *typed("rrc3"), "enter")
            assert "the download of the RRC3 is not public" in words(pilot)
            await press(pilot, "escape", "h", *typed("altos"), "enter", "enter")
            assert "/dev/nowhere" in words(pilot)
            assert "error" in words(pilot)


# Everywhere


async def test_every_pages_help_has_text_keys_and_an_existing_command(file: Path) -> None:
    from typer.main import get_command

    from fieldkit.cli.main import app

    commands = get_command(app).commands  # type: ignore[attr-defined]
    async with opened(file, (100, 40)) as pilot:
        for page in pages().values():
            await press(pilot, str(page.number), "escape")
            screen = pilot.app.screen
            assert isinstance(screen, PageScreen)
            assert len(screen.ABOUT.about) > 100
            assert len(screen.ABOUT.fields) >= 3
            assert screen.ABOUT.twin
            await press(pilot, "question_mark")
            assert isinstance(pilot.app.screen, HelpScreen)
            text = " ".join(str(part.content) for part in pilot.app.screen.query(Static))
            assert "Keys" in text
            for twin in screen.ABOUT.twin:
                assert twin in text
                assert twin.split()[1] in commands, twin
            await press(pilot, "escape")


@pytest.mark.sampled
@pytest.mark.parametrize("keys", ["1", "4", "4 _ c", "5", "6", "6 right", "6 right right", "6 left", "7", "1 enter"])
async def test_help_explains_every_heading_and_every_name_of_a_figure(file: Path, keys: str) -> None:
    async with opened(file, (160, 50)) as pilot:
        await press(pilot, *keys.split())
        screen = pilot.app.screen
        assert isinstance(screen, PageScreen)
        helped = " ".join([screen.ABOUT.about, *(f"{name}: {text}" for name, text in screen.ABOUT.fields)]).lower()
        titles = {head.title for table in screen.query(Table) for head in table.heads if table.display}
        for card in screen.query(ForecastCard):
            titles |= {line[:9].strip() for line in card.text.splitlines() if line[:9].strip() and line[9:11] == "  "}
        if isinstance(screen, FlightScreen):
            titles |= {column.title for column in (*READOUTS, *SETUP, *CONDITIONS)} | {"Log", "Cd", "thrust"}
        plain = {re.sub(r"^[✓!⊘✗?] | (m/s|s)$|[ ▲▼]+$", "", title).lower() for title in titles}
        assert plain
        assert not {title for title in plain if title not in helped and not title[:1].isdigit()}


@pytest.mark.thorough
@pytest.mark.sampled
@pytest.mark.parametrize("size", [(60, 20), (250, 70)], ids=str)
async def test_no_column_or_key_is_lost_in_small_and_large_terminals(file: Path, size: tuple[int, int]) -> None:
    with patch("fieldkit.capture.ports", list):
        async with opened(file, size) as pilot:
            for page in pages().values():
                await press(pilot, "escape", str(page.number), "escape")
                for table in pilot.app.screen.query(Table):
                    used = sum(table.widths()) + len(table.heads) + 1
                    assert not table.region.width or used <= table.region.width + 1, (page.title, size)
                assert "Quit" in shown(pilot) or page.title == "Add"
                assert "7" in shown(pilot).splitlines()[0]


async def test_keys_typed_ahead_are_not_lost(file: Path) -> None:
    async with opened(file) as pilot:
        await hurry(pilot, "slash", "f", "2", "4", "enter", "down")
        assert "4 of 12" in shown(pilot)
        assert "▸8" in shown(pilot)
        await press(pilot, "2")
        await hurry(pilot, "8", "ctrl+u", "9", "2", "4", "backspace", "3")
        assert pilot.app.screen.query_one("#in-apogee", Input).value == "923"


async def test_keys_typed_before_the_plan_is_ready_apply_to_it(file: Path) -> None:
    async with opened(file) as pilot:
        await hurry(pilot, "4", "b", "p")
        assert pilot.app.screen.query_one("#in-rocket", Input).value == "Astra"
        assert pilot.app.screen.query_one("#in-config", Input).value == "A", "b has gone on from B"


async def test_keys_typed_before_the_add_page_first_opens_are_not_lost(file: Path) -> None:
    async with opened(file) as pilot:
        await hurry(pilot, "a", *typed("923ft"), "enter", *typed("140mph"), "enter", "2")
        lines = [pilot.app.screen.query_one(f"#in-{name}", Input) for name in ("apogee", "top_speed", "burn_time")]
        assert [line.value for line in lines] == ["923ft", "140mph", "2"]
        assert pilot.app.focused is lines[-1]
        assert pilot.app.screen.query_one("#in-rocket", Input).value == "Astra"


@pytest.mark.thorough
async def test_pages_prepared_in_the_background_are_the_same_as_others(file: Path) -> None:
    async with opened(file, stays=True) as pilot:
        made = {stack[0] for stack in pilot.app._screen_stacks.values()}
        assert {page.screen for page in pages().values()} <= {type(screen) for screen in made}
        await press(pilot, "2")
        assert pilot.app.screen in made
        assert pilot.app.focused.id == "in-apogee"
        await hurry(pilot, "escape", "6", "4", "slash", *typed("f39"))
        assert "AeroTech F39T" in words(pilot)


async def test_resizing_keeps_the_page_and_its_place(file: Path) -> None:
    async with opened(file, (80, 24)) as pilot:
        await press(pilot, "down", "down")
        for size in ((60, 20), (250, 70), (80, 24)):
            await pilot.resize_terminal(*size)
            await calm(pilot)
            assert "▸10" in shown(pilot)


async def test_the_palette_finds_pages_colors_and_actions(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "ctrl+p", *typed("colors: night"), "_", "enter")
        await pilot.pause(0.3)
        await calm(pilot)
        assert pilot.app.theme == "night"
        listed = [command.title for command in pilot.app.get_system_commands(pilot.app.screen)]
        assert len(set(listed)) == len(listed), "an action with two keys is listed once"


async def test_the_mouse_opens_pages_and_help_like_keys(file: Path) -> None:
    async with opened(file) as pilot:
        await pilot.click("TopBar", offset=(32, 0))
        await calm(pilot)
        assert "file" in shown(pilot)
        for _ in range(3):  # on a busy machine a click may fall into a repaint
            bar = pilot.app.screen.query_one(KeyBar).region
            lines = shown(pilot).splitlines()[bar.y : bar.y + bar.height]
            row = next(row for row, line in enumerate(lines) if "Help" in line)
            await pilot.click(KeyBar, offset=(lines[row].index("Help"), row))
            await calm(pilot)
            if "Help: Import" in shown(pilot):
                break
        assert "Help: Import" in shown(pilot)


async def test_the_displayed_forecast_of_a_motor_is_the_saved_one(file: Path) -> None:
    async with opened(file) as pilot:
        with patch("fieldkit.tui.next.next_page.REST", 0.01):
            await press(pilot, "4", "_", "down", "_")
            page, table = pilot.app.screen, pilot.app.screen.query_one(Table)
            while table.current not in page._motors.exact:  # type: ignore[attr-defined]  # of the page in front
                await pilot.pause(0.01)
            await press(pilot, "_")
        card = pilot.app.screen.query_one(ForecastCard)
        before, row = card.text, pilot.app.screen.query_one(Table).current_text()
        await press(pilot, "enter", "_")
        assert card.text == before
        assert pilot.app.screen.query_one(Table).current_text() == row
    with Ledger.open(file) as ledger:
        saved = ledger.predictions("Astra")[-1].payload
    middle = f"{saved['apogee_m']['p50']:.1f}"
    assert f": {middle} m" in before
    assert middle in row


@pytest.mark.thorough
async def test_a_captured_flight_and_an_imported_log_are_paired_with_the_saved_forecast(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    log = file.parent / "field" / "flight.pf2"
    log.write_bytes((ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2").read_bytes())
    end = capture.Ended(log, "stratologger", 4000, 200, 0, "complete", True)
    here = [capture.Port("/dev/ttyUSB0", 0x0403, 0x6015, "A1", "adapter")]
    opens = capture.PortOpened("/dev/ttyUSB0", "stratologger", log)
    with (
        patch("fieldkit.capture.ports", lambda: here),
        patch("fieldkit.capture.capture", lambda *a, **k: iter([opens, end])),
    ):
        async with opened(file, page="next_flight") as pilot:
            await press(pilot, "b", "slash", *typed("f24"), "enter", "_", "enter", "_")
            await press(pilot, "7", "enter", "y", "_", "ctrl+s", "_")
            assert "Imported 1" in words(pilot)
            await press(pilot, "u", "_", "3", "down", "_", "enter", "_")
            assert "Not in the file" in words(pilot)
            assert "AeroTech F24W" in words(pilot)
            await press(pilot, "escape", "_")
            with Ledger.open(file) as ledger:
                assert len(ledger.flights()) == 12, "nothing is stored before the form is answered"
            await press(pilot, "enter", "_", "ctrl+s", "_")
            assert "Imported 1" in words(pilot)
    with Ledger.open(file) as ledger:
        flight = ledger.flights("Astra")[-1]
    assert (flight.rocket, flight.config) == ("Astra", "A")
    assert flight.motor.startswith("AeroTech F24W")
    assert flight.dry_mass == pytest.approx(0.322)


def test_forecasts_of_a_replaced_plan_are_not_shown_for_the_next_plan() -> None:
    old, new, choice = Mock(), Mock(), Mock()
    motors = MotorList(old)
    motors.put(old, [choice])
    assert motors.known == {choice.motor: choice}
    new.same_forecasts.return_value = False
    motors.turn_to(new)
    motors.put(old, [choice])
    assert motors.known == {}


def test_many_searches_keep_a_bounded_number_of_forecasts_and_all_of_the_last_one() -> None:
    plan = Mock(order=lambda target: MotorOrder(target))
    motors = MotorList(plan)
    for _ in range(5):
        motors.found = [Mock() for _ in range(MAX_FORECAST_MOTORS)]
        while waiting := motors.waiting(None):
            motors.put(plan, [Mock(motor=motor) for motor in waiting])
        assert all(motors.shown(motor) for motor in motors.found)
    assert len(motors.known) == MAX_STORED_FORECASTS
    motors.put_exact(motors.found[0], Mock())
    before = motors.found
    for _ in range(2):
        motors.found = [Mock() for _ in range(MAX_FORECAST_MOTORS)]
        motors.put(plan, [Mock(motor=motor) for motor in motors.found])
    assert before[0] not in motors.known
    assert motors.exact == set()


def test_motors_without_a_forecast_are_last_so_that_no_key_acts_on_one_of_them() -> None:
    """In a wind in which none fits, the flown one was replaced at the cursor by one that was still to be forecast."""
    flown, other = Mock(), Mock()
    plan = Mock(order=lambda target: MotorOrder(target, [flown], 200.0))
    motors = MotorList(plan, found=[other, flown])
    assert motors.ordered(None)[0] is flown
    motors.put(plan, [Mock(motor=flown, fits=False, weak=False, apogee=200.0)])
    assert motors.ordered(None) == [flown, other]
    motors.put(plan, [Mock(motor=other, fits=True, weak=False, apogee=300.0)])
    assert motors.ordered(None) == [other, flown]


def test_without_a_target_motors_are_sorted_by_distance_from_the_last_apogee_and_weak_ones_are_marked_at_once() -> None:
    """A motor that would lift the rocket 3 m was listed like any other until the fit judged it."""
    plan = Mock(order=lambda target: MotorOrder(target, [], 198.0), limits=limits(data_file("limits.toml")))
    heights = {"too weak": 3.0, "high": 431.0, "near": 189.0, "nearest": 203.0}
    names = {name: Mock(name=name) for name in heights}
    motors = MotorList(plan, found=list(names.values()))
    ratio = {"too weak": 2.6}
    motors.put_quick(
        plan,
        [
            QuickChoice(names[name], (apogee, apogee, apogee), None, False, ratio.get(name, 8.0), 8.0)
            for name, apogee in heights.items()
        ],
    )
    assert motors.ordered(None) == [names[name] for name in ("nearest", "near", "high", "too weak")]
    assert not motors.fits(names["too weak"])


async def test_quick_answers_are_shown_until_the_fit_replaces_them(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All motors at once, marked; the cursor stays on its motor, and no cell is ever empty again."""
    release = Event()

    def held(*args: object) -> object:
        release.wait(20)
        return guide(*args)  # type: ignore[arg-type]  # as passed

    monkeypatch.setattr("fieldkit.tui.next.next_page.guide", held)
    async with opened(file, page="home") as pilot:
        pilot.app.post_message(Key("4", "4"))
        for _ in range(1000):
            await asyncio.sleep(0.01)
            if pilot.app.screen.query("#motors") and "quick" in text_of(pilot, "#count"):
                break
        table = pilot.app.screen.query_one(Table)
        assert all(table.cells(motor)[1].startswith("≈") for motor in table.keys)
        assert len(table.keys) > 40
        table.move_to(table.keys[5])
        chosen = table.current
        for _ in range(1000):
            await asyncio.sleep(0.01)
            if chosen.designation in text_of(pilot, "#title"):
                break
        assert "provisional: off by up to 10% either way" in text_of(pilot, "#safety")
        assert "≈" in pilot.app.screen.query_one(ForecastCard).text
        release.set()
        for _ in range(400):
            await calm(pilot)
            if chosen in pilot.app.screen._motors.exact:  # type: ignore[attr-defined]  # of the page in front
                break
            await asyncio.sleep(0.05)  # until the cursor has rested
        assert not table.cells(table.current)[1].startswith(("≈", "…"))
        assert table.current is chosen
        assert "quick" not in text_of(pilot, "#count")
        assert "to check yourself" in text_of(pilot, "#safety")


async def test_without_an_answer_of_the_network_the_fit_answers(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(*_: object) -> object:
        raise DamagedModel("card.json: found no JSON, expected the card of an ensemble")

    monkeypatch.setattr("fieldkit.tui.next.next_page.quick_guide", damaged)
    async with opened(file, page="next_flight") as pilot:
        assert "Astra B on AeroTech" in shown(pilot)
        assert "error" not in words(pilot)
        assert "left" not in text_of(pilot, "#count")


async def test_enter_on_a_motor_still_to_be_forecast_saves_it_when_its_forecast_is_there(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A notice asked for a second Enter, and was overlooked."""

    def slow(*args: object) -> object:
        time.sleep(0.3)
        return guide(*args)  # type: ignore[arg-type]  # as passed

    monkeypatch.setattr("fieldkit.tui.next.next_page.guide", slow)
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)  # made at a frozen time in the past
    async with opened(file, page="home") as pilot:
        pilot.app.post_message(Key("f", "f"))
        for _ in range(500):
            if pilot.app.screen.query("#motors") and pilot.app.screen.query_one(Table).current is not None:
                break
            await asyncio.sleep(0.01)
        await hurry(pilot, "enter", "0")
        assert "Astra B on AeroTech F39" in words(pilot), "also on the page that came to the front meanwhile"
    with Ledger.open(file) as ledger:
        assert ledger.history()[-1].command == "forecast"


async def test_the_loop_shows_flown_apogees_and_the_effects_it_would_try_before_a_search(file: Path) -> None:
    async with opened(file, (160, 60), page="loop") as pilot:
        await press(pilot, "left")
        seen = words(pilot)
        assert "Apogee [m], flight by flight" in seen
        assert shown(pilot).count("●") >= 5
        for effect in effects().values():
            assert effect.form_of or effect.title in text_of(pilot, "#marks"), effect.title
        await press(pilot, "right", "_")
        assert "Each flight beside the others [m]" in words(pilot)
        assert shown(pilot).count("●") >= 5

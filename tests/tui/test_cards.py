"""Cards next to a row of the app: words for values from a log, lines on one scale, facts of the current row."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from fieldkit import settings
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.presentation import logged
from fieldkit.rocket import Configuration
from fieldkit.settings import FlyerCard
from fieldkit.tui.next import motor_facts
from fieldkit.tui.next.intervals import IntervalBar, Intervals, bar
from fieldkit.tui.setup import setup_card
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.groups import grouped, placed
from fieldkit.tui.widgets.table import Head, fitted
from tests.pressing import frozen, opened, press, season, shown, text_of, typed, words

pytestmark = pytest.mark.fast

LOGGED = {"stated_apogee_m": "161.544", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12"}
EXTRA = {"mach_delay_s": "2", "log_format": "perfectflite", "Platz": "Süd", "other_logs": "ab12 cd34"}


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    return tmp_path / "ledger.db"


def test_a_readout_measured_in_a_log_has_its_uncertainty_in_the_displayed_units() -> None:
    flight = Flight(apogee=162.8, sd={"apogee": 1.0})
    assert logged.readout(flight, BY_NAME["apogee"], "SI") == "162.8 ± 1.0 m"
    assert logged.readout(flight, BY_NAME["apogee"], "US") == "534.1 ± 3.3 ft"
    assert logged.readout(Flight(apogee=162.8), BY_NAME["apogee"], "SI") == "162.8 m"
    assert logged.readout(Flight(sd={"apogee": 1.0}), BY_NAME["apogee"], "SI") == ""


def test_values_from_a_log_are_described_in_words_with_units() -> None:
    assert logged.beside(LOGGED | EXTRA, "SI") == [
        ("Apogee, stated", "161.5 m"),
        ("Time to apogee", "5.71 ± 0.12 s"),
        ("Other logs of it", "2"),
        ("Mach delay", "2 s"),
        ("Log format", "perfectflite"),
        ("Platz", "Süd"),
    ]
    assert logged.beside({"stated_apogee_m": "high"}, "SI") == [("Apogee, stated", "high")]


def test_names_in_wide_characters_do_not_shift_columns() -> None:
    rows = (IntervalBar("飛行機雲 F39", 1.0, 2.0, 3.0), IntervalBar("12 F39", 1.0, 2.0, 3.0))
    drawn = str(Intervals(rows, str, {})).splitlines()
    assert cell_len(drawn[0]) == cell_len(drawn[1]) <= 76
    facts = str(cards.lines("", [("飛行機", "once"), ("F39", "twice")])).splitlines()
    assert [cell_len(line[: line.index(word)]) for line, word in zip(facts, ("once", "twice"), strict=True)] == [8, 8]


@given(st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=3), st.integers(10, 200))
def test_an_interval_on_its_own_scale_spans_the_full_width(ends: list[float], width: int) -> None:
    low, middle, high = sorted(ends)
    line = bar(IntervalBar("", low, middle, high), low, high, width)
    assert len(line) == width
    assert "●" in line
    if high - low > 1e-6 * max(1.0, abs(high)):
        assert set(line) <= set("├─●┤")


def test_an_arrow_points_to_what_is_beyond_a_scale() -> None:
    assert bar(IntervalBar("", 50.0, 150.0, 250.0), 0.0, 100.0, 11) == "     ├────→"
    assert bar(IntervalBar("", -50.0, 50.0, 250.0), 0.0, 100.0, 11) == "←────●────→"
    assert bar(IntervalBar("", 150.0, 180.0, 250.0), 0.0, 100.0, 11) == "          →"


def test_intervals_share_one_scale_with_ends_and_ticks_below() -> None:
    rows = (IntervalBar("4 s", -1.5, -0.7, 0.8), IntervalBar("5 s", -1.1, 0.0, 1.8, flown=1.5))
    lines = str(Intervals(rows, lambda value: f"{value:+.1f} s", {"apogee": 0.0})).splitlines()
    assert lines[0].index("●") < lines[0].index("◎")
    assert lines[1].index("◉") < lines[1].index("◆")
    assert lines[2].split() == ["-1.5", "s", "apogee", "+0.0", "s", "+1.8", "s"]


def test_a_motor_is_described_in_words_with_its_units() -> None:
    facts = dict(motor_facts.facts(catalogue().resolve("AeroTech F24W").motor, "US"))
    assert facts["total impulse"] == "47.3 N s"
    assert facts["kind"] == "reloadable, class F"
    assert facts["delays"] == "4, 7 s"
    assert facts["on sale"] == "yes"
    assert facts["loaded mass"].endswith(" oz")


def test_a_site_shows_its_air_and_what_its_safety_checks_lack() -> None:
    flights = [Flight(flight_id="1", rocket="Comet", site="Hill", apogee=200.0, site_elevation=1000.0)]
    (place,) = placed(grouped(["1"], flights, "site"), [Site("Hill", ceiling=300.0)])
    shown = "\n".join(map(str, setup_card.of_site(place, "", "SI").blocks))
    assert "1.112 kg/m³ on a standard day" in shown  # U.S. Standard Atmosphere 1976 at 1000 m
    assert "300.0 m" in shown
    assert "field size  not known" in shown


def test_overlong_text_shows_its_beginning_or_its_end() -> None:
    assert fitted("flight-dd2afbb08f", 8, Head("id", 8)) == "flight-…"
    assert fitted("flight-dd2afbb08f", 8, Head("id", 8, tail=True)) == "…afbb08f"
    assert fitted("pnut_tarc2023_f7.pf2", 13, Head("file", 13, middle=True)) == "pnut…3_f7.pf2"
    assert fitted("12", 4, Head("id", 4, True, tail=True)) == "  12"


async def test_each_list_of_setup_shows_the_facts_of_its_current_row(file: Path) -> None:
    with Ledger.open(file) as ledger:
        assert ledger.names("rocket") == ["Astra"]
        other = Flight("13", "Astra", "A", "Quest E35W-5", dry_mass=0.322, diameter=0.066, apogee=150.0, tags=("cato",))
        ledger.add([other])
    async with opened(file, (160, 50)) as pilot:
        await press(pilot, "6", "slash", *typed("f24"), "enter")
        assert "thrust [N] against time [s]" in words(pilot)
        await press(pilot, "right")
        assert "9, 4 of them normal" in words(pilot)
        assert "Quest E35W 5 times, to between 131.1 and 174.7 m" in words(pilot), "both spellings are one motor"
        await press(pilot, "right")
        assert "281.3 m Astra F24-4W" in words(pilot)
        await press(pilot, "right", "right")  # after the kits
        assert "Enter switches to the next; so does N" in words(pilot)
        assert "The same figures SI US mixed" in words(pilot)
        assert "Dry mass 322 g 11.36 oz 322 g" in words(pilot)
        await press(pilot, "down")
        assert "✗ ⊘ not possible, unsafe" in words(pilot)
        assert "a forecast: filled 90%" in words(pilot)


async def test_every_setting_shows_what_it_does_now(file: Path) -> None:
    settings.change_settings({"target": 200.0, "flyer": FlyerCard(rails=(1.2, 1.8))}, file.with_name("settings.json"))
    async with opened(file, (160, 50), page="setup") as pilot:
        await press(pilot, "left", "down", "down")
        assert "Astra so far within 3 m: " in text_of(pilot, "#facts")
        assert "flight by flight; ✗ tagged, ─ the target" in shown(pilot)
        await press(pilot, "down")
        assert "Plans start with length 1.8 m, the longest that you own" in text_of(pilot, "#facts")
        await press(pilot, "down")
        assert "Range box Motors that you have" in text_of(pilot, "#facts")
        await press(pilot, "down")
        assert "flights 12 of 1 rocket flown 2026-04-18 to 2026-04-18" in text_of(pilot, "#facts")
        assert "one is made before the first change of a day" in text_of(pilot, "#facts")
        await press(pilot, "down")
        assert "none yet i in the Motors list adds" in text_of(pilot, "#facts")
        await press(pilot, "down")
        assert "settings.json these settings: " in text_of(pilot, "#facts")


async def test_a_site_shows_the_fields_of_the_code_and_its_air(file: Path) -> None:
    async with opened(file, (160, 50), page="setup") as pilot:
        await press(pilot, "right", "right", "enter", "down", "down", *typed("130m"), "ctrl+s", "_")
        assert "Flown here Astra 12 times, to between 131.1 and 281.3 m" in words(pilot)
        assert "Field for model rockets by NAR Model Rocket Safety Code" in words(pilot)
        below = text_of(pilot, "#below")
        assert "C 122 m ✓ D 152 m ⊘ E to G 305 m ⊘" in below
        assert re.search(r"Air there, by the temperature 0 °C 1\.26\d kg/m³, altimeter reads \d\.\d% high", below)


async def test_without_a_site_the_fields_of_the_code_and_the_air_at_sea_level_are_shown(tmp_path: Path) -> None:
    async with opened(tmp_path / "ledger.db", (160, 50), page="setup") as pilot:
        await press(pilot, "right", "right")
        assert "A 30 m B 61 m C 122 m" in words(pilot)
        assert "30 °C 1.164 kg/m³" in words(pilot)  # 1.225 x 288.15 / 303.15


async def test_a_rocket_with_a_design_shows_its_centers_and_its_stability(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.keep_design(Configuration("Astra", "B", 0.448, 0.066, 0.9, 0.7, "astra.ork", cg=0.52, cp=0.66))
        ledger.keep_design(Configuration("Astra", "A", 0.322, 0.066, 0.9, 0.7, "astra.ork", cg=0.60, cp=0.65))
    async with opened(file, (160, 50), page="setup") as pilot:
        await press(pilot, "right")
        assert "stability 2.1 calibers off the rod, as simulated" in words(pilot)
        assert "CP ▲ ▲ CG" in words(pilot)
        assert "⊘" not in words(pilot)
        await press(pilot, "down")
        assert "stability 0.8 calibers off the rod, as simulated ⊘ below 1" in words(pilot)


async def test_a_filter_without_matches_reports_it(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "slash", *typed("zzz"))
        assert "no flight matches all of these words" in words(pilot)

"""Sentences for one flight, for names with spaces, and for figures that do not exist."""

import json
import re
from datetime import datetime
from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.predict import predict
from fieldkit.forecast.prediction import Prediction
from fieldkit.messages import message
from fieldkit.motors import catalogue
from fieldkit.planning.check import figure
from fieldkit.planning.descent_rate import Fall, usual
from fieldkit.presentation.finals_text import finals_headers
from fieldkit.presentation.forecast_text import ejection_in_words, in_words, rests_in_words
from fieldkit.presentation.report.finals_card import finals_card
from fieldkit.presentation.report.paper import moment_in_words
from fieldkit.quantities import in_system
from fieldkit.services.provenance import InputChange
from tests.commands import Run

CHECK_SHAPES = False
NAME = "$x_$ Big 火箭"
"""A name that matplotlib would read as a formula, a shell as several words, and whose characters its font lacks."""
EDGES = (".png", ".svg", ".pdf")


def forecast(motor: str, **given: object) -> Prediction:
    """The forecast of a rocket that has not flown."""
    plan = Flight(rocket="Alpha", motor=motor, dry_mass=0.322, diameter=0.066).with_changes(**given)
    (made,) = predict([], [(plan, catalogue().resolve(motor))], draws=50)
    return made


def test_the_reason_why_no_charge_fires_is_named() -> None:
    assert ejection_in_words(forecast("F24-4W")).endswith("apogee")
    assert ejection_in_words(forecast("F39")).startswith("delay unknown")
    assert ejection_in_words(forecast("F24-P")) == "none: a plugged motor has no charge"
    assert ejection_in_words(forecast("F24-4W", delay=90.0)) == "none: the rocket hits the ground first"
    assert re.search(
        r"after apogee; \d+% chance of hitting the ground first", ejection_in_words(forecast("F24-4W", delay=13.0))
    )
    assert ejection_in_words(forecast("F24-4W", dry_mass=30.0)) == "none: the rocket does not leave the rail"


def test_the_basis_of_a_new_rockets_forecast_is_the_same_in_every_sentence() -> None:
    made = forecast("F24-4W")
    assert "  based on  no flights of this rocket, only other rockets" in list(in_words(made))
    assert rests_in_words(made).startswith("no flights of this rocket, only other rockets; one normal flight")


def test_a_date_without_a_time_shows_no_time() -> None:
    assert moment_in_words(datetime(2026, 5, 1)) == "Friday, May 1, 2026"
    assert moment_in_words(datetime(2026, 5, 1, 9, 5)) == "Friday, May 1, 2026, 09:05"


def test_ounces_keep_their_decimals_in_the_limits_of_a_rule() -> None:
    printed = f"{figure(0.019, 'g')} of propellant, at most {figure(0.125, 'g')}; lands {figure(100.0, 'm')} away"
    assert in_system(message(printed), "US") == "0.67 oz of propellant, at most 4.41 oz; lands 328 ft away"
    assert in_system(message(printed), "SI") == "19 g of propellant, at most 125 g; lands 100 m away"


@pytest.mark.parametrize(
    ("change", "words", "american"),
    [
        (("dry_mass_g", "322", "340"), "dry mass was 322 g, now 340 g", "dry mass was 11.36 oz, now 11.99 oz"),
        (
            ("diameter_mm", "66", "50.8", "the design's "),
            "the design's diameter was 66 mm, now 50.8 mm",
            "the design's diameter was 2.598 in, now 2 in",
        ),
        (("temperature_c", "", "20"), "temperature was not given, now 20 °C", "temperature was not given, now 68 °F"),
        (("motor", "AeroTech F24W", "AeroTech F39T"), "motor was AeroTech F24W, now AeroTech F39T", None),
        (("thrust", "0f3a", "91bc"), "the motor's thrust curve changed", None),
        (("no correction replaced by model version 1",), "no correction replaced by model version 1", None),
    ],
)
def test_the_reason_why_a_forecast_is_stale_is_in_the_flyers_units(
    change: tuple[str, ...], words: str, american: str | None
) -> None:
    assert InputChange(*change).words() == words
    assert InputChange(*change).words("US") == (american or words)


@pytest.mark.parametrize("suffix", EDGES)
def test_a_name_is_not_read_as_a_formula_on_the_finals_card(suffix: str) -> None:
    row = ("800", "320", "-20", "383", "700-900", "40")
    heading = [f"{NAME} on AeroTech F24W " * 4, "wind not given"]
    assert finals_card(heading, finals_headers(usual()), [row], suffix, [NAME])
    row = ("800", "320", "-20", "383", "100%", "700-900", "30-50", "40")
    assert finals_card(heading, finals_headers(Fall(2.2, 0.1, 4)), [row], suffix, [NAME])


@pytest.fixture
def home(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user with US customary units, and five flights of one rocket."""
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "settings.json").write_text(json.dumps({"units": "US"}))
    rows = [f"{i},2026-05-0{i},{NAME},A,F24-4W,322,{240 + 3 * i},{45 if i == 1 else ''}" for i in range(1, 6)]
    header = "flight_id,date_time,rocket,config,motor,dry_mass_g,apogee_m,top_speed_mps"
    (tmp_path / "flights.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
    run("import", tmp_path / "flights.csv")
    return tmp_path


def test_cd_without_a_diameter_is_empty_and_warnings_are_in_the_flyers_units(home: Path, run: Run) -> None:
    printed = run("infer")
    assert "nan" not in printed.out
    assert "top speed of" in printed.err
    assert "mph" in printed.err
    assert "m/s" not in printed.err


def test_cd_without_a_diameter_is_null_in_json(home: Path, run: Run) -> None:
    flights = run("infer", "--json").document["flights"]
    assert [one["cd"] for one in flights] == [None] * 5
    assert all(one["alpha"] > 0 for one in flights)


def test_a_log_without_a_rocket_is_not_the_default_of_a_plan(home: Path, run: Run) -> None:
    (home / "log.csv").write_text("flight_id,apogee_m\nx,300\n")
    run("import", home / "log.csv")
    assert run("predict", "--motor", "F24-4W", "--json").document["predictions"][0]["rocket"] == NAME


def test_a_suggested_command_can_be_pasted_into_a_shell(home: Path, run: Run) -> None:
    assert f"`fieldkit loop --rocket '{NAME}'`" in run("loop", "--quick").out


def test_forecasts_of_two_builds_differ_in_their_configuration_and_no_date_is_cut(
    home: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    for build in ("A", "heavy"):
        run("predict", "--motor", "F24-4W", "--config", build, "--dry-mass", "322")
    printed = run("predictions").out
    assert len(re.findall(r" \d{4}-\d\d-\d\d ", printed)) == 2
    assert " heavy " in printed


@pytest.mark.thorough
def test_a_range_card_shows_a_name_unchanged(home: Path, run: Run) -> None:
    card = home / "card.svg"
    run("landing", "--motor", "F24-4W", "--wind", "5mph", "--card", card)
    assert "$x_$" in card.read_text(encoding="utf-8")

"""`fieldkit units` sets the units of every command, and no name is ever converted into them."""

from pathlib import Path

import pytest

from fieldkit.cli.units import ask_units_once, usual_units
from tests.commands import Run

CHECK_SHAPES = False
NAME = "Test 30 m"


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))


def test_units_are_shown_and_set_and_kept(run: Run) -> None:
    assert run("units", "--json").document["units"] == "SI"
    assert "apogee in ft" in run("units", "us").out
    assert run("units", "--json").document["shown"]["dry_mass"] == "oz"
    assert "expected one of SI, US, mixed" in " ".join(run("units", "furlongs", status=2).err.split())


def test_the_name_of_a_flight_is_never_converted(run: Run) -> None:
    run("units", "US")
    entry = ["add", "--flight-id", NAME, "--rocket", "Pad 90 m", "--motor", "F24-4W", "--dry-mass", "90kg"]
    added = run(*entry, "--diameter", "66mm", "--apogee", "250m")
    outputs = [added, run("show", NAME), run("tag", NAME, "off_axis"), run("flights"), run("untag", NAME, "off_axis")]
    outputs += [
        run("tag", "Test 98 ft", "x", status=1),
        run("predict", "--rocket", "Pad 90 m", "--motor", "F24-4W", status=None),
    ]
    texts = " ".join(" ".join((one.out + one.err).split()) for one in outputs)
    assert NAME in texts
    assert "Pad 90 m" in texts
    assert "Pad 295 ft" not in texts
    assert "did you mean Test 30 m?" in texts
    notes = " ".join(added.err.split())
    assert "excluded from every fit: a dry mass of 198.4 lb is more than the mass of" in notes
    assert "90000 g" not in texts, "one output has one system of units"


def test_the_name_of_a_file_is_never_converted(tmp_path: Path, run: Run) -> None:
    run("units", "US")
    table = tmp_path / "pad 30 m.csv"
    table.write_text("rocket,motor,dry_mass_g,apogee_m\nAstra,F24-4W,322,300000\nAstra,F24-4W,322,250\n")
    printed = run("import", table, status=None)
    assert "pad 30 m.csv" in printed.err
    assert "98 ft" not in printed.out + printed.err


@pytest.mark.parametrize(
    ("environment", "system"),
    [
        ({"LANG": "en_US.UTF-8"}, "US"),
        ({"LANG": "de_CH.UTF-8"}, "SI"),
        ({"LANG": "en_US.UTF-8", "LC_MEASUREMENT": "en_GB.UTF-8"}, "SI"),
        ({"LANG": "C"}, "SI"),
        ({}, "SI"),
    ],
)
def test_the_country_says_which_units_are_usual(environment: dict[str, str], system: str) -> None:
    assert usual_units(environment) == system


def test_nothing_is_asked_without_a_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    ask_units_once()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "asked"),
    [(("flights",), 1), (("units",), 0), (("docs",), 0), (("flights", "--json"), 0), (("flights", "--help"), 0)],
)
def test_any_command_in_a_terminal_asks_for_the_units_once(
    arguments: tuple[str, ...], asked: int, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    prompts: list[str] = []
    monkeypatch.setattr("fieldkit.cli.units.in_terminal", lambda: True)
    monkeypatch.setattr("typer.prompt", lambda text, **_: prompts.append(text) or "us")
    run(*arguments)
    run(*arguments)
    assert len(prompts) == asked
    assert not asked or run("units", "--json").document["units"] == "US"


def test_with_us_units_a_typed_date_has_the_month_first_and_import_notes_are_in_feet(run: Run, tmp_path: Path) -> None:
    run("units", "US")
    table = tmp_path / "t.csv"
    table.write_text(
        "flight_id,rocket,motor,dry_mass_g,diameter_mm,apogee_ft\n1,Lark,F24-4W,320,66,9230\n", encoding="utf-8"
    )
    assert "apogee of 9230 ft is more than" in run("import", table).err
    run("edit", "1", "date_time=10/3/2026")
    assert run("show", "1", "--json").document["date_time"] == "2026-10-03T00:00:00"

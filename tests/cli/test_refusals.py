"""Values, ledgers and folders that commands refuse in one line, and folders that they do not need."""

import json
import os
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import typer

from fieldkit.cli.main import OnDemand, app, main
from fieldkit.errors import LONGEST_LINE, LedgerError
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.limits import LIMITS
from fieldkit.ledger import Ledger
from fieldkit.units import unit
from tests.commands import Run

ROOT = Path(__file__).parents[2]

CHECK_SHAPES = False
TABLE = """flight_id,date_time,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m
1,2025-05-01T10:00,Astra,A,322,66,F24-4W,250
2,2025-05-02T10:00,Astra,A,322,66,F24-4W,255
3,2025-05-03T10:00,Astra,A,322,66,F24-4W,245
"""


@pytest.fixture
def filled(run: Run, tmp_path: Path) -> Run:
    """Runs a command line on a ledger of three flights."""
    (tmp_path / "flights.csv").write_text(TABLE)
    run("import", tmp_path / "flights.csv")
    return run


def paths() -> Iterator[list[str]]:
    """A command line for every option and argument of any command that takes a path, without the path."""
    for name, command in OnDemand().items():
        for inner, own in getattr(command, "commands", {"": command}).items():
            for parameter in own.params:
                if parameter.type.name == "path":
                    option = parameter.opts[:1] if parameter.param_type_name == "option" else []
                    yield [name, *filter(None, [inner]), *option]


@pytest.mark.parametrize("words", paths(), ids=" ".join)
def test_an_empty_path_is_refused(run: Run, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is no name for the current folder: a script forgot to set a variable."""
    monkeypatch.chdir(tmp_path)
    found = run(*words, "", status=2)
    assert "found an empty path, expected the name of a file or folder" in " ".join(found.err.replace("│", " ").split())


def test_an_empty_port_is_refused(run: Run) -> None:
    assert "found an empty name, expected a port" in run("capture", "", status=None).err


@pytest.mark.parametrize("words", [["predict", "--quick"], ["predict"], ["delay"], ["landing"], ["loop"]], ids=str)
def test_without_a_flight_or_a_rocket_the_refusal_begins_with_a_word(run: Run, words: list[str]) -> None:
    plan = ["--motor", "A8-3", "--dry-mass", "100g"] if words[0] != "loop" else []
    printed = run(*words, *plan, status=None)
    assert all(line[0] not in ":," for line in (printed.out + printed.err).splitlines() if line)


def test_a_forecast_that_cannot_be_saved_is_still_printed(filled: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a full or read-only disk a flyer still needs it, and learns that it is not saved."""

    def full(*_: object, **__: object) -> None:
        raise LedgerError("ledger.db: the disk is full")

    monkeypatch.setattr(Ledger, "keep_prediction", full)
    printed = filled("predict", "--motor", "F24-4W", status=1)
    assert "90% interval" in printed.out
    assert "saving the forecast failed: ledger.db: the disk is full" in printed.err


def test_scores_that_cannot_be_saved_are_still_printed(filled: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The table is not lost if its forecasts cannot be saved for later ones."""

    def full(*_: object, **__: object) -> None:
        raise LedgerError("ledger.db: the disk is full")

    monkeypatch.setattr(Ledger, "keep_predictions", full)
    printed = filled("score", status=1)
    assert "fieldkit" in printed.out
    assert "saving the forecasts failed: ledger.db: the disk is full" in printed.err


@pytest.mark.parametrize("column", ["flight_id", "rocket", "config", "site", "tags"])
def test_a_typed_name_of_20_000_characters_is_refused_in_one_line(filled: Run, column: str) -> None:
    (line,) = filled("edit", "1", f"{column}={'N' * 20_000}", status=1).err.splitlines()
    assert f"{'id' if column == 'flight_id' else column}: found 'NNNN" in line
    assert len(line) < 200
    if column == "tags":
        filled("tag", "1", "N" * 20_000, status=1)


def test_overlong_names_of_an_older_ledger_survive_an_export(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = {name: name * 100 for name in ("flight_id", "rocket", "config", "site")}
    flight = Flight(**names, tags=("t" * 2_000,), motor="F24-4W", apogee=250.0)
    with Ledger.open(tmp_path / "older.db") as older:
        older.add([flight])
    for suffix in (".csv", ".json"):
        table, newer = str(tmp_path / f"flights{suffix}"), str(tmp_path / f"newer{suffix}.db")
        assert main(["--ledger", str(tmp_path / "older.db"), "export", table]) == 0
        capsys.readouterr()
        assert main(["--ledger", newer, "import", table]) == 0
        notes = capsys.readouterr().err.splitlines()
        assert sum("which tables shorten" in line for line in notes) == 5
        assert max(map(len, notes)) < 2 * LONGEST_LINE
        with Ledger.open(newer) as ledger:
            assert ledger.flights() == [flight]


@pytest.mark.parametrize("suffix", [".csv", ".json"])
def test_figures_that_an_older_ledger_exports_beyond_the_limits_are_named_by_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], suffix: str
) -> None:
    table, sound = str(tmp_path / f"flights{suffix}"), Flight(flight_id="0", rocket="Astra", apogee=250.0)
    columns = {BY_NAME[name]: 2 * high + 1 for name, (_, high) in LIMITS.items()}
    beyond = [
        sound.with_changes(flight_id=column.header, **{column.name: unit(column.quantity, column.unit).to_si(figure)})
        for column, figure in columns.items()
    ]
    with Ledger.open(tmp_path / "older.db") as older:
        older.add([sound, *beyond])
    assert main(["--ledger", str(tmp_path / "older.db"), "export", table]) == 0
    capsys.readouterr()
    main(["--ledger", str(tmp_path / "newer.db"), "import", table, "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert answer["imported"] == 1
    assert [one["column"] for one in answer["rejected"]] == [column.header for column in columns]


def test_a_number_too_large_for_a_float_is_quoted_as_in_the_file(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "flights.json"
    file.write_text('{"flights": [{"flight_id": "9", "rocket": "Astra", "apogee_m": 2e999}]}')
    printed = run("import", file, status=None)
    assert "apogee_m: found '2e999', expected a number" in printed.out + printed.err


REFUSED = {
    "a motor colder than anything": ["--motor-temperature=-300"],
    "a motor of a thousand degrees": ["--motor-temperature", "1000"],
    "a waiver below the pad": ["--waiver=-500m"],
    "a waiver of nothing": ["--waiver", "0"],
    "a field of no size": ["--field-size", "0"],
    "a stability of next to nothing": ["--stability-cal", "1e-320"],
    "a parachute that opens after thirty years": ["--opening-time", "1e9"],
    "a parachute of a hair's width": ["--parachute-diameter", "0.1"],
    "a wind aloft faster than sound": ["--wind-aloft", "400", "--wind-aloft-height", "300"],
    "a wind above the air": ["--wind-aloft", "10", "--wind-aloft-height", "1e9"],
    "a main above the air": ["--main-altitude", "1e9"],
    "a wind that turns a thousand times": ["--wind-aloft", "10", "--wind-aloft-turn", "360000"],
    "a mass in twenty thousand digits": ["--dry-mass", "1" * 20_000 + " 1"],
}


@pytest.mark.parametrize("what", REFUSED)
def test_an_impossible_value_is_refused_in_one_line(what: str, filled: Run) -> None:
    (printed,) = filled("predict", "--motor", "F24-4W", *REFUSED[what], status=1).err.splitlines()
    assert "expected" in printed
    assert len(printed) < 300


def numbers(tree: Any, names: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Every command of the tree with an option that takes a number of any size, and that option."""
    for one in tree.params:
        if one.type.name.startswith("float"):
            yield (*names, one.opts[0])
    for name, child in getattr(tree, "commands", {}).items():
        yield from numbers(child, (*names, name))


@pytest.mark.parametrize("words", numbers(typer.main.get_command(app)), ids=" ".join)
def test_no_option_accepts_an_invalid_number(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    for number in ("nan", "inf", "-inf"):
        assert main([*words[:-1], f"{words[-1]}={number}"]) == 2
        assert f"found {number}" in (printed := capsys.readouterr().err) or "is not in the range" in printed


@pytest.mark.parametrize(
    "area", ["--reef=100%", "--reef=200%", "--reef=-10%", "--reef=nan", "--parachute=0", "--parachute=1e-300"]
)
def test_a_parachute_reefed_to_nothing_is_refused(area: str, filled: Run) -> None:
    printed = filled("contest", "--season", "2026", "--motor", "F24-4W", area, status=None)
    assert printed.status in (1, 2)
    assert "expected" in printed.err


@pytest.mark.parametrize("url", ["sqlite://", "sqlite:///", "sqlite:///:memory:"])
def test_a_ledger_that_would_store_nothing_is_refused(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    assert main(["--ledger", url, "add", "--rocket", "Astra", "--apogee", "100m"]) == 1
    printed = capsys.readouterr()
    assert "would store nothing, expected sqlite:///FILE" in printed.err
    assert "added" not in printed.out + printed.err


def test_an_unusable_home_folder_does_not_matter_if_a_ledger_is_named(
    filled: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "file" / "home"))
    for words in (["predict", "--motor", "F24-4W"], ["flights"], ["motors", "F24"], ["delay"], ["export"]):
        filled(*words)
    assert main(["flights"]) == 1
    assert "home" in capsys.readouterr().err


@pytest.mark.parametrize("named", ["~no_such_user/home", "~no_such_user"])
def test_the_home_folder_of_an_unknown_user_is_an_ordinary_name(
    named: str, filled: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FIELDKIT_HOME", named)
    for words in (["flights"], ["motors", "F24"]):
        assert main(words) == 0
    filled("predict", "--motor", "F24-4W")
    assert main(["--ledger", f"{named}.db", "flights"]) == 0


@pytest.mark.sampled
@pytest.mark.parametrize("date", ["0001-01-01T00:00", "9999-12-31T23:59", "0001-01-01", "9999-12-31"])
def test_the_last_possible_date_causes_no_overflow(date: str, filled: Run) -> None:
    filled("predict", "--motor", "F24-4W")
    filled("edit", "2", f"date_time={date}")
    for words in (
        ["score"],
        ["predictions"],
        ["show", "2"],
        ["flights"],
        ["predict", "--motor", "F24-4W"],
        ["history"],
    ):
        assert filled(*words, status=None).status in (0, 1)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full device")
@pytest.mark.usefixtures("filled")
def test_a_full_output_does_not_report_that_nothing_was_done(tmp_path: Path) -> None:
    ledger = str(tmp_path / "ledger.db")
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", ledger]
    flight = ["--rocket", "Astra", "--flight-id", "9", "--apogee", "100m"]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [*command, "add", *flight],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
    assert done.returncode == 1
    assert "may have finished" in done.stderr
    assert "nothing was changed" not in done.stderr
    assert "Traceback" not in done.stderr
    with Ledger.open(ledger) as opened:
        assert [flight.flight_id for flight in opened.flights()] == ["1", "2", "3", "9"]


def test_too_little_memory_is_reported_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def exhausted(arguments: object) -> int:
        raise MemoryError

    monkeypatch.setattr("fieldkit.cli.main._status", exhausted)
    assert main(["flights"]) == 1
    assert "too little memory" in capsys.readouterr().err


def test_a_flight_beside_a_damaged_one_is_not_shown_without_its_comparison(filled: Run, tmp_path: Path) -> None:
    """Flipped bits in another flight of the rocket made `show` leave out what it compares, and say nothing."""
    filled("show", "2")
    with closing(sqlite3.connect(tmp_path / "ledger.db")) as raw, raw:
        raw.execute("UPDATE flights SET apogee = 101.0 WHERE flight_id = '1'")
    message = filled("show", "2", status=1).err
    assert "the file is damaged (a row of 1 of" in " ".join(message.split())


@pytest.mark.parametrize(
    ("command", "found"),
    [
        (["sites", "x" * 5000, "--elevation", "5m"], "of length 5000, expected at most 200 characters"),
        (["kits", "x" * 5000, "--dry-mass", "80g", "--diameter", "40mm"], "of length 5000, expected at most 200 char"),
        (
            ["flyer", "--motor", "C6-5", "--count", "1", "--lot", "x" * 5000],
            "of length 5000, expected at most 200 char",
        ),
        (["flyer", "--motor", "C6-5", "--count", "9" * 20], "found a count of 1e+20, expected at most 1000"),
        (["finals", "--season", "2026", "--motor", "F24-4W", "--targets", "825-775"], "expected feet, the lower first"),
        (["serve", "--host", "x" * 5000], "cannot listen there (no computer has this name)"),
    ],
    ids=lambda one: one[0] if isinstance(one, list) else "",
)
def test_a_name_or_a_number_that_nothing_has_is_refused_before_it_is_saved(
    command: list[str], found: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--ledger", str(tmp_path / "ledger.db"), *command]) == 1
    assert found in " ".join(capsys.readouterr().err.split())


def test_a_forecast_without_a_motor_is_for_the_one_flown_last(filled: Run) -> None:
    printed = filled("predict", "--rocket", "Astra")
    assert "note: the motor is F24-4W, as last flown; change with --motor" in printed.err
    assert "Astra A on AeroTech F24-4W" in printed.out


def test_a_forecast_of_a_new_rocket_needs_a_motor(filled: Run) -> None:
    printed = filled("predict", "--rocket", "Bertha", "--dry-mass", "80g", "--diameter", "41.6mm", status=2)
    assert "found no --motor, expected one such as F24-4W" in " ".join(printed.err.replace("│", " ").split())

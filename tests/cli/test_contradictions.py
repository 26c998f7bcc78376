"""Options that contradict each other or would have no effect are usage errors: no input is ignored."""

from pathlib import Path

import pytest

from fieldkit.ledger import Ledger
from tests.commands import Run

CHECK_SHAPES = False
FLIGHTS = """flight_id,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m
1,Astra,A,322,66,F24-4W,250
"""
PLANS = """flight_id,rocket,config,dry_mass_g,diameter_mm,motor,wind_mps
a,Astra,A,322,66,F24-4W,2
"""
LINES = {
    "predict --flights plans.csv --wind 20mph": "--wind with --flights",
    "predict --flights plans.csv --motor F24-4W": "--motor with --flights",
    "predict --flights plans.csv --kit Bertha --dry-mass 900": "--dry-mass, --kit with --flights",
    "predict --motor F24-4W --dry-mass 322g --lift-off-mass 385g": "--dry-mass and --lift-off-mass",
    "daysheet --flights plans.csv --rocket Astra --out sheet.pdf": "--rocket with --flights",
    "remeasure 1 --rocket Astra": "flights and --rocket",
    "motors F24 --fit Astra": "--fit and a search",
    "motors --about --corrections": "--corrections and --about",
    "motors F24 --target 250m": "--target without --fit",
    "motors F24 --all": "--all without --fit",
    "motors F24 --wind 3": "--wind without --fit",
    "motors --about --shortlist-for Astra": "--shortlist-for without a search",
    "delay --motor F24-4W --cuts nan": "--cuts 'nan'",
    "delay --motor F24-4W --cuts 2,inf": "--cuts '2,inf'",
    "delay --motor F24-4W --cuts 0.001": "each at least 0.1",
}


@pytest.fixture
def folder(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a table of plans, and a ledger of one flight."""
    monkeypatch.setenv("COLUMNS", "400")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "flights.csv").write_text(FLIGHTS)
    (tmp_path / "plans.csv").write_text(PLANS)
    run("import", "flights.csv")
    return tmp_path


@pytest.mark.parametrize("line", LINES)
def test_an_option_without_effect_is_a_usage_error(line: str, folder: Path, run: Run) -> None:
    printed = run(*line.split(), status=2)
    assert LINES[line] in printed.err
    assert not printed.out
    assert not (folder / "sheet.pdf").exists()


def test_a_quick_look_cannot_decline_an_effect(folder: Path, run: Run) -> None:
    assert "--decline: found together with --quick" in run("loop", "--quick", "--decline", "wind", status=1).err


def test_the_conditions_of_a_day_still_complete_a_table(folder: Path, run: Run) -> None:
    run("daysheet", "--flights", "plans.csv", "--temperature", "68F", "--out", "sheet.pdf")
    assert (folder / "sheet.pdf").exists()


def test_an_unknown_rocket_cannot_be_remeasured(folder: Path, run: Run) -> None:
    assert "expected one of: Astra" in run("remeasure", "--rocket", "Nope", status=1).err


def test_an_unknown_site_is_reported_with_the_known_ones(folder: Path, run: Run) -> None:
    run("sites", "Meadow", "--elevation", "200m")
    printed = run("sites", "Medow", status=1).err
    assert "no site 'Medow'; did you mean Meadow?" in printed
    assert "No sites yet" not in printed


def test_consent_to_replace_one_file_is_not_consent_to_replace_the_other(
    folder: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    (folder / "map.kml").write_text("mine")
    (folder / "card.png").write_text("mine too")
    asked: list[Path] = []

    def settled(file: Path, force: bool) -> bool:
        asked.append(file)
        return force or file.name == "map.kml"

    monkeypatch.setattr("fieldkit.cli.landing.settled", settled)
    words = "landing --motor F24-4W --wind 2 --kml map.kml --pad 47.5,8.7 --card card.png"
    run(*words.split(), status=1)
    assert [file.name for file in asked] == ["map.kml", "card.png"]
    assert (folder / "card.png").read_text() == "mine too"


def test_a_long_import_is_one_short_line_in_the_history(folder: Path, run: Run) -> None:
    for number in range(9):
        table = FLIGHTS.replace("1,Astra", f"{number + 2},Astra").replace(",250", f",{260 + number}")
        (folder / f"day{number}.csv").write_text(table)
    run("import", *(f"day{number}.csv" for number in range(9)))
    with Ledger.open(folder / "ledger.db") as ledger:
        assert ledger.history()[-1].what == (
            "2, 3, 4, 5 and 5 more from day0.csv, day1.csv, day2.csv, day3.csv and 5 more"
        )


@pytest.mark.parametrize("command", ["predict", "daysheet --out sheet.pdf"])
def test_the_plans_of_a_table_are_counted(command: str, folder: Path, run: Run) -> None:
    """Each is simulated, and drawn on a day sheet: thousands took a quarter of an hour."""
    header, row, _ = PLANS.split("\n")
    (folder / "many.csv").write_text("\n".join([header, *[row.replace("a", str(n), 1) for n in range(201)]]))
    (folder / "none.csv").write_text(header)
    error = run(*command.split(), "--flights", "none.csv", status=1).err
    assert "none.csv: found no planned flights, expected a row for each" in error
    error = run(*command.split(), "--flights", "many.csv", status=1).err
    assert "many.csv: found 201 planned flights, expected at most 200 at a time" in error

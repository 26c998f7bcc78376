"""What `export` writes, and where the ledger is."""

import csv
from pathlib import Path

from tests.commands import Run


def test_no_csv_table_is_written_under_the_name_of_a_workbook(run: Run, tmp_path: Path) -> None:
    assert "found .xlsx, expected .csv" in run("export", tmp_path / "flights.xlsx", status=1).err
    assert not (tmp_path / "flights.xlsx").exists()
    run("export", tmp_path / "flights.xlsx", "--format", "csv")


def test_the_list_of_backups_names_the_ledger(run: Run, tmp_path: Path) -> None:
    run("import", "--example")
    run("tag", "1", "mine")
    assert f"{tmp_path / 'ledger.db'}" in run("backups").err


def test_a_table_in_units_of_the_flyer_imports_as_the_same_flights(run: Run, tmp_path: Path) -> None:
    run("add", "--rocket", "Lark", "--motor", "C6-5", "--dry-mass", "11.4oz", "--apogee", "923ft", "--wind", "8mph")
    run("import", "--example")
    table = tmp_path / "flights.csv"
    run("export", table, "--units", "us")
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    (row,) = [one for one in rows if one["rocket"] == "Lark"]
    assert (row["dry_mass_oz"], row["apogee_ft"], row["wind_mph"]) == ("11.4", "923", "8")
    assert {"diameter_in", "temperature_f", "pressure_inhg", "top_speed_mph", "peak_accel_g"} <= set(row)
    again = run("import", table, "--json").document
    assert (again["imported"], again["duplicates"], again["rejected"]) == (0, 13, [])
    assert "expected a table" in run("export", "--units", "US", "--format", "json", status=2).err
    assert "expected one of SI, US, mixed" in run("export", "--units", "imperial", status=2).err

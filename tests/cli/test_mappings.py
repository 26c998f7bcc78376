"""Columns of any table of flights are named once with `--map`, remembered, listed, changed and forgotten."""

import json
from pathlib import Path

import pytest

from tests.commands import Run

TABLE = """No,Model,Propulsion,Reached (feet),Pad weight [lb],When
1,Astra,F24-4W,812,0.95,2025-05-03
2,Astra,F24-4W,790,0.96,2025-05-03
"""
MAP = ("flight_id=No", "rocket=Model", "motor=Propulsion", "apogee=Reached (feet) [ft]", "date_time=When")


def options(*columns: str) -> list[str]:
    return [part for column in columns for part in ("--map", column)]


def flights(run: Run) -> list[dict[str, object]]:
    return json.loads(run("flights", "--json")[1])["flights"]  # type: ignore[no-any-return]


def test_a_table_of_flights_under_any_names_is_read_and_remembered(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "club.csv"
    table.write_text(TABLE)
    run("import", table, status=1)
    run("import", table, *options(*MAP, "liftoff_mass=Pad weight [lb]"))
    first, second = flights(run)
    assert (first["flight_id"], first["rocket"], first["motor"]) == ("1", "Astra", "F24-4W")
    assert first["apogee_m"] == pytest.approx(812 * 0.3048, abs=0.1)
    assert 300 < float(str(first["dry_mass_g"])) < 0.95 * 453.6 < float(str(second["dry_mass_g"])) + 150
    again = tmp_path / "next.csv"
    again.write_text(TABLE.replace("\n1,", "\n3,").replace("\n2,", "\n4,"))
    run("import", again)
    assert len(flights(run)) == 4


def test_mappings_are_listed_changed_and_forgotten(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "club.csv"
    table.write_text(TABLE)
    run("import", table, "--dry-run", *options(*MAP))
    assert json.loads(run("mappings", "--json")[1]) == {"mappings": []}
    run("import", table, *options(*MAP))
    (one,) = json.loads(run("mappings", "--json")[1])["mappings"]
    assert (one["of"], one["number"], one["map"]["apogee"]) == ("flights", 1, "Reached (feet) [ft]")
    run("mappings", "--edit", "1", *options("rocket=Model", "apogee=Reached (feet) [m]"))
    (one,) = json.loads(run("mappings", "--json")[1])["mappings"]
    assert one["map"] == {"rocket": "Model", "apogee": "Reached (feet) [m]"}
    refused = run("mappings", "--edit", "1", *options("rocket=Model", "apogee=Height"), status=1).err
    assert "Height" in refused
    assert "Reached (feet)" in refused
    assert json.loads(run("mappings", "--json")[1])["mappings"] == [one]
    run("mappings", "--forget", "2", status=1)
    run("mappings", "--forget", "1")
    assert "No saved mappings" in run("mappings")[1]


def test_samples_and_flights_are_not_mapped_together(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "club.csv"
    table.write_text(TABLE)
    error = run("import", table, *options("altitude=Reached (feet)", "rocket=Model"), status=1).err
    assert "found both" in error


def test_the_motors_mass_is_subtracted_from_a_lift_off_mass(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "lift.csv"
    table.write_text("flight_id,rocket,engine,liftoff_mass_g,motor_mass_g,apogee_m\n1,Astra,F24-4W,430,60,250\n")
    run("import", table)
    (flight,) = flights(run)
    assert flight["dry_mass_g"] == pytest.approx(370)


def test_one_column_has_one_meaning(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "club.csv"
    table.write_text(TABLE)
    refused = run("import", table, *options("motor=Propulsion", "rocket=Propulsion"), status=1).err
    assert "found the column 'Propulsion' for two meanings, expected one" in refused

"""`fieldkit loop --fleet`: the contract's keys, and options that exclude each other."""

from pathlib import Path

import pytest

from tests.commands import Run

CHECK_SHAPES = False

HEADER = "flight_id,date_time,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m"


def flights(rocket: str, motor: str, month: int, apogees: tuple[int, ...]) -> list[str]:
    return [
        f"{rocket}{month}.{day},2025-{month:02d}-{day:02d}T10:00,{rocket},A,322,66,{motor},{apogee}"
        for day, apogee in enumerate(apogees, start=1)
    ]


@pytest.fixture
def fleet(run: Run, tmp_path: Path) -> Run:
    """Two rockets whose F24 flights are a fifth lower since September."""
    rows = [HEADER]
    for rocket, less in (("Ash", 0), ("Birch", 5)):
        rows += flights(rocket, "E35-5W", 4, (170 - less, 168 - less))
        rows += flights(rocket, "F24-4W", 5, (250 - less, 246 - less, 253 - less))
        rows += flights(rocket, "F24-4W", 9, (192 - less, 197 - less, 189 - less))
        rows += flights(rocket, "E35-5W", 10, (171 - less, 166 - less))
    table = tmp_path / "flights.csv"
    table.write_text("\n".join(rows), "utf-8")
    run("import", table)
    return run


def test_a_weaker_motor_is_reported_with_its_rockets_and_the_errors_before_and_after(fleet: Run) -> None:
    document = fleet("loop", "--fleet", "--json").document
    first = document["findings"][0]
    assert (first["level"], first["effect"], first["from_date"]) == ("lot", "motor_thrust", "2025-09-01")
    assert first["rockets"] == ["Ash", "Birch"]
    assert len(first["flights"]) == 6
    assert first["probability"] > 0.8
    assert first["after"]["mae_m"] < first["before"]["mae_m"]
    assert {"name", "mae_m", "crps_m"} <= document["rivals"][0].keys()
    text = fleet("loop", "--fleet").out
    assert "AeroTech F24W since 2025-09-01" in text
    assert "less thrust and impulse than expected" in text


def test_the_fleet_and_one_rocket_exclude_each_other(fleet: Run) -> None:
    refused = fleet("loop", "--fleet", "--rocket", "Ash", status=1)
    assert "--rocket: found together with --fleet" in refused.err

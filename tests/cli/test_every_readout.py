"""Flights with every readout that the ledger has a column for, in every command that shows or uses flights."""

import csv
from collections.abc import Sequence
from pathlib import Path

import pytest

from fieldkit.flight import LOG_FIGURES
from tests.commands import Run

CHECK_SHAPES = False
READINGS = {
    "apogee_m": 250,
    "top_speed_mps": 68,
    "burn_time_s": 1.5,
    "peak_accel_g": 9,
    "avg_accel_g": 4.6,
    "coast_to_apogee_s": 5.6,
    "apogee_to_eject_s": 0.4,
    "eject_altitude_m": 248,
    "descent_speed_mps": 5.2,
    "duration_s": 55,
    "coast_drag_pkm": 2.7,
    "burn_impulse_mps": 84,
    "drogue_speed_mps": 14,
    "main_altitude_m": 120,
}


@pytest.fixture
def filled(run: Run, tmp_path: Path) -> Run:
    """Runs a command line on a ledger of five flights with every readout."""
    flights = [
        {
            "flight_id": f"{number}",
            "date_time": f"2025-05-0{number}T10:00",
            "rocket": "Astra",
            "config": "A",
            "dry_mass_g": 322,
            "diameter_mm": 66,
            "motor": "F24-4W",
            **{name: round(value * (0.97 + 0.01 * number), 3) for name, value in READINGS.items()},
        }
        for number in range(1, 6)
    ]
    with (tmp_path / "flights.csv").open("w", newline="") as file:
        out = csv.DictWriter(file, flights[0])
        out.writeheader()
        out.writerows(flights)
    run("import", tmp_path / "flights.csv")
    return run


def test_the_flights_have_every_readout() -> None:
    assert set(READINGS) == {column.header for column in LOG_FIGURES}


@pytest.mark.parametrize(
    "command",
    [
        ("flights",),
        ("show", "2"),
        ("infer",),
        ("predict", "--motor", "F24-4W"),
        ("loop", "--dry-run"),
        ("loop", "--dry-run", "--details"),
        ("loop", "--dry-run", "--quick"),
        ("loop", "--dry-run", "--report", "REPORT.html"),
        ("score",),
        ("compare", "1", "2"),
        ("contest", "--target", "250m"),
        ("delay", "--motor", "F24-4W"),
        ("ballast", "--motor", "F24-4W", "--target", "240m"),
        ("landing", "--motor", "F24-4W"),
        ("motors", "--fit", "Astra"),
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("form", [(), ("--json",)], ids=["text", "json"])
def test_every_command_takes_every_readout(
    filled: Run, command: Sequence[str], form: Sequence[str], tmp_path: Path
) -> None:
    filled(*(word.replace("REPORT", str(tmp_path / "report")) for word in command), *form)


@pytest.mark.parametrize(
    "command", [("report", "2", "--out", "REPORT.html"), ("export",), ("export", "--format", "json")], ids=" ".join
)
def test_every_readout_is_written(filled: Run, command: Sequence[str], tmp_path: Path) -> None:
    filled(*(word.replace("REPORT", str(tmp_path / "report")) for word in command))


def test_the_table_of_fingerprints_has_the_readouts_from_logs(filled: Run) -> None:
    printed = filled("loop", "--dry-run", "--details").out
    assert "coast dra" in printed
    assert "burn impu" in printed

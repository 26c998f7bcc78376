"""A table of very many flights is imported in bounded memory."""

import tracemalloc
from pathlib import Path

import pytest

from fieldkit.cli.session import known_motors
from fieldkit.ledger import Ledger
from fieldkit.services.imports import gather, take_in

COUNT = 2_000
"""Number of flights of the table. [1]"""
MOST_FOR_A_FLIGHT = 3_400
"""The memory that a flight may take: 340 MB for 100,000, beside 60 MB of modules. [byte]"""


def imported(folder: Path, count: int) -> int:
    """The peak of the memory that Python takes for the import of a table into a new ledger. [byte]"""
    file, motors = folder / f"{count}.csv", known_motors()
    rows = (f"{n},Rocket {n // 20},F24-4W,2020-01-01T10:{n % 60:02},320,66,{240 + n % 20}\n" for n in range(count))
    file.write_text("flight_id,rocket,motor,date_time,dry_mass_g,diameter_mm,apogee_m\n" + "".join(rows))
    with Ledger.open(folder / f"{count}.db") as ledger:
        tracemalloc.start()
        try:
            take_in(ledger, gather([file], lambda name: None), motors=motors)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
            assert len(ledger.flights()) == count


@pytest.mark.thorough
def test_the_memory_for_a_flight_of_a_table_is_bounded(tmp_path: Path) -> None:
    imported(tmp_path, 20)  # the modules and the motors are in memory from here on
    assert imported(tmp_path, COUNT) < COUNT * MOST_FOR_A_FLIGHT

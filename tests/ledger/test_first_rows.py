"""The first rows of the app, read without SQLAlchemy, are those that the ledger lists."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from datetime import datetime
from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.ledger.first_rows import first_rows
from fieldkit.services.launch_day import latest_flights
from tests.pressing import season

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
LISTED = ("flight_id", "rocket", "config", "motor", "apogee", "date_time", "log")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    season(tmp_path / "odd name #.db")
    return tmp_path / "odd name #.db"


def test_the_first_rows_are_the_latest_flights_of_the_ledger(file: Path) -> None:
    with Ledger.open(file) as ledger:
        wanted = latest_flights(ledger, ledger.flights())
    found = first_rows(file, 5)
    assert [id for id, _ in found] == [one.id for one in wanted[:5]] == ["12", "11", "10", "9", "8"]
    for (_, flight), one in zip(found, wanted, strict=False):
        assert all(getattr(flight, name) == getattr(one.flight, name) for name in LISTED)


@pytest.mark.parametrize(
    "other",
    [
        Flight("13", "Astra", apogee=100.0),
        Flight("12", "Bee", date_time=datetime(2026, 5, 1)),
        Flight("a/b", "Bee", date_time=datetime(2026, 5, 1)),
    ],
    ids=["without a date", "with an id of another rocket's flight", "with a slash in its id"],
)
def test_flights_whose_order_or_id_is_not_simple_are_left_to_the_ledger(file: Path, other: Flight) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([other])
    assert first_rows(file, 5) == []


@pytest.mark.parametrize("value", ["x", "9e999", "1e999", b"\xff"])
def test_a_damaged_row_is_left_to_the_ledger(file: Path, value: object) -> None:
    with closing(sqlite3.connect(file)) as raw:
        raw.execute("UPDATE flights SET apogee = ? WHERE flight_id = '12'", (value,))
        raw.commit()
    assert first_rows(file, 5) == []


def test_a_missing_ledger_another_file_or_a_server_has_no_first_rows(tmp_path: Path) -> None:
    (tmp_path / "text.db").write_text("not a database\n" * 100)
    for where in (tmp_path / "none.db", tmp_path / "text.db", tmp_path, "postgresql://nowhere/fieldkit"):
        assert first_rows(where, 5) == []
    assert not (tmp_path / "none.db").exists()


def test_sqlalchemy_is_not_imported_for_them(file: Path) -> None:
    code = (
        "import sys, fieldkit.presentation.home_text; from fieldkit.services.listed_flights import listed_at_once;"
        f"assert listed_at_once({str(file)!r}); assert 'sqlalchemy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)

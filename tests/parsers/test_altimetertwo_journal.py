"""The journal of AltimeterTwo readouts, tested with one that a flyer published."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fieldkit.importing import ImportedFile
from fieldkit.importing.read import read, read_together
from fieldkit.importing.recognize import claims
from tests.samples import any_motor

LOGS = Path(__file__).parents[3] / "shared" / "logs"
real = pytest.mark.skipif(not LOGS.is_dir(), reason="the published logs are not beside the checkout")
HEADER = (
    "LaunchID,RocketID,LaunchNumber,Date,Motors,DelayNote,Altitude,TopSpeed,BurnTime,PeakAcceleration,"
    "AverageAcceleration,CoastToApogeeTime,ApogeeToEjectionTime,EjectionAltitude,DescentSpeed,Duration,Note\n"
)


def journal(*rows: str) -> ImportedFile:
    return read((HEADER + "".join(f"{row}\n" for row in rows)).encode("cp1252"), "j.csv", any_motor)


def test_readouts_are_converted_to_si() -> None:
    (flight,) = journal("7,1,2,2014-05-03,C6-5,,640.000,140.000,1.8,9.8,3.5,4.4,-.100,628,9,52.1,").flights
    assert (flight.apogee, flight.top_speed) == pytest.approx((195.072, 62.5856))
    assert (flight.apogee_to_eject, flight.burn_time) == pytest.approx((-0.1, 1.8))
    assert flight.peak_accel == pytest.approx(9.8 * 9.80665)


@pytest.mark.parametrize("change", [str.upper, str.lower, str.title])
def test_the_case_of_the_header_does_not_matter(change: Callable[[str], str]) -> None:
    row = "7,1,2,2014-05-03,C6-5,,640.000,140.000,1.8,9.8,3.5,4.4,-.100,628,9,52.1,\n"
    written, changed = (read((header + row).encode(), "j.csv", any_motor) for header in (HEADER, change(HEADER)))
    assert changed.format == "altimetertwo_journal"
    assert changed.flights == written.flights


def test_an_empty_cell_is_not_recorded_and_zero_is_zero() -> None:
    (flight,) = journal("7,1,2,2014-05-03,C6-5,,640,,,,,,.000,,,,").flights
    assert flight.readouts() == pytest.approx({"apogee": 195.072, "apogee_to_eject": 0.0})


def test_the_note_on_the_delay_is_kept_and_not_read_as_a_delay() -> None:
    (flight,) = journal("7,1,2,2014-05-03,C6-5,2,640,,,,,,,,,,").flights
    assert flight.delay is None
    assert flight.extra["DelayNote"] == "2"


@pytest.mark.parametrize(
    ("motors", "motor", "tags"),
    [
        ("C6-5", "C6-5", ()),
        ('"4 C6-3, D12-3"', "4 C6-3, D12-3", ("cluster",)),
        ("D12-0 ½ A8-5", "D12-0 / A8-5", ("staged",)),
        ("D12-0 ? A8-5", "D12-0 / A8-5", ("staged",)),
        ("½A3-2", "½A3-2", ()),
        ("3 B6-4", "3 B6-4", ("cluster",)),
        ('"3 B6-4, C6-5"', "3 B6-4, C6-5", ("cluster",)),
        ('"2 ½A3-2T, A8-3"', "2 ½A3-2T, A8-3", ("cluster",)),
        ("B6-0 ? ½A3-2T", "B6-0 / ½A3-2T", ("staged",)),
        ('"2 A3-4T, B6-0 ½ A8-3"', "2 A3-4T, B6-0 / A8-3", ("staged", "cluster")),
    ],
)
def test_several_motors_are_tagged(motors: str, motor: str, tags: tuple[str, ...]) -> None:
    (flight,) = journal(f"7,1,2,2014-05-03,{motors},,640,,,,,,,,,,").flights
    assert (flight.motor, flight.tags) == (motor, tags)


def test_a_row_shifted_by_a_column_is_not_used_in_the_fit() -> None:
    (flight,) = journal("7,2,3,2014-06-21,D12-5,,,129,.5,3.1,13.1,18.0,,,,20.1,").flights
    assert flight.tags == ("altimeter_fault",)


def test_a_note_may_hold_commas_without_quotes() -> None:
    (flight,) = journal("7,2,3,2014-06-21,D12-5,,640,,,,,,,,,,Chute tangled, broke a fin, repaired").flights
    assert flight.notes == "Chute tangled, broke a fin, repaired"


@pytest.mark.parametrize(
    ("row", "column"),
    [
        ("7,1,2,2014-05-03,C6-5,,6o4,,,,,,,,,,", "Altitude"),
        ('7,1,2,2014-05-03,C6-5,,"1,148",,,,,,,,,,', "Altitude"),
        ("7,1,2,3 May,C6-5,,640,,,,,,,,,,", "Date"),
        ("7,1,2,2014-05-03,ZZ99-1,,640,,,,,,,,,,", "Motors"),
        ("7,1,2,2014-05-03,C6-5,,-640,,,,,,,,,,", "Altitude"),
        ("7,1,2,2014-05-03,C6-5,,640,1", None),
    ],
)
def test_the_error_of_a_bad_row_names_the_journals_own_column(row: str, column: str | None) -> None:
    got = journal(row, "8,1,2,2014-05-03,C6-5,,640,,,,,,,,,,")
    assert [(r.row, r.column) for r in got.rejected] == [(2, column)]
    assert len(got.flights) == 1


@real
def test_the_published_journal_is_read_completely() -> None:
    files = [(path.name, path.read_bytes()) for path in sorted(LOGS.glob("altimetertwo__*.csv"))]
    launches, rockets = read_together(files, any_motor)
    assert len(launches.flights) == 94
    assert not launches.rejected
    assert not rockets.rejected
    assert sum("left out: 242" in note for note in launches.notes) == 1
    assert [flight.flight_id for flight in launches.flights if "altimeter_fault" in flight.tags] == ["289"]
    assert all(flight.dry_mass for flight in launches.flights)


@real
def test_no_other_published_log_is_mistaken_for_a_table_of_flights() -> None:
    for path in filter(Path.is_file, LOGS.iterdir()):
        if not path.name.startswith("altimetertwo__"):
            assert not {"flight_table", "altimetertwo_journal"} & set(claims(path.read_bytes())), path.name

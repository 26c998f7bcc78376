"""Flights and samples in the shapes that clubs, apps and loggers give them, each with a known value."""

import numpy as np
import pytest

from fieldkit.importing.read import read
from fieldkit.importing.tables.headings import channel, heading
from fieldkit.motors.names import parse
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure
from tests.parsers.test_tables_as_people_make_them import APOGEE, FELT, PUSH, SEEN, TIME, apogee, opened, table, text
from tests.samples import any_motor

NET = np.where(SEEN.argmax() > np.arange(TIME.size), FELT - 1, 0.0) * GRAVITY


def apogees(log: str, name: str = "season.csv") -> list[float | None]:
    """The apogees in a table of flights. [m]"""
    return [flight.apogee for flight in read(log.encode(), name, any_motor, None, []).flights]


@pytest.mark.parametrize(
    "log",
    [
        "Flight,,Rocket,,Result,\nNo,Date,Name,Motor,Apogee [m],Duration [s]\n1,2026-03-07,Kite,D12-5,187,38\n",
        "Rocket,Motor,Apogee,Duration\n,,m,s\nKite,D12-5,187,38\n",
        "Flight,1\nMotor,D12-5\nMass (g),410\nApogee (m),187\n".replace("\n", ",\n"),
        "Flight,1,2\nMotor,D12-5,\nDate,2026-03-07,\nApogee (m),187,\n",
        "# Season\n\n| # | Motor | Apogee (m) |\n|--:|:------|-----------:|\n| 1 | D12-5 | 187 |\n\nWords | of mine\n",
        "Timestamp,What rocket did you fly?,Which motor did you use?,How high did it go? (m)\n,Kite,D12-5,187\n",
        "Flt\tMtr\tAlt(m)\n1\tD12-5\t187\n",
        "Rocket,Motor,Alt 1 (m),Alt 2 (m)\nKite,D12-5,187,190\n",
        "Subject: flight\n\nApogee: 187 m\nTop Speed: 60.5 m/s\nPeak Acceleration: 12.1 Gs\nDuration: 38.0 s\n",
        "Max altitude: 187 m\nMax velocity: 60.5 m/s\nFlight duration: 38.0 sec\nBattery: 8.9 V\n",
        "Raket;Motor;Hoogte (m);Vluchttijd (s)\nVlieger;C6-5;187,0;38\n",
        "Rocket,Motor (e.g. C6-5),Peak altitude from altimeter (m)\nKite,D12-5,187\n",
    ],
    ids=[
        "groups",
        "units",
        "column",
        "columns",
        "Markdown",
        "questions",
        "abbreviations",
        "altimeters",
        "mail",
        "page",
        "Dutch",
        "examples",
    ],
)
def test_the_apogee_of_a_flight_is_found_in_every_shape(log: str) -> None:
    assert apogees(log)[0] == pytest.approx(187)


def test_words_under_an_empty_header_are_a_note() -> None:
    (flight,) = read(
        b"Rocket,Motor,Apogee (m),\nKite,D12-5,187,landed in a tree\n", "a.csv", any_motor, None, []
    ).flights
    assert flight.notes == "landed in a tree"


def test_a_unit_under_an_empty_header_is_refused() -> None:
    opened = read(b"Rocket,Motor,Apogee (m),\nKite,D12-5,187,ft\n", "a.csv", any_motor, None, [])
    assert not opened.flights
    assert "under an empty header" in str(opened.rejected[0])


@pytest.mark.parametrize("row", ["Subtotal April,,2 flights,371", "Total,,2,371", "Best,,,187"])
def test_a_row_that_counts_the_motors_is_not_a_flight(row: str) -> None:
    opened = read(
        f"Rocket,Date,Motor,Apogee (m)\nKite,2026-03-07,D12-5,184\n{row}\nBest,2026-03-08,D12-5,187\n".encode(),
        "a.csv",
        any_motor,
        None,
        [],
    )
    assert [flight.rocket for flight in opened.flights] == ["Kite", "Best"]
    assert not opened.rejected


def test_a_duration_is_read_in_minutes_and_seconds() -> None:
    log = b"Rocket,Motor,Apogee (m),Time Aloft\nKite,D12-5,187,0:43\nKite,D12-5,187,1:02.5\n"
    assert [flight.duration for flight in read(log, "a.csv", any_motor, None, []).flights] == [43, 62.5]


@pytest.mark.parametrize(("name", "maker"), [("Quest Q-Jet D20-8W", "Quest"), ("Cesaroni Pro29 G88-11", "Cesaroni")])
def test_a_maker_may_be_named_beside_its_line(name: str, maker: str) -> None:
    assert (parse(name).maker, parse(name).core) == (maker, name.split()[-1].partition("-")[0])


@pytest.mark.parametrize("name", ["Altitude Time (sec)", "height_time_ms", "accel time (s)"])
def test_the_clock_of_a_sensor_is_a_clock(name: str) -> None:
    assert channel(heading(name)) == "time"


def test_two_sensors_with_their_own_clocks_are_one_flight() -> None:
    rows = table(
        "Altitude Time (s),Altitude (m),,Acceleration Time (s),Accel (g)", TIME, SEEN, [""] * TIME.size, TIME, FELT
    )
    (flight,) = opened(rows).flights
    assert flight.burn_time == pytest.approx(1.6, abs=0.1)
    assert flight.apogee == pytest.approx(APOGEE, abs=1)


@pytest.mark.parametrize(
    ("names", "form"),
    [("ALT FT   SECONDS", "{0} {1}"), ("Mission time,Height (ft)", "T{1:+},{0}")],
    ids=["words", "T-3"],
)
def test_names_of_several_words_and_times_before_a_launch_are_read(names: str, form: str) -> None:
    rows = [form.format(round(height / 0.3048, 1), round(time, 2)) for time, height in zip(TIME, SEEN, strict=True)]
    assert apogee("\n".join([names, *rows, ""]).encode()) == pytest.approx(APOGEE, abs=1)


def test_a_pressure_named_by_its_unit_is_read_whatever_its_first_value() -> None:
    pressure = text(height_pressure(SEEN + 200), "{:.0f}")
    assert apogee(table("ms;Pa", TIME * 1000, ["0", *pressure[1:]], separator=";")) == pytest.approx(APOGEE, abs=1)


def test_rows_that_a_program_printed_as_tuples_are_read() -> None:
    rows = table("time_s,altitude_m", TIME, SEEN).decode().splitlines()
    assert apogee("\n".join(f"({row})" for row in rows).encode()) == pytest.approx(APOGEE, abs=1)


def _peak(log: bytes) -> float:
    """The peak acceleration of the one flight in a log. [g]"""
    (flight,) = opened(log).flights
    assert flight.peak_accel is not None
    assert flight.source["peak_accel"] == "accel"
    return flight.peak_accel / GRAVITY


NAMES = {
    "counts": ("ax_raw,ay_raw,az_raw", (0, FELT * 2048, 0), "{:.0f}"),
    "counts by number": ("acc[0],acc[1],acc[2]", (0, 0, FELT * 4096), "{:.0f}"),
    "high range": ("LowG_X,LowG_Y,LowG_Z,HighG_X,HighG_Y,HighG_Z", (FELT.clip(-4, 4), 0, 0, FELT, 0, 0), "{:.3f}"),
    "net": ("acceleration", (NET,), "{:.3f}"),
    "net downward": ("accel_d", (-NET,), "{:.3f}"),
}


@pytest.mark.parametrize("name", NAMES)
def test_an_acceleration_without_a_unit_is_used(name: str) -> None:
    names, columns, form = NAMES[name]
    cells = [text(column + 0 * TIME, form) for column in columns]
    assert _peak(table(f"time_s,altitude_m,{names}", TIME, SEEN, *cells)) == pytest.approx(PUSH / GRAVITY, rel=0.05)


def test_a_parser_does_not_claim_a_table_whose_accelerations_it_would_not_read() -> None:
    rows = table("time(ms),altitude(m),AccelX(g),AccelY(g),AccelZ(g)", TIME * 1000, SEEN, FELT, 0 * TIME, 0 * TIME)
    assert _peak(rows) == pytest.approx(PUSH / GRAVITY, rel=0.05)

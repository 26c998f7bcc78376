"""Loggers whose files name no units: RRC3, whose pressures prove them, and Eggtimer, whose acceleration near apogee
may."""

from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Parsed, Reading
from fieldkit.importing.recognize import open_log, parsers
from fieldkit.physics.standard_atmosphere import height_pressure
from fieldkit.units import FOOT
from tests.parsers.real_logs import damage, reading, real
from tools.samples.one_parachute import flight

JUNO = "rrc3__juno3_cots_altimeter.csv"
HEADER = "Time,Altitude,Pressure,Velocity,Temperature,Events,Voltages"


def rrc3(unit: float, *, top: float = 200.0, header: str = HEADER, tail: str = "") -> bytes:
    """A climb of ten seconds to `top` [m] from a pad at 500 m, with altitudes in a unit [m]."""
    time = np.arange(0, 10, 0.05)
    height = np.linspace(0, top, len(time))
    mbar = height_pressure(500 + height) / 100
    rows = [f"{t:.2f},{h / unit:.5f},{p:.2f},1,20, -,9.1" for t, h, p in zip(time, height, mbar, strict=True)]
    return "\n".join([header, *rows, tail]).encode()


def found(parser: str, log: bytes) -> tuple[Reading, list[Parsed]]:
    flight, *rest = parsers()[parser].read(log)
    assert isinstance(flight, Reading)
    return flight, rest


@real
def test_pressures_prove_that_a_real_rrc3_log_is_in_meters() -> None:
    flight = reading(JUNO)
    (series,) = flight.clocks
    assert series.altitude is not None
    assert (len(series.time), series.time[0], series.time[-1]) == (609, 0, 30.4)
    assert series.altitude.max() == pytest.approx(3213.375)  # the flight card says 3213 m
    assert series.temperature is not None
    assert np.nanmax(series.temperature) == pytest.approx(273.15 + 32)
    assert flight.events == {"drogue": 30.45}


@real
def test_only_the_garbage_in_the_last_rows_of_a_real_rrc3_log_is_lost() -> None:
    assert damage(JUNO) == [
        "row 611, pressure: found 191.25 after 580.10 mbar, expected no such jump",
        "row 612, pressure: found 1158.70 after 191.25 mbar, expected no such jump",
    ]


@pytest.mark.parametrize(("unit", "temperature"), [(1.0, 293.15), (FOOT, 266.4833)])
def test_pressure_distinguishes_feet_from_meters(unit: float, temperature: float) -> None:
    flight, _ = found("rrc3", rrc3(unit))
    (series,) = flight.clocks
    assert series.altitude is not None
    assert series.altitude.max() == pytest.approx(200, rel=1e-3)
    assert series.speed == pytest.approx(np.full(200, unit))
    assert series.temperature == pytest.approx(np.full(200, temperature))


@pytest.mark.parametrize(("unit", "top"), [(0.9144, 200.0), (FOOT, 8.0)])
def test_an_altitude_whose_unit_pressure_does_not_determine_is_left_out(unit: float, top: float) -> None:
    flight, (note, *_) = found("rrc3", rrc3(unit, top=top))
    assert flight.clocks[0].altitude is None
    assert flight.clocks[0].speed is None
    assert flight.clocks[0].pressure is not None
    assert isinstance(note, Note)
    assert "altitude left out" in note.text


def test_pressures_that_are_not_in_mbar_are_refused() -> None:
    log = HEADER + "\n" + "".join(f"{t / 20:.2f},{t},101325,1,20, -,9.1\n" for t in range(100))
    with pytest.raises(DamagedLog, match="not in mbar"):
        parsers()["rrc3"].read(log.encode())


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "stray mark"])
def test_an_rrc3_log_reads_the_same_in_any_encoding(encoding: str) -> None:
    log = rrc3(FOOT)
    encoded = (
        b"\xef\xbb\xbf" + log.decode().encode("utf-16") if encoding == "stray mark" else log.decode().encode(encoding)
    )
    assert parsers()["rrc3"].recognises(encoded)
    flight, _ = found("rrc3", encoded)
    assert len(flight.clocks[0].time) == 200


def eggtimer(unit: float, *, eject: float = 0.0, header: str = "T,Alt,Veloc,LDA,N-O,Drogue,Main") -> bytes:
    """A flight with drag that coasts from 80 m/s; `eject` [s] after the top the parachute opens."""
    time, height, speed, rows = 0.0, 0.0, 80.0, []
    while height >= 0:
        rows.append((time, height))
        early = speed < -eject * 9.8
        speed += 0.01 * ((-6 - speed) / 0.3 if early else -9.81 - 0.002 * speed * abs(speed))
        height += 0.01 * speed
        time += 0.01
    lines = [f"{t * 1000:.0f},{h / unit:.0f},0,0,0,0,0" for t, h in rows[::5]]
    return "\n".join([header, *lines, ""]).encode()


@pytest.mark.parametrize("unit", [1.0, FOOT])
@pytest.mark.parametrize("eject", [0.0, 1.5])
def test_the_acceleration_near_apogee_distinguishes_feet_from_meters(unit: float, eject: float) -> None:
    flight, (note,) = found("eggtimer", eggtimer(unit, eject=eject))
    (series,) = flight.clocks
    assert series.altitude is not None
    assert series.altitude.max() == pytest.approx(208.7, abs=1)  # log(1 + 0.002 * 80**2 / 9.81) / 0.004
    assert series.time[1] == pytest.approx(0.05)
    assert isinstance(note, Note)
    assert note.text.endswith(f"taken in {'m' if unit == 1.0 else 'ft'}, as the deceleration just before apogee shows")


def test_a_note_states_how_the_unit_was_determined_where_the_top_does_not_show_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(parsers()["eggtimer"].read.__globals__, "unit_of_fall", lambda *_: "")  # type: ignore[attr-defined]
    log = Path(__file__).parents[2] / "sample_logs" / "eggtimer__trs_console_in_feet.txt"
    _, (note,) = found("eggtimer", log.read_bytes())
    assert isinstance(note, Note)
    assert note.text.endswith("taken in ft, by free fall")


def test_a_flight_cut_short_by_its_parachute_is_refused_and_a_header_with_a_unit_fixes_it() -> None:
    log = eggtimer(FOOT, eject=-2.5)
    with pytest.raises(DamagedLog, match="expected a header such as Alt_ft or Alt_m"):
        parsers()["eggtimer"].read(log)
    flight, rest = found("eggtimer", log.replace(b"T,Alt,", b"T,Alt_ft,"))
    assert flight.clocks[0].altitude is not None
    assert rest == []


@pytest.mark.parametrize("unit", [1.0, FOOT])
def test_the_coast_of_a_log_that_ends_while_climbing_determines_the_unit_once_it_is_long_enough(unit: float) -> None:
    lines = eggtimer(unit).split(b"\n")
    (short, long) = (b"\n".join(lines[:rows]) + b"\n" for rows in (30, 80))
    reading = next(item for item in parsers()["eggtimer"].read(long) if isinstance(item, Reading))
    assert reading.clocks[0].altitude is not None
    assert reading.clocks[0].altitude.max() == pytest.approx(185, abs=1)
    with pytest.raises(DamagedLog, match="whose unit cannot be determined"):
        parsers()["eggtimer"].read(short)


def test_several_flights_in_one_text_stay_separate_with_their_summaries() -> None:
    log = b"MON>A\r\nApogee: 751\r\n" + eggtimer(FOOT) + b"\r\nApogee: 752\r\n" + eggtimer(FOOT)
    first, second = (item for item in parsers()["eggtimer"].read(log) if isinstance(item, Reading))
    assert first.stated == {"apogee": pytest.approx(751 * FOOT)}
    assert second.stated == {"apogee": pytest.approx(752 * FOOT)}


def test_a_damaged_row_of_a_second_table_is_named_by_its_row_in_the_file() -> None:
    first, second = eggtimer(FOOT), eggtimer(FOOT).split(b"\n")
    second[3] = b"150,x7,0,0,0,0,0"
    items = parsers()["eggtimer"].read(first + b"\n".join(second))
    (damaged,) = (item for item in items if isinstance(item, DamagedLog))
    assert damaged.row == first.count(b"\n") + 4


def proton(height: np.ndarray, unit: float, time: np.ndarray, felt: np.ndarray) -> bytes:
    """What a Proton prints: whole units of height, and the acceleration in g."""
    rows = [
        f"{t:.2f},{h / unit:.0f},{h / unit:.0f},0,0,{a:.2f},0,0,0,0" for t, h, a in zip(time, height, felt, strict=True)
    ]
    return "\n".join(["T,Alt,FAlt,Veloc,FVeloc,Accel,LDA,LowV,Apogee,N-O", *rows, ""]).encode()


@pytest.mark.parametrize("unit", [1.0, FOOT])
def test_a_noisy_climb_distinguishes_feet_from_meters_and_an_accelerometer_is_used(unit: float) -> None:
    made = flight()
    time = np.arange(-2, made.time[-1], 0.05)
    height = made.at(time, made.height) + np.random.default_rng(7).normal(0, 0.3, len(time))
    log = proton(height, unit, time + 2, made.at(time, made.felt) / 9.80665)
    got, _ = found("eggtimer", log)
    (series,) = got.clocks
    assert series.altitude is not None
    assert series.altitude.max() == pytest.approx(made.apogee, abs=2)
    assert series.felt is not None
    assert series.felt[0] == pytest.approx(9.8, abs=0.1)


def test_the_units_that_pressures_prove_are_reported() -> None:
    columns = open_log(rrc3(FOOT), "log.csv", None).recognition.columns
    assert [(one.name, one.unit) for one in columns][:4] == [
        ("Time", "s"),
        ("Altitude", "ft"),
        ("Pressure", "mbar"),
        ("Velocity", "ft/s"),
    ]

"""Blue Raven: its app's files, their summary, and the frames sent over USB."""

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Parsed, Reading
from fieldkit.importing.read import read, read_together
from fieldkit.importing.recognize import parsers
from fieldkit.units import FOOT, STANDARD_GRAVITY
from tests.parsers.real_logs import LOGS, reading, real
from tests.samples import SAMPLES, any_motor

LOW, SUMMARY = "blueraven_app_lr__SN0829_2024-05-11.csv", "blueraven_app_summary__SN0829_2024-05-11.csv"
BY_NAME = {sample.name: sample.read_bytes() for sample in SAMPLES}


def frame(seconds: str, rest: str = "Bo: 6800 48000", kind: str = "LOG_LOW") -> bytes:
    body = f"@ {kind} 99 2026 5 2 11:04:{seconds} 10 {rest}".encode()
    return body + f" CRC: {crc(body):04X}\r\n".encode()


def crc(data: bytes) -> int:
    """CRC-16/BUYPASS bit by bit."""
    value = 0
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = value << 1 ^ 0x8005 if value & 0x8000 else value << 1
        value &= 0xFFFF
    return value


def usb(log: bytes) -> list[Parsed]:
    return list(parsers()["blueraven_usb"].read(log))


@real
def test_the_low_rate_of_a_real_flight() -> None:
    flight = reading(LOW)
    (low,) = flight.clocks
    assert (low.time[0], low.time[-1], len(low.time)) == (-1.92, 111.76, 2843)
    assert low.altitude is not None
    assert low.inertial_altitude is not None
    assert low.altitude.max() / FOOT == pytest.approx(4035.3)
    assert low.time[low.altitude.argmax()] == 14.76
    assert low.altitude.min() / FOOT == pytest.approx(-14.1)
    assert low.inertial_altitude.max() / FOOT == pytest.approx(4226, abs=1)
    assert str(flight.stated["date_time"]) == "2024-05-11 14:09:46.522000"
    assert flight.events["liftoff"] == 0
    assert flight.events["apogee"] == 17.72


@real
def test_the_summary_of_a_real_flight_states_figures() -> None:
    flight = reading(SUMMARY)
    stated = {name: value for name, value in flight.stated.items() if isinstance(value, float)}
    assert stated == pytest.approx(
        {
            "apogee": 4034.98 * FOOT,
            "top_speed": 700.36 * FOOT,
            "site_elevation": 230.55 * FOOT,
            "burn_time": 1.4,
            "peak_accel": 24.1 * STANDARD_GRAVITY,
            "descent_speed": 23.5 * FOOT,
        }
    )
    assert flight.serial == "SN829"
    assert flight.events == {
        "burnout": 1.4,
        "drogue": 17.8,
        "third channel": 18.3,
        "main": 87.6,
        "fourth channel": 1.4,
        "landing": 111.86,
    }
    assert flight.extra["drogue descent rate"] == "-45.7 feet/sec"


@real
def test_the_files_of_one_real_flight_give_one_flight_in_either_order() -> None:
    files = [(name, (LOGS / name).read_bytes()) for name in (SUMMARY, LOW)]
    for order in (files, files[::-1]):
        imported_files = {imported.source: imported for imported in read_together(order, any_motor)}
        (flight,) = imported_files[LOW].flights
        assert float(flight.extra["stated_apogee_m"]) == pytest.approx(4034.98 * FOOT)
        assert flight.apogee == pytest.approx(4034.98 * FOOT, rel=0.005)
        assert imported_files[SUMMARY].flights == ()
        assert imported_files[SUMMARY].notes == (f"{SUMMARY}: belongs to the flight of {LOW}",)


def test_low_and_high_rate_and_summary_are_one_flight() -> None:
    names = [name for name in BY_NAME if name.startswith(("blueraven_app", "blueraven_summary"))]
    imported_files = read_together([(name, BY_NAME[name]) for name in names], any_motor)
    assert [len(imported.flights) for imported in imported_files] == [0, 1, 0]


def test_files_of_flights_minutes_apart_stay_separate() -> None:
    low = BY_NAME["blueraven_app__low_rate.csv"]
    summary = BY_NAME["blueraven_summary__what_the_app_shows.csv"].replace(b"11:04:05.250", b"11:34:05.250")
    imported_files = read_together([("low.csv", low), ("summary.csv", summary)], any_motor)
    assert [len(imported.flights) for imported in imported_files] == [1, 1]


def test_a_flight_that_is_twice_in_a_file_is_read_once() -> None:
    low = BY_NAME["blueraven_app__low_rate.csv"]
    header, rows = low.split(b"\n", 1)
    imported = read(header + b"\n" + rows + rows, "low.csv", any_motor)
    assert len(imported.flights) == 1
    assert any("repeats an earlier flight" in note for note in imported.notes)


def test_the_day_is_kept_if_a_spreadsheet_spoiled_the_time_of_day() -> None:
    low = BY_NAME["blueraven_app__low_rate.csv"].replace(b",11:04:", b",04:")
    (flight,) = (item for item in parsers()["blueraven_app"].read(low) if isinstance(item, Reading))
    assert str(flight.stated["date_time"]) == "2026-05-02 00:00:00"


def test_a_flag_that_is_set_when_the_log_begins_does_not_state_its_time() -> None:
    head, *rows = BY_NAME["blueraven_app__low_rate.csv"].decode().splitlines(keepends=True)
    late = "".join([head, *(row for row in rows if float(row.split(",")[4]) > 0.5)])
    (whole,), (cut,) = (parsers()["blueraven_app"].read(log.encode()) for log in (head + "".join(rows), late))
    assert isinstance(whole, Reading)
    assert isinstance(cut, Reading)
    assert whole.events.keys() - cut.events.keys() == {"liftoff"}


@pytest.mark.parametrize("scale", [1.0, STANDARD_GRAVITY, 1000.0])
def test_a_high_rate_acceleration_is_one_g_on_the_pad_in_any_unit(scale: float) -> None:
    rows = [
        f"2026,5,2,11:04:05.0,{t:.3f},0,0,0,0,{-scale * (1 if t < 0 else 9):.3f},0,0" for t in np.arange(-1, 1, 0.01)
    ]
    header = "Year,Month,Day,Time,Flight_Time_(s),Sync,Gyro_X,Gyro_Y,Gyro_Z,Accel_X,Accel_Y,Accel_Z"
    (flight,) = parsers()["blueraven_app"].read("\n".join([header, *rows, ""]).encode())
    assert isinstance(flight, Reading)
    (high,) = flight.clocks
    assert high.felt is not None
    assert high.felt[0] == pytest.approx(STANDARD_GRAVITY, rel=1e-3)
    assert high.felt[-1] == pytest.approx(9 * STANDARD_GRAVITY, rel=1e-3)


@pytest.mark.parametrize("scale", [1.0, STANDARD_GRAVITY, 1000.0])
@pytest.mark.parametrize("lands", [True, False])
def test_a_high_rate_acceleration_without_the_pad_is_one_g_after_landing(scale: float, lands: bool) -> None:
    """The nose is along the second axis, and the rocket lies on its side in the end."""
    rows = []
    for t in np.arange(0.02, 20 if lands else 12, 0.02):
        nose, side = (8.0, 0.0) if t < 2 else (-0.5, 0.1) if t < 8 else (0.6 * np.sin(9 * t), 0.7)
        nose, side = (0.1, 0.995) if t > 15 else (nose, side)
        rows.append(f"2026,5,2,11:04:05.0,{t:.3f},0,0,0,0,0,{scale * nose:.4f},{scale * side:.4f}")
    header = "Year,Month,Day,Time,Flight_Time_(s),Sync,Gyro_X,Gyro_Y,Gyro_Z,Accel_X,Accel_Y,Accel_Z"
    flight, *notes = parsers()["blueraven_app"].read("\n".join([header, *rows, ""]).encode())
    assert isinstance(flight, Reading)
    felt = flight.clocks[0].felt
    assert (felt is None) == bool(notes) == (not lands)
    if felt is not None:
        assert felt[:90] == pytest.approx(8 * STANDARD_GRAVITY, rel=1e-2)


def test_a_high_rate_acceleration_of_unknown_unit_is_left_out() -> None:
    rows = [f"2026,5,2,11:04:05.0,{t:.3f},0,0,0,0,{3.3:.3f},0,0" for t in np.arange(-1, 1, 0.01)]
    header = "Year,Month,Day,Time,Flight_Time_(s),Sync,Gyro_X,Gyro_Y,Gyro_Z,Accel_X,Accel_Y,Accel_Z"
    flight, note = parsers()["blueraven_app"].read("\n".join([header, *rows, ""]).encode())
    assert isinstance(flight, Reading)
    assert flight.clocks[0].felt is None
    assert isinstance(note, Note)


def test_a_damaged_line_of_a_summary_loses_only_its_figure() -> None:
    summary = BY_NAME["blueraven_summary__what_the_app_shows.csv"].replace(b"Max velocity,", b"Max velocity,fast ")
    flight, damage = parsers()["blueraven_summary"].read(summary)
    assert isinstance(flight, Reading)
    assert "apogee" in flight.stated
    assert "top_speed" not in flight.stated
    assert str(damage).startswith("row 5, Max velocity: found 'fast ")


def test_the_checksum_of_frames_is_the_published_one() -> None:
    assert crc(b"123456789") == 0xFEE8


def test_a_frame_is_converted_to_si() -> None:
    flight, *_ = usb(frame("05.250", "Bo: 6800 48000 V: 4110 Vel: 100 2 3 Pos: 9 9 9 ang: 455 0 0") + frame("05.270"))
    assert isinstance(flight, Reading)
    (low,) = flight.clocks
    assert low.time.tolist() == [0, 0.02]
    assert low.temperature == pytest.approx([293.15, 293.15])
    assert low.pressure == pytest.approx([97272, 97272])
    assert low.voltage == pytest.approx([4.11, np.nan], nan_ok=True)
    assert low.inertial_speed == pytest.approx([30.48, np.nan], nan_ok=True)
    assert low.tilt == pytest.approx([np.radians(45.5), np.nan], nan_ok=True)


def test_of_a_line_overprinted_by_the_next_the_next_is_read() -> None:
    whole = frame("05.250")
    (flight,) = usb(frame("05.210") + whole[:30] + b"0@ LOG_LOW   " + whole + frame("05.290"))
    assert isinstance(flight, Reading)
    assert flight.clocks[0].time.tolist() == [0, 0.04, 0.08]
    flight, note = usb(frame("05.210") + whole[:30] + b"0@ LOG_LOW   @ LOG_LO\r\n" + frame("05.290"))
    assert isinstance(flight, Reading)
    assert flight.clocks[0].time.tolist() == [0, 0.08]
    assert note == Note("has a frame with a bad checksum, left out; 1 such line in all", 2)


def test_only_the_frame_with_a_flipped_bit_is_lost() -> None:
    log = bytearray(frame("05.250") * 1 + frame("05.270") + frame("05.290"))
    log[len(frame("05.250")) + 50] ^= 1
    flight, note = usb(bytes(log))
    assert isinstance(flight, Reading)
    assert len(flight.clocks[0].time) == 2
    assert isinstance(note, Note)


def test_frames_are_read_with_any_line_ending() -> None:
    log = frame("05.250") + frame("05.270")
    for end in (b"\n", b"\r"):
        (flight,) = usb(log.replace(b"\r\n", end))
        assert isinstance(flight, Reading)
        assert len(flight.clocks[0].time) == 2


def test_a_line_that_is_not_a_frame_is_ignored() -> None:
    with pytest.raises(DamagedLog, match="no frame"):
        usb(b"@ LOG_LOW")


def test_a_long_gap_in_the_frames_separates_two_flights() -> None:
    body = b"@ LOG_LOW 99 2026 5 2 11:44:05.250 10 Bo: 6800 48000"
    second = body + f" CRC: {crc(body):04X}\r\n".encode()
    flights = usb(frame("05.250") + second)
    assert [len(flight.clocks[0].time) for flight in flights if isinstance(flight, Reading)] == [1, 1]


def test_only_damaged_frames_are_not_a_flight() -> None:
    with pytest.raises(DamagedLog, match="no frame with a good checksum"):
        usb(frame("05.250").replace(b"48000", b"48001"))

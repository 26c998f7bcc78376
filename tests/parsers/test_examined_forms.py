"""Logs of other recorders in forms that are easy to misread, each made here from a known flight.

They follow the notes on formats about real files; none is a copy of one.
"""

import numpy as np
import pytest

from fieldkit.analysis import measure, simulated
from fieldkit.errors import DamagedLog
from fieldkit.importing import Reading
from fieldkit.importing.read import read
from fieldkit.importing.recognize import claims, open_log, parsers
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT
from tests.samples import SAMPLES, any_motor, owner
from tools.samples.one_parachute import flight

MADE = flight()
SIMULATED = [sample for sample in SAMPLES if owner(sample) in ("openrocket", "rocksim", "rasaero", "rocketpy")]


def readings(log: bytes) -> list[Reading]:
    return [item for item in open_log(log, "log", None).found if isinstance(item, Reading)]


def ground_station(own_name: str, *, station_first: bool) -> bytes:
    """What a ground station logs: position and height of the tracker, and its own while it is carried around."""
    time = np.arange(-10.0, MADE.time[-1], 0.5)
    height = (MADE.pad + MADE.at(time, MADE.height)) / FOOT
    speed = MADE.at(time, MADE.speed) / FOOT
    own = (MADE.pad + 3 * np.sin(time / 9)) / FOOT
    groups = ["ALT,LAT,LON,VERTV,FIX", ",".join(own_name + one for one in ("ALT", "LAT", "LON", "VERTV"))]
    lines = ["TRACKER,DATE,TIME," + ",".join(groups[::-1] if station_first else groups)]
    for t, h, v, o in zip(time + 20, height, speed, own, strict=True):
        tracker, station = f"{h:.0f},47.1,8.4,{v:.0f},3", f"{o:.0f},47.0990,8.3990,{2300 * np.sin(t):.0f}"
        cells = [station, tracker] if station_first else [tracker, station]
        lines.append(f"FWGPS_9,2026-05-02,15:04:{t % 60:04.1f}," + ",".join(cells) if t < 60 else
                     f"FWGPS_9,2026-05-02,15:{4 + int(t // 60):02d}:{t % 60:04.1f}," + ",".join(cells))  # fmt: skip
    return "\n".join(lines).encode() + b"\n"


@pytest.mark.parametrize("station_first", [False, True])
@pytest.mark.parametrize("own_name", ["GS", "GS ", ""])
def test_a_ground_station_s_own_height_and_speed_are_not_the_rocket_s(own_name: str, station_first: bool) -> None:
    log = ground_station(own_name, station_first=station_first)
    assert claims(log)[0] == "featherweight_gps"
    (reading,) = readings(log)
    figures = measure(reading.clocks, reading.events).figures
    assert figures["apogee"].value == pytest.approx(MADE.apogee, abs=4)
    (series,) = reading.clocks
    assert series.gps_speed is not None
    assert np.nanmax(series.gps_speed) < 1.05 * MADE.speed.max()
    if "top_speed" in figures:
        assert figures["top_speed"].value < 1.3 * MADE.speed.max()


@pytest.mark.parametrize("title", ["MET Acc Vel iAlt pAlt", "# MET  Acc  Vel  iAlt  pAlt"])
def test_an_arts2_table_may_have_spaces_around_names_and_commas_between_numbers(title: str) -> None:
    time = np.arange(-1.0, MADE.time[-1], 0.02)
    height, speed, felt = (MADE.at(time, values) for values in (MADE.height, MADE.speed, MADE.felt))
    rows = zip(time + 1, felt / GRAVITY, speed / FOOT, height / FOOT, height / FOOT, strict=True)
    log = (title + "\n" + "".join(",".join(f"{cell:.3f}" for cell in row) + "\n" for row in rows)).encode()
    assert claims(log)[0] == "arts2"
    (reading,) = readings(log)
    assert measure(reading.clocks).figures["apogee"].value == pytest.approx(MADE.apogee, abs=1)


@pytest.mark.parametrize("name", ["IMU0", "0"])
def test_the_accelerometers_of_a_cats_may_have_names(name: str) -> None:
    time = np.arange(-0.7, MADE.time[-1], 0.02)
    felt = MADE.at(time, MADE.felt)
    rows = "".join(f"{t:.3f},{name},{f:.3f},0.02,0.03,0,0,0\n" for t, f in zip(time, felt, strict=True))
    log = ("ts,id,Ax,Ay,Az,Gx,Gy,Gz\n" + rows).encode()
    assert claims(log)[0] == "cats"
    (reading,) = readings(log)
    assert reading.part == "imu"
    total = next(series.felt_total for series in reading.clocks if series.felt_total is not None)
    np.testing.assert_allclose(total, np.hypot(felt, 0.036), atol=0.01)


def test_the_new_form_of_filtered_data_of_a_cats_is_read() -> None:
    time = np.arange(-0.7, MADE.time[-1], 0.01)
    height, net = MADE.at(time, MADE.height), MADE.at(time, MADE.felt) - GRAVITY
    rows = "".join(f"{t:.3f},{h:.2f},{a:.2f}\n" for t, h, a in zip(time, height, net, strict=True))
    log = ("ts,filtered_altitude_AGL,filtered_acceleration\n" + rows).encode()
    assert claims(log)[0] == "cats"
    (reading,) = readings(log)
    assert measure(reading.clocks).figures["apogee"].value == pytest.approx(MADE.apogee, abs=1)


def telemetry(height: np.ndarray) -> bytes:
    """What a ground station hears of a TeleMetrum 2, ten packets a second. [m]"""
    lines = []
    for tick, metres in enumerate(height.tolist()):
        packet = bytearray(32)
        packet[0:2], packet[2:4], packet[4] = (2417).to_bytes(2, "little"), (10 * tick).to_bytes(2, "little"), 10
        packet[5] = 2
        packet[8:12] = int(97_700 - 11.6 * metres).to_bytes(4, "little")
        packet[12:14] = (2150).to_bytes(2, "little")
        packet[18:20] = int(metres).to_bytes(2, "little", signed=True)
        frame = bytes([34]) + bytes(packet) + bytes([0x1E, 0xB0])
        lines.append(f"TELEM {(frame + bytes([(0x5A + sum(frame[1:])) % 256])).hex()}")
    return "\n".join(lines).encode() + b"\n"


def test_radio_packets_without_a_flight_are_not_a_slow_flight() -> None:
    rng = np.random.default_rng(3)
    still = telemetry(np.clip(rng.normal(1, 1, 900), -5, 5))
    assert parsers()["altos_telem"].recognises(still)
    imported = read(still, "pad.telem", any_motor)
    assert imported.flights == ()
    assert any("no flight" in one.error for one in imported.rejected)
    flown = telemetry(MADE.at(np.arange(-5, MADE.time[-1], 0.1), MADE.height))
    (only,) = read(flown, "flown.telem", any_motor).flights
    assert only.apogee == pytest.approx(MADE.apogee, rel=0.03)


@pytest.mark.parametrize("boost", [0.0, 0.05, 1.0])
def test_a_log_of_only_accelerations_is_no_flight_because_nothing_is_measured(boost: float) -> None:
    time = np.arange(0, 60, 0.01)
    felt = np.where((time > 20) & (time < 20 + boost), 8.0, 1.0) + np.random.default_rng(2).normal(0, 0.05, time.size)
    lines = (f"{when:.2f},{one:.3f}" for when, one in zip(time.tolist(), felt.tolist(), strict=True))
    imported = read("\n".join(["time (s),acceleration (g)", *lines]).encode(), "felt.csv", any_motor)
    assert imported.flights == ()
    assert ("without any readout" in imported.rejected[0].error) == (boost > 0.5)


def live_radio(height: str) -> bytes:
    """The live form of AltOS CSV as a ground station's program writes it, whose own height it calls by another name."""
    time = np.arange(-5, MADE.time[-1], 0.1)
    lines = [f"serial,tick,ptype,state,state_name,height,{height},rssi,time (s)"]
    for tick, metres in enumerate(MADE.at(time, MADE.height).tolist()):
        lines.append(f"2417,{10 * tick % 65536},10,2,pad,,{metres / FOOT:.1f},-60,{tick / 10:.1f}")
    return "\n".join(lines).encode() + b"\n"


def test_a_live_log_that_yields_no_flight_falls_back_to_a_table_of_samples() -> None:
    log = live_radio("altitude (ft)")
    imported = read(log, "live.csv", any_motor)
    (only,) = imported.flights
    assert only.apogee == pytest.approx(MADE.apogee, abs=1)
    assert imported.format == "mapped_table"


def test_an_acceleration_derived_from_pressure_does_not_move_lift_off() -> None:
    """The logger has only a barometer; its program derives a delayed acceleration from filtered heights."""
    time = np.arange(-3.0, MADE.time[-1] + 8, 0.1)
    height = MADE.at(time, MADE.height)
    slow = [0.0]
    for metres in np.diff(height).tolist():
        slow.append(slow[-1] + (metres / 0.1 - slow[-1]) * 0.2)
    acceleration = np.convolve(np.gradient(slow, time), np.ones(6) / 6)[: time.size]
    names = "#version,serial,flight,time,state,state_name,acceleration,pressure,altitude,height,speed,temperature"
    rows = "".join(
        f"6, 2417, 3, {t:7.2f}, 2, pad, {a:8.2f}, {p:9.2f}, {MADE.pad + h:8.2f}, {h:8.2f}, {v:7.2f}, 21.4\n"
        for t, a, p, h, v in zip(time, acceleration, MADE.pressure(height), height, slow, strict=True)
    )
    (reading,) = readings((names + "\n" + rows).encode())
    recorded = measure(reading.clocks)
    assert abs(recorded.events["liftoff"].time) < 0.2
    assert recorded.events["liftoff"].source == "barometric altitude"
    assert recorded.figures["top_speed"].value == pytest.approx(MADE.speed.max(), rel=0.1)


@pytest.mark.parametrize("sample", SIMULATED, ids=lambda path: path.name)
def test_the_figures_of_a_simulation_are_its_own(sample) -> None:  # type: ignore[no-untyped-def]
    (reading,) = (one for one in parsers()[owner(sample)].read(sample.read_bytes()) if isinstance(one, Reading))
    (series,) = reading.clocks
    assert series.speed is not None
    assert series.altitude is not None
    recorded = simulated(reading.clocks, reading.events)
    assert recorded.figures["top_speed"].value == series.speed.max()
    assert recorded.figures["apogee"].value == series.altitude.max()
    assert {figure.source for figure in recorded.figures.values()} == {"simulation"}
    for name, moment in reading.events.items():
        assert recorded.events[name].time == moment
    if "burnout" in reading.events:
        burn = reading.events["burnout"] - recorded.events["liftoff"].time
        assert recorded.figures["burn_time"].value == pytest.approx(burn)
    assert recorded.climb is not None
    assert recorded.height_at(recorded.events["apogee"].time) == pytest.approx(series.altitude.max(), abs=0.5)


def test_a_simulation_without_a_climb_is_not_a_flight() -> None:
    (reading,) = (one for one in parsers()["openrocket"].read(SIMULATED[0].read_bytes()) if isinstance(one, Reading))
    (series,) = reading.clocks
    flat = type(series)(time=series.time, altitude=np.zeros(series.time.size))
    assert not simulated((flat,), {}).figures
    assert not simulated((type(series)(time=series.time),), {}).figures


def test_an_arts2_log_of_raw_counts_is_refused_with_the_reason() -> None:
    with pytest.raises(DamagedLog, match="raw counts"):
        open_log(b"MET,Acc(HI),Acc/Baro(LO),Baro(HI),State\n0.00,12,34,56,0\n" * 30, "raw.csv", None)

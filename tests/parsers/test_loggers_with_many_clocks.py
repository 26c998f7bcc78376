"""Loggers with a clock for each channel or file (Raven, AIM XTRA, CATS), and GPS, ARTS2, AltimeterCloud."""

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Reading
from fieldkit.importing.read import read_together
from fieldkit.importing.recognize import parser_for, parsers
from fieldkit.importing.tables.columns_read import watched
from fieldkit.units import FOOT, STANDARD_GRAVITY
from tests.parsers.real_logs import LOGS, damage, reading, real
from tests.samples import SAMPLES, any_motor

BY_NAME = {sample.name: sample.read_bytes() for sample in SAMPLES}


def clock_of(flight: Reading, channel: str) -> Series:
    (series,) = (series for series in flight.clocks if getattr(series, channel) is not None)
    return series


@real
def test_a_real_raven_has_a_clock_for_each_channel() -> None:
    flight = reading("raven_fip__top_shot.csv")
    fast, slow = clock_of(flight, "felt"), clock_of(flight, "altitude")
    assert (len(fast.time), fast.time[-1]) == (6188, 77.3388)
    assert (len(slow.time), slow.time[-1]) == (310, 77.295)
    assert slow.pressure is not None
    assert slow.pressure[0] == pytest.approx(0.91148 * 101_325)
    assert len(clock_of(flight, "inertial_speed").time) == 35  # the channel ended at apogee, but the rows continued
    assert len(clock_of(flight, "temperature").time) == 310
    assert flight.events == {"liftoff": 0.285, "burnout": 3.08875, "apogee": 8.63875}
    assert damage("raven_fip__top_shot.csv") == []


@real
def test_a_real_raven_edited_by_hand_reads_the_same() -> None:
    flight = reading("raven_fip_variant__ndrt_2020_flight_data.csv")
    slow = clock_of(flight, "altitude")
    assert slow.altitude is not None
    assert slow.altitude.max() == pytest.approx(4331.88 * FOOT)
    assert slow.time[slow.altitude.argmax()] == 17.095
    assert (len(slow.time), clock_of(flight, "felt").time[-1]) == (1819, 4.54625)
    assert flight.events["apogee"] == 17.545


def test_a_raven_channel_that_has_ended_leaves_two_cells_or_three() -> None:
    names = ("Axial Accel (Gs)", "Baro (Atm)", "Temperature (F)")
    log = (",".join(f"Time@{name},{name},bILBA" for name in names) + "\n").encode()
    log += b"0,1.0,b0000,0.01,0.97,b0000,0.02,50,b0000\n0.1,2.0,b1000,,,0.12,50,b0000\n0.2,3.0,b1100,,,,0.22,50,b0000\n"
    flight, *rest = parsers()["raven_fip"].read(log)
    assert isinstance(flight, Reading)
    assert clock_of(flight, "temperature").time.tolist() == [0.02, 0.12, 0.22]
    assert clock_of(flight, "pressure").time.tolist() == [0.01]
    assert rest == []


@real
def test_a_real_aim_log_is_sorted_group_by_group() -> None:
    flight = reading("entacore_aim_xtra__e190_h148r.csv")
    slow, fast = clock_of(flight, "altitude"), clock_of(flight, "felt")
    assert slow.altitude is not None
    assert slow.altitude.max() == pytest.approx(643.362)
    assert slow.time[slow.altitude.argmax()] == 11.9352
    assert (slow.time[0], slow.time[-1], len(slow.time)) == (-99.9397, 74.0938, 425)
    assert fast.felt is not None
    assert fast.felt[0] == pytest.approx(1.01953 * STANDARD_GRAVITY)
    assert flight.events == {"liftoff": 1.76831, "apogee": 11.7398, "output A": 11.7398, "output B": 32.6789}


@real
def test_the_real_files_of_a_cats_flight_are_one_flight() -> None:
    names = ["cats__hedy_gnssInfo.csv", "cats__hedy_filteredDataInfo.csv", "cats__hedy_flightInfo.csv"]
    imported_files = read_together([(name, (LOGS / name).read_bytes()) for name in names], any_motor)
    assert [len(imported.flights) for imported in imported_files] == [0, 1, 0]
    (series,) = reading(names[2]).clocks
    assert series.altitude is not None
    assert (len(series.time), series.time[0], series.time[-1]) == (24_563, -0.751, 244.869)
    assert series.altitude.max() == pytest.approx(5230.4, abs=0.05)
    assert series.time[series.altitude.argmax()] == pytest.approx(33.29, abs=2e-3)


@real
def test_a_real_cats_position_without_satellites_is_not_used() -> None:
    (series,) = reading("cats__hedy_gnssInfo.csv").clocks
    assert series.latitude is not None
    assert (len(series.time), int(np.isnan(series.latitude).sum())) == (388, 38)


def test_files_of_two_cats_flights_in_a_folder_are_not_mixed_up() -> None:
    info, positions = BY_NAME["cats__flight_info.csv"], BY_NAME["cats__positions.csv"]
    together = [("a/1.csv", info), ("a/2.csv", info.replace(b".0000,", b".0001,")), ("a/3.csv", positions)]
    assert [len(imported.flights) for imported in read_together(together, any_motor)] == [1, 1, 1]
    separate = [("a/1.csv", info), ("b/1.csv", info.replace(b".0000,", b".0001,")), ("a/2.csv", positions)]
    assert [len(imported.flights) for imported in read_together(separate, any_motor)] == [1, 1, 0]


def test_each_cats_sensor_in_a_file_has_its_own_clock() -> None:
    (flight,) = parsers()["cats"].read(BY_NAME["cats__two_barometers.csv"])
    assert isinstance(flight, Reading)
    assert len(flight.clocks) == 2


@real
def test_a_real_gps_log_is_sorted_and_read_as_feet_above_sea_level() -> None:
    flight = reading("featherweight_gps__adventurer_j510w.csv")
    (series,) = flight.clocks
    assert series.gps_altitude_msl is not None
    assert series.gps_altitude_msl[0] / FOOT == pytest.approx(2871)
    assert series.gps_altitude_msl.max() / FOOT == pytest.approx(13_539)  # 10 668 ft above the pad
    assert (len(series.time), series.time[0], series.time[-1]) == (480, 0, 241.1)
    assert (series.time[1:] > series.time[:-1]).all()
    assert flight.extra == {"utc at the first sample": "Apr 17 2021 19:06:44.900 UTC"}


@real
def test_a_real_gps_log_with_fewer_columns_keeps_its_own_zero() -> None:
    (series,) = reading("featherweight_gps_derived__juno3_cots_GNSS.csv").clocks
    assert series.gps_altitude_msl is not None
    assert series.gps_speed is not None
    assert (series.time[0], series.time[-1]) == (-0.7, 148.401)
    assert series.gps_altitude_msl[0] / FOOT == pytest.approx(4583)
    climb = np.gradient(series.gps_altitude_msl, series.time)[-20:]
    assert np.median(series.gps_speed[-20:] / climb) == pytest.approx(1, abs=0.05)  # feet per second as well


def test_each_tracker_received_by_a_ground_station_is_one_flight_even_over_midnight() -> None:
    log = b"TRACKER,DATE,TIME,ALT,LAT,LON\n"
    for i, clock in enumerate((b"23:59:58.5", b"23:59:59.5", b"00:00:00.5")):
        log += b"one,2026-05-02,%b,%d,47.1,8.4\ntwo,2026-05-02,%b,1000,47.1,8.4\n" % (clock, 1000 + i, clock)
    one, two = parsers()["featherweight_gps"].read(log)
    assert isinstance(one, Reading)
    assert isinstance(two, Reading)
    assert (one.serial, two.serial) == ("one", "two")
    assert one.clocks[0].time.tolist() == [0, 1, 2]


def test_a_gps_with_milliseconds_of_unix_time_is_read_in_seconds() -> None:
    log = b"UTCTIME,UNIXTIME,ALT,LAT,LON\n" + b"".join(
        b"x,%d,1000,47.1,8.4\n" % (1715421600000 + 500 * i) for i in range(4)
    )
    (flight,) = parsers()["featherweight_gps"].read(log)
    assert isinstance(flight, Reading)
    assert flight.clocks[0].time == pytest.approx([0, 0.5, 1.0, 1.5])


def test_a_gps_without_a_possible_time_is_damaged() -> None:
    log = b"UTCTIME,UNIXTIME,ALT,LAT,LON\n" + b"x,9e20,1000,47.1,8.4\n" * 4
    with pytest.raises(DamagedLog):
        parsers()["featherweight_gps"].read(log)


def test_a_gps_without_a_fix_has_no_height() -> None:
    log = b"UTCTIME,UNIXTIME,ALT,LAT,LON,FIX\n" + b"".join(b"x,%d,1000,47.1,8.4,%d\n" % (i, i % 4) for i in range(4))
    (flight,) = parsers()["featherweight_gps"].read(log)
    assert isinstance(flight, Reading)
    (series,) = flight.clocks
    assert series.gps_altitude_msl == pytest.approx([np.nan] * 3 + [1000 * FOOT], nan_ok=True)
    assert series.latitude == pytest.approx([np.nan, np.nan, 47.1, 47.1], nan_ok=True)


@pytest.mark.parametrize(("level", "channel"), [(1.0, "felt"), (0.0, "acceleration")])
def test_samples_at_rest_on_the_pad_show_whether_an_arts2_includes_gravity(level: float, channel: str) -> None:
    rows = "".join(f"{i / 50:.2f} {level:.2f} 0 0 {i}\n" for i in range(100))
    (flight,) = parsers()["arts2"].read(f"# MET Acc Vel iAlt pAlt\n{rows}".encode())
    assert isinstance(flight, Reading)
    (series,) = flight.clocks
    assert getattr(series, channel) is not None
    assert series.altitude == pytest.approx(np.arange(100) * FOOT)


def test_raw_counts_of_an_arts2_are_refused_with_advice() -> None:
    log = b"MET,Acc(HI),Acc/Baro(LO),Baro(HI),State\n0.00,120,33,200,1\n"
    with pytest.raises(DamagedLog, match="expected the interpreted export"):
        parser_for(log).read(log)


def test_altimetercloud_labels_are_kept_and_its_apogee_is_stated() -> None:
    (flight,) = parsers()["altimetercloud"].read(BY_NAME["altimetercloud__labels_before_the_table.csv"])
    assert isinstance(flight, Reading)
    assert flight.stated == {"apogee": 172.2}
    assert (flight.serial, flight.firmware) == ("N-0042", "4.2")
    (series,) = flight.clocks
    assert series.felt is not None
    assert series.felt[0] == pytest.approx(STANDARD_GRAVITY, rel=0.05)  # its y axis points down


def test_an_altimetercloud_apogee_without_a_unit_is_not_stated() -> None:
    log = BY_NAME["altimetercloud__labels_before_the_table.csv"].replace(b"Apogee (m)", b"Apogee")
    flight, *notes = parsers()["altimetercloud"].read(log)
    assert isinstance(flight, Reading)
    assert flight.stated == {}
    assert not any(isinstance(item, Note) for item in notes)


@pytest.mark.parametrize(
    ("sample", "name", "channel"),
    [
        ("aim_xtra__groups_that_end_early.csv", "pressure agl", "altitude"),
        ("raven_fip__channels_that_end_early.csv", "baro (atm)", "pressure"),
    ],
)
def test_columns_are_shown_with_the_logs_own_names(sample: str, name: str, channel: str) -> None:
    with watched() as tables:
        parsers()[sample.split("__")[0]].read(BY_NAME[sample])
    shown = {column.name: column.channel for column in tables[-1].columns}
    assert shown[name] == channel
    assert all(channel == "time" for name, channel in shown.items() if name.startswith("time"))

"""Tables of samples with the columns that loggers, apps, spreadsheets and people give them, each of a known flight."""

import gzip
import json
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
import pytest

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.flight import Flight
from fieldkit.importing import ImportedFile
from fieldkit.importing.read import read
from fieldkit.importing.tables.mapping import read_choice
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure
from fieldkit.units import FOOT
from tests.samples import any_motor

PAD = 250.0
RNG = np.random.default_rng(8)
TIME = np.arange(-3.0, 45.0, 0.05)
BURN, PUSH, SINKS = 1.6, 40.0, 6.0
_SPEED = PUSH * BURN
_BURNOUT = PUSH * BURN**2 / 2
_TOP = BURN + _SPEED / GRAVITY
APOGEE = _BURNOUT + _SPEED**2 / (2 * GRAVITY)
HEIGHT = np.select(
    [TIME < 0, TIME < BURN, TIME < _TOP],
    [0 * TIME, PUSH * TIME**2 / 2, APOGEE - GRAVITY * (TIME - _TOP) ** 2 / 2],
    np.maximum(APOGEE - SINKS * (TIME - _TOP), 0),
)
SPEED = np.gradient(HEIGHT, TIME)
SEEN = HEIGHT + RNG.normal(0, 0.1, TIME.size)
PRESSURE = height_pressure(SEEN + PAD)
FELT = np.select([TIME < 0, TIME < BURN, TIME < _TOP], [1.0, PUSH / GRAVITY + 1, 0.0], 0.4) + RNG.normal(
    0, 0.02, TIME.size
)


def table(names: str, *columns: np.ndarray | Sequence[str], separator: str = ",") -> bytes:
    """A table with these names and columns; numbers have three decimals."""
    cells = [[one if isinstance(one, str) else f"{one:.3f}" for one in column] for column in columns]
    return "\n".join([names, *(separator.join(row) for row in zip(*cells, strict=True)), ""]).encode()


def opened(log: bytes, *maps: str) -> ImportedFile:
    return read(log, "log.csv", any_motor, None, [read_choice(maps)] if maps else [])


def apogee(log: bytes, *maps: str) -> float:
    """The apogee of the one flight in a log. [m]"""
    (flight,) = opened(log, *maps).flights
    assert flight.apogee is not None
    return flight.apogee


def text(values: np.ndarray, form: str) -> list[str]:
    return [form.format(one) for one in values.tolist()]


def wrapped(values: np.ndarray, *, signed: bool) -> np.ndarray:
    """Integers as 16 bits store them."""
    return values.astype(np.int64).astype(np.int16 if signed else np.uint16).astype(float)


CLOCK = 1000 * (TIME - TIME[0])
NORTH, EAST = 47 + 0 * TIME, 8 + 0 * TIME
HIGHEST, FASTEST = np.maximum.accumulate(SEEN), np.maximum.accumulate(SPEED)
LATER = 22.0 + 0 * TIME + RNG.normal(0, 0.1, TIME.size)
GPS = HEIGHT + PAD + 12 + RNG.normal(0, 3, TIME.size)


@pytest.mark.parametrize(
    ("names", "columns"),
    [
        ("time_ms,altitude_m,temperature_alt_celsius", (CLOCK, SEEN, LATER)),
        ("time_ms,baro_temperature,baro_altitude", (CLOCK, LATER, SEEN)),
        ("time_ms,altitude_m,alt_temp,baro_voltage,density_altitude_m", (CLOCK, SEEN, LATER, LATER / 3, SEEN + 400)),
        ("t [ms],T,p [Pa]", (CLOCK, LATER, PRESSURE)),
        ("ts[deciseconds],altitude[m]", (CLOCK / 100, SEEN)),
        ("time (not s),time approx (s),z (m)", (CLOCK / 50, CLOCK / 1000, SEEN)),
        (
            "time (s),latitude,longitude,altitude (m),height (m),pressure (Pa)",
            (TIME, NORTH, EAST, GPS, SEEN, PRESSURE),
        ),
        (
            "time (s),height (m),altitude (m),lat,lon,altitude (m)",
            (TIME, SEEN, SEEN + PAD, NORTH, EAST, GPS),
        ),
        ("time (s),altitude (m),pressure (Pa)", (TIME, SEEN, 0 * TIME + 99_000)),
        ("time (s),altitude (m),altitude 2 (m)", (TIME, SEEN, 0 * TIME)),
        ("time (s),height (cm)", (TIME, wrapped(100 * (SEEN + 260), signed=False))),
        ("time (s),height (cm)", (TIME, wrapped(100 * (SEEN + 260), signed=True))),
        ("time (s),height (m)", (TIME, wrapped(100 * (SEEN + 450), signed=True) / 100)),
        (
            "time (s),altitude (m),Apogee (m),duration_s,top_speed",
            (TIME, SEEN, HIGHEST, TIME + 3, FASTEST),
        ),
        ("time,GS Alt asl (ft),TRACKER Alt asl (ft)", (CLOCK / 1000, 0 * TIME + 900, GPS / FOOT)),
    ],
    ids=lambda one: one[:40] if isinstance(one, str) else "",
)
def test_the_apogee_is_that_of_the_height_among_other_columns(names: str, columns: tuple[np.ndarray, ...]) -> None:
    error = 6.0 if "TRACKER" in names else 1.5
    assert apogee(table(names, *columns)) == pytest.approx(APOGEE, abs=error)


@pytest.mark.parametrize("mark", [" ", "\u00a0", "\u202f", "'", "\u2019"])
@pytest.mark.parametrize("start", [0.0, 2000.0])
def test_thousands_may_be_separated_by_a_space_or_an_apostrophe(mark: str, start: float) -> None:
    feet = [f"{one:,.1f}".replace(",", mark).replace(".", ",") for one in (SEEN / FOOT + start).tolist()]
    log = table("Temps (s);Hauteur (ft)", text(TIME + 3, "{:.2f}"), feet, separator=";").decode()
    lines = [line.partition(";")[0].replace(".", ",") + ";" + line.partition(";")[2] for line in log.splitlines()[1:]]
    assert apogee("\n".join(["Temps (s);Hauteur (ft)", *lines, ""]).encode()) == pytest.approx(APOGEE, abs=1.5)


def test_a_decimal_comma_that_also_separates_cells_is_named() -> None:
    log = table("time (s),altitude (m)", TIME + 3, SEEN).decode().replace(".", ",")
    with pytest.raises(DamagedLog, match=r"log.csv, row 2: .*commas of the decimals"):
        opened(log.encode())


def test_two_columns_that_differ_in_case_are_chosen_by_their_exact_names() -> None:
    log = table("t,T,p", CLOCK, LATER, PRESSURE)
    assert apogee(log, "time=t [ms]", "pressure=p [Pa]") == pytest.approx(APOGEE, abs=1.5)
    imported = opened(log, "time=#1 [ms]", "pressure=#3 [Pa]")
    assert imported.recognition.rows == TIME.size


def test_a_hint_for_a_unit_is_accepted() -> None:
    log = table("time(not s),alt (m)", CLOCK / 50, SEEN)
    with pytest.raises(DamagedLog, match=r"write --map 'time=#1 \[s\]'"):
        opened(log)
    assert opened(log, "time=#1 [s]").recognition.rows == TIME.size


def test_a_column_can_be_excluded() -> None:
    log = table("time (s),alt a (m),alt b (m)", TIME, SEEN, SEEN + 30 * np.sin(TIME))
    with pytest.raises(DamagedLog, match="two columns for altitude"):
        opened(log)
    assert apogee(log, "exclude=alt b (m)") == pytest.approx(APOGEE, abs=1.5)
    assert apogee(log, "exclude=#3", "time=time (s)") == pytest.approx(APOGEE, abs=1.5)


def test_a_pressure_that_no_pad_has_is_refused_whether_too_low_or_too_high() -> None:
    for factor in (3.4, 0.1):
        with pytest.raises(DamagedLog, match="expected about 1000 hPa"):
            opened(table("time (s),pressure (atm)", TIME, factor * PRESSURE / 101_325))


def test_trackers_in_one_table_are_flights_of_their_own() -> None:
    names = np.where(np.arange(2 * TIME.size) % 2, "Alpha", "Beta").tolist()
    both = np.ravel(np.column_stack([TIME, TIME + 0.01])) + 3
    heights = np.ravel(np.column_stack([GPS, 0.5 * HEIGHT + 300 + RNG.normal(0, 1, TIME.size)]))
    imported = opened(table("TRACKER,time (s),Alt asl (m)", names, both, heights))
    assert len(imported.flights) == 2
    tops = sorted(flight.apogee or 0.0 for flight in imported.flights)
    assert tops == pytest.approx([APOGEE / 2, APOGEE], abs=8)


@pytest.mark.parametrize("total", [True, False])
def test_accelerations_without_a_unit_are_in_the_one_that_reads_one_g_at_rest(*, total: bool) -> None:
    """Also if the boost is a small part of a long log."""
    wait = np.arange(-400.0, -3.0, 0.05)
    time, seen = np.append(wait, TIME), np.append(0 * wait, SEEN)
    felt = 9.8 * np.append(1 + RNG.normal(0, 0.02, wait.size), FELT)
    noise = RNG.normal(0, 0.1, time.size)
    columns = (np.abs(felt),) if total else (noise, felt, noise)
    log = table(f"time (s),altitude (m),{'total acceleration' if total else 'ax,ay,az'}", time, seen, *columns)
    (flight,) = opened(log).flights
    if not total:
        assert flight.peak_accel == pytest.approx(PUSH, rel=0.1)
    assert flight.burn_time == pytest.approx(BURN, abs=0.15 if total else 0.06)


def test_a_table_of_simulations_is_refused() -> None:
    names = "Name,Configuration,Velocity off rod (m/s),Apogee (m),Optimum delay (s),Ground hit velocity (m/s)"
    with pytest.raises(DamagedLog, match="table of simulations"):
        opened(f"{names}\nSimulation 1,[C6-5],15.1,310,5.6,4.5\nSimulation 2,[B6-4],14.1,110,4.6,4.5\n".encode())


@pytest.mark.parametrize(
    "names",
    ["Time (sec),Altitude (ft),Thrust (lb)", "Time (sec),Mach Number,Altitude (ft)", "time (s),CD,altitude (ft)"],
)
def test_a_trimmed_export_of_a_simulation_is_no_flight(names: str) -> None:
    feet, other = HEIGHT / FOOT, np.maximum(SPEED, 0)
    columns = (feet, other) if names.lower().index("alt") < 14 else (other, feet)
    with suppress(UnknownFormat):
        assert opened(table(names, TIME + 3, *columns)).flights == ()


def test_a_log_without_any_readout_is_not_a_flight() -> None:
    axes = (0 * TIME, 0 * TIME, 9.81 * FELT)
    imported = opened(table("Time (s),Vel Z (m/s),Acc X (m/s2),Acc Y (m/s2),Acc Z (m/s2)", TIME, SPEED, *axes))
    assert imported.flights == ()
    assert "without any readout" in imported.rejected[0].error


@pytest.mark.parametrize(("name", "scale"), [("ms", 1000.0), ("us", 1e6), ("s", 1.0)])
def test_a_first_column_named_by_a_unit_of_time_is_the_clock(name: str, scale: float) -> None:
    """Only a first one, and only without another clock: `ms` may also be a speed."""
    (reading,) = opened(table(f"{name},altitude (m),G's", scale * (TIME + 3), SEEN, FELT)).recorded
    assert reading is not None
    assert reading.figures["apogee"].value == pytest.approx(APOGEE, abs=1.0)
    assert reading.figures["burn_time"].value == pytest.approx(BURN, abs=0.1)
    assert "acceleration" in reading.figures["burn_time"].source
    with pytest.raises((DamagedLog, UnknownFormat)):
        opened(table(f"altitude (m),{name}", SEEN, scale * (TIME + 3)))


@pytest.mark.parametrize(
    ("names", "time", "heights"),
    [
        ("time,altitude", 1e3, HEIGHT * 100),
        ("time,altitude", 1e6, HEIGHT * 1000),
        ("time,altitude", 100, HEIGHT),
        ("time (h),altitude (m)", 1 / 3600, HEIGHT),
        ("ticks (10 ms),Height_above_pad", 100, HEIGHT),
        ("time_s,alt (ft x10)", 1, HEIGHT / FOOT * 10),
        ("time_s,estimated_altitude_m", 1, HEIGHT),
        ("time_s,alt_ft_msl", 1, (HEIGHT + PAD) / FOOT),
        ("millis,Pressure [Pa*10]", 1e3, PRESSURE * 10),
        ("millis,pressure", 1e3, PRESSURE * 10),
        ("seconds,mBar", 1, PRESSURE / 100),
    ],
)
def test_clocks_and_heights_that_state_no_usual_unit_are_read(names: str, time: float, heights: np.ndarray) -> None:
    clock = text((TIME + 3) * time, "{:.8f}")
    assert apogee(table(names, clock, heights)) == pytest.approx(APOGEE, abs=1.0)


@pytest.mark.parametrize(("names", "ticks", "unit"), [("time,altitude (m)", 20, 1), ("time,altitude (ft)", 128, FOOT)])
def test_a_clock_that_gravity_contradicts_is_refused(names: str, ticks: float, unit: float) -> None:
    with pytest.raises(DamagedLog, match=r"time=#1 \[m?s\]"):
        opened(table(names, (TIME + 3) * ticks, HEIGHT / unit))


@pytest.mark.parametrize("header", [True, False], ids=["with a second header", "without"])
def test_units_follow_from_the_flight_of_a_logger_that_was_switched_on_twice(*, header: bool) -> None:
    """It stood on the pad first; no unit is stated, and the header of the second start is no damaged row."""
    names, pad = "millis,pressure,altitude,ax,ay,az", 200
    before = [CLOCK[:pad], PRESSURE[0] + RNG.normal(0, 8, pad), RNG.normal(0, 0.7, pad), 0 * CLOCK[:pad]]
    first = table(names, *before, before[-1], before[-1] + 1)
    second = table(names, CLOCK, PRESSURE, SEEN, 0 * TIME, 0 * TIME, FELT)
    found = opened(first + (second if header else second.partition(b"\n")[2]))
    (flight,) = found.flights
    assert flight.apogee == pytest.approx(APOGEE, rel=0.01)
    assert not any("found 'millis'" in str(one) for one in found.rejected)


@pytest.mark.parametrize("gap", [3000.0, 40.0], ids=["two flights", "silence within one"])
def test_a_long_gap_between_two_climbs_separates_flights(gap: float) -> None:
    """A shorter one, or one on the ground, is a pause of the recording."""
    later = np.concatenate([TIME, TIME[-1] + gap + TIME - TIME[0]])
    flights = opened(table("time_s,altitude_m", later, np.concatenate([SEEN, SEEN]))).flights
    assert len(flights) == (2 if gap > 1000 else 1)
    paused = np.where(TIME[-40] < TIME, TIME + gap, TIME)
    assert apogee(table("time_s,altitude_m", paused, SEEN)) == pytest.approx(APOGEE, rel=0.01)


@pytest.mark.parametrize("name", ["az", "Acc Z (g)"])
def test_one_axis_that_feels_one_g_on_the_pad_is_along_the_rocket(name: str) -> None:
    (flight,) = opened(table(f"time_s,altitude_m,{name}", TIME, SEEN, FELT)).flights
    (across,) = opened(table(f"time_s,altitude_m,{name}", TIME, SEEN, 0.1 * FELT)).flights
    assert flight.peak_accel == pytest.approx(PUSH, rel=0.03)
    assert flight.sd["peak_accel"] < 0.5 * across.sd["peak_accel"]


@pytest.mark.parametrize("name", ["GPSTime", "UTC Time (s)", "gps_time"])
def test_the_clock_of_a_receiver_serves_where_there_is_no_other(name: str) -> None:
    assert apogee(table(f"{name},BaroAlt(m)", 36000 + TIME, SEEN)) == pytest.approx(APOGEE, rel=0.01)
    wrong = 36000 + 1.1 * TIME
    assert apogee(table(f"{name},time_s,BaroAlt(m)", wrong, TIME, SEEN)) == pytest.approx(APOGEE, rel=0.01)
    (flight,) = opened(table(f"{name},time_s,BaroAlt(m)", wrong, TIME, SEEN)).flights
    assert flight.coast_to_apogee == pytest.approx(_TOP - BURN, rel=0.04)


def test_milliseconds_with_separated_thousands_are_read() -> None:
    """Every number of the table could have a decimal comma, but those below a thousand have no mark."""
    clock = [f'"{one:,}"' for one in np.round(CLOCK).astype(int).tolist()]
    assert apogee(table("Time (ms),Altitude (m)", clock, text(np.round(SEEN), "{:.0f}"))) == pytest.approx(
        APOGEE, rel=0.01
    )
    cells = [f'"{one:.3f}"'.replace(".", ",") for one in (1 + CLOCK / 1000).tolist()]
    thousandths = table("Time (s),Altitude (m)", cells, text(np.round(SEEN), "{:.0f}"))
    with suppress(DamagedLog, UnknownFormat):
        assert apogee(thousandths) == pytest.approx(APOGEE, rel=0.01)


@pytest.mark.parametrize("names", ["ms;Pa", "millis;mb"])
def test_columns_named_by_their_units_alone_are_read(names: str) -> None:
    pressure = PRESSURE if "Pa" in names else PRESSURE / 100
    assert apogee(table(names, CLOCK, pressure, separator=";")) == pytest.approx(APOGEE, rel=0.03)


def test_a_height_downward_in_meters_is_not_in_decimeters() -> None:
    assert apogee(table("time_s,pos_n_m,pos_e_m,pos_d_m", TIME, 0.1 * TIME, 0.2 * TIME, -SEEN)) == pytest.approx(
        APOGEE, rel=0.01
    )


def test_a_position_of_one_axis_that_points_down_is_a_height() -> None:
    assert apogee(table("t,posD,velD", TIME, -SEEN, -SPEED)) == pytest.approx(APOGEE, rel=0.01)


def test_seconds_and_nanoseconds_of_a_stamp_are_a_clock() -> None:
    whole, rest = np.divmod(TIME + 1.75e9, 1.0)
    stamps = text(whole, "{:.0f}"), text(1e9 * rest, "{:.0f}")
    assert apogee(table("header.stamp.secs,header.stamp.nsecs,altitude", *stamps, SEEN)) == pytest.approx(
        APOGEE, rel=0.01
    )


def test_two_barometers_without_units_that_differ_by_their_calibration_are_one() -> None:
    log = table("time_ms,ms5611_pressure,bmp390_pressure", 1000 * TIME, PRESSURE, PRESSURE + 60)
    assert apogee(log) == pytest.approx(APOGEE, rel=0.03)


def test_names_that_a_spreadsheet_took_for_another_encoding_are_read() -> None:
    names = "Zeit [s];Höhe [m];Beschleunigung [m/s²]".encode().decode("cp1252")
    log = table(names, TIME, SEEN, GRAVITY * FELT, separator=";")
    assert apogee(log) == pytest.approx(APOGEE, rel=0.01)


@pytest.mark.parametrize("form", ["np.float64({})", '="{}"', '"=""{}"""'])
def test_numbers_are_read_from_what_programs_write_around_them(form: str) -> None:
    columns = [[form.format(f"{one:.3f}") for one in column] for column in (TIME, SEEN)]
    assert apogee(table("time (s),altitude (m)", *columns)) == pytest.approx(APOGEE, rel=0.01)
    records = "".join(f"{{'t': {time}, 'alt': {height}}}\n" for time, height in zip(*columns, strict=True))
    assert form != "np.float64({})" or apogee(records.encode()) == pytest.approx(APOGEE, rel=0.01)


def test_a_compressed_log_is_called_so() -> None:
    with pytest.raises(UnknownFormat, match=r"log\.csv: .*it is compressed \(gzip\); unpack it first"):
        opened(gzip.compress(table("time (s),altitude (m)", TIME, SEEN)))


def test_zeros_of_a_receiver_before_its_fix_are_no_pad() -> None:
    heights = np.where(TIME < -1.5, 0.0, SEEN + PAD)
    position = text(np.where(TIME < -1.5, 0.0, 47.1), "{:.1f}"), text(np.where(TIME < -1.5, 0.0, 8.2), "{:.1f}")
    assert apogee(table("millis,Lat,Lon,Alt (m)", 1000 * TIME, *position, heights)) == pytest.approx(APOGEE, rel=0.02)


def test_the_time_since_the_logger_was_switched_on_is_a_clock() -> None:
    assert apogee(table("uptime_ms,alt_m", 1000 * TIME + 5e6, SEEN)) == pytest.approx(APOGEE, rel=0.01)


def test_objects_whose_first_value_is_named_after_the_unit_of_a_clock_are_samples() -> None:
    records = [{"ms": f"{1000 * t:.0f}", "alt": f"{h:.2f}"} for t, h in zip(TIME.tolist(), SEEN.tolist(), strict=True)]
    assert apogee(json.dumps({"log": records}).encode()) == pytest.approx(APOGEE, rel=0.01)


@pytest.mark.parametrize("mark", ["ovf", "ERR", "invalid"])
def test_what_a_sketch_prints_instead_of_a_number_costs_no_row(mark: str) -> None:
    heights = [mark if place % 50 == 9 else f"{one:.2f}" for place, one in enumerate(SEEN.tolist())]
    imported = opened(table("time (s),altitude (m),temp (C)", TIME, heights, 21 + 0 * TIME))
    assert imported.flights[0].apogee == pytest.approx(APOGEE, rel=0.01)
    assert not any("expected a number" in str(note) for note in (*imported.notes, *imported.rejected))


@pytest.mark.parametrize("part", [0.03, 0.1, 0.3])
@pytest.mark.parametrize("mark", ["65535", "-999", "9999.99", "4294967295", "-32768"])
@pytest.mark.parametrize(("name", "column"), [("altitude (m)", SEEN), ("pressure (hPa)", PRESSURE / 100)])
def test_numbers_that_mark_a_missing_reading_are_none(part: float, mark: str, name: str, column: np.ndarray) -> None:
    cells = [f"{one:.2f}" for one in column.tolist()]
    for place in np.random.default_rng(3).choice(TIME.size, int(part * TIME.size), replace=False).tolist():
        cells[place] = mark
    assert apogee(table(f"time (s),{name}", TIME, cells)) == pytest.approx(APOGEE, rel=0.02)


def test_a_mark_of_a_missing_pressure_does_not_decide_its_unit() -> None:
    cells = [("65535" if place % 25 == 7 else f"{one:.0f}") for place, one in enumerate((PRESSURE / 10).tolist())]
    with pytest.raises(DamagedLog, match=r"log\.csv, pressure_dapa: found .*unit"):
        opened(table("time_ms,pressure_dapa", 1000 * TIME, cells))


@pytest.mark.parametrize("mark", ["n/a", "#N/A", "null", "None", "inf", "#DIV/0!"])
def test_a_word_for_a_missing_reading_may_begin_a_table(mark: str) -> None:
    heights = [mark if place % 3 == 0 else f"{one:.2f}" for place, one in enumerate(SEEN.tolist())]
    assert apogee(table("time_s,altitude_m", TIME, heights)) == pytest.approx(APOGEE, rel=0.01)


def test_an_acceleration_of_nine_point_eight_g_at_rest_is_in_another_unit() -> None:
    (flight,) = opened(table("time (s),altitude (m),accel (g)", TIME, SEEN, GRAVITY * FELT)).flights
    assert flight.apogee == pytest.approx(APOGEE, rel=0.01)
    assert flight.peak_accel == pytest.approx(PUSH, rel=0.1)


@pytest.mark.parametrize("begins", [0.5, 1.0, 2.5])
@pytest.mark.parametrize("felt", [False, True])
def test_heights_that_a_logger_zeroed_in_flight_are_not_above_the_pad(begins: float, felt: bool) -> None:
    log = np.flatnonzero(begins <= TIME)
    names, columns = "time (s),altitude (m)", [TIME[log], SEEN[log] - HEIGHT[log][0]]
    cut_off = opened_or_none(table(names + ",accel (g)" * felt, *columns, *([FELT[log]] if felt else [])))
    assert cut_off is None or cut_off.apogee is None
    rest = np.arange(TIME[-1] + 0.05, 70.0, 0.05)
    down = np.maximum(APOGEE - SINKS * (rest - _TOP), 0) - HEIGHT[log][0]
    columns = [np.append(one, more) for one, more in zip(columns, (rest, down), strict=True)]
    whole = opened_or_none(table(names, *columns))
    assert whole is not None
    assert whole.burn_time is None
    assert whole.apogee is None or abs(whole.apogee - APOGEE) < 2 * whole.sd["apogee"]


def opened_or_none(log: bytes) -> Flight | None:
    """The flight of a log, if it has a readout."""
    return next(iter(opened(log).flights), None)

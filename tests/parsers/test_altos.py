"""AltOS: every version of CSV, the flash in both forms and the radio log, each compared with a known flight."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.analysis.possible import MAX_RELATIVE_SD
from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Reading
from fieldkit.importing.read import read as read_log
from fieldkit.importing.read import read_together
from fieldkit.importing.recognize import claims, parsers
from fieldkit.importing.tables.altos import STATES, Coefficients, entered, ms5607
from fieldkit.importing.tables.altos_flash import LAYOUTS
from fieldkit.physics.standard_atmosphere import GRAVITY, pressure_height
from tests.parsers.recorded import LOGS as RECORDINGS
from tests.parsers.recorded import recorded
from tests.samples import any_motor
from tools.samples.altos_eeprom import MINUS, PLUS, SENSOR, WARM, flash, logged, raw_pressure, settings
from tools.samples.two_parachutes import PAD, air, flight
from tools.samples.writing import little, noise, text

LOGS = Path(__file__).parents[2] / "sample_logs"
V5 = "header does not match its rows of 70 cells, read up to main_voltage"


def read(name: str, log: bytes | None = None) -> tuple[Reading, list[Parsed]]:
    first, *rest = parsers()[name.split("__")[0]].read((LOGS / name).read_bytes() if log is None else log)
    assert isinstance(first, Reading)
    return first, rest


def heights(series: Series) -> np.ndarray:
    """Heights above the pad, from pressure if the log has no others. [m]"""
    if series.altitude is not None:
        return series.altitude
    assert series.pressure is not None
    return pressure_height(series.pressure) - PAD


@pytest.mark.parametrize(
    ("name", "rows", "start", "stop", "highest", "when", "events"),
    [
        ("2012-04-07-serial-882-flight-001", 2251, -0.3, 100.15, 568.48, 9.96, ("drogue", 10.09)),
        ("2012-05-28-serial-319-flight-005", 1064, -0.3, 36.27, 230.89, 2.02, ("landing", 36.27)),
        ("2012-08-31-serial-334-flight-003", 1681, -0.3, 25.29, 738.22, 0.06, ("drogue", 15.11)),
        ("2012-11-17-serial-209-flight-013", 2513, -0.3, 92.27, 888.22, 13.76, ("drogue", 13.76)),
    ],
)
def test_rows_of_version_5_are_read_by_position(
    name: str, rows: int, start: float, stop: float, highest: float, when: float, events: tuple[str, float]
) -> None:
    reading, rest = read("altos_csv__", recorded(f"altos_csv__{name}.csv"))
    (series,) = reading.clocks
    assert (len(series.time), series.time[0], series.time[-1]) == (rows, start, stop)
    assert heights(series).max() == highest
    assert series.time[heights(series).argmax()] == when
    assert reading.events[events[0]] == events[1]
    assert reading.device.startswith("TeleMetrum-v1.")
    assert series.gps_altitude_msl is None
    assert [note.text for note in rest if isinstance(note, Note)] == [V5]


def test_the_current_export_has_its_second_altitude_from_satellites() -> None:
    log = recorded("altos_csv__prometheus_2022-06-24-serial-5115-flight-0001-TeleMetrum.csv")
    reading, rest = read("altos_csv__", log)
    (series,) = reading.clocks
    assert (len(series.time), series.time[0], series.time[-1]) == (7081, -0.3, 237.94)
    assert (heights(series).max(), series.time[heights(series).argmax()]) == (3903.77, 29.61)
    assert series.gps_altitude_msl is not None
    assert series.gps_altitude_msl[0] == 1390.0
    assert reading.events["liftoff"] == 0.0
    assert (reading.serial, reading.extra["flight"]) == ("5115", "1")
    assert not rest


@pytest.mark.parametrize(
    ("name", "rows", "seconds", "steps"),
    [
        ("altos_csv__a_barometer_alone.csv", 248, 0.1, 1.0),
        ("altos_csv__with_satellites.csv", 211, 0.2, 1.0),
        ("altos_csv__version_5_with_a_comma_missing.csv", 193, 0.1, 1.0),
        ("altos_csv__version_5_with_cells_too_many.csv", 97, 0.2, 1.0),
        ("altos_eeprom__easymini.eeprom", 255, 0.1, 1.0),
        ("altos_eeprom__easymega_cut_off.eeprom", 209, 0.1, 1.0),
        ("altos_eeprom__telemetrum_2_with_damage.eeprom", 253, 0.1, 1.0),
        ("altos_eeprom__telemetrum_2_old_form.eeprom", 254, 0.1, 1.0),
        ("altos_eeprom__telemetrum_1_among_commands.eeprom", 255, 0.1, 2.0),
        ("altos_eeprom__telemini_1.eeprom", 87, 0.1, 1.0),
        ("altos_telem__telemetrum_2_with_gaps.telem", 231, 0.3, 1.0),
        ("altos_telem__telemetrum_1.telem", 133, 0.2, 1.0),
    ],
)
def test_the_flight_is_recovered_from_every_form(name: str, rows: int, seconds: float, steps: float) -> None:
    reading, _ = read(name)
    series, truth = reading.clocks[0], flight()
    assert len(series.time) == rows
    assert np.nanmax(heights(series)) == pytest.approx(truth.apogee, abs=steps)
    assert series.time[np.nanargmax(heights(series))] == pytest.approx(truth.time[truth.height.argmax()], abs=0.3)
    for event, state in (("liftoff", 3), ("burnout", 5), ("drogue", 6)):
        assert reading.events[event] == pytest.approx(truth.time[(truth.state == state).argmax()], abs=seconds)


@pytest.mark.parametrize(
    "name",
    [
        "altos_eeprom__telemetrum_2_with_damage.eeprom",
        "altos_eeprom__telemetrum_1_among_commands.eeprom",
        "altos_eeprom__easymega_cut_off.eeprom",
        "altos_telem__telemetrum_1.telem",
        "altos_csv__with_satellites.csv",
    ],
)
def test_acceleration_is_net_of_gravity(name: str) -> None:
    series, truth = read(name)[0].clocks[0], flight()
    assert series.acceleration is not None
    expected = np.interp(series.time, truth.time, truth.acceleration)
    in_flight = (series.time > 1.5) & (series.time < 5.0)
    assert series.acceleration[in_flight] == pytest.approx(expected[in_flight], abs=0.5)
    assert series.acceleration[series.time < 0] == pytest.approx(0.0, abs=0.5)


def test_accelerometer_counts_that_do_not_fit_the_pad_are_not_used() -> None:
    """For example if a unit was mounted upside down, or its firmware stores something else there."""
    name = "altos_eeprom__easymega_cut_off.eeprom"
    log = (LOGS / name).read_bytes().replace(b"46 31 09 00 03 00 bb 3c", b"46 32 09 00 03 00 bb 3b")
    assert log != (LOGS / name).read_bytes()
    assert read(name, log)[0].clocks[0].acceleration is None


def test_missing_measurements_are_nan() -> None:
    series = read("altos_csv__a_barometer_alone.csv")[0].clocks[0]
    assert series.temperature is not None
    assert series.voltage is not None
    assert np.flatnonzero(np.isnan(series.temperature)).tolist() == [30]
    assert np.flatnonzero(np.isnan(series.voltage)).tolist() == [30]


def test_a_repeated_fix_without_satellites_is_not_used() -> None:
    series = read("altos_csv__with_satellites.csv")[0].clocks[0]
    for channel in (series.latitude, series.longitude, series.gps_altitude_msl):
        assert channel is not None
        assert np.isnan(channel).sum() == 40


def test_a_state_that_recurs_does_not_move_its_event() -> None:
    log = (LOGS / "altos_csv__version_5_with_a_comma_missing.csv").read_bytes()
    assert log.count(b"3,   boost") == 17
    assert read("altos_csv__", log)[0].events["liftoff"] == 0.0
    assert read("altos_csv__", log)[0].events["burnout"] == 1.1


def test_the_clock_of_the_radio_form_continues_where_it_wraps_and_over_gaps() -> None:
    (series,) = read("altos_csv__heard_by_radio.csv")[0].clocks
    steps = np.diff(series.time)
    assert steps.min() == pytest.approx(0.1)
    assert steps.max() == pytest.approx(1.2)
    assert np.nanmax(heights(series)) == pytest.approx(flight().apogee, abs=1)


def test_two_flights_in_a_csv_are_two_readings() -> None:
    log = (LOGS / "altos_csv__a_barometer_alone.csv").read_text()
    second = "".join(line.replace("2417, 3,", "2417, 4,") + "\n" for line in log.splitlines()[1:])
    found = parsers()["altos_csv"].read((log + second).encode())
    assert [item.extra["flight"] for item in found if isinstance(item, Reading)] == ["3", "4"]


def test_only_the_records_on_a_damaged_line_of_flash_are_lost() -> None:
    whole, _ = read("altos_eeprom__telemetrum_2_old_form.eeprom")
    hurt, rest = read("altos_eeprom__telemetrum_2_with_damage.eeprom")
    lost = set(whole.clocks[0].time.round(2)) - set(hurt.clocks[0].time.round(2))
    assert len(lost) == 1
    assert isinstance(rest[0], DamagedLog)
    assert rest[0].row == 65
    assert "1 record has a wrong checksum" in str(rest[1])


def test_positions_have_their_own_clock() -> None:
    _, positions = read("altos_eeprom__telemetrum_2_with_damage.eeprom")[0].clocks
    assert len(positions.time) == 5
    assert positions.latitude == pytest.approx(np.full(5, 47.1), abs=1e-4)


def test_a_sensor_without_its_calibration_is_refused() -> None:
    log = (LOGS / "altos_eeprom__easymini.eeprom").read_bytes()
    with pytest.raises(DamagedLog, match="ms5607 tcs"):
        read("altos_eeprom__", log.replace(b'"ms5607_tcs": 29059', b'"ms5607_tcs": 2147483647'))
    with pytest.raises(DamagedLog, match="log format 9, TeleGPS,"):
        read("altos_eeprom__", log.replace(b'"log_format": 6', b'"log_format": 9'))


def test_a_garbled_radio_packet_is_not_used() -> None:
    reading, rest = read("altos_telem__telemetrum_2_with_gaps.telem")
    assert Note("7 packets with a bad radio checksum, left out") in rest
    assert DamagedLog in [type(item) for item in rest]
    assert (reading.device, reading.serial) == ("TeleMetrum 2", "2417")
    assert len(reading.clocks) == 2


def test_a_state_in_radio_packets_was_entered_since_the_packet_before() -> None:
    """After apogee packets are a second apart, so the first one with a state is half a second late on average."""
    states, time = np.array([3, 5, 5, 6]), np.array([0.0, 1.0, 9.0, 10.0])
    assert entered(states, time, blind=2.0, in_packets=True)["drogue"] == 9.5
    assert entered(states, time, blind=2.0)["drogue"] == 10.0


def test_two_rockets_on_one_channel_are_two_readings() -> None:
    logs = [(LOGS / f"altos_telem__{name}.telem").read_bytes() for name in ("telemetrum_1", "telemetrum_2_with_gaps")]
    found = parsers()["altos_telem"].read(b"".join(logs))
    assert [item.serial for item in found if isinstance(item, Reading)] == ["209", "2417"]


def other_locale(name: str, separator: str, decimal: str) -> bytes:
    """A sample as saved by a spreadsheet or program with another locale."""
    text = (LOGS / name).read_text(encoding="utf-8")
    return text.replace(",", "\0").replace(".", decimal).replace("\0", separator).encode()


@pytest.mark.parametrize(("separator", "decimal"), [(";", ","), ("\t", "."), ("\t", ",")])
def test_separators_may_be_those_of_another_locale(separator: str, decimal: str) -> None:
    name = "altos_csv__a_barometer_alone.csv"
    log = other_locale(name, separator, decimal)
    assert claims(log) == ["altos_csv"]
    assert heights(read(name, log)[0].clocks[0]) == pytest.approx(heights(read(name)[0].clocks[0]))


def test_a_comma_that_may_separate_cells_or_decimals_is_refused() -> None:
    name = "altos_csv__a_barometer_alone.csv"
    with pytest.raises(DamagedLog, match="commas both between cells and in decimals"):
        read(name, other_locale(name, ",", ","))


def test_the_csv_and_the_flash_of_one_flight_are_one_flight() -> None:
    names = ("altos_csv__with_satellites.csv", "altos_eeprom__telemetrum_2_old_form.eeprom")
    first, second = read_together([(name, (LOGS / name).read_bytes()) for name in names], any_motor)
    (flight,) = first.flights
    assert not second.flights
    assert "belongs to the flight of altos_csv__with_satellites.csv" in second.notes[0]
    assert (flight.extra["serial"], flight.extra["flight"], flight.extra["device"]) == ("2417", "3", "TeleMetrum-v2.0")
    elsewhere = read_together([(f"{i}/{name}", (LOGS / name).read_bytes()) for i, name in enumerate(names)], any_motor)
    assert [len(imported.flights) for imported in elsewhere] == [1, 1]


def test_the_old_form_of_a_telemini_1_has_pressures_of_the_letter_p() -> None:
    whole, _ = read("altos_eeprom__telemini_1.eeprom")
    body = (LOGS / "altos_eeprom__telemini_1.eeprom").read_text().partition("\n}\n")[2]
    flight, *words = np.frombuffer(bytes.fromhex(body), "<u2").tolist()
    records, tick, state = [f"F {0:4x} {0:4x} {flight:4x}"], 0, 0
    for word in words[: words.index(0xFFFF) if 0xFFFF in words else None]:
        if word >= 0x8000:
            state = word & 0x7FFF
            records.append(f"S {tick:4x} {state:4x} {0:4x}")
        else:
            records.append(f"P {tick:4x} {0:4x} {word:4x}")
            tick += 100 if state >= 6 else 10
    for form in ("log-format 2\n", ""):
        log = "Config version: 1.3\n" + form + "serial-number 2417\n" + "\n".join(records) + "\n"
        old, _ = read("altos_eeprom__", log.encode())
        np.testing.assert_allclose(old.clocks[0].time, whole.clocks[0].time, atol=1e-6)
        np.testing.assert_array_equal(old.clocks[0].pressure, whole.clocks[0].pressure)
        assert old.clocks[0].acceleration is None
        assert old.events == pytest.approx(whole.events)


def test_settings_may_be_on_one_line() -> None:
    log = (LOGS / "altos_eeprom__easymini.eeprom").read_bytes()
    settings, mark, body = log.partition(b"\n}\n")
    one, _ = read("altos_eeprom__", log)
    other, _ = read("altos_eeprom__", settings.replace(b"\n", b" ") + mark + body)
    assert (other.device, other.firmware, other.serial) == (one.device, one.firmware, one.serial)
    assert other.firmware


def test_the_last_line_of_flash_may_be_shorter() -> None:
    log = (LOGS / "altos_eeprom__telemetrum_2_with_damage.eeprom").read_bytes()
    settings, mark, body = log.partition(b"\n}\n")
    lines = [line for line in body.splitlines() if b"zz" not in line and not line.startswith(b"ff")]
    lines = lines[: len(lines) // 2 * 2 - 1]
    rows = [b" ".join(lines[place : place + 2]) for place in range(0, len(lines), 2)]
    whole, rest = read("altos_eeprom__", settings + mark + b"\n".join([*lines, b""]))
    wide, more = read("altos_eeprom__", settings + mark + b"\n".join([*rows, b""]))
    assert len(rows[-1]) < len(rows[0])
    assert more == rest
    np.testing.assert_array_equal(wide.clocks[0].time, whole.clocks[0].time)


@pytest.mark.parametrize(("setting", "highest"), [("", 500), ("altitude-32 1\n", 500 + (7 << 16))])
def test_altitudes_of_older_firmware_have_two_bytes(setting: str, highest: int) -> None:
    log = (LOGS / "altos_eeprom__telemetrum_2_old_form.eeprom").read_text()
    other = re.sub(r"(?m)^(P .*) 00 00$", r"\1 07 00", log).replace("log-format 7\n", "log-format 7\n" + setting)
    assert other.count(" 07 00\n") == 5
    altitude = read("altos_eeprom__", other.encode())[0].clocks[1].gps_altitude_msl
    assert altitude is not None
    assert abs(altitude.max() - highest) < 200


def twins(number: int, begin: float) -> tuple[bytes, bytes]:
    """The flash of a device with this log format, from a time on, and the table that Altus Metrum's program makes of
    it: heights above the pressure on the pad that the record of the flight holds."""
    layout, seen, pad = LAYOUTS[number], flight().between(begin, 25.0, 0.05), air(np.array([PAD]))[0]
    counts = raw_pressure(seen.pressure + noise(21, len(seen.time), 2.0))
    gravities = np.round(PLUS + 2 + seen.acceleration / GRAVITY * (PLUS - MINUS) / 2)
    place = layout.acceleration or 0

    def sample(i: int) -> bytes:
        if not layout.acceleration:
            return little(counts[i], 3) + little(WARM, 3)
        return (little(counts[i], 4) + little(WARM, 4)).ljust(place, b"\0") + little(gravities[i], 2)

    records = logged(seen, layout.size, lambda: little(3, 2) + little(PLUS + 2, 2) + little(pad, 4), sample, 500)
    pressure = ms5607(counts, np.full(len(counts), WARM), Coefficients(*SENSOR))[0]
    height = pressure_height(pressure) - pressure_height(np.array([np.floor(pad)]))
    net = (gravities - PLUS - 2) / ((PLUS - MINUS) / 2) * GRAVITY
    names = "#version,serial,flight,time,state,state_name,acceleration,pressure,height"
    rows = [
        f"6,2417,3,{time:.2f},{int(state)},state,{felt:.3f},{p:.0f},{h:.3f}"
        for time, state, felt, p, h in zip(seen.time, seen.state, net, pressure, height, strict=True)
    ]
    if not layout.acceleration:
        names = names.replace("acceleration,", "")
        rows = [",".join((*row.split(",")[:6], *row.split(",")[7:])) for row in rows]
    return text([*settings(number), *flash(records)]), text([names, *rows])


@pytest.mark.parametrize("begin", [-1.0, -0.05, 0.3])
@pytest.mark.parametrize("number", LAYOUTS.keys() - {1})
def test_the_flash_gives_the_figures_of_its_table_also_if_it_begins_in_the_boost(number: int, begin: float) -> None:
    flash_of, table_of = twins(number, begin)
    one, other = (read_together([("a", log)], any_motor)[0].recorded[0] for log in (flash_of, table_of))
    assert one is not None
    assert other is not None
    assert one.figures.keys() == other.figures.keys() >= {"apogee", "descent_speed"}
    for name, figure in one.figures.items():
        assert figure.value == pytest.approx(other.figures[name].value, abs=figure.sd, rel=0.002)
    assert one.figures["apogee"].value == pytest.approx(flight().apogee, abs=2.5)


def test_every_recorded_flash_gives_the_figures_of_its_table() -> None:
    """Of the real recordings, those with the same name and both endings, if there are any beside the checkout."""
    for file in RECORDINGS.glob("*.eeprom") if RECORDINGS.is_dir() else ():
        table = next((one for one in RECORDINGS.glob(f"*{file.stem.partition('__')[2]}.csv")), None)
        if table is None:
            continue
        logs = [(one.name, one.read_bytes()) for one in (file, table)]
        one, other = (read_together([log], any_motor)[0].recorded[0] for log in logs)
        assert one is not None
        assert other is not None
        for name in one.figures.keys() & other.figures.keys():
            first, second = one.figures[name], other.figures[name]
            assert abs(first.value - second.value) < max(3 * np.hypot(first.sd, second.sd), 0.01 * abs(second.value))


@pytest.mark.parametrize("form", ["Config version: 1.3\n", "Config version: 1.3\nproduct TeleMetrum-v2.0\n"])
def test_the_layout_of_old_records_is_that_of_most_if_no_format_is_stated(form: str) -> None:
    """The first line that looks like a record may be another one: a setting, or a record cut short."""
    name = "altos_eeprom__telemetrum_1_among_commands.eeprom"
    if "2.0" in form:
        name = "altos_eeprom__telemetrum_2_old_form.eeprom"
    whole, _ = read(name)
    lines = (LOGS / name).read_text().rstrip("\0").splitlines()
    rest = [line for line in lines if not re.match("~|> |log-format|Config|product|flight|done", line)]
    log = form + "\n".join(["X 0001 02 03 04 05", *rest, ""])
    old, _ = read("altos_eeprom__", log.encode())
    assert len(old.clocks[0].time) == len(whole.clocks[0].time)


def as_csv(reading: Reading) -> bytes:
    """The export of a flash log by AltOS, with its columns and decimals: heights above the pad's pressure."""
    series = reading.clocks[0]
    assert series.pressure is not None
    above = pressure_height(series.pressure)
    height = series.altitude if series.altitude is not None else above - np.median(above[:10])
    entered_at = sorted((when, STATES[name][0]) for name, when in reading.events.items() if name in STATES)
    state = [max([2, *(number for when, number in entered_at if when <= one)]) for one in series.time.tolist()]
    columns: dict[str, Any] = {
        "version": "5",
        "serial": "1",
        "flight": "1",
        "time": series.time,
        "state": np.array(state, float),
    }
    columns |= {} if series.acceleration is None else {"acceleration": series.acceleration}
    columns |= {"pressure": series.pressure, "altitude": above, "height": height}
    cells = [
        [one] * series.time.size if isinstance(one, str) else [f"{value:.2f}" for value in one.tolist()]
        for one in columns.values()
    ]
    lines = [f"#{','.join(columns)}", *(",".join(row) for row in zip(*cells, strict=True))]
    return ("\n".join(lines) + "\n").encode()


@pytest.mark.parametrize("name", sorted(path.name for path in LOGS.glob("*.eeprom")))
def test_a_flash_log_and_its_export_give_the_same_figures(name: str) -> None:
    log = (LOGS / name).read_bytes()
    reading = next(item for item in parsers()["altos_eeprom"].read(log) if isinstance(item, Reading))
    both = [(name, log), ("export.csv", as_csv(reading))]
    flash_flight, export = (
        next(one for one in read_log(log, file, any_motor).recorded if one is not None) for file, log in both
    )
    every = {**export.figures, **flash_flight.figures}
    for readout, figure in every.items():
        other, own = export.figures.get(readout), flash_flight.figures.get(readout)
        if other is None or own is None:  # rounding in the export decides whether it is known at all
            assert figure.sd > 0.95 * MAX_RELATIVE_SD * figure.value, readout
            continue
        # and whether a lag of the heights shows
        assert other.value == pytest.approx(figure.value, abs=max(figure.sd, 0.01)), readout

"""PerfectFlite: the values in a .pf2 file and in the exports of its program, and the handling of their rows."""

import re
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Reading
from fieldkit.importing.read import read
from fieldkit.importing.recognize import claims, parsers
from fieldkit.units import FOOT
from tests.parsers.recorded import recorded
from tests.samples import any_motor
from tools.samples import one_parachute
from tools.samples.two_parachutes import flight

pytestmark = pytest.mark.fast

LOGS = Path(__file__).parents[2] / "sample_logs"
HEADER = "PerfectFlite Pnut\r\nFirmware: 1.0\r\nSerial Number: 1\r\nApogee: 100' AGL\r\n"
DATA = "Data: (Time, Altitude, Velocity, Temperature (F), Voltage)\r\n"
ROWS = "".join(f"{i * 0.05:.2f}, {i}, -0, 36.28, 4.20\r\n" for i in range(20))


def sample(name: str) -> bytes:
    return (LOGS / name).read_bytes()


def pf2(log: str | bytes) -> tuple[Reading, list[Parsed]]:
    first, *rest = parsers()["perfectflite"].read(log if isinstance(log, bytes) else log.encode())
    assert isinstance(first, Reading)
    return first, rest


def heights(series: Series) -> np.ndarray:
    assert series.altitude is not None
    return series.altitude


def test_a_real_pnut_log_keeps_its_stated_apogee_beside_its_highest_row() -> None:
    reading, rest = pf2(recorded("perfectflite__pnut_top_shot.pf2"))
    (series,) = reading.clocks
    assert reading.stated == {"apogee": pytest.approx(1009 * FOOT), "site_elevation": pytest.approx(2486 * FOOT)}
    assert (reading.device, reading.firmware, reading.serial) == ("PerfectFlite Pnut", "1.0", "4214")
    assert reading.extra["Flight Number"] == "4"
    assert len(series.time) == 1664
    assert (series.time[0], series.time[-1]) == (0.0, 83.15)
    assert heights(series).max() == pytest.approx(1028 * FOOT)
    assert series.time[heights(series).argmax()] == 10.45
    assert not rest


def test_a_dual_deploy_log_shows_when_its_outputs_fired() -> None:
    reading, rest = pf2(sample("perfectflite__drogue_and_main.pf2"))
    assert reading.events == {"drogue": 5.6, "main": 11.95}
    assert reading.extra["Main Setting"] == "200"
    assert heights(reading.clocks[0]).max() == pytest.approx(flight().apogee, abs=1.0)
    assert not rest


def test_rows_after_a_loss_of_power_are_left_out_and_no_apogee_is_stated() -> None:
    reading, rest = pf2(sample("perfectflite__power_lost_and_celsius.csv"))
    (series,) = reading.clocks
    assert "apogee" not in reading.stated
    assert len(series.time) == 178
    assert heights(series).max() < 200
    assert series.temperature == pytest.approx(np.full(178, 287.36), abs=0.02)
    assert [note.row for note in rest if isinstance(note, Note)] == [190, None]


def test_rows_of_three_cells_are_read_and_only_bad_ones_are_lost() -> None:
    reading, rest = pf2(sample("perfectflite__three_cells_and_a_bad_row.pf2"))
    (series,) = reading.clocks
    assert series.voltage is None
    assert len(series.time) == 485
    assert [str(error) for error in rest if isinstance(error, DamagedLog)] == [
        "row 52, Altitude: found '1o 299', expected a number"
    ]


def test_a_temperature_without_a_unit_is_left_out_rather_than_guessed() -> None:
    reading, _ = pf2(HEADER + DATA.replace(" (F)", "") + ROWS)
    assert reading.clocks[0].temperature is None
    assert reading.clocks[0].altitude is not None


@pytest.mark.parametrize("apogee", ["300 yards AGL", "999999' AGL", "-3' AGL", "1e3' AGL", "nan"])
def test_an_impossible_apogee_is_left_out_and_reported(apogee: str) -> None:
    reading, rest = pf2(HEADER.replace("100' AGL", apogee) + DATA + ROWS)
    assert "apogee" not in reading.stated
    assert any(isinstance(item, Note) and item.text.startswith("Apogee: found") for item in rest)


def test_fewer_rows_than_the_header_promises_are_reported() -> None:
    _, rest = pf2(HEADER + "NumSamps: 30\r\n" + DATA + ROWS)
    assert rest == [Note("found 20 samples, expected 30 as NumSamps says")]


def test_a_header_without_rows_is_a_damaged_log() -> None:
    for log in (HEADER, HEADER + DATA, HEADER + DATA + "x\r\n"):
        with pytest.raises(DamagedLog):
            pf2(log)


@pytest.mark.parametrize(
    ("name", "warmest", "notes"),
    [
        ("commas_and_celsius.csv", 14.3, 1),
        ("tabs.txt", 14.3, 1),
        ("tabs_without_a_header.txt", 14.3, 1),
        ("renamed_by_hand.csv", 14.3, 0),
    ],
)
def test_every_export_has_feet_and_the_unit_of_its_cells(name: str, warmest: float, notes: int) -> None:
    reading, *rest = parsers()["perfectflite_table"].read(sample(f"perfectflite_table__{name}"))
    assert isinstance(reading, Reading)
    (series,) = reading.clocks
    assert heights(series).max() == pytest.approx(flight().apogee, abs=1.0)
    assert series.temperature is not None
    assert series.temperature.max() == pytest.approx(273.15 + warmest, abs=0.06)
    assert len(rest) == notes


def test_a_cell_in_another_unit_than_its_column_loses_its_row() -> None:
    log = sample("perfectflite_table__tabs.txt").replace(b"57.6F\t", b"14.2C\t", 1)
    reading, *rest = parsers()["perfectflite_table"].read(log)
    assert isinstance(reading, Reading)
    assert len(reading.clocks[0].time) == 486
    assert "expected a number with F" in str(rest[0])


def test_heights_renamed_to_meters_are_meters() -> None:
    log = sample("perfectflite_table__renamed_by_hand.csv").replace(b"altitude_ft", b"altitude_m")
    reading = parsers()["perfectflite_table"].read(log)[0]
    assert isinstance(reading, Reading)
    assert heights(reading.clocks[0]).max() == pytest.approx(flight().apogee / FOOT, abs=2)
    with pytest.raises(DamagedLog, match="furlongs"):
        parsers()["perfectflite_table"].read(log.replace(b"altitude_m", b"altitude_furlongs"))


TWO_ROWS = b"""PerfectFlite Pnut
Apogee: 308%s AGL
NumSamps: 2

Data: (Time, Altitude, Velocity, Temperature (F), Voltage)
0.00, 0, 0, 70.0, 3.9
0.05, 3, 60, 70.0, 3.9
"""


@pytest.mark.parametrize(
    ("apogee", "old", "new", "height", "speed"),
    [
        (b"'", b"", b"", 3 * 0.3048, 60 * 0.3048),
        (b" ft", b"", b"", 3 * 0.3048, 60 * 0.3048),
        (b" m", b"", b"", 3.0, 60.0),
        (b"m", b"", b"", 3.0, 60.0),
        (b"'", b"Altitude, Velocity", b"Altitude (m), Velocity (m/s)", 3.0, 60.0),
        (b"'", b"Altitude, Velocity", b"Altitude (ft), Velocity (ft/s)", 3 * 0.3048, 60 * 0.3048),
    ],
)
def test_heights_of_a_pf2_have_the_unit_of_its_apogee_or_of_their_column(
    apogee: bytes, old: bytes, new: bytes, height: float, speed: float
) -> None:
    flight, _ = pf2((TWO_ROWS % apogee).replace(old, new))
    [series] = flight.clocks
    assert series.altitude is not None
    assert series.speed is not None
    assert (series.altitude[1], series.speed[1]) == (pytest.approx(height), pytest.approx(speed))
    assert flight.stated["apogee"] == pytest.approx(308.0 if b"m" in apogee else 308 * 0.3048)


def test_several_files_in_a_row_are_flights_with_their_own_figures() -> None:
    bad = ROWS.replace("0.50, 10,", "0.50, x,")
    log = HEADER + DATA + ROWS + HEADER.replace("100'", "200'").replace("Number: 1", "Number: 2") + DATA + bad
    found = parsers()["perfectflite"].read(log.encode())
    flights = [item for item in found if isinstance(item, Reading)]
    assert [(one.stated["apogee"], one.serial) for one in flights] == [(100 * FOOT, "1"), (200 * FOOT, "2")]
    assert [len(one.clocks[0].time) for one in flights] == [20, 19]
    assert [item.row for item in found if isinstance(item, DamagedLog)] == [1 + log[: log.index("x,")].count("\n")]


def test_a_mawd_writes_heights_from_10000_ft_with_five_digits() -> None:
    log = sample("mawd__all_it_answers.txt").decode().replace("\r", "")
    head, mark, rows = log.partition("Sample interval is  50 ms")
    taller = re.sub(r"(?m)^ (\d{4})$", lambda row: f"{int(row[1]) * 20:04d}".rjust(5), rows)
    heights = []
    for text in (log, head + mark + taller):
        (reading,) = parsers()["mawd"].read(text.encode())
        assert isinstance(reading, Reading)
        assert reading.clocks[0].altitude is not None
        heights.append(reading.clocks[0].altitude)
    above = heights[0] > 0
    assert heights[1].max() > 20_000 * FOOT
    np.testing.assert_allclose(heights[1][above], 20 * heights[0][above])


@pytest.mark.parametrize(
    ("title", "row"),
    [
        ("PerfectFlite StratoLoggerCF flight 3", "{t:.2f},{ft:.0f},{fps:.0f},{f:.1f}F,9.1V"),
        ("Saturday, third flight", "{t:.2f}\t{ft:.0f}\t{f:.1f}F\t9.1V"),
        ("Swift on a Stratologger", "{t:.2f}\t{ft:.0f}\t{fps:.0f}\t{f:.1f}\t9.1"),
        ("PerfectFlite Pnut\nFirmware: 1.3\nFlight Number: 2", "{t:.2f},{ft:.0f},{fps:.0f},{f:.1f},4.1"),
    ],
)
def test_an_export_may_have_titles_and_no_names(title: str, row: str) -> None:
    made = one_parachute.flight()
    times = np.arange(0.0, made.time[-1], 0.05)
    feet, speeds = (made.at(times, values) / FOOT for values in (made.height, made.speed))
    rows = [row.format(t=t, ft=h, fps=v, f=68.0) for t, h, v in zip(times, feet, speeds, strict=True)]
    log = "\n".join([title, *rows, ""]).encode()
    imported = read(log, "log.csv", any_motor)
    assert imported.format == "perfectflite_table"
    assert imported.flights[0].apogee == pytest.approx(made.apogee, rel=0.01)


def test_numbers_below_a_title_without_the_maker_s_name_are_not_its_export() -> None:
    rows = "".join(f"{i / 20:.2f},{min(i, 90)},{i % 7},68.0,9.1\n" for i in range(200))
    assert claims(f"Saturday\n{rows}".encode()) == []

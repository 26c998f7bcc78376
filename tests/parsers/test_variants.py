"""Variants of exports by program version, country, and the spreadsheet that saved them.

Each is made from a sample log or a small flight, following the notes on formats about real files.
"""

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Reading
from fieldkit.importing.recognize import claims, parser_for, parsers
from fieldkit.physics.standard_atmosphere import GRAVITY, pressure_height
from fieldkit.units import FOOT
from tests.samples import SAMPLES, owner
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, table

MADE = flight()
TIME = np.arange(-2, MADE.time[-1], 0.05)
HEIGHT, SPEED, FELT = (MADE.at(TIME, values) for values in (MADE.height, MADE.speed, MADE.felt))
PASCAL = MADE.pressure(HEIGHT)
UNIX = [f"{1_700_000_000 + time:.3f}".replace(".", "") + "000000" for time in TIME]
STILL = cells(np.full(len(TIME), 0.02), ".2f")


def text(name: str) -> str:
    (sample,) = (one for one in SAMPLES if one.name.startswith(name))
    return sample.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")


def quoted(log: str) -> str:
    """Lines as saved by a spreadsheet if some contain commas: those in quotation marks, and all padded to the
    widest."""
    rows = [line.split(",") if re.match(r"-?[\d.]+,", line) else [line] for line in log.splitlines()]
    rows = [[f'"{cell}"' if ", " in cell else cell.strip() for cell in row] for row in rows]
    return "\r\n".join(",".join(row + [""] * (5 - len(row))) for row in rows) + "\r\n"


def in_quotes(log: str) -> str:
    """A table as saved by a spreadsheet with every cell in quotation marks, and comments padded to the width of the
    rows."""
    rows = [[line] if "Event" in line else line.split(",") for line in log.splitlines()]
    rows = [row + [""] * (max(map(len, rows)) - len(row)) for row in rows]
    return "\n".join(",".join(f'"{cell}"' for cell in row) for row in rows) + "\n"


def parted(log: str, separator: str) -> str:
    """A table with decimal commas."""
    return re.sub(r"(?<=\d)\.(?=\d)", "\0", log).replace(",", separator).replace("\0", ",")


MPD, MAWD, ROCKET = text("micropeak__a_small"), text("mawd__all"), text("openrocket__as_it_comes")
MAPPED = text("mapped_table__time_three_axes")
LIVE = text("stratologger_telemetry")
TRS = text("eggtimer__classic")
USB, SENTENCES = text("blueraven_usb"), text("bdureau__two_flights")
PF2, EXPORT = text("perfectflite__drogue_and_main"), text("perfectflite_table__commas_and_celsius")
ALTOS, RRC3, ARTS2 = text("altos_csv__with_satellites"), text("rrc3__feet_and_commas"), text("arts2__interpreted")
RAVEN, EEPROM = text("blueraven_app__low_rate"), text("altos_eeprom__easymini")
SETTINGS, FLASH = EEPROM[: EEPROM.index("}") + 1], EEPROM[EEPROM.index("}") + 1 :]
VARIANTS: Sequence[tuple[str, str, bytes, bytes]] = [
    ("a pf2 as a spreadsheet saves it", "perfectflite", PF2.encode(), quoted(PF2).encode()),
    ("a pf2 with a mark before it", "perfectflite", PF2.encode(), PF2.encode("utf-8-sig")),
    ("a pf2 whose columns are in no brackets", "perfectflite", PF2.encode(),
        re.sub(r"(?m)^Data: \((.*)\)$", r"Data: \1", PF2).encode()),
    ("an export with tabs and decimal commas", "perfectflite_table", EXPORT.encode(), parted(EXPORT, "\t").encode()),
    ("an export with semicolons and no header", "perfectflite_table", EXPORT.encode(),
        parted(EXPORT.partition("\n")[2], ";").encode()),
    ("AltOS without padding", "altos_csv", ALTOS.encode(), re.sub(r" *, *", ",", ALTOS).encode("utf-8-sig")),
    ("AltOS without its mark", "altos_csv", ALTOS.encode(), ALTOS.replace("#version", "version").encode()),
    ("an RRC3 row with a comma more", "rrc3", RRC3.encode(), RRC3.replace("\n", ",\n").encode()),
    ("an RRC3 in capitals below a title", "rrc3", RRC3.encode(),
        ("Flight 3\n" + RRC3.replace("Time,Altitude", "TIME,ALTITUDE")).encode()),
    ("an RRC3 in UTF-16 behind a mark of UTF-8", "rrc3", RRC3.encode(), b"\xef\xbb\xbf" + RRC3.encode("utf-16")),
    ("an RRC3 in UTF-16 with two marks", "rrc3", RRC3.encode(), ("\ufeff" + RRC3).encode("utf-16")),
    ("an ARTS2 with tabs", "arts2", ARTS2.encode(), ARTS2.replace(" ", "\t").encode()),
    ("an ARTS2 with commas and no mark", "arts2", ARTS2.encode(),
        ARTS2.replace("# ", "").replace(" ", ",").encode()),
    ("a Blue Raven flight twice, header and all", "blueraven_app", RAVEN.encode(), (RAVEN + RAVEN).encode()),
    ("a Blue Raven whose times a spreadsheet cut", "blueraven_app", RAVEN.encode(),
        re.sub(r"\d\d:(\d\d:\d\d\.\d)\d\d", r"\1", RAVEN).encode("utf-8-sig")),
    ("an .eeprom with its settings on one line", "altos_eeprom", EEPROM.encode(),
        (" ".join(SETTINGS.split()) + FLASH).encode()),
    ("an .eeprom with a mark before it", "altos_eeprom", EEPROM.encode(), EEPROM.encode("utf-8-sig")),
    ("an .eeprom in UTF-16", "altos_eeprom", EEPROM.encode(), EEPROM.encode("utf-16")),
    ("sentences in UTF-16", "bdureau", SENTENCES.encode(), SENTENCES.encode("utf-16")),
    ("frames in UTF-16", "blueraven_usb", USB.encode(), USB.encode("utf-16")),
    ("an Eggtimer with a mark before it", "eggtimer", TRS.encode(), TRS.encode("utf-8-sig")),
    ("AltOS in quotation marks", "altos_csv", ALTOS.encode(),
        re.sub(r"[^,\n]+", r'"\g<0>"', ALTOS[ALTOS.index("#version") :]).encode()),
    ("AltOS below a title", "altos_csv", ALTOS.encode(), b"Saturday\n\n" + ALTOS.encode()),
    ("a pf2 with semicolons", "perfectflite", PF2.encode(), PF2.replace(",", ";").encode()),
    ("a table whose lines end twice", "mapped_table", MAPPED.encode(), MAPPED.replace("\n", "\r\r\n").encode()),
    ("a table with every other line blank", "mapped_table", MAPPED.encode(), MAPPED.replace("\n", "\n\n").encode()),
    ("an .mpd in UTF-16", "micropeak", MPD.encode("latin-1"), MPD.encode("utf-16")),
    ("a MAWD whose lines end in a carriage return", "mawd", MAWD.encode(), MAWD.replace("\n", "\r").encode()),
    ("a MAWD below sea level", "mawd", MAWD.encode(), MAWD.replace("G00812", "G-0043").encode()),
    ("a MAWD asked twice", "mawd", MAWD.encode(), (MAWD + MAWD[MAWD.index("Sample interval") :]).encode()),
    ("live telemetry with decimal commas", "stratologger_telemetry", LIVE.encode(), parted(LIVE, ";").encode()),
    ("an OpenRocket export in quotation marks", "openrocket", ROCKET.encode(), in_quotes(ROCKET).encode()),
    ("an .eeprom in capitals", "altos_eeprom", EEPROM.encode(), (SETTINGS + FLASH.upper()).encode()),
]  # fmt: skip


@pytest.mark.parametrize(("parser", "plain", "variant"), [v[1:] for v in VARIANTS], ids=[v[0] for v in VARIANTS])
def test_a_variant_has_the_samples_of_the_plain_log(parser: str, plain: bytes, variant: bytes) -> None:
    assert claims(variant) == [parser]
    expected, got = (
        [clock for one in parser_for(log).read(log) if isinstance(one, Reading) for clock in one.clocks]
        for log in (plain, variant)
    )
    assert len(expected) == len(got) >= 1
    for one, other in zip(expected, got, strict=True):
        for channel in one.__slots__:
            np.testing.assert_array_equal(getattr(other, channel), getattr(one, channel), channel)


def saved(log: str, separator: str, decimal: str) -> bytes:
    """A table as saved by a spreadsheet: a byte order mark, all rows padded to the widest, numbers as short as
    possible."""
    parted = max(",;\t", key=log.splitlines()[-2].count)
    rows = [[shortest(cell, decimal) for cell in row] for row in csv.reader(io.StringIO(log), delimiter=parted)]
    rows = [row + [""] * (max(map(len, rows)) - len(row)) for row in rows]
    written = io.StringIO()
    csv.writer(written, delimiter=separator).writerows([*rows, [""] * len(rows[-1]), [""] * 4])
    return written.getvalue().encode("utf-8-sig")


def shortest(cell: str, decimal: str) -> str:
    match = re.fullmatch(r"\s*(-?[\d:]*)[.,](\d*?)0*(e-?\d+)?([CFV]?)\s*", cell, re.IGNORECASE)
    if not match:
        return cell
    fraction = decimal + match[2] if match[2] else ""
    return (match[1] if match[1].strip("-") else match[1] + "0") + fraction + (match[3] or "") + match[4]


TABULAR = [
    *("aim_xtra", "altimetercloud", "altos_csv", "blueraven_app", "cats", "eggtimer", "featherweight_gps"),
    *("micropeak_csv", "perfectflite_table", "rasaero", "raven_fip", "rocksim", "rrc3", "stratologger_telemetry"),
]


@pytest.mark.sampled
@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
@pytest.mark.parametrize("sample", [one for one in SAMPLES if owner(one) in TABULAR], ids=lambda one: one.name)
def test_a_table_saved_by_a_spreadsheet_has_the_samples_of_the_log(sample: Path, separator: str, decimal: str) -> None:
    log, name = sample.read_bytes(), owner(sample)
    again = saved(log.decode("utf-16" if log[1:2] == b"\xfe" else "utf-8-sig"), separator, decimal)
    assert claims(again) == [name]
    expected, got = (
        [clock for one in parsers()[name].read(one) if isinstance(one, Reading) for clock in one.clocks]
        for one in (log, again)
    )
    assert len(expected) == len(got) >= 1
    for one, other in zip(expected, got, strict=True):
        for channel in one.__slots__:
            values = getattr(other, channel), getattr(one, channel)
            assert (values[0] is None) == (values[1] is None), channel
            if values[0] is not None:
                np.testing.assert_allclose(*values, rtol=1e-9, atol=1e-9, err_msg=channel)


def other_rows(values: list[str], odd: bool) -> list[str]:
    """Cells of a sensor that alternates with another one, row by row."""
    return [value if number % 2 == odd else "" for number, value in enumerate(values)]


METRES, FEET, GRAVITIES = cells(HEIGHT, ".3f"), cells(HEIGHT / FOOT, ".0f"), cells(FELT / GRAVITY, ".3f")
CLOCK = [f"12:{3 + int(time + 2) // 60:02d}:{(time + 2) % 60:06.3f}" for time in TIME]
SINCE = cells(TIME + 2, ".3f")
TABLES: Sequence[tuple[str, Sequence[Sequence[str]], str]] = [
    ("Time (sec),X (g),Y (g),Z (g),Total (g),Altitude (feet)", [SINCE, STILL, GRAVITIES, STILL, GRAVITIES, FEET],
        "altitude"),
    ("Time (s),Altitude (ft),Time (s),X (g),Y (g),Z (g)", [SINCE, FEET, SINCE, STILL, GRAVITIES, STILL], "altitude"),
    ("time(ms),altitude (meters)", [cells((TIME + 2) * 1000, ".0f"), METRES], "altitude"),
    ("Date Time,Altitude (m)", [[f"2023-06-24 {clock}" for clock in CLOCK], METRES], "altitude"),
    ("Date,Time,Altitude (m)", [["2023-06-24"] * len(TIME), CLOCK, METRES], "altitude"),
    ("timestamp,altitude_m", [[f"2023-06-24T{clock}Z" for clock in CLOCK], METRES], "altitude"),
    ("time,alt,pres\ns,m,Pa", [SINCE, METRES, cells(PASCAL, ".0f")], "altitude"),
    ("Logger: Foo\nRate (Hz): 20\n\ntime_s,alt_agl_ft", [SINCE, FEET], "altitude"),
    ("Time since launch (s),Height above ground (m)", [SINCE, METRES], "altitude"),
    ("time[ms],p[Pa],T[degC],h[m]", [cells((TIME + 2) * 1000, ".0f"), cells(PASCAL, ".0f"), STILL, METRES], "altitude"),
    ("seconds,alt_ft", [SINCE, FEET], "altitude"),
    ("Время (с),Высота (м)", [SINCE, METRES], "altitude"),
    ("Time (s),Altitude AGL (m),Altitude ASL", [SINCE, METRES, cells(HEIGHT + 300, ".3f")], "altitude"),
    ("t (s),X (hPa)", [SINCE, cells(PASCAL / 100, ".4f")], "pressure"),
    ("time,Pressure (hPa)", [[clock.replace(".", ":") for clock in CLOCK], cells(PASCAL / 100, ".4f")], "pressure"),
    ("Time,Altitude (ft)", [[f"{clock} PM" for clock in CLOCK], FEET], "altitude"),
    ("datetime,altitude_ft", [[f"2024-05-04T{clock}-05:00" for clock in CLOCK], FEET], "altitude"),
    ("t,p_kPa", [SINCE, cells(PASCAL / 1000, ".4f")], "pressure"),
    ("time_s,alt_m", [SINCE[::-1], METRES[::-1]], "altitude"),
    ("Time (s),Altitude (ft),Baro Alt (ft)", [SINCE, cells(HEIGHT * 4, ".1f"), FEET], "altitude"),
    ("UTC,Lat,Alt (m)", [CLOCK, STILL, METRES], "altitude"),
    ("Time (s),Accel Altitude (ft),Accel Velocity (ft/s),Baro Velocity (ft/s),Baro (ft)",
        [SINCE, cells(HEIGHT * 4, ".1f"), STILL, cells(SPEED / FOOT, ".1f"), FEET], "altitude"),
    ('Flight,12\n"Top Speed","98 mph"\n\n"Time (s)","Altitude (ft)"', [SINCE, FEET], "altitude"),
    ("Time,Alt\n# logging started", [SINCE, METRES], "altitude"),
    ("roll_deg_sec,time_s,alt_m", [STILL, SINCE, METRES], "altitude"),
    ("state,timestamp,scaledAccelX,scaledAccelY,scaledAccelZ,estPressureAlt,estLinearAccelX",
        [["S"] * len(TIME), UNIX, other_rows(GRAVITIES, False), other_rows(STILL, False), other_rows(STILL, False),
         other_rows(cells(HEIGHT + 300, ".3f"), True), other_rows(cells(FELT, ".3f"), True)], "altitude_msl"),
    ("timestamp,scaledAccelX,estPressureAlt,current_altitude,vertical_velocity,predicted_apogee",
        [UNIX, other_rows(GRAVITIES, False), other_rows(cells(HEIGHT + 300, ".3f"), True), other_rows(METRES, True),
         other_rows(cells(SPEED, ".3f"), True), [""] * len(TIME)], "altitude"),
]  # fmt: skip


@pytest.mark.parametrize(("header", "columns", "channel"), TABLES, ids=[header for header, *_ in TABLES])
def test_heights_of_an_unknown_table_are_read_in_meters(
    header: str, columns: Sequence[Sequence[str]], channel: str
) -> None:
    log = table(header, columns)
    assert claims(log) == ["mapped_table"]
    (reading,) = (one for one in parser_for(log).read(log) if isinstance(one, Reading))
    heights = next(values for clock in reading.clocks if (values := getattr(clock, channel)) is not None)
    if channel == "pressure":
        heights = pressure_height(heights)
    assert np.nanmax(heights) - np.nanmin(heights) == pytest.approx(MADE.apogee, abs=0.5)
    assert np.ptp(reading.clocks[0].time) == pytest.approx(np.ptp(TIME), abs=0.1)


@pytest.mark.parametrize("name", ["rocksim", "rasaero"])
@pytest.mark.parametrize("above", ["sep=,\n", "Astra, take 2\n\n"])
def test_a_simulation_below_a_title_is_not_a_flight(name: str, above: str) -> None:
    log = (above + text(name)).encode()
    assert claims(log) == [name]
    assert [one.describes for one in parser_for(log).read(log) if isinstance(one, Reading)] == ["simulation"]


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_summary_saved_by_a_spreadsheet_states_the_same(separator: str) -> None:
    plain = text("blueraven_summary")
    variant = "".join(separator.join((*line.split(",", 1), "", "\r\n")) for line in plain.splitlines())
    assert claims(variant.encode()) == ["blueraven_summary"]
    one, other = (parsers()["blueraven_summary"].read(log.encode())[0] for log in (plain, variant))
    assert one == other


def test_a_header_of_version_5_is_still_wrong_if_a_spreadsheet_padded_its_rows() -> None:
    """It names 74 columns but its rows have 70 cells: names after main_voltage are not above their cells."""
    for name in ("altos_csv__version_5_with_a_comma", "altos_csv__version_5_with_cells"):
        log = saved(text(name), ",", ".")
        (reading,) = (one for one in parser_for(log).read(log) if isinstance(one, Reading))
        assert reading.clocks[0].latitude is None
        assert reading.clocks[0].gps_altitude_msl is None


def test_a_truncated_row_does_not_restore_heights_from_after_the_loss_of_power() -> None:
    log = text("perfectflite__power_lost").encode().rstrip()
    whole, torn = (len(parsers()["perfectflite"].read(one)[0].clocks[0].time) for one in (log, log[:-7]))
    assert whole == torn


@pytest.mark.parametrize(("cut", "remaining"), [(0, 0), (1, 1), (2, 1)])
def test_a_last_cell_truncated_within_its_digits_is_not_a_number(cut: int, remaining: int) -> None:
    """A file that ends without a line ending may be complete, but missing digits there cannot be restored."""
    rows = [f"{number / 20:.2f},{number % 40 + 0.25:.2f}" for number in range(200)]
    log = ("time (s),altitude (m)\n" + "\n".join(rows)).encode()
    items = parsers()["mapped_table"].read(log[: len(log) - cut])
    (reading,) = (one for one in items if isinstance(one, Reading))
    assert len(reading.clocks[0].time) == 200 - remaining
    assert sum("cut off" in getattr(one, "text", "") for one in items) == remaining


def test_a_table_with_a_date_and_readouts_is_a_table_of_flights() -> None:
    assert claims(b"date_time,apogee,notes\n2026-05-02 11:04,923ft,windy\n") == ["flight_table"]


def test_a_damaged_start_of_live_telemetry_is_reported_with_its_row() -> None:
    title, began, rest = LIVE.split("\n", 2)
    log = "\n".join([title, "device,stratologger", "", began.replace("2026", "noon"), rest])
    (damage,) = [one for one in parsers()["stratologger_telemetry"].read(log.encode()) if isinstance(one, DamagedLog)]
    assert damage.row == 4

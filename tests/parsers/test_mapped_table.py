"""Tables that no parser of a logger recognizes: names, units, physics, and the flyer's mapping."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import BadValue, DamagedLog, FieldkitError, UnknownFormat
from fieldkit.flight import Series
from fieldkit.importing import Mapped, Note, Reading
from fieldkit.importing.read import read
from fieldkit.importing.reading import ColumnChoice
from fieldkit.importing.recognize import claims, open_log, parsers
from fieldkit.importing.tables import mapping
from fieldkit.importing.tables.headings import channel, heading, stated_unit
from fieldkit.importing.tables.mapping import read_choice, remember, remembered
from fieldkit.paths import LOCK_NAME
from fieldkit.services.imports.mappings import columns_of
from tests.commands import Run
from tests.parsers.recorded import recorded
from tests.samples import any_motor

FOOT = 0.3048


def climb(step: float = 0.05) -> list[tuple[float, float, float]]:
    """Seconds, meters and meters per second of a flight to 254 m, down by parachute."""
    rows = []
    for i in range(int(30 / step)):
        t = i * step
        if t < 1:
            rows.append((t, 35 * t * t, 70 * t))
        elif t < 8.14:
            rows.append((t, 35 + 70 * (t - 1) - 4.9 * (t - 1) ** 2, 70 - 9.8 * (t - 1)))
        else:
            rows.append((t, max(285 - 10 * (t - 8.14), 0.0), -10.0))
    return rows


def table(header: str, row: str, step: float = 0.05) -> bytes:
    """A table of that flight; `row` names t, h, v, p in SI, and a `low` height."""
    lines = [
        row.format(t=t, ms=t * 1000, h=h, ft=h / FOOT, low=0.98 * h, v=v, p=101325 * (1 - h / 44330.77) ** 5.25588)
        for t, h, v in climb(step)
    ]
    return "\n".join([header, *lines, ""]).encode()


def found(log: bytes, *choices: ColumnChoice) -> tuple[list[Series], str]:
    """The series of a log, and the line on how it was read."""
    parser = parsers()["mapped_table"]
    assert parser.mapped is not None
    items = parser.mapped(log, choices)
    (line,) = (item.text for item in items if isinstance(item, Mapped))
    return [series for item in items if isinstance(item, Reading) for series in item.clocks], line


def top(series: Series) -> float:
    """The highest sample. [m]"""
    assert series.altitude is not None
    return float(np.nanmax(series.altitude))


HEADERS = [
    ("t(s)", "time", "s"),
    ("time_ms", "time", "ms"),
    ("timestamp_seconds", "time", "seconds"),
    ("timeMs", "time", "ms"),
    ("Time (µs)", "time", "µs"),
    ("Alt (ft)", "altitude", "ft"),
    ("altitude[m]", "altitude", "m"),
    ("Altitude Feet", "altitude", "feet"),
    ("Altitude (AGL) [m]", "altitude", "m"),
    ("GPS altitude (m)", "gps_altitude_msl", "m"),
    ("alt_msl_ft", "altitude_msl", "ft"),
    ("pressure_pascals", "pressure", "pascals"),
    ("velocity[m/s]", "speed", "m/s"),
    ("Velocity Feet / Sec", "speed", "feet/sec"),
    ("raw_acceleration_x_gs", "felt_x", "gs"),
    ("Total Accel (g)", "felt_total", "g"),
    ("Vertical acceleration (m/s²)", "acceleration", "m/s²"),
    ("temperature_celsius", "temperature", "celsius"),
    ("latitude", "latitude", "deg"),
    ("Altitude (feet AGL)", "altitude", "feet"),
    ("Height (m above ground)", "altitude", "m"),
    ("Altitude (ft MSL)", "altitude_msl", "ft"),
    ("Altitude (m above sea level)", "altitude_msl", "m"),
    ("Feet", "altitude", "feet"),
    ("Seconds", "time", "seconds"),
    ("[Altitude (Baro-Ft)]", "altitude", "Ft"),
    ("Altitude (Accel-Ft)", "inertial_altitude", "Ft"),
    ("Alt (m, GPS)", "gps_altitude_msl", "m"),
]


@pytest.mark.parametrize(("spelled", "name", "unit"), HEADERS, ids=[header[0] for header in HEADERS])
def test_a_header_gives_its_channel_and_unit(spelled: str, name: str, unit: str) -> None:
    head = heading(spelled)
    assert (channel(head), stated_unit(head, name)) == (name, unit)


@pytest.mark.parametrize(
    "spelled",
    [
        "predicted_apogee",
        "target altitude (m)",
        "raw_angular_rate_x_deg_per_s",
        "est_position_z_meters",
        "est_velocity_z_meters_per_s",
        "velocity_x (m/s)",
        "wind speed (m/s)",
        "motor pressure (Pa)",
        "Sea level pressure (hPa)",
        "QNH pressure [hPa]",
        "update_timestamp_ns",
        "Note",
        "",
        "\u200b",
    ],
)
def test_a_header_of_another_quantity_is_not_a_channel(spelled: str) -> None:
    assert channel(heading(spelled)) == ""


@pytest.mark.parametrize("height", ["altitude (m)", "alt", "height_agl (m)"])
def test_heights_of_a_tracker_that_start_at_zero_are_those_of_satellites(height: str) -> None:
    (series,), line = found(table(f"time (s),latitude,longitude,{height}", "{t:.2f},47.1,8.2,{h:.1f}"))
    assert series.gps_altitude_msl is not None
    assert series.altitude is None
    assert "beside a position, and no barometer" in line


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("time (s),latitude,longitude,baro altitude (m)", "{t:.2f},47.1,8.2,{h:.1f}"),
        ("time (s),latitude,longitude,altitude (m),pressure (Pa)", "{t:.2f},47.1,8.2,{h:.1f},{p:.1f}"),
        ("time (s),latitude,longitude,altitude (m),temperature (C)", "{t:.2f},47.1,8.2,{h:.1f},20"),
    ],
)
def test_heights_of_a_barometer_beside_a_position_stay_its_own(header: str, row: str) -> None:
    (series,), _ = found(table(header, row))
    assert series.altitude is not None
    assert series.gps_altitude_msl is None


def test_the_only_heights_of_a_tracker_have_the_unit_that_its_coast_shows_or_it_is_asked_for() -> None:
    log = table("time (s),gps altitude", "{t:.2f},{h:.1f}")
    (series,), _ = found(log)
    assert series.gps_altitude_msl is not None
    with pytest.raises(DamagedLog, match=r"--map 'gps_altitude_msl=#2 \[m\]'"):
        found(b"\n".join(log.split(b"\n")[::40]))


def test_a_sensor_that_starts_late_does_not_hide_the_table() -> None:
    log = table("time_s,altitude_m", "{t:.2f},{h:.2f}").decode().split("\n")
    log[1:6] = [f"{line.partition(',')[0]},NaN" for line in log[1:6]]
    (series,), _ = found("\n".join(log).encode())
    assert top(series) == pytest.approx(285, abs=0.2)


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("time_ms,alt_m", "{ms:.0f},{h:.2f}"),
        ("t (s);Höhe;Alt (ft)", "{t:.2f};x;{ft:.2f}"),
        ("Time,Altitude\ns,m", "{t:.2f},{h:.2f}"),
        ("# time (s), alt (m)", "{t:.2f}, {h:.2f}"),
        ("time_s alt_m", "{t:.2f} {h:.2f}"),
        ("Team Alpha\nserial,12\n\ntime_s,alt_m,state", "{t:.2f},{h:.2f},PAD"),
        ('"time (s)","alt, baro (m)"', '"{t:.2f}","{h:.2f}"'),
    ],
)
def test_units_are_those_of_the_header(header: str, row: str) -> None:
    (series,), _ = found(table(header, row))
    assert top(series) == pytest.approx(285, abs=0.2)
    assert series.time[-1] == pytest.approx(29.95)


def test_a_comma_is_a_decimal_comma_if_semicolons_separate_the_cells() -> None:
    log = table("t (s);alt (m)", "{t:.2f};{h:.2f}").replace(b".", b",")
    (series,), _ = found(log)
    assert top(series) == pytest.approx(285, abs=0.2)


def test_numbers_that_may_be_thousands_are_refused() -> None:
    log = b"t (ms);alt (m)\n" + b"".join(b"%d,%03d;1,%03d\n" % (i + 1, 500, i) for i in range(20))
    with pytest.raises(DamagedLog, match="found '1,500', which may be '1500' or a decimal comma"):
        found(log)


@pytest.mark.parametrize(
    ("row", "unit", "why"),
    [
        ("{t:.2f},{h:.1f}", "m", "the coast"),
        ("{t:.2f},{ft:.1f}", "ft", "free fall"),
        ("{t:.2f},{ft:.1f},{p:.1f}", "ft", "the pressure"),
        ("{t:.2f},{h:.1f},{p:.1f}", "m", "the pressure"),
        ("{ms:.0f},{ft:.1f},{p:.1f}", "ft", "the pressure"),
    ],
)
def test_physics_determines_the_unit_of_a_height_without_one(row: str, unit: str, why: str) -> None:
    header = "time,alt" + ",press" * row.count("{p")
    (series,), line = found(table(header, row))
    assert top(series) == pytest.approx(285, abs=0.2)
    assert series.time[-1] == pytest.approx(29.95)
    assert f"'alt' in {unit} (by {why}" in line


def test_a_speed_determines_the_other_units() -> None:
    (series,), line = found(table("t,alt,vel (m/s)", "{t:.2f},{h:.1f},{v:.1f}"))
    assert top(series) == pytest.approx(285, abs=0.2)
    assert "speed and height" in line


def test_a_unit_that_nothing_determines_is_asked_for() -> None:
    descent = b"t (s),alt\n" + b"".join(b"%d,%d\n" % (i, 900 - 3 * i) for i in range(200))
    with pytest.raises(DamagedLog, match=r"expected one of m, .*: write --map 'altitude=#2 \[m\]'"):
        found(descent)
    (series,), line = found(descent, read_choice(["altitude=alt [ft]"]))
    assert series.altitude_msl is not None or top(series) == pytest.approx(900 * FOOT)
    assert "as chosen" in line


def test_the_unit_of_an_ambiguous_pressure_is_asked_for() -> None:
    log = b"t (s),press\n" + b"".join(b"%d,%d\n" % (i, 700 - i) for i in range(60))
    with pytest.raises(DamagedLog, match=r"write --map 'pressure=#2 \[Pa\]'"):
        found(log)


def test_a_stated_unit_that_the_pressure_contradicts_is_refused_unless_mapped_explicitly() -> None:
    log = table("t (s),alt (ft),press (hPa)", "{t:.2f},{h:.1f},{p:.1f}").replace(b"hPa", b"Pa")
    with pytest.raises(DamagedLog, match=r"implies to be in m; write --map 'altitude=#2 \[m\]'"):
        found(log)
    assert top(found(log, read_choice(["altitude=#2 [m]"]))[0][0]) == pytest.approx(285, abs=0.2)
    (insisted,), line = found(log, read_choice(["altitude=#2 [ft]"]))
    assert top(insisted) == pytest.approx(285 * FOOT, abs=0.2)
    assert "in ft (as you chose, although the pressure column implies m)" in line


def test_an_unknown_unit_is_never_mistaken_for_another() -> None:
    with pytest.raises(DamagedLog, match="found the unit 'furlong', expected one of m"):
        found(table("t (s),alt (furlong)", "{t:.2f},{h:.4f}")[:400])


def test_unneeded_columns_without_a_unit_are_left_out_and_reported() -> None:
    (series,), line = found(table("t (s),alt (m),temp", "{t:.2f},{h:.2f},21.5"))
    assert series.temperature is None
    assert "left out, no unit: 'temp'" in line


def test_samples_at_rest_show_whether_an_acceleration_includes_gravity() -> None:
    felt = b"t (s),accel (g),alt (m)\n" + b"".join(
        b"%.2f,%.3f,%d\n" % (i / 20, 1.0 + (i > 400), i // 9) for i in range(900)
    )
    (series,), _ = found(felt)
    assert series.felt is not None
    net = felt.replace(b",1.000,", b",0.000,").replace(b",2.000,", b",0.500,")
    (series,), _ = found(net)
    assert (series.felt, series.acceleration is not None) == (None, True)


@pytest.mark.parametrize(("shift", "channel_name"), [(0.0, "felt"), (-1.0, "acceleration")])
@pytest.mark.parametrize("charge", [0.0, 15.0])
def test_the_coast_shows_the_kind_of_acceleration_of_a_log_that_begins_in_flight(
    shift: float, channel_name: str, charge: float
) -> None:
    rising = [(t, h) for t, h, _ in climb() if h > 4.0]
    top = max(rising, key=lambda sample: sample[1])[0]
    felt = [8.0 - t if t < 1.2 else charge if abs(t - top - 1.5) < 0.06 else -0.1 for t, _ in rising]
    rows = "".join(f"{t:.2f},{h:.2f},{g + shift:.2f}\n" for (t, h), g in zip(rising, felt, strict=True))
    (series,), line = found(f"t (s),alt (m),accel (g)\n{rows}".encode())
    assert getattr(series, channel_name) is not None
    assert "from its value before apogee" in line


def test_an_acceleration_of_unknown_kind_is_left_out_with_the_reason() -> None:
    rows = "".join(f"{t:.2f},{h:.2f},{0.5 + (t < 1.2):.2f}\n" for t, h, _ in climb())
    (series,), line = found(f"t (s),alt (m),accel (g)\n{rows}".encode())
    assert (series.felt, series.acceleration) == (None, None)
    assert "left out, neither one g nor zero at rest: 'accel (g)'" in line


def test_three_axes_without_a_unit_are_scaled_to_one_g_at_rest() -> None:
    rows = b"".join(b"%.2f,0.1,9.79,0.2\n" % (i / 20) for i in range(400))
    (series,), line = found(b"t (s),ax,ay,az\n" + rows)
    assert series.felt_total is not None
    assert series.felt_total[0] == pytest.approx(9.79, abs=0.02)
    assert "rom one g at rest" in line


def test_a_unix_clock_is_shifted_to_zero_and_its_start_kept() -> None:
    log = table("time,alt (m)", "{t:.3f},{h:.2f}")
    rows = log.decode().split("\n")
    shifted = [f"{1_700_000_000_000 + float(r.split(',')[0]) * 1000:.0f},{r.split(',')[1]}" for r in rows[1:] if r]
    items = parsers()["mapped_table"].read("\n".join([rows[0], *shifted]).encode())
    (reading,) = (item for item in items if isinstance(item, Reading))
    (series,) = reading.clocks
    assert (series.time[0], series.time[-1]) == (0.0, pytest.approx(29.95))
    assert reading.extra["log_started_utc"] == "2023-11-14T22:13:20Z"


@pytest.mark.parametrize("start", [b"0:%02d:%04.1f", b"28:%02d:%04.1f", b"2026-05-01T10:%02d:%04.1f"])
def test_a_clock_with_colons_needs_no_unit(start: bytes) -> None:
    rows = b"".join(start % (i // 600, i / 10 % 60) + b",%d\n" % min(i, 90) for i in range(900))
    (series,), _ = found(b"time,alt (m)\n" + rows)
    assert series.time[-1] - series.time[0] == pytest.approx(89.9)


def test_two_flights_in_a_file_are_two_and_a_repeated_one_is_one() -> None:
    one = table("t (s),alt (m)", "{t:.2f},{h:.2f}")
    body = one.split(b"\n", 1)[1]
    lower = b"".join(b"%.2f,%.2f\n" % (t, h / 2) for t, h, _ in climb())
    assert [round(top(series)) for series in found(one + lower)[0]] == [285, 142]
    items = parsers()["mapped_table"].read(one + body)
    assert sum(isinstance(item, Reading) for item in items) == 1
    assert any(isinstance(item, Note) and "imported once" in item.text for item in items)


def test_only_rows_out_of_order_are_lost() -> None:
    lines = table("t (s),alt (m)", "{t:.2f},{h:.2f}").split(b"\n")
    lines[40], lines[41] = lines[41], lines[40]
    (series,), _ = found(b"\n".join(lines))
    assert len(series.time) == 599
    assert (np.diff(series.time) >= 0).all()


def test_equal_columns_with_the_same_meaning_are_one_and_different_ones_are_asked_for() -> None:
    both = table("t(s),alt(ft),alt(m)", "{t:.2f},{ft:.4f},{h:.4f}")
    assert top(found(both)[0][0]) == pytest.approx(285, abs=0.2)
    other = table("t(s),alt(ft),altitude of the balloon (m)", "{t:.2f},{ft:.4f},{v:.4f}")
    with pytest.raises(DamagedLog, match=r"found two columns for altitude that differ, .* choose one with --map"):
        found(other)
    assert found(both, read_choice(["altitude=alt(m)"]))[1].count("'alt(m)' in m")


@pytest.mark.parametrize("names", ["alt1 (m),alt2 (m)", "Altitude (m),Altitude 2 (m)"])
def test_of_several_sensors_of_one_kind_the_first_is_used(names: str) -> None:
    log = table(f"t (s),{names}", "{t:.2f},{h:.2f},{low:.2f}")
    assert top(found(log)[0][0]) == pytest.approx(285, abs=0.2)
    with pytest.raises(DamagedLog, match="found two columns for altitude that differ"):  # not of one flight
        found(table(f"t (s),{names}", "{t:.2f},{h:.2f},{ft:.2f}"))


def test_a_height_that_does_not_start_at_zero_is_not_above_the_pad() -> None:
    rows = b"".join(b"%.1f,%.1f\n" % (i / 10, 4583 + max(0, i - 50)) for i in range(300))
    (series,), line = found(b"t (s),ALT (ft)\n" + rows)
    assert (series.altitude, series.altitude_msl is not None) == (None, True)
    assert "it does not start at zero" in line


def unnamed(row: str) -> bytes:
    """The table of that flight without its line of names."""
    return table("x", row).split(b"\n", 1)[1]


@pytest.mark.parametrize("row", ["{ms:.0f},{ft:.0f}", "{t:.2f};{h:.1f}", "{t:.6e} {h:.6e}"])
def test_two_columns_without_names_are_a_clock_and_heights_or_pressures(row: str) -> None:
    imported = read(unnamed(row), "bare.csv", any_motor)
    (recorded,) = imported.recorded
    assert recorded is not None
    assert recorded.figures["apogee"].value == pytest.approx(285.0, abs=2.0)
    assert any("without names guessed from their numbers" in str(note) for note in imported.notes)


@pytest.mark.parametrize(
    ("row", "mapping"),
    [
        ("{ms:.0f},{p:.0f},{h:.2f},24.1", ["time=#1 [ms]", "altitude=#3 [m]"]),
        ("$LOG,{t:.2f},{ft:.1f},3,9.1*5A", ["time=#2 [s]", "altitude=#3 [ft]"]),
        ("{ms:.0f},24.1,{p:.0f}", ["time=#1 [ms]", "pressure=#3 [pa]"]),
    ],
)
def test_the_mapping_of_a_table_without_names_is_offered(row: str, mapping: list[str]) -> None:
    with pytest.raises(UnknownFormat) as refused:
        read(unnamed(row), "bare.csv", any_motor)
    assert " ".join(f"--map '{one}'" for one in mapping) in str(refused.value)
    (series,), _ = found(unnamed(row), read_choice(mapping))
    assert len(series.time) == 600


def test_two_columns_without_names_that_are_no_flight_are_refused() -> None:
    rows = "".join(f"{60 * i},{21 + math.sin(i / 50):.2f}\n" for i in range(600))
    with pytest.raises(DamagedLog, match="found no unit, and nothing that implies one"):
        read(rows.encode(), "bare.csv", any_motor)


@pytest.mark.parametrize(
    ("texts", "complaint"),
    [
        (["altitude"], "expected a channel and a column such as 'altitude=Alt"),
        (["altitud=Alt"], "found the channel 'altitud', expected one of time, altitude"),
        (["altitude=a", "altitude=b"], "found altitude twice"),
    ],
)
def test_an_invalid_mapping_is_refused_with_what_to_write(texts: Sequence[str], complaint: str) -> None:
    with pytest.raises(BadValue, match=complaint):
        read_choice(texts)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("altitude=Height", r"found no column 'Height', expected one of 't', 'alt'"),
        ("altitude=alt [furlong]", "found the unit 'furlong' for altitude, expected one of m"),
        ("altitude=t [m]", "found the column 't' for time and altitude, expected two columns"),
    ],
)
def test_a_mapping_that_matches_nothing_lists_what_there_is(text: str, complaint: str) -> None:
    with pytest.raises(DamagedLog, match=complaint):
        found(table("t,alt", "{t:.2f},{h:.2f}"), read_choice(["time=t", text]))


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(mapping, "data_file", lambda name: tmp_path / name)
    return tmp_path


def test_a_mapping_is_remembered_only_for_its_headers(home: Path) -> None:
    first = ColumnChoice({"time": "a", "altitude": "b [m]"}, ("a", "b"))
    remember(first)
    remember(ColumnChoice({"time": "x"}, ("x", "y")))
    remember(ColumnChoice({"time": "b"}, ("a", "b")))
    assert [choice.channels for choice in remembered()] == [{"time": "b"}, {"time": "x"}]
    assert {file.name for file in home.iterdir()} == {"mappings.json", LOCK_NAME}


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"mappings": [{"map": {"nonsense": "a"}, "headers": []}]}', "[" * 9999]
)
def test_a_damaged_file_of_mappings_is_named_and_not_overwritten(home: Path, text: str) -> None:
    (home / "mappings.json").write_text(text)
    with pytest.raises(FieldkitError, match=r"mappings\.json: cannot be read as saved mappings; repair or delete it"):
        remember(ColumnChoice({"time": "a"}, ("a", "b")))
    assert (home / "mappings.json").read_text() == text


def test_a_mapping_is_shown_chosen_once_and_remembered(home: Path, tmp_path: Path, run: Run) -> None:
    log = tmp_path / "team.csv"
    log.write_bytes(table("a,b", "{ms:.0f},{ft:.1f}"))
    assert "--map 'time=its column'" in run("import", log, status=1).err
    chosen = ["--map", "time=a", "--map", "altitude=b"]
    notes = run("import", log, *chosen, "--dry-run").err
    assert "columns as chosen: time = 'a' in ms (by free fall), altitude = 'b' in ft" in notes
    assert not (home / "mappings.json").exists()
    run("import", log, *chosen)
    assert "columns as chosen before: time = 'a' in ms" in run("import", log, "--dry-run").err


def test_a_mapping_of_a_table_without_names_is_remembered_by_the_form_of_its_rows(
    home: Path, tmp_path: Path, run: Run
) -> None:
    logs = [tmp_path / f"{name}.csv" for name in ("first", "later", "of_another_logger")]
    for log, row in zip(logs, ("{t:.2f},7,{ft:.0f}", "{t:.2f},7,{ft:.0f}", "{t:.3f},7,{h:.1f}"), strict=True):
        log.write_bytes(table("x", row).split(b"\n", 1)[1])
    logs[1].write_bytes(logs[1].read_bytes() + b"30.00,7,0\n")
    run("import", logs[0], "--map", "time=#1 [s]", "--map", "altitude=#3 [ft]")
    assert "columns as chosen before: time = '#1' in s, altitude = '#3' in ft" in run("import", logs[1]).err
    assert "no parser recognizes" in run("import", logs[2], status=1).err
    assert columns_of(remembered()[0]).names == ("#1", "#2", "#3")  # as `--map` and the form spell them


def test_a_mapping_is_refused_for_a_log_that_needs_none(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "t.csv"
    log.write_text("rocket,apogee_m\nSwift,100\n")
    refused = run("import", log, "--map", "altitude=apogee_m", status=1).err
    assert "flight_table reads without one; expected no mapping, or --format mapped_table" in refused


def test_escape_sequences_in_a_header_do_not_reach_messages() -> None:
    log = table("t (s),alt\x1b[31m (m),temp\x1b]0;x", "{t:.2f},{h:.2f},3")
    assert "\x1b" not in found(log)[1]


@pytest.mark.parametrize(
    ("name", "apogee", "time"),
    [("generic__andromeda_flight_data.csv", 3438.5, 26.75), ("generic__polito_altimeter_cavour.csv", 2789.0, 23.8)],
)
def test_a_real_table_is_read_by_its_column_names(name: str, apogee: float, time: float) -> None:
    log = recorded(name)
    assert claims(log) == ["mapped_table"]
    (series,), _ = found(log)
    assert series.altitude is not None
    assert top(series) == pytest.approx(apogee, abs=0.1)
    assert series.time[int(np.nanargmax(series.altitude))] == pytest.approx(time)


def test_a_real_logger_with_a_long_wait_on_the_pad_is_read_by_its_names() -> None:
    (series,), line = found(recorded("generic__ncsu_firm_jackpot_launch_1.csv"))
    assert series.pressure is not None
    assert series.felt_total is not None
    assert (len(series.time), round(float(series.time[0]), 2)) == (6616, 129.01)
    height = 44330.77 * (1 - (float(np.nanmin(series.pressure)) / float(np.median(series.pressure[:50]))) ** 0.190263)
    assert height == pytest.approx(762.28, rel=0.02)
    assert math.isclose(float(np.median(series.felt_total[:50])), 9.8, rel_tol=0.03)
    assert "pressure = 'pressure_pascals' in pascals" in line


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("cats__hedy_flightInfo.csv", "m"),
        ("perfectflite__pnut_top_shot.pf2", "ft"),
        ("rrc3__juno3_cots_altimeter.csv", "m"),
        ("raven_fip_variant__ndrt_2020_flight_data.csv", "ft"),
    ],
)
def test_physics_finds_the_unit_of_a_real_log_that_does_not_state_it(name: str, unit: str) -> None:
    log = recorded(name)
    if name.startswith("raven"):
        log = log.replace(b"(Ft-AGL)", b"", 1)
    assert f"in {unit} (by " in found(log)[1].split("altitude = ")[1].split(",")[0]


@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_names_may_be_in_another_language_and_decimals_commas(codec: str) -> None:
    log = table("Zeit [s];Höhe [m];Luftdruck [hPa]", "{t:.2f};{h:.2f};{p:.0f}").decode().replace(".", ",")
    (series,), line = found(log.replace("\n", "\r\n").encode(codec))
    assert top(series) == pytest.approx(285, abs=1)
    assert "altitude = 'Höhe [m]' in m" in line


def test_maximum_and_sideways_columns_are_not_channels_in_another_language() -> None:
    assert [channel(heading(name)) for name in ("maximale Höhe (m)", "horizontale Geschwindigkeit (m/s)")] == ["", ""]


def beside(second: str, row: str) -> bytes:
    """A table of times and heights, and another with half as many rows on its right."""
    left = table("Time (s),Altitude (ft)", "{t:.2f},{ft:.1f}").decode().splitlines()
    right = [second, *(row.format(t=i * 0.025, felt=1.0 + 9 * (1 < i * 0.025 < 2)) for i in range(len(left) // 2))]
    return "\n".join(
        f"{a},{right[i] if i < len(right) else ',' * second.count(',')}" for i, a in enumerate(left)
    ).encode()


def test_two_tables_side_by_side_keep_their_own_clocks() -> None:
    heights, forces = found(beside("Time (s),Accel X (g),Accel Y (g),Accel Z (g)", "{t:.3f},{felt},0.0,0.0"))[0]
    assert (heights.time[-1], forces.time[-1]) == (pytest.approx(29.95), pytest.approx(7.475))
    assert heights.felt_total is None
    assert forces.altitude is None
    assert forces.felt_total is not None
    assert forces.felt_total.max() == pytest.approx(10 * 9.80665)


def test_two_tables_of_heights_side_by_side_are_two_flights() -> None:
    log = beside("Time (s),Altitude (m)", "{t:.3f},{felt}")
    assert len([item for item in parsers()["mapped_table"].read(log) if isinstance(item, Reading)]) == 2


def test_a_time_of_day_continues_for_hours_and_over_midnight() -> None:
    rows = [
        ((86400 - 60 + n / 10) % 86400, max(0.0, 80 * (n / 10 - 150) - 4.9 * (n / 10 - 150) ** 2)) for n in range(3000)
    ]
    text = "Clock,Altitude (m)\n" + "".join(
        f"{int(t // 3600):02}:{int(t % 3600 // 60):02}:{t % 60:05.2f},{h:.1f}\n" for t, h in rows
    )
    (series,), _ = found(text.encode())
    assert len(series.time) == 3000
    assert series.time[-1] - series.time[0] == pytest.approx(299.9)


def test_the_magnitude_of_three_axes_is_not_taken_for_the_axis() -> None:
    rng = np.random.default_rng(1)
    rows = []
    for n in range(900):
        felt = 1.0 if n < 200 else 8.0 if n < 220 else -0.5 if n < 300 else 1.0
        x, y, z = 0.02 * rng.normal(), felt, 0.02 * rng.normal()
        rows.append(f"{n / 20:.2f},{x:.3f},{y:.3f},{z:.3f},{np.hypot(np.hypot(x, y), z):.3f},{n // 9}\n")
    (series,), _ = found(("Time (s),X (g),Y (g),Z (g),Accel (g),Altitude (ft)\n" + "".join(rows)).encode())
    assert series.felt_total is not None
    assert series.felt is not None
    assert series.felt.min() < 0


def test_an_accelerometer_whose_log_begins_in_flight_has_no_guessed_unit() -> None:
    rows = []
    for n in range(1500):
        felt = 90.0 - n / 2 if n < 60 else 1.0 if n < 300 else 6.0
        rows.append(f"{n / 50:.2f},0.1,{felt:.2f},0.1,{max(0.0, 20 + 60 * (n / 50) - 4.9 * (n / 50) ** 2):.1f}\n")
    (series,), line = found(("time,ax,ay,az,altitude (m)\n" + "".join(rows)).encode())
    assert series.felt is None
    assert series.felt_total is None
    assert "'ay'" in line


@pytest.mark.parametrize("names", ["altitude,height", "height,altitude"])
@pytest.mark.parametrize("elevation", [310.0, 1500.0])
def test_of_two_heights_the_one_above_the_pad_is_used(names: str, elevation: float) -> None:
    rows = []
    for time in np.arange(0, 16, 0.05):
        climb = max(0.0, min(time - 2, 12.0))
        above = 60 * climb - 4.9 * climb**2 if climb < 12.2 else 0.0
        pair = (above + elevation, above) if names.startswith("altitude") else (above, above + elevation)
        rows.append(f"{time:.2f},{pair[0]:.2f},{pair[1]:.2f}")
    log = f"time (s),{names.replace(',', ' (m),')} (m)\n" + "\n".join(rows) + "\n"
    (reading,) = (one for one in open_log(log.encode(), "log.csv", None).found if isinstance(one, Reading))
    (series,) = reading.clocks
    assert series.altitude is not None
    assert abs(series.altitude[0]) < 1


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("time_min,alt_m", "{min:.5f},{h:.2f}"),
        ("seconds_since_boot,pressure_hpa", "{t:.2f},{hpa:.3f}"),
        ("time_s,static_kPa,temp_C", "{t:.2f},{kpa:.4f},21.5"),
        ("us,time (us),baroAlt (cm)", "{i},{us:.0f},{cm:.0f}"),
        ("t/s;h/m;v/(m/s)", "{t:.2f};{h:.2f};{v:.1f}"),
        ("| Time (s) | Altitude (m) |\n|---|---|", "| {t:.2f} | {h:.2f} |"),
        ("Time;Altitude;Velocity", "{t:.2f} s;{h:.2f} m;{v:.1f} m/s"),
        ("baro.time,baro.altitude,imu.time", "{t:.2f},{h:.2f},{t:.3f}"),
        ("time_s,alt1_m,alt2_m", "{t:.2f},{h:.2f},{h:.1f}"),
    ],
)
def test_a_table_of_unusual_names_has_the_same_apogee(header: str, row: str) -> None:
    lines = [header]
    on_pad = [(i / 20, 0.0, 0.0) for i in range(40)]
    for i, (t, h, v) in enumerate([*on_pad, *((t + 2, h, v) for t, h, v in climb())]):
        pascals = 101325 * (1 - h / 44330.77) ** 5.25588
        units = {"min": t / 60, "us": t * 1e6, "cm": h * 100, "hpa": pascals / 100, "kpa": pascals / 1000}
        lines.append(row.format(i=i, t=t, h=h, v=v, **units))
    imported = read("\n".join([*lines, ""]).encode(), "log.csv", any_motor)
    assert imported.flights[0].apogee == pytest.approx(285, rel=0.02)


def test_a_stated_unit_that_makes_the_pressure_on_the_ground_impossible_is_refused() -> None:
    log = table("t_s,pressure_hPa", "{t:.2f},{p:.1f}")
    with pytest.raises(DamagedLog, match=r"found pressures up to 101\d\d\d hPa by the unit 'hpa', .*#2 \[pa\]'"):
        found(log)
    (series,), _ = found(log, read_choice(["pressure=#2 [pa]"]))
    assert series.pressure is not None
    assert series.pressure[0] == pytest.approx(101325, rel=1e-3)


def test_the_pressure_in_a_motor_is_not_that_of_the_air() -> None:
    rows = "".join(f"{i / 20:.2f},{15 + 300 * (20 < i < 60)}\n" for i in range(200))
    with pytest.raises(UnknownFormat):
        read(f"time_s,chamber [psi]\n{rows}".encode(), "stand.csv", any_motor)


@pytest.mark.parametrize("names", [("low_g_accel (g)", "high_g_accel (g)"), ("high_g (g)", "low_g (g)")])
def test_of_two_accelerometers_the_one_that_is_not_saturated_is_used(names: tuple[str, str]) -> None:
    """Filling in what the low one missed from the heights, as for a logger that has no other, is far less precise."""
    thrust = [1.0, *np.linspace(9, 7, 20), -1.0]
    lines = []
    for t, h, _ in climb():
        felt = float(np.interp(t, [0.0, *np.linspace(0.05, 1.0, 20), 1.05], thrust, right=-0.3))
        low = min(max(felt, -4.0), 4.0)
        cells = (low, felt) if names[0].startswith("low") else (felt, low)
        lines.append(f"{t:.2f},{h:.2f},{cells[0]:.2f},{cells[1]:.2f}")
    header = ",".join(("time (s)", "altitude (m)", *names))
    found = open_log("\n".join([header, *lines]).encode(), "log.csv", None).found
    (series,) = next(one for one in found if isinstance(one, Reading)).clocks
    assert series.felt is not None
    assert np.nanmax(series.felt) == pytest.approx(9 * 9.80665, rel=0.01)

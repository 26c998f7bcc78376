"""Exports of flight simulators: read as simulations, whatever the user's separators, units and language."""

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Reading
from fieldkit.importing.read import read, read_plans
from fieldkit.importing.recognize import claims, parsers
from tests.samples import SAMPLES, any_motor, owner

SIMULATED = [sample for sample in SAMPLES if owner(sample) in ("openrocket", "rocksim", "rasaero", "rocketpy")]
OPENROCKET = next(s for s in SIMULATED if s.name == "openrocket__as_it_comes.csv").read_bytes()


def only(log: bytes, name: str = "openrocket") -> Reading:
    (reading,) = (item for item in parsers()[name].read(log) if isinstance(item, Reading))
    return reading


@pytest.mark.parametrize("sample", SIMULATED, ids=lambda path: path.name)
def test_a_simulation_has_its_original_figures(sample) -> None:  # type: ignore[no-untyped-def]
    reading = only(sample.read_bytes(), owner(sample))
    (series,) = reading.clocks
    assert reading.describes == "simulation"
    assert series.altitude is not None
    assert series.speed is not None
    assert float(series.altitude.max()) == pytest.approx(252, abs=0.3)
    assert float(series.speed.max()) == pytest.approx(90.7, abs=0.2)
    assert float(series.time[np.argmax(series.altitude)]) == pytest.approx(6.8, abs=0.1)


@pytest.mark.parametrize("sample", SIMULATED, ids=lambda path: path.name)
def test_a_simulation_is_never_mistaken_for_a_flight(sample) -> None:  # type: ignore[no-untyped-def]
    imported = read(sample.read_bytes(), sample.name, any_motor)
    assert (imported.flights, imported.rejected) == ((), ())
    assert any("is a simulation" in note for note in imported.notes)
    assert read_plans(sample.read_bytes(), sample.name, any_motor) == []


def test_events_and_states_of_openrocket_are_read() -> None:
    reading = only(OPENROCKET)
    assert reading.events["apogee"] == pytest.approx(6.8)
    assert (reading.events["burnout"], reading.events["ejection"]) == (1.2, pytest.approx(7.3))
    assert reading.extra["simulation"] == "Swift, C6-5"
    assert reading.extra["state"] == "Up to date"
    assert reading.extra["warnings"].startswith("Large angle of attack")


def test_an_event_that_recurs_is_kept_each_time() -> None:
    line = b"# Event RECOVERY_DEVICE_DEPLOYMENT occurred at t=20 seconds\n"
    events = only(OPENROCKET + line).events
    assert (events["recovery_device_deployment"], events["recovery_device_deployment 2"]) == (pytest.approx(7.3), 20.0)


@pytest.mark.parametrize(("separator", "mark"), [(";", "#"), ("\t", "%"), (" ", "//"), ("|", "!"), (",", "")])
def test_any_separator_and_decimal_mark_is_read(separator: str, mark: str) -> None:
    text = OPENROCKET.decode()
    lines = []
    for line in text.splitlines():
        if "Time (s)" in line or not line.startswith("#"):
            line = line.replace(",", separator)
        lines.append(f"{mark} {line[1:].strip()}".strip() if line.startswith("#") else line)
    log = "\n".join(lines).encode()
    assert claims(log) == ["openrocket"]
    (series,) = only(log).clocks
    assert series.altitude is not None
    assert float(series.altitude.max()) == pytest.approx(252, abs=0.3)


@pytest.mark.parametrize(("unit", "factor"), [("ft", 0.3048), ("km", 1000.0), ("in", 0.0254)])
def test_heights_are_read_in_any_unit(unit: str, factor: float) -> None:
    rows = "".join(f"{i / 10:.1f},{i * (120 - i) / 60 / factor:.6f}\n" for i in range(120))
    (series,) = only(f"# Time (s),Altitude ({unit})\n{rows}".encode()).clocks
    assert series.altitude is not None
    assert float(series.altitude.max()) == pytest.approx(60)


@pytest.mark.parametrize(
    "names", ["Temps (s),Altitude (m)", "Zeit (s),Höhe (m)", "Czas (s),Wysokość (m)", "时间 (s),高度 (m)"]
)
def test_translated_names_are_recognized(names: str) -> None:
    rows = "".join(f"{i / 10:.1f},{i * (120 - i) / 60:.4f}\n" for i in range(120))
    log = f"# {names}\n{rows}".encode()
    assert claims(log) == ["openrocket"]
    assert len(only(log).clocks[0].time) == 120


def test_an_unknown_name_is_an_error_that_lists_the_columns() -> None:
    with pytest.raises(DamagedLog, match=r"found no column of altitude with its unit among 'Time \(s\)', 'Xyz \(m\)'"):
        parsers()["openrocket"].read(b"# Time (s),Xyz (m)\n0,1\n1,2\n")


def test_units_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(DamagedLog, match="expected units that agree"):
        parsers()["openrocket"].read(OPENROCKET.replace(b"Altitude (m)", b"Altitude (ft)"))


def test_total_velocity_is_not_vertical_velocity() -> None:
    log = b"Time,Thrust N,Altitude Feet,Velocity Feet / Sec\n"
    for i in range(200):
        t = i / 20
        log += b"%.2f,0,%.3f,%.3f\n" % (t, 160 * t - 16 * t * t, abs(160 - 32 * t))
    (series,) = only(log, "rocksim").clocks
    assert series.speed is None


def test_a_flight_log_with_units_in_brackets_is_not_a_simulation() -> None:
    log = b"Time (s),Altitude (m)\n" + b"".join(b"%d,%d\n" % (i, i * (30 - i)) for i in range(30))
    assert claims(log) == ["mapped_table"]


def test_a_flight_log_with_a_commented_header_is_not_a_simulation() -> None:
    heights = [0.3, -0.2, 0.1, *(i * (30 - i) for i in range(30))]
    rows = "".join(f"{i - 3},{height}\n" for i, height in enumerate(heights))
    assert claims(f"# Time (s),Altitude (m)\n{rows}".encode()) == ["mapped_table"]


@pytest.mark.parametrize("name", ["openrocket", "rocksim", "rasaero"])
def test_a_header_without_rows_is_damaged(name: str) -> None:
    sample = next(s for s in SIMULATED if owner(s) == name).read_text(encoding="utf-8")
    header = next(line for line in sample.splitlines() if "Altitude" in line)
    with pytest.raises(DamagedLog):
        parsers()[name].read(header.encode())


def test_damaged_rows_are_reported_and_the_rest_is_read() -> None:
    found = parsers()["openrocket"].read(OPENROCKET.replace(b"\n0.06,", b"\n0.o6,"))
    assert [item.row for item in found if isinstance(item, DamagedLog)] == [11]
    assert not [item for item in found if isinstance(item, Note)]


def test_an_export_of_rocksim_without_thrust_is_no_flight() -> None:
    rows = "".join(f"{i / 20:.2f}, {i * (240 - i) / 40:.3f}, {(120 - i) / 2:.2f}\n" for i in range(240))
    assert claims(f"Time,Altitude Feet,Velocity Feet / Sec\n{rows}".encode()) == ["rocksim"]

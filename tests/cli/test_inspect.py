"""`fieldkit inspect` and the lines of `import` for each file come from the same reading of the file."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.flight import TWO_DEVICES
from fieldkit.ledger import Ledger
from tests.analysis.recordings import SMALL, Logger, fly, log
from tests.commands import Run
from tests.samples import SAMPLES, owner

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
FOLDER = Path(__file__).parents[2] / "sample_logs"
PNUT = FOLDER / "perfectflite__drogue_and_main.pf2"
TABLE = FOLDER / "flight_table__some_rows_are_bad.csv"
KEYS = {"file", "format", "why", "columns", "rows", "dropped", "readouts", "events", "notes", "would_store"}


def inspected(run: Run, *files: Path) -> list[dict[str, Any]]:
    out = run("inspect", *files, "--json").out
    return json.loads(out)["files"]


def test_inspect_describes_a_log_and_stores_nothing(run: Run, tmp_path: Path) -> None:
    (found,) = inspected(run, PNUT)
    assert found.keys() >= KEYS
    assert found["format"] == "perfectflite"
    assert "PerfectFlite" in found["why"]
    assert {"name": "Altitude", "channel": "altitude", "unit": "ft", "source": "baro"} in found["columns"]
    assert (found["rows"], found["dropped"], found["would_store"]) == (487, 0, 1)
    apogee = found["readouts"]["apogee"]
    assert apogee["stated"] == pytest.approx(161.54, abs=0.01)
    assert apogee["value"] == pytest.approx(162.8, abs=0.2)
    assert 0 < apogee["sd"] < 3
    assert apogee["sensor"] == "baro"
    events = {one["name"]: one for one in found["events"]}
    assert events["liftoff"] == {"name": "liftoff", "time_s": 0.0, "altitude_m": 0.0, "sensor": "baro"}
    assert events["apogee"]["altitude_m"] == pytest.approx(apogee["value"], abs=apogee["sd"])
    assert events["ejection"]["sensor"] == "device"
    assert not (tmp_path / "ledger.db").exists()


@pytest.mark.sampled
@pytest.mark.parametrize("sample", [one for one in SAMPLES if not owner(one).startswith("altimetertwo")])
def test_what_inspect_shows_is_what_import_stores(run: Run, tmp_path: Path, sample: Path) -> None:
    (seen,) = inspected(run, sample)
    assert seen["columns"]
    assert seen["rows"] > 0
    out = run("import", sample, "--json").out
    document = json.loads(out)
    (file,) = document["files"]
    assert document["imported"] == seen["would_store"] == len(seen["flights"])
    assert file["format"] == seen["format"] == owner(sample)
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        stored = {flight.flight_id: flight for flight in ledger.flights()}
    assert stored.keys() == {one["flight_id"] for one in seen["flights"]}
    for one in seen["flights"]:
        flight = stored[one["flight_id"]]
        # with an error: a device's setting of the main altitude is none that was measured
        two = {c.name: float(flight.extra[c.header]) for c in TWO_DEVICES if c.sd_header in flight.extra}
        kept = flight.readouts() | two
        assert kept.keys() == one["readouts"].keys()
        if "apogee" in kept:
            assert one["readouts"]["apogee"]["value"] == pytest.approx(kept["apogee"], abs=1e-3)
    apogees = [one["readouts"]["apogee"]["value"] for one in seen["flights"] if "apogee" in one["readouts"]]
    assert file["apogees_m"] == apogees
    assert file["apogee_m"] == (apogees[0] if len(apogees) == 1 else None)


def test_a_readout_names_the_sensors_it_is_based_on(run: Run, tmp_path: Path) -> None:
    barometer, felt = log(fly(SMALL), Logger(accelerometer=100.0), np.random.default_rng(0))
    heights = np.interp(felt.time, barometer.time, barometer.altitude)
    rows = np.column_stack([felt.time, heights, felt.felt])
    path = tmp_path / "own.csv"
    path.write_text(
        "time [s],altitude [m],acceleration [m/s2]\n" + "".join(f"{t:.3f},{h:.3f},{a:.3f}\n" for t, h, a in rows)
    )
    (found,) = inspected(run, path)
    assert found["readouts"]["apogee"]["sensor"] == "baro"
    assert "accel" in found["readouts"]["burn_time"]["sensor"]
    assert found["readouts"]["peak_accel"]["sensor"] == "accel"
    assert ("altitude [m]", "altitude", "m", "baro") in [tuple(one.values()) for one in found["columns"]]


def test_dropped_rows_are_counted(run: Run) -> None:
    (found,) = inspected(run, FOLDER / "perfectflite__three_cells_and_a_bad_row.pf2")
    assert found["dropped"] >= 1
    assert any("bad" in str(one) or "found" in one for one in found["notes"])
    (table,) = inspected(run, TABLE)
    assert table["would_store"] < table["rows"] + table["dropped"]


def test_inspect_prints_a_file_in_detail(run: Run) -> None:
    out = run("inspect", PNUT).out
    for text in ("PerfectFlite .pf2 (perfectflite)", "Altitude [ft]", "162.8 ± 1.0 m", "device: ", "apogee"):
        assert text in out


def test_import_states_format_and_apogee_in_one_line(run: Run) -> None:
    _, out, _ = run("import", PNUT)
    assert "PerfectFlite .pf2, apogee 162.8 m" in " ".join(out.split())


def test_import_says_which_columns_of_a_table_no_fit_uses(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "season.csv"
    table.write_text(
        "Date,Motor,Lot,Altitude (ft),Descent,Coach\n2026-09-05,F24-4W,B7,800,41.2,Ann\n", encoding="utf-8"
    )
    _, out, _ = run("import", table)
    assert " ".join(out.split()).endswith("; stored as text: Descent, Coach")
    assert "Lot -> lot of the motor, stored as text" in run("inspect", table).out


def test_an_unrecognized_file_is_named_and_makes_the_exit_status_nonzero(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "junk.bin"
    path.write_bytes(b"\x00\x01\x02 nothing at all")
    _, out, error = run("inspect", path, "--json", status=1)
    assert out == ""
    assert "junk.bin" in error


@pytest.mark.parametrize("command", ["inspect", "import"])
def test_one_unusable_file_of_several_is_named_and_the_others_are_imported(
    run: Run, tmp_path: Path, command: str
) -> None:
    junk = tmp_path / "junk.bin"
    junk.write_bytes(b"\x00\x01\x02 nothing at all")
    _, out, error = run(command, junk, PNUT, "--json", status=1)
    assert "junk.bin: no parser recognizes this file" in error
    files = json.loads(out)["files"]
    assert [one["format"] for one in files] == ["perfectflite"]


def test_a_folder_of_logs_is_imported_by_several_processes(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "logs"
    folder.mkdir()
    for number, sample in enumerate(sorted(PNUT.parent.glob("p*.pf2")) * 5):
        (folder / f"{number:02d}.pf2").write_bytes(sample.read_bytes())
    (folder / ".hidden").write_bytes(b"no log")
    several = run("inspect", folder, "--json")
    alone = [run("inspect", path, "--json") for path in sorted(folder.glob("*.pf2"))]
    assert several[0] == 0
    assert json.loads(several[1])["files"] == [file for one in alone for file in json.loads(one[1])["files"]]


def test_a_simulation_is_inspected_with_its_own_events_and_not_stored(run: Run) -> None:
    (found,) = inspected(run, FOLDER / "openrocket__as_it_comes.csv")
    assert found["would_store"] == 0
    assert not found["flights"]
    assert found["simulations"][0]["curve"]["height_m"]
    assert found["readouts"]["top_speed"]["sensor"] == "simulation"
    assert {one["sensor"] for one in found["events"]} == {"simulation"}
    assert {one["source"] for one in found["columns"]} == {"clock", "simulation"}
    out = run("inspect", FOLDER / "openrocket__as_it_comes.csv").out
    assert "states    simulation 1" in out


def test_the_json_has_the_whole_flight_as_plotted(run: Run) -> None:
    (found,) = inspected(run, PNUT)
    curve = found["flights"][0]["curve"]
    assert len({len(values) for values in curve.values()}) == 1
    assert curve["time_s"][0] < 0.5 < curve["time_s"][-1]
    assert max(curve["height_m"]) == pytest.approx(found["readouts"]["apogee"]["value"], rel=0.02)
    events = {one["name"]: one["time_s"] for one in found["events"]}
    assert curve["time_s"][-1] > events["apogee"] + 5
    out = run("inspect", PNUT).out
    for what in ("height", "speed", "accel", "events", "from lift-off", "lift-off     T"):
        assert what in out
    assert "liftoff" not in out


def test_inspect_lists_the_columns_of_a_table_that_are_only_stored(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "launches.csv"
    table.write_text("Date,Motor,Mass (g),Apogee (ft)\n2024-05-01,C6-5,61,812\n")
    (found,) = inspected(run, table)
    assert {"name": "Mass (g)", "channel": None, "unit": None, "source": "text"} in found["columns"]
    assert "Mass (g) -> not used, stored as text" in run("inspect", table)[1]

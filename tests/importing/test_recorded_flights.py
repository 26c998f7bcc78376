"""Logs from bytes through a parser into the ledger and back, and commands on them."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import FieldkitError
from fieldkit.flight import Series
from fieldkit.importing import Parser, Reading, recognize
from fieldkit.importing.recognize import parsers
from fieldkit.ledger import Ledger
from fieldkit.services.replay import recording_of
from tests.analysis.recordings import LARGE, SMALL, Logger, Rocket, fly, log
from tests.commands import Run
from tests.samples import SAMPLES

CHECK_SHAPES = False

flown = cache(fly)


def written(*rockets: Rocket, kind: str = "flight", stated: float | None = None, **changes: float) -> bytes:
    """A log in a format of these tests: JSON with time and height of each flight."""
    flights = []
    for number, rocket in enumerate(rockets):
        (series,) = log(flown(rocket), Logger(**changes), np.random.default_rng(number))
        flights.append([series.time.round(3).tolist(), series.altitude.round(2).tolist()])
    return json.dumps({"lark": flights, "kind": kind, "stated": stated}).encode()


def _read(content: bytes) -> list[Reading]:
    reported = json.loads(content)
    stated = {"apogee": reported["stated"]} if reported["stated"] else {}
    return [
        Reading(
            stated,
            series=Series(time=np.array(time), altitude=np.array(height)),
            describes=reported["kind"],
            device="Lark 1",
            serial="7",
        )
        for time, height in reported["lark"]
    ]


LARK = Parser("Lark", lambda head: head.startswith(b'{"lark"'), _read)


@pytest.fixture(autouse=True)
def _plug_in_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {**parsers(), "lark": LARK}
    monkeypatch.setattr(recognize, "parsers", lambda: known)


def test_a_log_becomes_a_flight_with_its_uncertainties(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "one.lark"
    path.write_bytes(written(SMALL, stated=465.0))
    out = run("import", path, "--json").out
    (id,) = json.loads(out)["flights"]
    shown = json.loads(run("show", id, "--json")[1])
    truth = flown(SMALL).readouts()
    assert shown["apogee_m"] == pytest.approx(truth["apogee"], abs=1.0)
    assert shown["stated_apogee_m"] == "465"
    assert 0 < float(shown["apogee_sd_m"]) < 1
    assert (shown["device"], shown["serial"], shown["log_format"]) == ("Lark 1", "7", "lark")
    assert shown["recording"]["events"]["liftoff"]["time_s"] == pytest.approx(100, abs=0.2)
    assert shown["recording"]["stated"] == {"apogee_m": 465.0}
    _, card, _ = run("show", id)
    assert "±" in card
    assert "lift-off" in card
    assert "liftoff" not in card
    _, out, _ = run("import", path, "--json")
    assert json.loads(out)["duplicates"] == 1


def test_several_flights_in_a_log_are_distinguished_and_recognized_again(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "two.lark"
    path.write_bytes(written(SMALL, LARGE))
    ids = json.loads(run("import", path, "--json")[1])["flights"]
    assert len(set(ids)) == 2
    run("edit", ids[1], "flight_id=renamed")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        for id, rocket in ((ids[0], SMALL), ("renamed", LARGE)):
            found = recording_of(ledger, id)
            assert found is not None
            assert found.recorded.figures["apogee"].value == pytest.approx(flown(rocket).readouts()["apogee"], abs=2)
            assert found.recorded.forces is not None


def test_a_table_is_read_again_with_the_columns_that_were_chosen(run: Run, tmp_path: Path) -> None:
    """In the loop, the app and reports as in the import; other logs need no saved choices."""
    (series,) = log(flown(SMALL), Logger(), np.random.default_rng(0))
    rows = "".join(f"{time:.3f};{height:.2f}\n" for time, height in zip(series.time, series.altitude, strict=True))
    (tmp_path / "odd.csv").write_text("Zeit;Hoch\n" + rows)
    sample = next(sample for sample in SAMPLES if sample.name == "rrc3__feet_and_commas.csv")
    chosen = ("--map", "time=Zeit [s]", "--map", "altitude=Hoch [m]")
    (odd,) = json.loads(run("import", tmp_path / "odd.csv", *chosen, "--json")[1])["flights"]
    (plain,) = json.loads(run("import", sample, "--json")[1])["flights"]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        found = recording_of(ledger, odd)
        assert found is not None
        assert found.recorded.figures["apogee"].value == pytest.approx(flown(SMALL).readouts()["apogee"], abs=2)
        (tmp_path / "home" / "mappings.json").write_text("damaged")
        assert recording_of(ledger, plain) is not None
        with pytest.raises(FieldkitError, match=r"mappings\.json: cannot be read as saved mappings"):
            recording_of(ledger, odd)


def test_a_flight_without_a_log_has_no_recording(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("flight_id,rocket,apogee_m\n1,Swift,200\n")
    run("import", table)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert recording_of(ledger, "1") is None
        with pytest.raises(FieldkitError, match="no flight 'nine'"):
            recording_of(ledger, "nine")


def test_a_log_named_in_a_table_fills_in_its_row_and_is_a_duplicate_later(run: Run, tmp_path: Path) -> None:
    (tmp_path / "one.lark").write_bytes(written(SMALL))
    table = tmp_path / "t.csv"
    table.write_text("flight_id,rocket,apogee_m,log\n1,Swift,460,one.lark\n")
    run("import", table)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        flight, recording = ledger.flight("1"), recording_of(ledger, "1")
    assert flight.apogee == 460
    assert "apogee" not in flight.sd
    assert flight.top_speed is not None
    assert "top_speed" in flight.sd
    assert recording is not None
    assert recording.recorded.events["apogee"].sd > 0


def test_a_simulation_is_not_a_flight_and_the_message_suggests_compare(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "sim.lark"
    path.write_bytes(written(SMALL, kind="simulation", noise=0.0))
    _, out, err = run("import", path, "--json")
    assert json.loads(out)["imported"] == 0
    (line,) = err.splitlines()
    assert "simulation" in line
    assert "fieldkit compare" in line


def test_a_log_without_an_apogee_is_reported_and_kept(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "short.lark"
    path.write_bytes(written(LARGE, early=0.8, stated=1500.0))
    _, out, err = run("import", path, "--json")
    assert "no apogee: the log ends" in err
    shown = json.loads(run("show", json.loads(out)["flights"][0], "--json")[1])
    assert shown["apogee_m"] == 1500.0
    assert shown["duration_s"] is None


@pytest.mark.thorough
def test_compare_shows_a_flight_beside_another_device_and_a_simulation(run: Run, tmp_path: Path) -> None:
    one, two, sim = (tmp_path / f"{name}.lark" for name in ("one", "two", "sim"))
    one.write_bytes(written(SMALL))
    two.write_bytes(written(SMALL, start=7.0, rate=50))
    sim.write_bytes(written(SMALL, kind="simulation", noise=0.0, start=0.0))
    (id,) = json.loads(run("import", one, "--json")[1])["flights"]
    out = run("compare", id, two, sim, "--json").out
    reported = json.loads(out)
    assert [one["kind"] for one in reported["recordings"]] == ["Lark 1", "Lark 1", "simulation"]
    for compared, shift in zip(reported["compared"], (93.0, 100.0), strict=True):
        assert compared["shift_s"] == pytest.approx(shift, abs=0.15)
        assert compared["rms_height_m"] < 1.5
        assert abs(compared["differences"]["apogee_m"]["difference"]) < 1.0
    _, text, _ = run("compare", id, two)
    assert "RMS" in text
    assert "Apogee" in text


def test_compare_accepts_typed_readouts(run: Run, tmp_path: Path) -> None:
    one, table = tmp_path / "one.lark", tmp_path / "t.csv"
    one.write_bytes(written(SMALL))
    table.write_text("flight_id,rocket,apogee_m\n1,Swift,200\n")
    out = run("compare", one, table, "--json").out
    (compared,) = json.loads(out)["compared"]
    assert compared["rms_height_m"] is None
    assert compared["differences"]["apogee_m"]["difference"] < -100


def test_compare_requires_two_recordings(run: Run, tmp_path: Path) -> None:
    one = tmp_path / "one.lark"
    one.write_bytes(written(SMALL))
    run("compare", one, status=1)
    err = run("compare", one, tmp_path / "nothing.csv", status=1).err
    assert "no flight" in err

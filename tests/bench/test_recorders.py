"""The recorder bench: its truth is a valid flight, its logs are read, and measured errors match their standard
deviations."""

from pathlib import Path

import numpy as np
import pytest

from bench.recorders.__main__ import main
from bench.recorders.flights import draw
from bench.recorders.judge import Miss, cells, judged, read, table
from bench.recorders.models import RECORDERS
from bench.recorders.record import WIND_PRESSURE_SD, receiver_drift, wind_pressure, written

SOME = (
    "5 Hz feet",
    "pressure 50 Hz",
    "accel 100 Hz",
    "clipped 8 g",
    "three axes",
    "begins 1 s late",
    "radio 10 Hz, gap 12 s at the top",
    "sonic accel, shocks 250 m",
)


def test_there_are_at_least_sixty_kinds_of_recorders() -> None:
    assert len(RECORDERS) >= 60


@pytest.mark.sampled
@pytest.mark.parametrize("sonic", [False, True])
def test_the_flights_of_the_bench_are_valid(sonic: bool) -> None:
    for path in draw(np.random.default_rng(5), 3, sonic=sonic):
        right = path.readouts()
        assert right["top_speed"] > (340 if sonic else 15)
        assert right["burn_time"] < right["time_to_apogee"] < right["duration"]
        assert right["avg_accel"] < 1.1 * right["peak_accel"]  # heights of cold air make one larger, not the other


def test_a_perfect_recorder_is_read_perfectly() -> None:
    recorder = RECORDERS["accel 400 Hz"]
    random = np.random.default_rng(3)
    for path in draw(random, 2):
        found, right = read(written(path, recorder, random)).figures, path.readouts()
        assert found["apogee"].value == pytest.approx(right["apogee"], abs=1.5)
        assert found["burn_time"].value == pytest.approx(right["burn_time"], abs=0.1)


@pytest.mark.sampled
@pytest.mark.parametrize("name", SOME)
def test_readout_errors_match_their_standard_deviations(name: str) -> None:
    misses, refused = judged(name, RECORDERS[name], 2, seed=7)
    assert not refused
    assert {"apogee", "descent_speed"} <= {one.readout for one in misses}
    assert [one for one in misses if abs(one.sds) > 4] == []


def test_a_table_of_the_bench_counts_large_errors() -> None:
    misses = [Miss("a", 0, "apogee", 30.0, 1.0, 300.0), Miss("a", 1, "apogee", 1.0, 1.0, 300.0)]
    lines = list(table({"a": cells(misses, 2)}))
    assert next(line for line in lines if line.startswith("| a |")).startswith("| a | 100/50/1 |")
    assert next(line for line in lines if line.startswith("| **all** |")).startswith("| **all** | 100/50/1 |")


def test_an_interrupted_bench_resumes_where_it_stopped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = tmp_path / "kept.json"
    for only in ("5 Hz feet", "2 Hz"):
        assert main(["--flights", "1", "--keep", str(kept), "--only", only]) == 0
    first = kept.read_text()
    shown = capsys.readouterr().out
    assert "| 5 Hz feet |" in shown
    assert "| 2 Hz |" in shown
    assert main(["--flights", "1", "--keep", str(kept), "--only", "5 Hz feet"]) == 0
    assert kept.read_text() == first
    with pytest.raises(SystemExit):
        main(["--flights", "2", "--keep", str(kept), "--only", "5 Hz feet"])


def test_a_receiver_drifts_as_much_on_the_pad_as_in_flight() -> None:
    """Its drift began long before the log, so its size does not depend on the time since then."""
    random, when = np.random.default_rng(5), np.arange(0.0, 30.0, 0.2)
    drifts = np.array([receiver_drift(when, RECORDERS["satellites 5 Hz"], random) for _ in range(300)])
    early, late = drifts[:, :5].std(), drifts[:, -5:].std()
    assert early == pytest.approx(late, rel=0.15)


def test_the_wind_moves_the_heights_of_every_barometer_by_as_much_as_it_should() -> None:
    random = np.random.default_rng(6)
    ends = np.array([wind_pressure(2001, random)[[0, 100, 2000]] for _ in range(400)])
    assert ends.std(axis=0) == pytest.approx(WIND_PRESSURE_SD, rel=0.15)
    assert np.corrcoef(ends.T)[0, 1] > 0.7 > 0.3 > np.corrcoef(ends.T)[0, 2]


def test_an_accelerometer_feels_a_charge_after_it_fired() -> None:
    random = np.random.default_rng(7)
    path = next(one for one in draw(random, 5) if one.ejection is not None)
    rows = [line.split(",") for line in written(path, RECORDERS["accel 400 Hz"], random).decode().splitlines()[1:]]
    time, felt = np.array([[float(row[0]), float(row[2])] for row in rows if row[2]]).T
    wait = RECORDERS["accel 400 Hz"].wait
    near = np.abs(time - wait - path.ejection) < 0.15
    strongest = time[near][np.argmax(felt[near])] - wait - path.ejection
    assert 0.0 < strongest < 0.06

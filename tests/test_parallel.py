"""Resumable jobs: results are saved one by one, resumed, and the same on a cluster that loses a worker."""

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench import score
from fieldkit.errors import BadValue, FieldkitError
from fieldkit.inference.training import parts
from fieldkit.model.prior_predictive import Truth, split_motors
from fieldkit.parallel import done, workers


def square(number: int) -> bytes:
    if number < 0:
        raise BadValue("found a number below zero")
    return str(number**2).encode()


def test_an_interrupted_job_resumes_where_it_stopped(tmp_path: Path) -> None:
    worked: list[int] = []

    def noting(number: int) -> bytes:
        worked.append(number)
        return square(number)

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(BadValue, match="below zero"):
            list(done(noting, {"a": 2, "b": 3, "c": -1, "d": 5}, tmp_path, pool))
        assert worked[:3] == [2, 3, -1]
        found = dict(done(noting, {"a": 2, "b": 3, "c": 4, "d": 5}, tmp_path, pool))
    assert found == {"a": b"4", "b": b"9", "c": b"16", "d": b"25"}
    assert worked.count(2) == worked.count(3) == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a", "b", "c", "d"], "nothing half-made"


def test_a_local_worker_does_the_work(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with workers("local:1") as pool:
        assert dict(done(str.encode, {"a": "x", "b": "y"}, tmp_path, pool)) == {"a": b"x", "b": b"y"}


LOSES_A_WORKER = """
import os, sys
from pathlib import Path
from fieldkit.inference.training import parts
from fieldkit.parallel import workers

OUT = Path(sys.argv[1])
fly_part = parts.fly_part

def fly_or_die(part):
    if part.number == 1 and not (OUT / "lost").exists():
        (OUT / "lost").touch()
        os._exit(9)
    return fly_part(part)

if __name__ == "__main__":
    parts.SIZE, parts.fly_part = 300, fly_or_die
    with workers("local:2") as pool:
        (OUT / "whole").write_bytes(parts.packed(parts.simulate_parts(OUT, 7, 1000, ("wind",), pool)))
"""


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_flights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    script = tmp_path / "loses_a_worker.py"
    script.write_text(
        LOSES_A_WORKER.replace("real, parts", "parts").replace("= parts.fly_part, fly_part", "= fly_part")
    )
    home = {"PYTHONPATH": str(Path(__file__).parents[1]), "OMP_NUM_THREADS": "1"}
    subprocess.run([sys.executable, script, tmp_path], env=os.environ | home, check=True, capture_output=True)
    assert (tmp_path / "lost").exists()
    monkeypatch.setattr(parts, "SIZE", 300)
    with ThreadPoolExecutor(1) as pool:
        here = parts.simulate_parts(tmp_path / "here", 7, 1000, ("wind",), pool)
    there = parts.unpacked((tmp_path / "whole").read_bytes())
    for name in Truth.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))


def test_parts_with_another_seed_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "SIZE", 60)
    few = split_motors()[0][::50]
    monkeypatch.setattr(parts, "split_motors", lambda: (few, []))
    steps: list[tuple[int, int]] = []
    with ThreadPoolExecutor(1) as pool:
        one = parts.simulate_parts(tmp_path, 1, 100, (), pool, lambda *message: steps.append(message))
        other = parts.simulate_parts(tmp_path, 2, 100, (), pool)
        again = parts.simulate_parts(tmp_path, 1, 100, (), pool)
    assert steps == [(1, 2), (2, 2)]
    assert not np.isin(one.alpha, other.alpha).any(), "parts draw random numbers of their own"
    assert len(np.unique(one.alpha)) == len(one)
    np.testing.assert_array_equal(one.readouts, again.readouts)
    parts.drop_parts(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_parts_of_another_catalog_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if only the thrust of a motor has changed."""
    few = split_motors()[0][::50]
    stronger = [replace(few[0], thrust=few[0].thrust * 1.01), *few[1:]]
    with ThreadPoolExecutor(1) as pool:
        for motors in (few, stronger):
            monkeypatch.setattr(parts, "split_motors", lambda motors=motors: (motors, []))
            parts.simulate_parts(tmp_path, 1, 20, (), pool)
    assert len(list(tmp_path.glob("*/*/*.npy"))) == 2


@pytest.mark.parametrize(
    ("where", "message"), [("local:0", "at least one worker"), ("nowhere://x", "no Dask scheduler")]
)
def test_missing_workers_are_reported(where: str, message: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(FieldkitError, match=message), workers(where):
        pass


def test_the_bench_scores_a_set_from_its_input_alone_and_resumes(tmp_path: Path) -> None:
    label = {"set": "set_001", "scenario": "wind", "label": "wind", "level": 1}
    label |= {"ideal_mae_m": 5.0, "blind_mae_m": 10.0, "ideal_future_mae_m": 5.0}
    for name in ("set_001.csv", "set_001_future.csv"):
        (tmp_path / name).write_text("flight_id\n1\n")
    failing = score.to_score(tmp_path, [label], [sys.executable, "-c", "raise SystemExit(1)"], 20.0)
    (result,) = score.results(failing, tmp_path / "kept", 1, "")
    assert result.error.startswith("CommandFailed")
    kept = json.loads((tmp_path / "kept" / "set_001").read_text())
    assert kept["scenario"] == "wind"
    (tmp_path / "kept" / "set_001").write_text(json.dumps(kept | {"error": "", "verdict": "wind", "also": ["mass"]}))
    (again,) = score.results(failing, tmp_path / "kept", 1, "")
    assert (again.verdict, again.also, again.right) == ("wind", ("mass",), True)


BUSY = """
import time
from multiprocessing import active_children
from fieldkit.parallel import processes
with processes(3) as pool:
    waiting = [pool.submit(time.sleep, 1000) for _ in range(9)]
    print(*(one.pid for one in active_children()), flush=True)
    time.sleep(1000)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="processes are read from /proc")
def test_no_worker_outlives_the_process_that_started_it() -> None:
    with subprocess.Popen([sys.executable, "-c", BUSY], stdout=subprocess.PIPE, text=True) as began:
        assert began.stdout is not None
        workers = began.stdout.readline().split()
        assert len(workers) == 3
        began.kill()
    limit = time.monotonic() + 60.0
    while any(Path(f"/proc/{one}").exists() for one in workers):
        assert time.monotonic() < limit, "orphans wait for ever"
        time.sleep(0.1)

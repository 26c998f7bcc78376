"""Resumable jobs: results are saved one by one, resumed, and the same on a cluster that loses a worker."""

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from bench import score
from fieldkit.errors import BadValue, FieldkitError
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
from fieldkit.parallel import done, workers

LOST = Path(sys.argv[1]) / "lost"

def cube_or_die(number):
    if number == 1 and not LOST.exists():
        LOST.touch()
        os._exit(9)
    return str(number**3).encode()

if __name__ == "__main__":
    with workers("local:2") as pool:
        for name, content in done(cube_or_die, {str(n): n for n in range(4)}, Path(sys.argv[1]) / "kept", pool):
            print(name, content.decode())
"""


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_results(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    script = tmp_path / "loses_a_worker.py"
    script.write_text(LOSES_A_WORKER)
    home = {"PYTHONPATH": str(Path(__file__).parents[1]), "OMP_NUM_THREADS": "1"}
    work = [sys.executable, script, tmp_path]
    printed = subprocess.run(work, env=os.environ | home, check=True, capture_output=True, text=True).stdout
    assert (tmp_path / "lost").exists()
    assert sorted(printed.splitlines()) == ["0 0", "1 1", "2 8", "3 27"]


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

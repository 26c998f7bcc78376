"""`loop` on twenty flights with logs, the first time and again: `pytest -o addopts= --benchmark-only -s
tests/benchmarks/bench_logs.py`.

The logs are simulated by `bench`, at 50 Hz, with an accelerometer or without. Each call is a whole process, in
processor time; the ratio to the first one is printed.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from bench.recorders.flights import paths, sport_launch
from bench.recorders.models import RECORDERS
from bench.recorders.record import written
from fieldkit.ledger import Ledger
from fieldkit.paths import HOME
from fieldkit.services.imports import bring_in
from tests.benchmarks import timing
from tests.benchmarks.timing import beside, of_children, whole_process
from tests.samples import any_motor

pytestmark = pytest.mark.benchmark(timer=of_children)
COMMAND = "import sys; sys.argv[1:] = ['--ledger', {!r}, 'loop', '--dry-run']; from fieldkit.cli.main import run; run()"
FLIGHTS, SCATTER = 20, 0.03
"""Number of flights, and the standard deviation of their drag. [1]"""
KINDS = {"with an accelerometer": "accel 50 Hz", "of heights alone": "50 Hz"}


@pytest.mark.parametrize("kind", KINDS)
def test_the_loop_with_logs(
    benchmark: BenchmarkFixture, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    benchmark.group = f"the loop with logs {kind}"
    monkeypatch.setattr(timing, "FLYER", timing.FLYER | {HOME: str(tmp_path)})
    code = COMMAND.format(str(ledger(KINDS[kind], tmp_path)))
    before = of_children()
    whole_process(code)
    first = of_children() - before
    benchmark.pedantic(whole_process, [code], rounds=3)
    beside(benchmark, float(benchmark.stats.stats.min), first, f"the first time, {first:.3g} s")


def ledger(recorder: str, folder: Path) -> Path:
    """A ledger of the flights of one rocket, with their logs."""
    rng = np.random.default_rng(5)
    first = sport_launch(rng)
    drags = first.drag.cd * np.exp(rng.normal(0, SCATTER, FLIGHTS))
    tilts = np.radians(np.abs(rng.normal(0, 4, FLIGHTS)))
    launches = [
        replace(first, drag=replace(first.drag, cd=cd), tilt=tilt)
        for cd, tilt in zip(drags.tolist(), tilts.tolist(), strict=True)
    ]
    files = []
    for number, path in enumerate(paths(launches, rng)):
        files.append(folder / f"{number}.csv")
        files[-1].write_bytes(written(path, RECORDERS[recorder], rng))
    about = {"rocket": "Astra", "motor": first.motor.name, "dry_mass": first.dry_mass}
    with Ledger.open(folder / "ledger.db") as one:
        bring_in(one, files, any_motor, defaults=about | {"diameter": first.airframe.diameter})
    return folder / "ledger.db"

"""Ledgers with 100 to 100,000 flights:
`pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_ledger.py`.

The same requests for ledgers of every size, in processor time, relative to 100 flights. A rocket has 20 flights in
each, so that requests for one rocket are the same work.
"""

import shutil
import time
from collections.abc import Callable
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.ledger.backups import folder_of
from fieldkit.ledger.opening import keep_backup
from fieldkit.motors import Catalogue, catalogue
from fieldkit.services.close_loop import diagnosis_of
from fieldkit.services.forecasts import predict_plans
from tests.benchmarks.timing import beside, measured

pytestmark = pytest.mark.benchmark(timer=time.process_time)
SIZES = (100, 1_000, 10_000, 100_000)
EACH = 20
"""Flights of a rocket. [1]"""
FIRST: dict[str, float] = {}
"""Time of each request with 100 flights. [s]"""


@cache
def motors() -> Catalogue:
    return catalogue()


@cache
def ledger(size: int) -> Path:
    """A ledger with this number of flights."""
    rng, first = np.random.default_rng(size), datetime(2000, 1, 1, 10)
    flights = [
        Flight(
            flight_id=str(n),
            rocket=f"Rocket {n // EACH}",
            config="AB"[n % 2],
            motor=("E35-5W", "F24-4W", "F39-6T")[n % 3],
            date_time=first + timedelta(hours=n),
            dry_mass=0.32,
            diameter=0.066,
            tags=("weak_launch",) if n % 50 == 49 else (),
            apogee=(170.0, 260.0, 270.0)[n % 3] * float(rng.normal(1.0, 0.03)),
        )
        for n in range(size)
    ]
    file = Path(mkdtemp(prefix="bench_ledger")) / "ledger.db"
    with Ledger.open(file) as opened:
        opened.add(flights)
    return file


def first_backup(ledger: Ledger) -> None:
    """A backup without an earlier one, so that every row is checked."""
    shutil.rmtree(folder_of(Path(ledger.name)), ignore_errors=True)
    assert not keep_backup(ledger._engine, always=True)


def another_backup(ledger: Ledger) -> None:
    """A backup after one with the same rows, which are compared."""
    assert not keep_backup(ledger._engine, always=True)


QUESTIONS: dict[str, tuple[Callable[[Ledger], Any], int]] = {
    "list all": (lambda ledger: ledger.flights(), 3),
    "of one rocket": (lambda ledger: ledger.flights("Rocket 1"), 9),
    "by a tag": (lambda ledger: ledger.flights(tag="weak_launch"), 3),
    "by an id": (lambda ledger: ledger.flight("77"), 9),
    "add one": (lambda ledger: ledger.add([Flight(flight_id="new", rocket="Rocket 1")], dry_run=True), 9),
    "first backup": (first_backup, 1),
    "another backup": (another_backup, 3),
    "predict": (lambda ledger: predict_plans(ledger, motors(), [PLAN], save="nothing"), 3),
    "loop": (lambda ledger: diagnosis_of(ledger, motors(), "Rocket 1"), 1),
}
PLAN = Flight(rocket="Rocket 1", config="A", motor="F24-4W")


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("question", QUESTIONS)
def test_a_question(benchmark: BenchmarkFixture, question: str, size: int) -> None:
    benchmark.group = question
    ask, rounds = QUESTIONS[question]
    with Ledger.open(ledger(size)) as opened:
        seconds = measured(benchmark, ask, opened, rounds=rounds)
    beside(benchmark, seconds, FIRST.setdefault(question, seconds), f"{question} of 100 flights")

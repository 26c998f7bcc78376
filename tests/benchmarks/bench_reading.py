"""How fast logs are read and flights inferred:
`pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_reading.py`.

A log of 100 MB stands beside pandas reading the same CSV into a table and doing nothing with it; a
flight in a batch beside one alone. Times are of the processor.
"""

import time
from collections.abc import Callable
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.importing.read import read_recordings
from fieldkit.inference.network.flights import infer
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from tests.benchmarks.timing import beside, measured
from tests.importing.test_bad_input import write_waiting
from tests.samples import any_motor

pytestmark = pytest.mark.benchmark(timer=time.process_time)
SIZE = 100_000_000
"""Of the log. [byte]"""
ROUNDS = 3
"""Of reading it, by each: memory is slower where others use it too. [1]"""
BATCH = 1000
"""Flights inferred together. [1]"""


@pytest.mark.benchmark(group="a log of 100 MB")
def test_a_log_of_a_hundred_megabytes(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    import pandas

    file = tmp_path / "big.csv"
    write_waiting(file, SIZE, flown=True)
    least = min(_spent(lambda: pandas.read_csv(file)) for _ in range(ROUNDS))
    took = measured(benchmark, lambda: read_recordings(file.read_bytes(), file.name), rounds=ROUNDS)
    benchmark.extra_info["megabytes_per_second"] = round(SIZE / 1e6 / took, 1)
    beside(benchmark, took, least, f"pandas' {SIZE / 1e6 / least:.0f} MB/s")


def _spent(work: Callable[[], object]) -> float:
    """What it takes. [s]"""
    began = time.process_time()
    work()
    return time.process_time() - began


@pytest.mark.benchmark(group="ensemble")
@pytest.mark.parametrize("count", [1, 12, BATCH])
def test_flights_inferred_together(benchmark: BenchmarkFixture, count: int, tmp_path: Path) -> None:
    from fieldkit.importing.read import read

    motors = catalogue()
    known = read(REFERENCE_FLIGHTS.read_bytes(), REFERENCE_FLIGHTS.name, any_motor).flights
    flights = [known[n % len(known)].with_changes(flight_id=str(n)) for n in range(count)]
    took = measured(benchmark, infer, flights, motors)
    benchmark.extra_info["flights_per_second"] = round(count / took, 1)
    beside(benchmark, took / count, ALONE.setdefault(0, took), "one flight alone")


ALONE: dict[int, float] = {}

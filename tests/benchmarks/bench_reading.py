"""Reading logs and inferring flights:
`pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_reading.py`.

A log of 100 MB is compared with pandas reading the same CSV into a table, and a flight in a batch with a single flight.
Times are processor time.
"""

import time
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.services.inferred import FlightInference
from tests.benchmarks.timing import beside, measured, whole_process
from tests.importing.test_bad_input import write_waiting
from tests.samples import any_motor

pytestmark = pytest.mark.benchmark(timer=time.process_time)
SIZE = 100_000_000
"""Size of the log. [byte]"""
MAX_RATIO = 1.5
"""Maximum ratio to the time of pandas for the same columns. [1]"""
ROUNDS = 3
"""Number of readings by each, because memory is slower if others use it too. [1]"""
BATCH = 1000
"""Flights inferred together. [1]"""


MEMORY = 300
"""Maximum memory of a process that reads it. [MB]"""
BOTH = """
import resource, sys, time
from pathlib import Path
from fieldkit.importing.read import read_recordings
file, rounds, alone = Path({file!r}), {rounds}, {alone}
def spent(work):
    began = time.process_time()
    work()
    return time.process_time() - began
if alone:
    read_recordings(file.read_bytes(), file.name)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
else:
    import pandas
    ours = lambda: read_recordings(file.read_bytes(), file.name)
    theirs = lambda: pandas.read_csv(file, usecols=range(4))
    ours()
    times = [(spent(ours), spent(theirs)) for _ in range(rounds)]
    print(min(one for one, _ in times), min(other for _, other in times))
"""
"""Both alternate in one process, so that they see the same machine."""


@pytest.mark.benchmark(group="a log of 100 MB")
def test_a_log_of_a_hundred_megabytes(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    file = tmp_path / "big.csv"
    write_waiting(file, SIZE, flown=True)
    times = whole_process(BOTH.format(file=str(file), rounds=ROUNDS, alone=False))
    seconds, least = map(float, times.split())
    memory = float(whole_process(BOTH.format(file=str(file), rounds=ROUNDS, alone=True)))
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info |= {"megabytes_per_second": round(SIZE / 1e6 / seconds, 1), "memory_mb": round(memory)}
    benchmark.extra_info |= {"min_s": seconds, "median_s": seconds}
    assert memory < MEMORY
    assert beside(benchmark, seconds, least, f"pandas' {SIZE / 1e6 / least:.0f} MB/s of the same columns") < MAX_RATIO


@pytest.mark.benchmark(group="ensemble")
@pytest.mark.parametrize("count", [1, 12, BATCH])
def test_flights_inferred_together(benchmark: BenchmarkFixture, count: int, tmp_path: Path) -> None:
    from fieldkit.importing.read import read

    motors = catalogue()
    known = read(REFERENCE_FLIGHTS.read_bytes(), REFERENCE_FLIGHTS.name, any_motor).flights
    flights = [known[n % len(known)].with_changes(flight_id=str(n)) for n in range(count)]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        seconds = measured(benchmark, FlightInference(ledger, motors).infer, flights)
    benchmark.extra_info["flights_per_second"] = round(count / seconds, 1)
    beside(benchmark, seconds / count, ALONE.setdefault(0, seconds), "one flight alone")


ALONE: dict[int, float] = {}

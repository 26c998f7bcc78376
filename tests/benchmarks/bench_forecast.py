"""A forecast from twenty flights:
`pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_forecast.py`.

Processor time on one core from flights in memory to draws of the next apogee, relative to the import of numpy.
"""

import time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.forecast.predict import predict
from fieldkit.model.readout_data import OBSERVED_READOUTS
from tests.benchmarks.timing import beside, measured, of_children, whole_process
from tests.seasons import season

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="forecast")
FLIGHTS = 20


@pytest.fixture(scope="module")
def numpy_import() -> float:
    """Processor time to import numpy, a measure of the machine's speed. [s]"""
    spent = []
    for _ in range(5):
        began = of_children()
        whole_process("import numpy")
        spent.append(of_children() - began)
    return min(spent)


@pytest.mark.parametrize("wind", [None, 3.0], ids=["still", "windy"])
@pytest.mark.parametrize("recorded", [("apogee",), OBSERVED_READOUTS], ids=["apogees", "all readouts"])
def test_from_flights_to_a_forecast(
    benchmark: BenchmarkFixture, recorded: tuple[str, ...], wind: float | None, numpy_import: float
) -> None:
    flown = season(np.random.default_rng(7), recorded, FLIGHTS, wind)
    plan, found = flown[0]
    planned = [(plan.with_changes(flight_id="next", **dict.fromkeys(recorded)), found)]
    seconds = measured(benchmark, lambda: predict(flown, planned))
    beside(benchmark, seconds, numpy_import, "the import of numpy")

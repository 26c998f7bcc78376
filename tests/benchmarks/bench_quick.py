"""Quick answers from one linear pass compared with the fit, on twenty flights:
`pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_quick.py`.

Processor time on one core from flights in memory: the quick search relative to the loop, the next apogee and the
apogees of two hundred motors relative to the fit, one more readout of a flight being entered, as usual or odd, relative
to a whole quick forecast.
"""

import time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import forecast_at_once, forecasts_at_once, prepare_at_once
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.quick_forecast import answers
from fieldkit.model.readout_data import observe
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of
from fieldkit.planning.motor_guide import SLANTED_PATH_DRAWS, lifts
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.quick_look import quick_look, repeated
from tests.benchmarks.timing import beside, measured
from tests.seasons import season

pytestmark = pytest.mark.benchmark(timer=time.process_time)
FLIGHTS = 20
MOTORS = 200
RECORDED = ("apogee", "top_speed", "coast_to_apogee")


@pytest.fixture(scope="module")
def flown() -> list[tuple[Flight, Found]]:
    return season(np.random.default_rng(7), RECORDED, FLIGHTS, 3.0)


def test_the_quick_search(benchmark: BenchmarkFixture, flown: list[tuple[Flight, Found]]) -> None:
    used = [True] * FLIGHTS
    seconds = measured(benchmark, lambda: quick_look("Test", flown, used))
    model = rocket_model(history_of([flight for flight, _ in flown], [found for _, found in flown]))
    began = time.process_time()
    diagnose(model, observe(model.history.using(used)))
    beside(benchmark, seconds, time.process_time() - began, "the search of the loop")


def test_the_next_apogee(benchmark: BenchmarkFixture, flown: list[tuple[Flight, Found]]) -> None:
    flight, found = flown[0]
    plan = flight.with_changes(flight_id="next", **dict.fromkeys(RECORDED)), found
    seconds = measured(benchmark, lambda: forecast_at_once(flown, plan))
    spent = []
    for _ in range(3):
        began = time.process_time()
        predict(flown, [plan])
        spent.append(time.process_time() - began)
    beside(benchmark, seconds, min(spent), "the forecast of the fit")


@pytest.mark.parametrize("ratio", [1.0, 0.6], ids=["usual", "odd"])
def test_one_more_readout(benchmark: BenchmarkFixture, flown: list[tuple[Flight, Found]], ratio: float) -> None:
    flight, found = flown[-1]
    speed = ratio * (flight.top_speed or 0.0)
    plan = repeated(flight), found
    began = time.process_time()
    forecast_at_once(flown, plan)
    whole = time.process_time() - began
    ready = prepare_at_once(flown, [plan], [True] * FLIGHTS)
    others = [one for one, _ in flown[:-1]]
    seconds = measured(benchmark, lambda: answers(ready, [*others, flight.with_changes(top_speed=speed)]), rounds=20)
    assert beside(benchmark, seconds, whole, "the forecast from the start") < 1


def test_two_hundred_motors(benchmark: BenchmarkFixture, flown: list[tuple[Flight, Found]]) -> None:
    flight, _ = flown[0]
    listings = [one for some in catalogue().listings.values() for one in some]
    motors = [motor for motor in (one.motor() for one in listings) if lifts(motor, flight.dry_mass or 0.0)][:MOTORS]
    assert len(motors) == MOTORS
    plan = flight.with_changes(flight_id="next", delay=None, **dict.fromkeys(RECORDED))
    plans = [(plan.with_changes(motor=motor.name), Found(motor, None)) for motor in motors]
    seconds = measured(benchmark, lambda: forecasts_at_once(flown, plans), rounds=3)
    began = time.process_time()
    predict(flown, plans, draws=SLANTED_PATH_DRAWS)
    assert beside(benchmark, seconds, time.process_time() - began, "the fit of the motor guide") < 1

"""Plans compared with one `predict`: `pytest -s -o addopts= --benchmark-only tests/benchmarks/bench_plan.py`.

The catalog is every motor for a 29 mm mount, with adapters, with every safety check. Times are processor time; the
ratio to one forecast varies less than seconds on other or busy machines.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue, Motor, catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.planning.ballast import Goal, ballast
from fieldkit.planning.contest import season
from fieldkit.planning.delay import delays
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import Wanted, guide, suitable_motors
from fieldkit.planning.outlook import outlook
from fieldkit.services.forecasts import predict_plans, rocket_of
from fieldkit.services.plans import completed_plan
from fieldkit.settings import Settings
from tests.benchmarks.timing import beside, measured

pytestmark = pytest.mark.benchmark(timer=time.process_time)
CATALOGUE = 1.0
"""Maximum processor time of the whole catalog for one rocket. [s]"""


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ledger]:
    path = str(tmp_path_factory.mktemp("plans") / "ledger.db")
    assert main(["--ledger", path, "import", str(REFERENCE_FLIGHTS)]) == 0
    with Ledger.open(path) as ledger:
        yield ledger


@pytest.fixture(scope="module")
def motors() -> Catalogue:
    return catalogue()


@pytest.fixture(scope="module")
def every(motors: Catalogue) -> list[Motor]:
    return suitable_motors(motors, Wanted(mount=0.029, adapter=True))


@pytest.fixture(scope="module")
def one(ledger: Ledger, motors: Catalogue) -> float:
    """Time of one forecast in `predict`, the minimum of some rounds. [s]"""
    rounds = []
    for _ in range(4):
        completed_plan = time.process_time()
        predict_plans(ledger, motors, [PLAN], save="nothing")
        rounds.append(time.process_time() - completed_plan)
    return min(rounds)


def timed(benchmark: BenchmarkFixture, one: float, work: Callable[[], Any]) -> float:
    """The minimum time of some work, relative to one forecast. [s]"""
    seconds = measured(benchmark, work, rounds=3)
    beside(benchmark, seconds, one, "one predict")
    return seconds


PLAN = Flight(rocket="Astra", config="A", motor="F24-4W")


@pytest.mark.parametrize("wind", [None, 3.0], ids=["still", "windy"])
def test_the_whole_catalog_for_one_rocket(
    benchmark: BenchmarkFixture, one: float, ledger: Ledger, motors: Catalogue, every: list[Motor], wind: float | None
) -> None:
    day = PLAN.with_changes(wind=wind)

    def work() -> None:
        guide(
            rocket_of(ledger, motors, "Astra"), completed_plan(ledger, motors, day, Settings()), every, limits(), Site()
        )

    benchmark.extra_info["motors"] = len(every)
    assert timed(benchmark, one, work) < CATALOGUE


@pytest.mark.parametrize("wind", [None, 3.0], ids=["still", "windy"])
def test_one_predict(
    benchmark: BenchmarkFixture, one: float, ledger: Ledger, motors: Catalogue, wind: float | None
) -> None:
    day = PLAN.with_changes(wind=wind)
    timed(benchmark, one, lambda: predict_plans(ledger, motors, [day], save="nothing"))


def test_a_delay(benchmark: BenchmarkFixture, one: float, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), completed_plan(ledger, motors, PLAN, Settings())
    timed(benchmark, one, lambda: delays(Plan(rocket, plan, motors.resolve("F67W")), 15.0))


def test_ballast(benchmark: BenchmarkFixture, one: float, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), completed_plan(ledger, motors, PLAN, Settings())
    timed(benchmark, one, lambda: ballast(Plan(rocket, plan, motors.resolve("F24-4W")), Goal(240.0, 3.0)))


def test_a_contest(benchmark: BenchmarkFixture, one: float, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), completed_plan(ledger, motors, PLAN, Settings())
    timed(benchmark, one, lambda: outlook(season(2027), Plan(rocket, plan, motors.resolve("F24-4W"))))

"""What plans cost beside one `predict`: `pytest -s -o addopts= --benchmark-only tests/bench_plan.py`.

The catalogue is what fits a 29 mm mount and narrower, adapters and all, with every safety line. The ratio to one
forecast is printed at the end, for it holds where seconds do not: on another machine, or a busy one.
"""

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.ledger.sites import Site
from fieldkit.loop.desk import predict_plans
from fieldkit.loop.paper.reference import TABLE
from fieldkit.motors import Catalogue, Motor, catalogue
from fieldkit.plan.ballast import Goal, ballast
from fieldkit.plan.contest import outlook, season
from fieldkit.plan.delay import delays
from fieldkit.plan.desk import begun, rocket_of
from fieldkit.plan.guide import Wanted, fitting, guide
from fieldkit.plan.limits import limits
from fieldkit.settings import Settings

SECONDS: dict[str, float] = {}
"""Time of the processor for each way, the shortest of its rounds. [s]"""


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ledger]:
    path = str(tmp_path_factory.mktemp("plans") / "ledger.db")
    assert main(["--ledger", path, "import", str(TABLE)]) == 0
    with Ledger.open(path) as ledger:
        yield ledger


@pytest.fixture(scope="module")
def motors() -> Catalogue:
    return catalogue()


@pytest.fixture(scope="module")
def every(motors: Catalogue) -> list[Motor]:
    return fitting(motors, Wanted(mount=0.029, adapter=True))


@pytest.fixture(scope="module", autouse=True)
def _told() -> Iterator[None]:
    """Print the seconds and their ratio to one forecast at the end."""
    yield
    one = SECONDS.get("one predict", float("nan"))
    rows = (
        f"{name:36s}{spent:8.3f} s of the processor{spent / one:8.2f} predicts\n" for name, spent in SECONDS.items()
    )
    sys.stdout.write("\n" + "".join(rows))


def timed(benchmark: BenchmarkFixture, name: str, work: Callable[[], Any]) -> None:
    """Run some work a few times, and keep the least that it took of the processor."""

    def measured() -> None:
        begun = time.process_time()
        work()
        SECONDS[name] = min(SECONDS.get(name, float("inf")), time.process_time() - begun)

    benchmark.pedantic(measured, rounds=3, warmup_rounds=1)


PLAN = Flight(rocket="Astra", config="A", motor="F24-4W")


@pytest.mark.parametrize("wind", [None, 3.0], ids=["still", "windy"])
def test_the_whole_catalogue_for_one_rocket(
    benchmark: BenchmarkFixture, ledger: Ledger, motors: Catalogue, every: list[Motor], wind: float | None
) -> None:
    day = PLAN.with_changes(wind=wind)

    def work() -> None:
        guide(rocket_of(ledger, motors, "Astra"), begun(ledger, day, Settings()), every, limits(), Site())

    timed(benchmark, f"motors --fit, {len(every)} motors, {'windy' if wind else 'still'}", work)


@pytest.mark.parametrize("wind", [None, 3.0], ids=["still", "windy"])
def test_one_predict(benchmark: BenchmarkFixture, ledger: Ledger, motors: Catalogue, wind: float | None) -> None:
    day = PLAN.with_changes(wind=wind)
    name = "one predict" + (", windy" if wind else "")
    timed(benchmark, name, lambda: predict_plans(ledger, motors, [day], keep=False))


def test_a_delay(benchmark: BenchmarkFixture, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), begun(ledger, PLAN, Settings())
    timed(benchmark, "delay", lambda: delays(rocket, plan, motors.resolve("F67W"), 15.0))


def test_ballast(benchmark: BenchmarkFixture, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), begun(ledger, PLAN, Settings())
    timed(benchmark, "ballast", lambda: ballast(rocket, plan, motors.resolve("F24-4W"), Goal(240.0, 3.0)))


def test_a_contest(benchmark: BenchmarkFixture, ledger: Ledger, motors: Catalogue) -> None:
    rocket, plan = rocket_of(ledger, motors, "Astra"), begun(ledger, PLAN, Settings())
    timed(benchmark, "contest", lambda: outlook(season(2027), rocket, plan, motors.resolve("F24-4W")))

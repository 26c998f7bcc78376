"""The simulator in flights per second on one core, compared with scipy.

    pytest tests/benchmarks/bench_simulator.py --benchmark-only

Times are processor time, to be independent of other load; ratios are between figures of one run.
"""

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from scipy.integrate import solve_ivp

from fieldkit.flight import Flight
from fieldkit.motors import catalogue
from fieldkit.physics import paper
from fieldkit.physics.effect import effects
from fieldkit.physics.flight import apogees, fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.state import Setup
from tests.physics.simulated import rocket

pytestmark = pytest.mark.benchmark(timer=time.process_time)
MILLION = 1_000_000
AS_PUBLISHED, TO_APOGEE = 300_000, 1_000
"""Required ratio to scipy's flights per second: as the paper uses it, and ended at apogee."""
CLOSE = 0.1
"""Accuracy for comparing flights. [m]"""
RATES: dict[str, float] = {}


def timed(benchmark: BenchmarkFixture, name: str, flights: int, fly_them: Callable[[], Any], rounds: int = 5) -> Any:
    """The results of the flights; notes the rate of the fastest round."""
    result = benchmark.pedantic(fly_them, rounds=rounds, warmup_rounds=1)
    RATES[name] = flights / benchmark.stats.stats.min
    benchmark.extra_info["flights_per_second"] = round(RATES[name])
    return result


def paper_draws(count: int) -> Setup:
    rng = np.random.default_rng(0)
    mass = rng.choice(list(paper.DRY_MASS.values()), count)
    return paper.paper_setup(
        rng.integers(0, 3, count), mass, rng.uniform(0.3, 0.9, count), rng.uniform(0.8, 1.2, count)
    )


SAMPLE = paper_draws(12)


def by_scipy(row: int, **options: Any) -> float:
    """Apogee of one flight of the sample by solve_ivp with the plain equations. [m]"""
    motor = paper.MOTORS[int(SAMPLE.motor[row])]
    dry_mass, area, alpha = (float(v[row]) for v in (SAMPLE.dry_mass, SAMPLE.drag_area, SAMPLE.thrust_factor))
    burn, peak, mean = motor.burn_time, motor.peak_thrust, motor.mean_thrust
    rise = paper.RISE * burn

    def slopes(t: float, y: Any) -> list[float]:
        height, speed = y
        if t >= burn:
            thrust, mass = 0.0, dry_mass
        else:
            thrust = peak * t / rise if t < rise else peak + (mean - peak) * (t - rise) / (burn - rise)
            mass = dry_mass + motor.propellant_mass * (1 - t / burn)
        density = paper.SEA_LEVEL_DENSITY * np.exp(-height / paper.SCALE_HEIGHT)
        drag = 0.5 * density * area * speed * abs(speed)
        upward = (alpha * thrust - drag) / mass - paper.GRAVITY
        return [speed, max(upward, 0.0) if height <= 0 and t < burn else upward]

    result = solve_ivp(slopes, (0, 60), [0.0, 0.0], **options)
    return float(result.y[0].max())


def ends_climb(t: float, y: Any) -> float:
    """Upward speed after lift-off, for the event of apogee."""
    return 1.0 if t < 0.3 else float(y[1])


ends_climb.terminal, ends_climb.direction = True, -1  # type: ignore[attr-defined]


def loosest() -> dict[str, Any]:
    """The loosest tolerances of solve_ivp, ended at apogee, with an error below `CLOSE`."""
    exact = [
        by_scipy(row, method="DOP853", rtol=1e-9, atol=1e-9, max_step=0.01, events=ends_climb) for row in range(12)
    ]
    for rtol in 10.0 ** -np.arange(2, 9):
        options = {"rtol": rtol, "atol": rtol, "events": ends_climb}
        if max(abs(by_scipy(row, **options) - exact[row]) for row in range(12)) < CLOSE:
            return options
    raise AssertionError("solve_ivp does not come close at any tolerance")


def test_flights_in_the_papers_physics(benchmark: BenchmarkFixture) -> None:
    setup = paper_draws(MILLION)
    heights = timed(benchmark, "paper, apogees", MILLION, lambda: apogees(setup))
    exact = [
        by_scipy(row, method="DOP853", rtol=1e-9, atol=1e-9, max_step=0.01, events=ends_climb) for row in range(12)
    ]
    np.testing.assert_allclose(apogees(SAMPLE), exact, atol=CLOSE)
    assert heights.shape == (MILLION,)


def test_all_readouts_in_the_papers_physics(benchmark: BenchmarkFixture) -> None:
    setup = paper_draws(MILLION)
    timed(benchmark, "paper, all readouts", MILLION, lambda: fly(setup), rounds=3)


def test_scipy_as_the_paper_uses_it(benchmark: BenchmarkFixture) -> None:
    timed(benchmark, "scipy as published", 6, lambda: [by_scipy(row, max_step=0.02) for row in range(6)], rounds=2)


def test_scipy_ended_at_apogee(benchmark: BenchmarkFixture) -> None:
    options = loosest()
    timed(benchmark, "scipy to apogee", 12, lambda: [by_scipy(row, **options) for row in range(12)])


@pytest.fixture(scope="module")
def whole_catalogue() -> Setup:
    """A million flights, with every motor of the catalog equally often."""
    rng, motors = np.random.default_rng(1), catalogue().motors
    draws = MILLION // len(motors) + 1
    weight = np.array([motor.average_thrust / (9.8 * 8) for motor in motors])
    loaded, width = (np.array([getattr(motor, name) for motor in motors]) for name in ("loaded_mass", "diameter"))
    mass = np.maximum(weight - loaded, 0.5 * loaded) * rng.uniform(0.8, 1.5, (draws, 1))
    area = rng.uniform(0.3, 1.2, (draws, len(motors))) * np.pi / 4 * (1.4 * width) ** 2
    return rocket(motors, motor=np.arange(len(motors)), dry_mass=mass, drag_area=area)


@pytest.mark.parametrize("what", [apogees, fly], ids=["apogees", "all readouts"])
def test_flights_over_the_whole_catalog(benchmark: BenchmarkFixture, whole_catalogue: Setup, what: Any) -> None:
    flights = int(np.prod(whole_catalogue.draw_shape))
    timed(benchmark, f"catalogue, {what.__name__}", flights, lambda: what(whole_catalogue), rounds=2)


def season(count: int) -> Setup:
    motors = ("E35-5W", "F24-4W", "F39-6T")
    plans = [Flight(str(i), dry_mass=0.35, diameter=0.066, motor=motors[i % 3], wind=3.0) for i in range(30)]
    area = np.random.default_rng(2).uniform(0.3, 0.9, (count // 30, 30)) * np.pi / 4 * 0.066**2
    return field_setup(plans, [catalogue().resolve(plan.motor) for plan in plans], area)


def test_slanted_flights(benchmark: BenchmarkFixture) -> None:
    setup = season(60_000)
    windy = setup.with_changes(wind=np.asarray(3.0))
    timed(benchmark, "slanted, all readouts", 60_000, lambda: fly(windy), rounds=2)


@pytest.mark.parametrize("name", effects())
def test_flights_with_an_effect(benchmark: BenchmarkFixture, name: str) -> None:
    effect = effects()[name]
    setup = season(60_000)
    strength = effect.strength(np.full((1, 30), max(effect.prior.mean, 0.1 * effect.prior.sd)))
    bent = effect.bend_setup(setup, strength)
    timed(benchmark, f"with {name}", 60_000, lambda: fly(bent), rounds=2)


@pytest.fixture(scope="module", autouse=True)
def _rates_printed() -> Iterator[None]:
    """Print the rates and their ratios at the end."""
    yield
    sys.stdout.write("\n" + "".join(f"{name:28s}{rate:14,.1f} flights/s\n" for name, rate in RATES.items()))


def test_the_simulator_is_as_many_times_quicker_as_it_should_be(benchmark: BenchmarkFixture) -> None:
    ratios = benchmark.pedantic(
        lambda: [RATES["paper, apogees"] / RATES[name] for name in ("scipy as published", "scipy to apogee")]
    )
    sys.stdout.write(f"\nas many flights as scipy as published: {ratios[0]:,.0f}, ended at apogee: {ratios[1]:,.0f}\n")
    assert ratios[0] > AS_PUBLISHED
    assert ratios[1] > TO_APOGEE

"""Drag along a coast against simulated coasts whose drag is known."""

from functools import cache

import numpy as np
import pytest

from fieldkit.analysis.force_profile import DragProfile, drag_profile, step_sums
from tests.analysis.coasts import coast_log

OWN = 1.2e-3
SEEDS = range(12)


@cache
def profile(seed: int, felt: bool = True, ports: float = 0.0, lag: float = 0.0, rate: float = 50.0) -> DragProfile:
    clocks, recorded = coast_log(lambda time: OWN, seed, felt=felt, ports=ports, lag=lag, rate=rate)
    found = drag_profile(clocks, recorded)
    assert found is not None
    return found


@pytest.mark.parametrize("felt", [True, False])
@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_a_constant_drag_is_found_within_its_standard_deviation(felt: bool, rate: float) -> None:
    found = np.array([profile(seed, felt, rate=rate).level for seed in SEEDS])
    off = (found[:, 0] - OWN) / found[:, 1]
    assert np.abs(off).max() < 3
    assert np.sqrt(np.mean(off**2)) < 1.5


@pytest.mark.parametrize(("ports", "lag"), [(0.05, 0.0), (-0.05, 0.0), (0.0, 0.15)])
def test_the_error_of_ports_and_a_lag_are_within_the_standard_deviation(ports: float, lag: float) -> None:
    for felt in (True, False):
        off = [(value - OWN) / sd for value, sd in (profile(seed, felt, ports, lag).level for seed in SEEDS)]
        assert np.abs(np.mean(off)) < 2


@pytest.mark.parametrize("gain", [0.96, 1.04])
def test_a_gain_that_is_right_on_the_pad_alone_is_within_the_standard_deviation(gain: float) -> None:
    # zeroed where it feels 1 g, an accelerometer that is 4% off is 0.4 m/s^2 off in free fall
    found = []
    for seed in SEEDS:
        one = drag_profile(*coast_log(lambda time: OWN, seed, gain=gain))
        assert one is not None
        found.append((one.level[0] - OWN) / one.level[1])
    assert np.abs(np.mean(found)) < 1.1


def test_an_accelerometer_shows_the_drag_better_than_heights() -> None:
    assert profile(0).level[1] < 0.6 * profile(0, felt=False).level[1]


def test_drag_that_doubles_shows_when_it_doubles() -> None:
    clocks, recorded = coast_log(lambda time: OWN * (1 if time < 3.0 else 2), 3)
    found = drag_profile(clocks, recorded)
    assert found is not None
    likely = found.likelihoods[0].with_any_ports()
    step = np.where(found.time_from_liftoff < 3.0, 1.0, 2.0) * OWN / found.reference
    along = likely.given(step)
    early, late = (along[part].mean() for part in (found.time_from_liftoff < 2.9, found.time_from_liftoff > 3.1))
    assert late / early == pytest.approx(2.0, rel=0.2)


def test_the_sums_over_steps_are_the_products_with_steps() -> None:
    rng = np.random.default_rng(1)
    root = rng.normal(size=(9, 6))
    precision, shift = root.T @ root, rng.normal(size=6)
    both, constant, pushed = step_sums(precision, shift)
    step = np.array([0, 0, 1, 1, 1, 0.0])
    assert both[2, 5] == pytest.approx(step @ precision @ step)
    assert constant[2, 5] == pytest.approx(step @ precision @ np.ones(6))
    assert pushed[2, 5] == pytest.approx(step @ shift)


def test_a_log_without_a_coast_shows_no_drag() -> None:
    clocks, recorded = coast_log(lambda time: OWN, 0, speed=12.0)
    assert drag_profile(clocks, recorded) is None


def test_a_coast_that_gains_speed_shows_no_drag() -> None:
    """Heights that jumped in the boost have a start from which only a push leads to the apogee."""
    clocks, recorded = coast_log(lambda time: -OWN, 0, felt=False)
    assert drag_profile(clocks, recorded) is None

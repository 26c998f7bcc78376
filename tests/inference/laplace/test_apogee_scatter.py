"""The scatter of apogees is estimated from leave-one-out errors, and forecasts have the right width."""

import numpy as np
import pytest

from fieldkit.inference.laplace.leave_one_out import FACTORS, TAIL, apogee_spread

pytestmark = pytest.mark.fast

FLIGHTS = 400


def errors(factor: float, flights: int = FLIGHTS, seed: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of forecasts with a scatter of `factor` times the claimed one, and the two claimed variances."""
    rng = np.random.default_rng(seed)
    known, own = np.full(flights, 0.01**2), rng.uniform(0.02, 0.05, flights) ** 2
    scattered = factor * np.sqrt(own * (TAIL - 2) / TAIL) * rng.standard_t(TAIL, flights)
    return np.sqrt(known) * rng.normal(size=flights) + scattered, known, own


@pytest.mark.parametrize("factor", [0.7, 1.0, 1.8, 2.6])
def test_scatter_that_is_larger_or_smaller_than_claimed_is_found(factor: float) -> None:
    found = apogee_spread(*errors(factor), np.ones(FLIGHTS, bool))
    assert np.sqrt(FACTORS**2 @ found.weight) == pytest.approx(factor, rel=0.2)


def test_one_outlier_does_not_widen_the_intervals_of_other_flights() -> None:
    error, known, own = errors(1.0, 20)
    seen = np.ones(20, bool)
    calm = apogee_spread(error, known, own, seen)
    error[3] = 1.0
    scales = apogee_spread(error, known, own, seen)
    assert np.sqrt(scales.mean_square_without[3]) == pytest.approx(np.sqrt(calm.mean_square_without[3]))
    assert np.sqrt(FACTORS**2 @ scales.weight) < 1.3 * np.sqrt(FACTORS**2 @ calm.weight)


def test_leaving_a_flight_out_gives_the_spread_of_the_others_only() -> None:
    error, known, own = errors(1.8, 12)
    seen = np.ones(12, bool)
    others = np.arange(12) != 5
    alone = apogee_spread(error[others], known[others], own[others], seen[others])
    assert apogee_spread(error, known, own, seen).weight_without[:, 5] == pytest.approx(alone.weight)


def test_flights_without_an_apogee_have_no_influence() -> None:
    error, known, own = errors(2.6, 12)
    prior = apogee_spread(error, known, own, np.zeros(12, bool))
    assert np.log(FACTORS) @ prior.weight == pytest.approx(0.0, abs=0.05)

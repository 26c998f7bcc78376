"""Weights move slowly to the better method, and the mixture follows its weights."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from fieldkit.forecast.evaluation.forward_in_time import Forecast, next_weights, with_stacked
from fieldkit.forecast.evaluation.stacking import (
    MIN_FORECASTS_TO_STACK,
    MODEL_ALONE,
    PRIOR_FLIGHTS,
    PRIOR_OWN,
    STACKED_RIVALS,
    ScoredForecast,
    log_density,
    prior_counts,
    saved_scores,
    stacked,
    stacking_weights,
    weights_after,
)

pytestmark = pytest.mark.fast

LEVELS = (np.arange(400) + 0.5) / 400


def lognormal(median: float, sd: float) -> np.ndarray:
    """Equally likely values."""
    return np.asarray(median * np.exp(sd * norm.ppf(LEVELS)))


def test_the_density_of_draws_is_that_of_their_distribution() -> None:
    for flown in (180.0, 200.0, 230.0):
        assert log_density(lognormal(200.0, 0.1), flown) == pytest.approx(
            norm.logpdf(np.log(flown / 200), 0, 0.1), abs=0.1
        )
    half = np.concatenate([np.zeros(400), lognormal(200.0, 0.1)])
    assert log_density(half, 200.0) == pytest.approx(log_density(lognormal(200.0, 0.1), 200.0) - np.log(2))
    assert log_density(np.array([200.0]), 200.0) == -np.inf
    assert np.isfinite(log_density(lognormal(200.0, 0.01), 400.0))


def test_few_flights_do_not_move_the_weights_and_many_favor_the_better_method() -> None:
    for better in range(3):
        scores = np.zeros((300, 3))
        scores[:, better] = 2.0
        weights = stacking_weights(scores, prior_counts(3))
        assert weights.argmax() == better
        assert weights[better] > 0.9
        few = stacking_weights(scores[:3], prior_counts(3))
        assert few[0] > 0.6


def test_the_model_forecasts_alone_until_a_rival_has_the_higher_total() -> None:
    ahead, behind = (ScoredForecast(False, (0.0, own, -9.0, -9.0)) for own in (9.0, -0.1))
    assert weights_after([ahead] * (MIN_FORECASTS_TO_STACK - 1), first=False) == MODEL_ALONE
    assert weights_after([ahead] * 60, first=False)[1] > 0.8
    assert weights_after([behind] * 60, first=False) == MODEL_ALONE


def test_first_flights_and_later_ones_have_weights_of_their_own() -> None:
    scores = [
        ScoredForecast(first, (0.0, 2.0 if first else -2.0, -1.0, -1.0)) for first in (True, False) for _ in range(30)
    ]
    assert weights_after(scores, first=True)[1] > 0.5
    assert weights_after(scores, first=False) == MODEL_ALONE


def test_saved_scores_are_read_and_damaged_ones_left_out() -> None:
    good = {"earlier": 0, "log_scores": [1.0, 2.0, 3.0, 4.0]}
    bad: list[dict[str, object]] = [
        {},
        {"log_scores": None},
        {"log_scores": [1.0]},
        {"log_scores": [1.0, float("nan"), 2.0, 3.0]},
        {"log_scores": [1.0, 1e308, 2.0, 3.0]},
        {"log_scores": [1.0, 10**400, 2.0, 3.0]},
        {"log_scores": ["1", "2", "3", "4"]},
        {"log_scores": [[1.0], 2.0, 3.0, 4.0]},
        {"log_scores": [None, 2.0, 3.0, 4.0]},
    ]
    assert saved_scores([good, *bad]) == [ScoredForecast(True, (1.0, 2.0, 3.0, 4.0))]


def test_without_a_difference_the_weights_keep_their_prior() -> None:
    weights = stacking_weights(np.zeros((50, 3)), prior_counts(3))
    np.testing.assert_allclose(weights, prior_counts(3) / PRIOR_FLIGHTS)
    assert weights[0] == pytest.approx(PRIOR_OWN)
    assert stacking_weights(np.full((5, 3), -np.inf), prior_counts(3)) == pytest.approx(weights)


@given(st.lists(st.tuples(st.floats(-8, 3), st.floats(-8, 3), st.floats(-8, 3)), min_size=1, max_size=30))
def test_no_other_weights_score_higher(rows: list[tuple[float, float, float]]) -> None:
    scores, prior = np.array(rows), prior_counts(3)

    def value(weights: np.ndarray) -> float:
        return float(np.log(np.exp(scores) @ weights).sum() + prior @ np.log(weights))

    best = stacking_weights(scores, prior)
    assert best.sum() == pytest.approx(1)
    rng = np.random.default_rng(1)
    for other in rng.dirichlet(np.ones(3), 20):
        assert value(best) >= value(0.9 * best + 0.1 * other) - 1e-4


def test_a_mixture_contains_each_method_by_its_weight() -> None:
    one, other = lognormal(100.0, 0.02), lognormal(300.0, 0.02)
    mixture = stacked(one, [other], [0.7, 0.3])
    assert len(mixture) == len(one)
    assert (mixture < 200).mean() == pytest.approx(0.7, abs=0.002)
    np.testing.assert_array_equal(stacked(one, [other], [1.0, 0.0]), one)
    assert np.median(stacked(one, [other], [0.0, 1.0])) == pytest.approx(300.0, rel=0.001)


def row(number: int, flown: float, **rivals: np.ndarray) -> Forecast:
    """A forecast of 200 m, some 5% wide."""
    draws = lognormal(200.0, 0.05)
    return Forecast("Astra", str(number), "F24-4", number, flown, 184.0, 200.0, 217.0, draws, rivals)


def test_forecasts_are_stacked_from_earlier_flights_only() -> None:
    better = {"fleet_ratio": lognormal(250.0, 0.05)}
    rows = [row(n, 250.0, **better) for n in range(40)]
    found = with_stacked(rows)
    changed = with_stacked([*rows[:30], *(row(n, 200.0, **better) for n in range(30, 40))])
    medians, others = ([float(np.median(one.rivals["stacked"])) for one in all_of] for all_of in (found, changed))
    assert medians[:31] == others[:31]
    assert medians[39] != others[39]
    assert medians[0] == pytest.approx(200.0, rel=0.001)
    assert medians[-1] > 240
    assert next_weights(found)["fleet_ratio"] > 0.7


def test_the_weight_of_a_rival_without_a_forecast_or_a_spread_goes_to_the_model() -> None:
    alone = next_weights(with_stacked([row(n, 210.0, scalar=np.array([210.0])) for n in range(30)]))
    assert alone == {"fieldkit": 1.0, **dict.fromkeys(STACKED_RIVALS, 0.0)}
    (*_, last) = with_stacked([row(n, 210.0) for n in range(30)])
    np.testing.assert_allclose(np.quantile(last.rivals["stacked"], LEVELS), lognormal(200.0, 0.05), rtol=0.02)

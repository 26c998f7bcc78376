"""Proper scores, calibration relative to chance, and differences of scores on the same flights."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import norm

from fieldkit.scoring.bootstrap import paired
from fieldkit.scoring.proper_scores import calibration, crps, interval_score, pit
from fieldkit.scoring.score import Forecasts, score
from fieldkit.shapes import Array

pytestmark = pytest.mark.fast


def test_the_crps_of_a_point_is_its_error_and_that_of_a_normal_follows_the_formula() -> None:
    assert crps(np.array([210.0]), 200.0) == 10.0
    draws = np.random.default_rng(2).normal(0.0, 1.0, 40_000)
    assert crps(draws, 0.0) == pytest.approx((np.sqrt(2) - 1) / np.sqrt(np.pi), rel=0.02)  # Gneiting and Raftery, 2007


def test_the_score_is_best_for_the_truth() -> None:
    rng = np.random.default_rng(3)
    truth = rng.normal(0.0, 1.0, 600)
    mean = {
        (shift, wide): np.mean([crps(shift + wide * rng.normal(size=300), y) for y in truth])
        for shift, wide in ((0.0, 1.0), (0.7, 1.0), (0.0, 2.0), (0.0, 0.4))
    }
    assert min(mean, key=lambda key: mean[key]) == (0.0, 1.0)


def test_the_range_expected_by_chance_is_binomial() -> None:
    found = calibration([0.5] * 20)
    assert found.expected == (0.0, 4.0)
    assert found.intervals[-1].expected == (0.8, 1.0)
    assert pit(np.array([1.0, 2.0, 3.0]), 2.0) == 0.5


def test_few_draws_have_the_quantiles_of_their_distribution() -> None:
    levels = np.array([0.03, 0.04, 0.06, 0.5, 0.94, 0.97])
    draws = ndtri((np.arange(40) + 0.5) / 40)
    assert [pit(draws, value) for value in ndtri(levels)] == pytest.approx(levels, abs=4e-3)
    assert [pit(draws, value) for value in (-9.0, 9.0)] == [0.0, 1.0]
    assert pit(np.array([0.0, 0.0, 1.0, 1.0, 1.0]), 1.0) == pytest.approx(0.7)


def test_the_coverage_of_an_issued_interval_is_that_of_its_ends() -> None:
    assert [one.held for one in calibration([0.5, 0.96], inside={0.9: [True, True]}).intervals] == [0.5, 0.5, 1.0]


def test_the_score_of_an_interval_is_its_width_and_twenty_times_a_miss() -> None:
    assert interval_score(180.0, 220.0, 200.0) == 40.0
    assert interval_score(180.0, 220.0, 230.0) == pytest.approx(40 + 20 * 10)
    assert interval_score(180.0, 220.0, 179.0) == pytest.approx(40 + 20)
    assert interval_score(180.0, 220.0, 170.0, level=0.5) == pytest.approx(40 + 4 * 10)


def test_the_score_of_an_interval_is_smallest_at_the_true_quantiles() -> None:
    truth = ndtri((np.arange(1000) + 0.5) / 1000)
    ends = {
        (low, high): np.mean([interval_score(float(ndtri(low)), float(ndtri(high)), float(y)) for y in truth])
        for low in (0.01, 0.05, 0.1)
        for high in (0.9, 0.95, 0.99)
    }
    assert min(ends, key=lambda key: ends[key]) == (0.05, 0.95)


def test_differences_are_paired_and_have_a_verdict_from_five_flights_on() -> None:
    rng = np.random.default_rng(1)
    common = rng.exponential(1.0, 60)
    found = paired(common, common + 0.1 + 0.01 * rng.normal(size=60))
    assert found.less == pytest.approx(found.theirs - found.ours)
    assert found.interval[0] < found.less < found.interval[1]
    assert found.verdict == "better"
    assert paired(common + 0.1, common).verdict == "worse"
    assert paired(common, rng.permutation(common)).verdict == "unclear"
    assert paired(common[:4], common[:4] + 1).verdict == "unclear"
    assert paired(np.zeros(0), np.zeros(0)).flights == 0


def test_an_absurd_forecast_has_a_finite_score() -> None:
    """The square of an error of 1e195 m would overflow; the others are as usual."""
    one = np.ones((1, 2))
    assert np.isfinite(score(Forecasts(450 * one, one, one), np.full(2, 5.0), np.ones(2, bool)).rmse)
    usual = score(Forecasts(np.log([[110.0, 80.0]]), one, one), np.log([100.0, 100.0]), np.ones(2, bool))
    assert (usual.rmse, usual.mae) == (pytest.approx(np.sqrt(250)), pytest.approx(15))


def test_the_crps_of_a_mixture_of_normals_is_the_closed_form() -> None:
    """Grimit, Gneiting, Berrocal and Johnson, Quarterly Journal of the Royal Meteorological Society 132, 2006."""

    def distance(mean: Array, variance: Array) -> Array:
        sd = np.sqrt(variance)
        return np.asarray(2 * sd * norm.pdf(mean / sd) + mean * (2 * norm.cdf(mean / sd) - 1))

    mean, sd, weight = (
        np.array([[5.0], [5.3], [5.1]]),
        np.array([[0.05], [0.1], [0.03]]),
        np.array([[0.6], [0.2], [0.2]]),
    )
    between = 0.5 * (weight * weight.T * distance(mean - mean.T, sd**2 + sd.T**2)).sum()
    for flown in (4.0, 4.7, 5.02, 5.3, 6.0):
        exact = (weight * distance(flown - mean, sd**2)).sum() - between
        assert Forecasts(mean, sd, weight).crps(np.array([flown])) == pytest.approx(exact, rel=1e-3)

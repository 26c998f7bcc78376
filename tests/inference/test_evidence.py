"""The closed forms of the evidence, against dense normal densities and quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import log_ndtr
from scipy.stats import multivariate_normal, norm

from fieldkit.inference.evidence import (
    LinearModel,
    NormalPrior,
    StrengthPrior,
    distinct_columns,
    log_mass,
    normal_posterior,
    pair_evidence,
    strength_posterior,
    term_posterior,
)

RNG = np.random.default_rng(5)
SLOPE, MISS, SDS = RNG.normal(size=(6, 3)), RNG.normal(size=6), np.array([0.5, 1.0, 2.0])


def dense(columns: list[int]) -> float:
    """Log evidence of unit noise and some terms, against none."""
    covariance = np.eye(6) + (SLOPE[:, columns] * SDS[columns] ** 2) @ SLOPE[:, columns].T
    return float(multivariate_normal.logpdf(MISS, cov=covariance) - multivariate_normal.logpdf(MISS, cov=np.eye(6)))


def test_the_evidence_of_terms_is_that_of_a_normal_density_with_their_covariance() -> None:
    found = normal_posterior(SLOPE.T @ SLOPE, SLOPE.T @ MISS, np.diag(1 / SDS**2), np.array(-2 * np.log(SDS).sum()))
    assert found.log_bayes == pytest.approx(dense([0, 1, 2]))


def test_terms_that_act_only_by_their_sum_have_the_posterior_of_each_alone() -> None:
    """With some independent terms, some with a joint prior, and one on which no readout depends."""
    sums = np.array([[1, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 0.0]])
    slope = RNG.normal(size=(2, 9, 2)) @ sums
    joint, block, variance = np.array([0, 2, 3]), np.cov(RNG.normal(size=(3, 9))), np.exp(RNG.normal(size=(2, 6)))
    variance[:, joint] = 0
    prior = NormalPrior(variance, joint, block)
    distinct, found_sums = distinct_columns(slope[0])
    np.testing.assert_array_equal(found_sums, sums)
    np.testing.assert_array_equal(distinct, slope[0][:, :2])
    score = RNG.normal(size=(2, 2))
    information = np.swapaxes(slope, 1, 2) @ slope
    few = information[:, :2, :2]
    found = term_posterior(few, score, prior, sums)
    precision = np.linalg.inv(prior.covariance())
    mean, covariance, log_bayes = normal_posterior(
        information, score @ sums, precision, np.linalg.slogdet(precision).logabsdet
    )
    np.testing.assert_allclose(found.offset, mean, rtol=1e-9)
    np.testing.assert_allclose(found.covariance(), covariance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.covariance(np.array([1])), covariance[1:], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.variance(np.array([4, 0])), np.diagonal(covariance, 0, 1, 2)[:, [4, 0]])
    np.testing.assert_allclose(found.covariance_of(sums), sums @ covariance @ sums.T, rtol=1e-9)
    np.testing.assert_allclose(found.log_bayes, log_bayes, rtol=1e-9)


def test_the_evidence_of_a_pair_is_that_of_both_terms() -> None:
    gram, score = SLOPE.T @ SLOPE, SLOPE.T @ MISS
    found = pair_evidence(gram, np.diagonal(gram) + 1 / SDS**2, score[:, None]) - np.log(np.multiply.outer(SDS, SDS))
    for one, other in ((0, 1), (0, 2), (2, 1)):
        assert found[one, other] == pytest.approx(dense([one, other]))


def test_a_bounded_strength_has_the_evidence_of_quadrature() -> None:
    a, b, mean, sd, low, high = (np.array([one]) for one in (4.0, 3.0, 0.2, 0.5, 0.0, 0.9))
    prior = StrengthPrior(mean, sd, low, high, log_mass(mean, sd, low, high))
    found, _, _ = strength_posterior(a, b, prior)
    mass = norm.cdf(0.9, 0.2, 0.5) - norm.cdf(0.0, 0.2, 0.5)
    whole, _ = quad(lambda s: np.exp(3 * s - 2 * s**2) * norm.pdf(s, 0.2, 0.5) / mass, 0.0, 0.9)
    assert found[0] == pytest.approx(np.log(whole))


def test_a_strength_far_outside_its_bounds_gains_nothing_from_the_distance() -> None:
    """The readouts favor -20 standard deviations of a strength that cannot be negative."""
    a, b, one, zero = np.array([400.0]), np.array([-400.0]), np.ones(1), np.zeros(1)
    assert log_mass(-20 * one, one, zero, np.inf * one)[0] == pytest.approx(log_ndtr(-20.0))
    positive = StrengthPrior(zero, one, zero, np.inf * one, np.log([0.5]))
    assert strength_posterior(a, b, positive)[0][0] < 0


def test_products_after_the_terms_are_refitted_are_those_with_the_inverse_covariance_of_all_readouts() -> None:
    slope, change = RNG.normal(size=(4, 2, 3)), RNG.normal(size=(4, 2, 5))
    noise = np.stack([np.diag(RNG.uniform(0.5, 2.0, 2)) for _ in range(4)])[None]
    sharpness, prior = np.linalg.inv(noise), np.diag(1 / SDS**2)
    covariance = np.linalg.inv(prior + np.einsum("fot,sfop,fpu->stu", slope, sharpness, slope))
    whole = np.zeros((8, 8))
    for row in range(4):
        whole[2 * row : 2 * row + 2, 2 * row : 2 * row + 2] = noise[0, row]
    whole += slope.reshape(8, 3) @ np.diag(SDS**2) @ slope.reshape(8, 3).T
    model = LinearModel(slope, sharpness, covariance)
    columns = model.regressors(change)
    weighed = np.linalg.solve(whole, change.reshape(8, 5))
    np.testing.assert_allclose(model.weighed(columns, 0), weighed)
    np.testing.assert_allclose(columns.gram()[0], change.reshape(8, 5).T @ weighed)
    np.testing.assert_allclose(columns.products(columns)[0], np.diagonal(columns.gram()[0]))
    np.testing.assert_allclose(columns.every(1, 3).gram()[0], columns.gram()[0][1::3, 1::3])

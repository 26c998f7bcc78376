"""The closed forms of the evidence, against dense normal densities and quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import log_ndtr
from scipy.stats import multivariate_normal, norm

from fieldkit.inference.evidence import (
    LinearModel,
    StrengthPrior,
    grouped_posterior,
    log_mass,
    normal_posterior,
    pair_evidence,
    strength_posterior,
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


def test_scales_with_the_same_readouts_have_the_posterior_of_each_alone() -> None:
    """The terms whose prior they share are eliminated once."""
    slope, group, varied = RNG.normal(size=(2, 9, 5)), np.array([0, 0, 0, 1, 1]), np.isin(np.arange(5), [1, 4])
    information, score = np.swapaxes(slope, 1, 2) @ slope, RNG.normal(size=(2, 5))
    shared = np.linalg.inv(np.cov(RNG.normal(size=(3, 9))))  # terms with a joint prior
    sds = np.exp(RNG.normal(size=(5, 5)))
    prior = np.stack([np.diag(1 / row**2) for row in sds])
    prior[:, np.array([[0], [2], [3]]), np.array([0, 2, 3])] = shared
    log_det = np.linalg.slogdet(prior)[1]
    found = grouped_posterior(information, score, prior, log_det, group, varied)
    alone = normal_posterior(information[group], score[group], prior, log_det)
    for one, other in zip(found, alone, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


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

"""The Gamma function and distribution agree with scipy's."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import digamma, gammaincinv, gammaln

from fieldkit.inference.gamma import gamma_quantiles, log_gamma
from fieldkit.inference.laplace.outlier_flights import log_tail


def test_its_logarithm_is_that_of_scipy() -> None:
    values = np.geomspace(1e-3, 1e4, 60).reshape(3, 20)
    assert_allclose(log_gamma(values), gammaln(values), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("shape", [0.05, 0.5, 1.0, 2.0, 7.5, 100.0, 5000.0])
def test_its_quantiles_are_those_of_scipy(shape: float) -> None:
    level = np.concatenate([[1e-6, 1e-3], (np.arange(32) + 0.5) / 32, [0.999]])
    assert_allclose(gamma_quantiles(shape, level), gammaincinv(shape, level), rtol=1e-9)


def test_the_tail_of_outlier_flights_is_its_variational_bound() -> None:
    weight, count, nu = np.array([0.2, 0.9, 1.6]), np.array([1, 3, 6]), 4.0
    a, a0 = (nu + count) / 2, nu / 2
    b = a / weight
    jensen = count / 2 * (digamma(a) - np.log(b) - np.log(weight))
    divergence = (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * (np.log(b) - np.log(a0)) + a * (a0 - b) / b
    assert_allclose(log_tail(weight, count, nu), jensen - divergence, rtol=1e-12)
    assert log_tail(np.ones(1), np.zeros(1, dtype=int), nu) == 0.0

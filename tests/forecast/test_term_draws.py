"""Draws of terms: bounds truncate a distribution and do not collect draws at its ends."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from fieldkit.flight import Flight
from fieldkit.forecast.term_draws import term_draws
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
DRAWS = 4000
WIND = effects()["wind"]


def model() -> Model:
    """Drag, which is unbounded, and wind, whose square is not below zero."""
    prior = WIND.prior
    terms = (
        Term(TermName("drag"), "drag", 0.0, 1.0, np.ones(1)),
        Term(TermName("wind", "effect"), WIND, prior.mean, prior.sd, np.ones(1), prior.low, prior.high),
    )
    return Model(history_of([Flight()], []), terms)


def fitted(terms: list[int], mean: np.ndarray, covariance: np.ndarray) -> Any:
    """A fit of some terms at one pair of scales."""
    weights = np.zeros(len(model().hyperprior.scales()[0]))
    weights[0] = 1.0
    several = len(weights)
    return SimpleNamespace(
        model=model().only(terms),
        mean=np.tile(mean, (several, 1)),
        covariance=np.tile(covariance, (several, 1, 1)),
        weights=weights,
    )


def test_a_posterior_at_a_bound_is_truncated_together_with_correlated_terms() -> None:
    covariance = np.array([[1.0, 0.8], [0.8, 1.0]])
    values, _ = term_draws(model(), [0, 1], fitted([0, 1], np.zeros(2), covariance), DRAWS, np.random.default_rng(0))
    assert values[:, 1].min() > 0.0
    assert kstest(values[:, 1], truncnorm(0.0, 6.0).cdf).pvalue > 0.01
    assert values[:, 0].mean() == pytest.approx(0.8 * np.sqrt(2 / np.pi), abs=0.06)


def test_the_prior_of_an_unconstrained_term_is_truncated() -> None:
    result = fitted([0], np.zeros(1), np.eye(1))
    values, _ = term_draws(model(), [0], result, DRAWS, np.random.default_rng(0))
    prior = WIND.prior
    ends = (prior.low - prior.mean) / prior.sd, (prior.high - prior.mean) / prior.sd
    assert kstest(values[:, 1], truncnorm(*ends, loc=prior.mean, scale=prior.sd).cdf).pvalue > 0.01


def test_a_motor_and_its_lot_deviate_independently() -> None:
    names = [TermName("thrust", "motor", "Estes C6"), TermName("thrust", "lot", "Estes C6 lot 2")]
    terms = tuple(Term(name, "thrust", 0.0, 1.0, np.ones(1)) for name in names)
    known = model().with_terms(*terms)
    values, _ = term_draws(known, [0, 1], fitted([0, 1], np.zeros(2), np.eye(2)), DRAWS, np.random.default_rng(0))
    assert np.corrcoef(values[:, 2], values[:, 3])[0, 1] == pytest.approx(0.0, abs=0.05)


def test_a_posterior_far_beyond_a_bound_is_at_the_bound() -> None:
    result = fitted([0, 1], np.array([0.0, -60.0]), np.eye(2))
    values, _ = term_draws(model(), [0, 1], result, 50, np.random.default_rng(0))
    assert (values[:, 1] == WIND.prior.low).all()

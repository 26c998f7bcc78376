"""The odds of effects beside each other, compared with sums over sets and with the limits of Bayes' theorem."""

from itertools import combinations

import numpy as np
import pytest

from fieldkit.inference.history.effect_probabilities import log_odds

pytestmark = pytest.mark.fast
PRIOR = np.full(2, np.log(0.25))
"""Log odds of two effects before any flight. [nat]"""


def test_odds_are_sums_over_sets_of_at_most_two() -> None:
    rng = np.random.default_rng(1)
    alone, prior, count = rng.normal(0.0, 3.0, 5), rng.normal(-2.0, 1.0, 5), 5
    both = rng.normal(0.0, 3.0, (count, count))
    both = both + both.T
    beside = np.where(np.eye(count, dtype=bool), alone[:, None], both - alone[None, :])
    sets: list[tuple[int, ...]] = [(), *((i,) for i in range(count)), *combinations(range(count), 2)]
    evidence = {one: both[one] if len(one) == 2 else sum(alone[i] for i in one) for one in sets}
    weight = {one: np.exp(prior[list(one)].sum() + evidence[one]) for one in sets}
    found, none = log_odds(prior, alone, beside)
    for i in range(count):
        there = sum(value for one, value in weight.items() if i in one)
        assert np.exp(found[i]) == pytest.approx(there / (sum(weight.values()) - there))
    assert np.exp(none) == pytest.approx(weight[()] / (sum(weight.values()) - weight[()]))


def test_effects_that_explain_the_same_flights_share_the_odds() -> None:
    alone = np.array([20.0, 20.0])
    found, none = log_odds(PRIOR, alone, np.array([[20.0, -1.0], [-1.0, 20.0]]))
    assert np.abs(found).max() < 1.0
    assert none < -15.0


def test_an_effect_that_shows_only_beside_another_gets_its_odds() -> None:
    found, _ = log_odds(PRIOR, np.array([15.0, 0.0]), np.array([[15.0, 27.0], [12.0, 0.0]]))
    assert found.min() > 8.0


def test_without_effects_there_are_no_odds() -> None:
    found, none = log_odds(np.zeros(0), np.zeros(0), np.zeros((0, 0)))
    assert len(found) == 0
    assert none == 0.0

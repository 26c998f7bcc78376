"""The problem with an exact answer: the lowest possible error of any method."""

import numpy as np
import pytest

from fieldkit.model.observations import disc
from fieldkit.physics.paper import DIAMETER
from studies.validation.restricted import SUBSETS, Exact, Restricted, exact, restricted_draws

pytestmark = pytest.mark.fast

FLIGHTS = 300


@pytest.fixture(scope="module")
def flights() -> Restricted:
    return restricted_draws(np.random.default_rng(1), FLIGHTS)[0]


@pytest.fixture(scope="module")
def grid() -> Exact:
    return exact(100)


@pytest.mark.parametrize(
    ("names", "cd", "alpha"),
    [("apogee", 0.0878, 0.0707), ("apogee, speed", 0.023, 0.013), ("all five", 0.0165, 0.0098)],
)
def test_the_exact_posterior_has_the_known_error(
    names: str, cd: float, alpha: float, flights: Restricted, grid: Exact
) -> None:
    found = np.array([grid.medians(flights, row, SUBSETS[names]) for row in range(FLIGHTS)])
    truth = np.stack([np.exp(flights.truth[:, 0]) / disc(np.asarray(DIAMETER)), flights.truth[:, 1]], axis=-1)
    assert np.abs(found - truth).mean(axis=0) == pytest.approx([cd, alpha], rel=0.15)


def test_a_log_posterior_sums_to_one(flights: Restricted, grid: Exact) -> None:
    assert np.exp(grid.log_posterior(flights, 0, ("apogee",))).sum() == pytest.approx(1.0)

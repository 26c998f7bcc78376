"""Mixtures over bounded parameters: they integrate to one, their draws stay inside, their margins agree."""

import numpy as np
import pytest

from fieldkit.inference.network.mixture import COMPONENTS, WIDTH, Mixture, logits, mixture
from fieldkit.inference.validation.field import score

pytestmark = pytest.mark.fast

LOW, HIGH = np.array([-8.0, 0.75]), np.array([-6.0, 1.25])


def some(flights: int, seed: int = 1, spread: float = 0.4) -> Mixture:
    outputs = np.random.default_rng(seed).normal(0.0, spread, size=(flights, 3, WIDTH))
    return mixture(outputs, np.broadcast_to(LOW, (flights, 2)), np.broadcast_to(HIGH, (flights, 2)))


def test_weights_of_all_members_sum_to_one() -> None:
    found = some(4)
    assert found.weight.shape == (4, 3 * COMPONENTS)
    assert found.weight.sum(axis=1) == pytest.approx(np.ones(4))


def test_a_density_integrates_to_one_over_its_interval() -> None:
    cells = (np.arange(200) + 0.5) / 200
    x, y = np.meshgrid(LOW[0] + 2.0 * cells, LOW[1] + 0.5 * cells)
    values = np.stack([x.ravel(), y.ravel()], axis=-1)[:, None]
    total = np.exp(some(2).log_density(values)).sum(axis=0) * (2.0 * 0.5) / 200**2
    assert total == pytest.approx([1.0, 1.0], abs=0.02)


def test_the_density_outside_of_its_interval_is_zero() -> None:
    assert some(1).log_density(np.array([[-5.9, 1.0]]))[0] == -np.inf


def test_draws_stay_inside_and_agree_with_the_margins() -> None:
    found = some(3)
    drawn = found.draws(np.random.default_rng(2), 40_000)
    assert ((drawn > LOW) & (drawn < HIGH)).all()
    levels = np.array([0.05, 0.5, 0.95])
    for axis in (0, 1):
        margin = found.margin(axis)
        assert margin.quantiles(levels) == pytest.approx(
            np.quantile(drawn[..., axis], levels, axis=0).T, abs=0.02 * (HIGH - LOW)[axis]
        )
        mean, sd = margin.moments()
        assert mean == pytest.approx(drawn[..., axis].mean(axis=0), abs=0.01 * (HIGH - LOW)[axis])
        assert sd == pytest.approx(drawn[..., axis].std(axis=0), rel=0.03)


def test_logits_and_intervals_are_inverse_functions() -> None:
    values = np.array([[-7.3, 0.9], [-6.1, 1.2]])
    line = logits(values, np.broadcast_to(LOW, (2, 2)), np.broadcast_to(HIGH, (2, 2)))
    assert LOW + (HIGH - LOW) / (1 + np.exp(-line)) == pytest.approx(values)


def test_a_right_posterior_is_recognized_as_calibrated_and_an_overconfident_one_is_not() -> None:
    rng = np.random.default_rng(3)
    found = some(3000)
    truth = found.draws(rng, 1)[0]
    right, _ = score(rng, found, truth)
    sure = Mixture(found.weight, found.mean, found.sharp + 0.5, found.slope, found.low, found.high)
    wrong, _ = score(rng, sure, truth)
    for name in ("drag_area", "alpha"):
        assert right["coverage"][name]["0.8"] == pytest.approx(0.8, abs=0.03)
    assert wrong["coverage"]["alpha"]["0.8"] < 0.77
    assert right["expected_coverage"]["covered"] == pytest.approx(right["expected_coverage"]["at"], abs=0.03)

"""Evidence and leave-one-out by importance sampling, compared with more draws and with repeated fits."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.stats import genpareto

from fieldkit.inference.laplace import importance
from fieldkit.inference.laplace.fit import fit, refits_without
from fieldkit.inference.laplace.importance import (
    BATCH,
    DRAWS,
    MORE_DRAWS,
    RELIABLE_PARETO_K,
    Sampled,
    _squares,
    sampled,
    summed,
)
from fieldkit.inference.laplace.outlier_weights import flight_weights
from fieldkit.inference.laplace.pareto import smoothed
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data, observe
from fieldkit.model.rocket_model import Model, base_model
from fieldkit.model.term_names import TermName
from fieldkit.physics.history import history_of
from tests.seasons import season

pytestmark = pytest.mark.fast

CHECK_SHAPES = False


@cache
def fitted(readouts: int = 6) -> Fit:
    """The plain model fitted to a season with some of its readouts."""
    model, data = _season()
    seen = data.seen & (np.arange(len(OBSERVED_READOUTS)) < readouts)
    return fit(model, replace(data, seen=seen), outlier_flights=True)


def _season() -> tuple[Model, Data]:
    flown = season(np.random.default_rng(7), OBSERVED_READOUTS[:6])
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    history = history_of(flights, found, used_in_fit=[True] * len(flights))
    return base_model(history, CERTIFIED_PRIOR), observe(history, CERTIFIED_PRIOR)


@cache
def drawn(readouts: int = 6) -> Sampled:
    return sampled(fitted(readouts), np.random.default_rng(1))


@pytest.mark.sampled
@pytest.mark.parametrize("readouts", [6, 2, 1])
def test_few_draws_agree_with_many(readouts: int) -> None:
    few, many = drawn(readouts), sampled(fitted(readouts), np.random.default_rng(2), 12_000)
    assert few.pareto_k < RELIABLE_PARETO_K
    assert abs(few.log_evidence - many.log_evidence) < 4 * np.hypot(few.error, many.error)
    np.testing.assert_allclose(few.log_without, many.log_without, atol=0.35)


def test_likelihoods_are_computed_in_batches_and_the_fit_is_kept_without_its_solution(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sizes: list[int] = []

    def counted(fit: Fit, evidence: Any, flown: Any) -> Any:
        sizes.append(len(flown))
        return given(fit, evidence, flown)

    given = importance._given
    monkeypatch.setattr(importance, "_given", counted)
    monkeypatch.setattr(importance, "RELIABLE_PARETO_K", -np.inf)  # no draws are enough
    found = sampled(fitted(), np.random.default_rng(1))
    assert sizes == [BATCH] * (DRAWS // BATCH * MORE_DRAWS)
    assert found.fit.solution is None


def test_the_fits_lower_bound_is_close_below_the_evidence() -> None:
    gap = drawn().log_evidence - fitted().log_evidence
    assert -3 * drawn().error < gap < 2.5


def test_a_model_in_which_a_flight_cannot_lift_off_has_no_evidence() -> None:
    model, data = _season()
    heavy = [one.with_changes(dry_mass=9.0) if row == 2 else one for row, one in enumerate(model.flights)]
    result = fit(base_model(history_of(heavy, model.found), CERTIFIED_PRIOR), data, outlier_flights=True)
    assert np.isnan(result.tangent.values[2]).all()
    found = sampled(result, np.random.default_rng(1))
    assert -3 * found.error < found.log_evidence - result.log_evidence < 2.5


def test_leave_one_out_agrees_with_a_fit_without_the_flight() -> None:
    result, rows = fitted(), [0, 4]
    for row, again in zip(rows, refits_without(result, rows), strict=True):
        assert not again.data.seen[row].any()
        exact = sampled(again, np.random.default_rng(3), 4000)
        assert drawn().log_without[row] == pytest.approx(exact.log_evidence, abs=0.3)
        mean = (drawn().weight * drawn().mean)[:, row].sum()
        other = (exact.weight * exact.mean)[:, row].sum()
        spread = np.sqrt((exact.weight * (exact.known + exact.own))[:, row].sum())
        assert abs(mean - other) < 0.25 * spread


def test_an_outlier_has_little_weight() -> None:
    result = fitted()
    values = result.data.values.copy()
    values[3, :2] -= 0.5
    with_outlier = fit(result.model, replace(result.data, values=values), outlier_flights=True)
    weight = flight_weights(with_outlier)
    assert weight[3] < 0.35
    assert np.median(np.delete(weight, 3)) > 0.8
    plain = fit(result.model, replace(result.data, values=values))
    drag = result.model.names.index(TermName("drag"))
    true, robust, other = (one.moments()[0][drag] for one in (result, with_outlier, plain))
    assert abs(robust - true) <= max(abs(other - true), 0.01)


@pytest.mark.parametrize("shape", [0.2, 0.6, 1.1])
def test_the_shape_of_a_pareto_tail_is_estimated(shape: float) -> None:
    weight = genpareto(shape).rvs(20_000, random_state=4)
    smooth, found = smoothed(np.log(weight))
    assert found == pytest.approx(shape, abs=0.15)
    assert smooth.max() <= np.log(weight).max()
    assert np.all(np.diff(smooth[np.argsort(np.log(weight))]) >= -1e-9)


def test_squares_are_the_mahalanobis_distances_of_each_flight() -> None:
    rng = np.random.default_rng(3)
    miss, half = rng.normal(size=(5, 4, 3)), rng.normal(size=(2, 4, 3, 3))
    sharp = half @ np.swapaxes(half, -1, -2)
    expected = np.einsum("dfo,sfop,dfp->dsf", miss, sharp, miss)
    np.testing.assert_allclose(_squares(miss, sharp), expected, rtol=1e-10)


def test_sums_over_scales_keep_their_parts_and_pass_draws_outside_the_bounds() -> None:
    joint = np.array([[-1000.0, -1001.0], [-np.inf, -np.inf], [3.0, -np.inf]])
    total, parts = summed(joint)
    np.testing.assert_allclose(total, [-1000 + np.log1p(np.exp(-1)), -np.inf, 3.0])
    np.testing.assert_allclose(parts.sum(axis=1), [1, 0, 1])

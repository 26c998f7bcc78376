"""Grids of scales around their mode: the evidence on them is that on a dense grid."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.inference.laplace.scale_grids import around_mode
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import base_model
from fieldkit.physics.history import history_of
from tests.seasons import season

pytestmark = pytest.mark.fast


@cache
def fitted(readouts: int) -> Fit:
    """A fit of a season's flights with some of the readouts."""
    flown = season(np.random.default_rng(7), OBSERVED_READOUTS[:readouts])
    flights = [flight for flight, _ in flown]
    model = base_model(history_of(flights, [motor for _, motor in flown]), CERTIFIED_PRIOR)
    return fit(model, observe(model.history.using([True] * len(flights)), CERTIFIED_PRIOR), outlier_flights=True)


def midpoints(low: float, high: float, count: int = 30) -> tuple[float, ...]:
    """The midpoints of even intervals of a logarithm."""
    edges = np.linspace(np.log(low), np.log(high), count + 1)
    return tuple(np.exp((edges[1:] + edges[:-1]) / 2).tolist())


def on_dense_grids(result: Fit) -> Fit:
    """The same fit with dense grids of all scales between the ends of their priors."""
    before = fitted(1).model.hyperprior
    dense = before.with_scales(*(replace(scale, grid=midpoints(*scale.range)) for scale in before.unknown_scales))
    return solve(replace(result.model, hyperprior=dense), result.data, result.tangent, result.flight_weight)


@pytest.mark.thorough
@pytest.mark.sampled
@pytest.mark.parametrize("readouts", [6, 2, 1])
def test_a_few_values_of_each_scale_around_its_mode_integrate_like_a_dense_grid(readouts: int) -> None:
    fine = around_mode(fitted(readouts))
    dense = on_dense_grids(fine)
    assert fine.log_evidence == pytest.approx(dense.log_evidence, abs=0.15)
    for own, other in zip(fine.moments(), dense.moments(), strict=True):
        np.testing.assert_allclose(own, other, rtol=0.05, atol=0.02)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0, 4.0])
def test_the_mode_is_found_from_any_grid_of_the_fit(factor: float) -> None:
    """If the first grid does not contain the mode, the log density may rise to the end of the prior."""
    coarse = fitted(6)
    hyperprior = coarse.model.hyperprior
    assert hyperprior.motors
    moved = replace(hyperprior.motors, grid=tuple(factor * value for value in (0.7, 1.4)))
    other = replace(coarse.model, hyperprior=replace(hyperprior, motors=moved))
    start = solve(other, coarse.data, coarse.tangent, coarse.flight_weight)
    fine = around_mode(start)
    assert fine.log_evidence == pytest.approx(on_dense_grids(fine).log_evidence, abs=0.2)


def test_no_value_around_the_mode_has_nearly_all_the_weight() -> None:
    assert fitted(6).weights.max() > 0.8
    assert around_mode(fitted(6)).weights.max() < 0.3


def test_regular_burn_times_and_delays_do_not_lower_the_scatter_of_thrust() -> None:
    """They do if one scale stands for both: then scatter of thrust looks like an effect."""

    def scatter_of_thrust(one_scale: bool) -> float:
        coarse = fitted(6)
        hyperprior = replace(CERTIFIED_PRIOR, motors=None) if one_scale else CERTIFIED_PRIOR
        fine = around_mode(fit(replace(coarse.model, hyperprior=hyperprior), coarse.data, outlier_flights=True))
        return float(fine.weights @ fine.model.scatter_scales()[:, 0])

    assert scatter_of_thrust(one_scale=True) < 0.7 < 0.85 < scatter_of_thrust(one_scale=False) < 1.2

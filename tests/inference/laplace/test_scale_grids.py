"""Grids of scales around their mode: the evidence on them is that on a dense grid."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.inference.laplace.scale_grids import around_mode
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import base_model
from tests.seasons import season

pytestmark = pytest.mark.fast


@cache
def fitted(readouts: int) -> Fit:
    """A fit of a season's flights with some of the readouts."""
    flown = season(np.random.default_rng(7), OBSERVED_READOUTS[:readouts])
    flights = [flight for flight, _ in flown]
    model = base_model(flights, [motor for _, motor in flown])
    return fit(model, observe(model.flights, model.found, [True] * len(flights)), outlier_flights=True)


def midpoints(low: float, high: float, count: int = 150) -> tuple[float, ...]:
    """The midpoints of even intervals of a logarithm."""
    edges = np.linspace(np.log(low), np.log(high), count + 1)
    return tuple(np.exp((edges[1:] + edges[:-1]) / 2).tolist())


def on_dense_grids(result: Fit) -> Fit:
    """The same fit with dense grids of both scales between the ends of their priors."""
    before = fitted(1).model.hyperprior
    scatter, reading = (
        replace(scale, grid=midpoints(scale.grid[0], scale.grid[-1])) for scale in (before.scatter, before.reading)
    )
    dense = replace(before, scatter=scatter, reading=reading)
    return solve(replace(result.model, hyperprior=dense), result.data, result.tangent, result.flight_weight)


@pytest.mark.thorough
@pytest.mark.sampled
@pytest.mark.parametrize("readouts", [6, 2, 1])
def test_five_values_of_each_scale_around_its_mode_integrate_like_a_dense_grid(readouts: int) -> None:
    fine = around_mode(fitted(readouts))
    dense = on_dense_grids(fine)
    assert fine.log_evidence == pytest.approx(dense.log_evidence, abs=0.1)
    for own, other in zip(fine.moments(), dense.moments(), strict=True):
        np.testing.assert_allclose(own, other, rtol=0.05, atol=0.02)


def test_no_value_around_the_mode_has_nearly_all_the_weight() -> None:
    assert fitted(6).weights.max() > 0.8
    assert around_mode(fitted(6)).weights.max() < 0.3

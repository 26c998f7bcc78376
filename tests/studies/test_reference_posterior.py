"""The exact sampler on problems with known answers: densities and models with a normal posterior."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.inference.laplace.linearization import launch_angle_slope, tangents
from fieldkit.model.hyperprior import START, Hyperprior, learned
from fieldkit.model.readout_data import Data, observe
from fieldkit.model.rocket_model import Model, apogee_scatter, base_model
from fieldkit.model.scale import Scale
from fieldkit.physics.history import history_of
from fieldkit.shapes import Array
from studies.generated_ledgers import LedgerRecipe, ledger
from studies.reference_posterior.hamiltonian import effective_size, sample, split_r_hat
from studies.reference_posterior.readouts import linear
from studies.reference_posterior.summaries import excess_crps
from studies.reference_posterior.target import Target, target


@pytest.mark.fast
def test_chains_sample_a_normal_distribution_with_an_inexact_force() -> None:
    rng = np.random.default_rng(3)
    root = np.eye(5) + 0.2 * rng.normal(size=(5, 5))
    covariance, mean = root @ root.T, np.arange(5.0)
    precision = np.linalg.inv(covariance)
    wrong = precision * rng.uniform(0.85, 1.15, 5)

    def density(at: Array) -> tuple[Array, Array]:
        away = at - mean
        return -0.5 * np.einsum("ci,ij,cj->c", away, precision, away), -away @ wrong.T

    chains = sample(density, mean + 3 * rng.normal(size=(200, 5)), 100, 400, rng)
    flat = chains.positions.reshape(-1, 5)
    size = min(effective_size(chains.positions[..., i]) for i in range(5))
    assert size > 2000
    assert max(split_r_hat(chains.positions[..., i]) for i in range(5)) < 1.02
    sds = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(flat.mean(axis=0), mean, atol=4 * sds.max() / np.sqrt(size))
    np.testing.assert_allclose(np.cov(flat.T) / np.outer(sds, sds), covariance / np.outer(sds, sds), atol=0.1)


def test_a_start_without_a_density_is_reported() -> None:
    with pytest.raises(ValueError, match="outside the support"):
        sample(lambda at: (np.full(len(at), -np.inf), at), np.zeros((2, 1)), 1, 1, np.random.default_rng(0))


def plain(motors: Scale | None = None) -> Hyperprior:
    """Known scales and an opening time far from its bound: with normal residuals, the posterior is normal."""
    known = Scale((1.0,), 1.0, 1e-9)
    return replace(learned(), scatter=known, reading=known, motors=motors, opening=(4.0, 0.3))


def linear_target(student: bool, motors: Scale | None = None) -> tuple[Model, Data, Target]:
    (history,) = ledger(np.random.default_rng(4), [LedgerRecipe(4, 2)], learned())
    flights, found = zip(*history.flown, strict=True)
    model = base_model(history_of(flights, found), plain(motors))
    data = observe(model.history.using([True] * len(flights)), model.hyperprior)
    at = np.array([term.mean for term in model.terms])
    (near,) = tangents(model, [(tuple(range(len(at))), at)], launch_angle_slope(model, at))
    return model, data, target(model, data, at, linear(model, near), student=student)


@pytest.mark.thorough
def test_the_sampler_agrees_with_the_closed_form_of_a_linear_model() -> None:
    model, data, density = linear_target(student=False)
    read, scatter = density.readouts, {kind.bends: kind.sd for kind in model.scatter}
    count, flights = len(model.terms), len(model.flights)
    means, sds = (np.array([getattr(term, name) for term in model.terms]) for name in ("mean", "sd"))
    at = read(means[None], {})[0]
    by_term = read(means + np.eye(count), {}) - at
    every = np.ones((1, flights))
    by_scatter = [(read(means[None], {kind: every})[0] - at) * sd for kind, sd in scatter.items()]
    width = data.sd**2
    width[:, 0] += apogee_scatter(model) ** 2
    # every flight has its own random effects, which act as noise within a flight: y = A x + noise
    noise = np.zeros((flights, width.shape[1], flights, width.shape[1]))
    for f in range(flights):
        noise[f, :, f] = sum(np.outer(one[f], one[f]) for one in by_scatter) + np.diag(width[f])
    seen = density.seen.ravel()
    slope = by_term.reshape(count, -1).T[seen]
    inverse = np.linalg.inv(noise.reshape(len(seen), -1)[np.ix_(seen, seen)])
    covariance = np.linalg.inv(slope.T @ inverse @ slope + np.diag(1 / sds**2))
    mean = means + covariance @ slope.T @ inverse @ (data.values - at).ravel()[seen]

    rng = np.random.default_rng(0)
    middle = density.coordinates(means)
    root = np.linalg.inv(np.linalg.cholesky(density.curvature(middle)))

    def whitened(place: Array) -> tuple[Array, Array]:
        log_density, force = density(middle + place @ root)
        return log_density, force @ root.T

    chains = sample(whitened, rng.normal(size=(200, density.dimension)), 100, 200, rng)
    terms = density.point(middle + chains.positions.reshape(-1, density.dimension) @ root).terms
    own = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((terms.mean(axis=0) - mean) / own, 0, atol=0.1)
    np.testing.assert_allclose(np.cov(terms.T) / np.outer(own, own), covariance / np.outer(own, own), atol=0.12)


@pytest.mark.parametrize(("student", "motors"), [(True, START.motors), (False, None)])
def test_the_force_of_a_linear_model_is_the_gradient(student: bool, motors: Scale | None) -> None:
    model, _, density = linear_target(student, motors)
    rows = {str(kind.bends): np.ones((1, len(model.flights))) for kind in model.scatter}
    means = np.array([[term.mean for term in model.terms]])
    at = density.readouts(means, {})
    slopes = density.slopes[0].copy()
    for name, row in rows.items():  # the slopes of the linear readouts in place of those of wider steps
        slopes[..., density.kinds.index(name)] = (density.readouts(means, {name: row}) - at)[0]
    for name in ("mass", "opening"):
        moved = means + np.array([float(term.bends == name and term.weight.all()) for term in model.terms])
        count = sum(term.bends == name and bool(term.weight.all()) for term in model.terms)
        slopes[..., density.kinds.index(name)] = (density.readouts(moved, {}) - at)[0] / count
    density = replace(density, slopes=np.stack([slopes, slopes]))
    place = np.random.default_rng(1).normal(size=density.dimension) * 0.5
    step = 1e-5 * np.eye(density.dimension)
    gradient = (density(place + step)[0] - density(place - step)[0]) / 2e-5
    np.testing.assert_allclose(density(place[None])[1][0], gradient, rtol=1e-4, atol=1e-4)


def test_the_excess_crps_agrees_with_its_definition() -> None:
    rng = np.random.default_rng(2)
    exact, forecast = rng.normal(size=400), 0.3 + 1.5 * rng.normal(size=400)

    def crps(draws: Array) -> float:
        """Expected CRPS over truths that are the exact draws."""
        spread = np.abs(draws[:, None] - draws).mean() / 2
        return float(np.abs(draws[:, None] - exact).mean() - spread)

    assert excess_crps(forecast, exact) == pytest.approx(crps(forecast) / crps(exact) - 1, rel=1e-6)
    assert excess_crps(exact, exact) == 0

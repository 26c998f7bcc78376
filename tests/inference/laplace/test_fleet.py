"""Rockets of a fleet inform each other exactly as one dense normal distribution of all their flights would."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.inference.laplace.fleet import (
    RocketFit,
    independent_prior,
    joint_evidence,
    message_of,
    rocket_fit,
    shared_prior,
)
from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.model.rocket_model import Model, Term, base_model, scatter_of, with_shared
from fieldkit.model.scale import NODES, Scale
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of
from fieldkit.shapes import Array
from tests.seasons import season

FLIGHTS = 4
SHARED = (TermName("drag", "fleet"), TermName("thrust", "fleet"))
DRAG = TermName("drag")
PRIOR = {SHARED[0]: (-0.4, 0.3), SHARED[1]: (0.1, 0.2), DRAG: (0.0, 0.5)}
ONE_SCALE = replace(learned(), scatter=Scale((1.0,), 1.0, 0.5), reading=Scale((1.0,), 1.0, 0.5))
"""Without scales to integrate over, everything is normal and messages are exact."""


def linear_rocket(seed: int) -> Fit:
    """A rocket whose readouts are linear in two shared terms and one of its own."""
    rng = np.random.default_rng(seed)
    shape = (FLIGHTS, len(OBSERVED_READOUTS))
    terms = tuple(Term(name, "drag", mean, sd, np.ones(FLIGHTS)) for name, (mean, sd) in PRIOR.items())
    model = Model(history_of([Flight()] * FLIGHTS, [catalogue().resolve("F24")] * FLIGHTS), terms, ONE_SCALE)
    data = Data(rng.normal(size=shape), rng.uniform(0.2, 1.0, shape), np.ones(shape, bool), np.ones(shape))
    slope = rng.normal(size=(*shape, len(terms)))
    near = Tangent(
        rng.normal(size=len(terms)),
        rng.normal(size=shape),
        slope,
        rng.normal(size=(*shape, len(scatter_of(ONE_SCALE)))) * 0.1,
    )
    return solve(model, data, near)


def dense(fits: list[Fit]) -> tuple[Array, Array, float]:
    """Mean and covariance of the shared terms given all rockets, and the log evidence, written out in full."""
    names = [*SHARED, *(TermName("drag", "rocket", i) for i in range(len(fits)))]
    sds = np.array([PRIOR[name][1] if name in PRIOR else PRIOR[DRAG][1] for name in names])
    means = np.array([PRIOR[name][0] if name in PRIOR else PRIOR[DRAG][0] for name in names])
    rows, miss, noise = [], [], []
    for i, result in enumerate(fits):
        at_fit = result.evidence
        design = np.zeros((at_fit.miss.size, len(names)))
        design[:, [0, 1, 2 + i]] = at_fit.slope.reshape(at_fit.miss.size, -1)
        rows.append(design)
        miss.append(at_fit.miss.ravel())
        blocks = np.zeros((at_fit.miss.size, at_fit.miss.size))
        width = len(at_fit.readouts)
        for flight in range(FLIGHTS):
            part = slice(flight * width, (flight + 1) * width)
            blocks[part, part] = at_fit.noise()[0, flight]
        noise.append(blocks)
    design, seen = np.concatenate(rows), np.concatenate(miss)
    full = np.zeros((len(seen), len(seen)))
    first = 0
    for block in noise:
        full[first : first + len(block), first : first + len(block)] = block
        first += len(block)
    prior = np.diag(sds**2)
    total = design @ prior @ design.T + full
    gain = prior @ design.T @ np.linalg.inv(total)
    evidence = float(multivariate_normal(np.zeros(len(seen)), total).logpdf(seen))
    mean, covariance = means + gain @ seen, prior - gain @ design @ prior
    return mean[:2], covariance[:2, :2], evidence


def alone(result: Fit) -> RocketFit:
    return RocketFit(result.log_evidence, message_of(result), independent_prior([result.model]))


def test_all_messages_combined_give_the_dense_posterior_of_the_shared_terms() -> None:
    fits = [linear_rocket(seed) for seed in range(3)]
    found = shared_prior([alone(result) for result in fits])
    assert found is not None
    mean, covariance, _ = dense(fits)
    order = [found.names.index(name) for name in SHARED]
    np.testing.assert_allclose(found.mean[order], mean, atol=1e-8)
    np.testing.assert_allclose(found.covariance[np.ix_(order, order)], covariance, atol=1e-8)


def test_the_evidence_of_a_fleet_is_that_of_all_its_flights_together() -> None:
    fits = [linear_rocket(seed) for seed in range(3)]
    assert joint_evidence([alone(result) for result in fits]) == pytest.approx(dense(fits)[2], abs=1e-7)


def test_a_rocket_with_messages_from_the_others_has_the_dense_posterior() -> None:
    fits = [linear_rocket(seed) for seed in range(3)]
    others = shared_prior([alone(result) for result in fits[1:]])
    model = with_shared(fits[0].model, others)
    near = fits[0].tangent
    result = solve(model, fits[0].data, near)
    rows = [model.names.index(name) for name in SHARED]
    np.testing.assert_allclose(result.mean[0, rows], dense(fits)[0], atol=1e-8)
    np.testing.assert_allclose(result.covariance[0][np.ix_(rows, rows)], dense(fits)[1], atol=1e-8)


def test_a_rocket_without_readouts_sends_no_information() -> None:
    flown = [
        (flight.with_changes(apogee=None), found) for flight, found in season(np.random.default_rng(1), ("apogee",), 3)
    ]
    message = rocket_fit(flown, learned()).message
    assert np.abs(message.precision).max() < 1e-6
    assert np.abs(message.shift).max() < 1e-6


def test_marginals_of_a_shared_prior_are_its_rows() -> None:
    a, b, c, other = map(TermName, "abcz")
    prior = SharedPrior((a, b, c), np.arange(3.0), np.diag([1.0, 2.0, 3.0]) + 0.1)
    part = prior.only([c, a, other])
    assert part.names == (a, c)
    np.testing.assert_allclose(part.covariance, prior.covariance[np.ix_([0, 2], [0, 2])])


def lower(flown: list[tuple[Flight, Found]], factor: float) -> list[tuple[Flight, Found]]:
    return [(one.with_changes(apogee=one.apogee * factor), motor) for one, motor in flown if one.apogee]


def scattered(flown: list[tuple[Flight, Found]], sd: float) -> list[tuple[Flight, Found]]:
    """Flights whose apogees alternate around their expectation."""
    return [lower([one], 1 + sd * (-1) ** turn)[0] for turn, one in enumerate(flown)]


def test_the_scatter_of_a_flyers_rockets_says_what_to_expect_of_the_next_one() -> None:
    plain = season(np.random.default_rng(1), ("apogee",), 8)
    calm, wild = (shared_prior([rocket_fit(scattered(plain, sd), learned())] * 3) for sd in (0.01, 0.25))
    model = base_model(history_of([Flight(motor="F24", dry_mass=0.3)], [catalogue().resolve("F24")]), learned())
    grids = {name: with_shared(model, prior).hyperprior.scatter for name, prior in (("calm", calm), ("wild", wild))}
    mean = {
        name: float(np.exp(one.log_density) @ one.values / np.exp(one.log_density).sum()) for name, one in grids.items()
    }
    alone = model.hyperprior.scatter
    usual = float(np.exp(alone.log_density) @ alone.values / np.exp(alone.log_density).sum())
    assert mean["calm"] < 0.7 * usual
    assert mean["wild"] > 1.4 * usual


def test_a_fleet_that_says_nothing_leaves_the_prior_of_scatter() -> None:
    alone = learned().scatter
    ends = alone.range
    quantiles = []
    for scale in (alone, alone.pooled([0.0] * NODES)):
        fine = replace(scale, points=400).between(*ends)
        quantiles.append(np.interp((0.05, 0.5, 0.95), np.cumsum(np.exp(fine.log_prior)), fine.values))
    np.testing.assert_allclose(quantiles[1], quantiles[0], rtol=0.08)


def test_a_fleet_that_flies_low_lowers_the_forecast_of_a_new_rocket() -> None:
    from fieldkit.forecast.predict import predict

    rockets = [lower(season(np.random.default_rng(seed), ("apogee",), 4), 0.75) for seed in range(6)]
    fleet = shared_prior([rocket_fit(flown, learned()) for flown in rockets])
    plan = (Flight("plan", "New", "A", "F24", dry_mass=0.322, diameter=0.066), catalogue().resolve("F24"))
    (before,), (after,) = predict([], [plan]), predict([], [plan], Assumed(shared=fleet))
    low, middle, high = after.apogee_quantiles()
    assert middle < 0.95 * before.apogee_quantiles()[1]
    assert np.log(high / low) < np.log(before.apogee_quantiles()[2] / before.apogee_quantiles()[0])

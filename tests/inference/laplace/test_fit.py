"""The fit recovers true parameters with calibrated uncertainty, and leaves flights out as if they had never been
flown."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, Literal
from unittest.mock import patch

import numpy as np
import pytest
from jaxtyping import config as shapes
from scipy.stats import binom, multivariate_normal, norm

from fieldkit.flight import Flight
from fieldkit.inference.laplace import fit as fitting
from fieldkit.inference.laplace.damped_steps import DampedSteps
from fieldkit.inference.laplace.fit import Lane, fit, fit_lanes, refits_without
from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.inference.laplace.linearization import Tangent, launch_angle_slope
from fieldkit.inference.laplace.posterior import Fit, growing, log_inside, solve, term_sds
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import FROM_LOGS, Hyperprior, learned
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, Data, compared, observe, reading_sd
from fieldkit.model.rocket_model import Model, Term, base_model, scatter_of, with_shared
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.shapes import Array

SETS = 40
"""Number of sets of flights, each with separate terms."""
PLANS = tuple(
    Flight(str(number), "Test", config, motor, dry_mass=mass, diameter=0.066, site="mead", delay=10.0)
    for number, (config, mass, motor) in enumerate(
        [("A", 0.322, "F24"), ("A", 0.322, "F39"), ("B", 0.448, "F39"), ("A", 0.322, "E35")] * 2
    )
)
"""Delays are long, because ejection near apogee changes a flight in one direction only, which is not linear."""
Readouts = np.ndarray[Any, Any]


@cache
def model() -> Model:
    return base_model(history_of(PLANS, [catalogue().resolve(plan.motor) for plan in PLANS]), CERTIFIED_PRIOR)


@cache
def truths() -> np.ndarray[Any, Any]:
    """Terms of every set, from their priors. [set term]"""
    rng = np.random.default_rng(21)
    terms = model().terms
    drawn = np.array([term.mean for term in terms]) + rng.normal(size=(SETS, len(terms))) * [term.sd for term in terms]
    return np.asarray(np.clip(drawn, [term.low for term in terms], [term.high for term in terms]))


@cache
def seasons() -> tuple[Data, ...]:
    """The observations of every set: simulated flights with the model's scatter and reading errors.

    A launch angle can only lower a flight; the fit treats it as normal scatter, and so do these.
    """
    rng = np.random.default_rng(22)
    scatter_scale, reading_scale, log_prior = CERTIFIED_PRIOR.scales()
    pair = rng.choice(len(log_prior), SETS, p=np.exp(log_prior))
    size = (SETS, len(PLANS))
    scatter = {s.bends: rng.normal(size=size) * s.sd * scatter_scale[pair, None] for s in model().scatter}
    launch_angle = scatter.pop("tilt")
    raw, upright, leaning = (
        np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1)
        for readings in (
            shown(model(), truths(), scatter),
            shown(model(), truths(), {"tilt": np.zeros(size)}),
            shown(model(), truths(), {"tilt": np.ones(size)}),
        )
    )
    scales = np.repeat(reading_scale[pair, None, None], len(OBSERVED_READOUTS), axis=-1)
    scales[..., 0] = 1.0
    typed = len(OBSERVED_READOUTS) - len(FROM_LOGS)  # none of these flights has a log
    drawn = rng.normal(size=(*raw.shape[:-1], typed))
    noise = (
        np.concatenate([drawn, np.zeros((*raw.shape[:-1], len(FROM_LOGS)))], axis=-1)
        * scales
        * np.stack([reading_sd(part, CERTIFIED_PRIOR) for part in raw])
    )
    noisy = compared(raw) + noise + launch_angle[..., None] * (compared(leaning) - compared(upright))
    seen = np.where(IS_LOGARITHMIC, np.exp(noisy), noisy)
    return tuple(
        observe(history_of(flights(part), model().found, used_in_fit=[True] * len(PLANS)), CERTIFIED_PRIOR)
        for part in seen
    )


def flights(readouts: Readouts) -> list[Flight]:
    """The plans with readouts. [flight readout]"""
    named = (dict(zip(OBSERVED_READOUTS, map(float, row), strict=True)) for row in readouts)
    return [plan.with_changes(**row) for plan, row in zip(PLANS, named, strict=True)]


@cache
def fits() -> tuple[Fit, ...]:
    """The fit of every set; shapes are checked in the fits below."""
    with patch.object(shapes, "jaxtyping_disable", True):
        return tuple(fit(model(), data) for data in seasons())


def errors(results: tuple[Fit, ...]) -> np.ndarray[Any, Any]:
    """Errors of the posterior means in posterior standard deviations. [set term]"""
    moments = np.array([result.moments() for result in results])
    return np.asarray((truths() - moments[:, 0]) / moments[:, 1])


def calibrated(error: np.ndarray[Any, Any], level: float) -> bool:
    """Whether the fraction of errors inside an interval is within chance, with a false alarm of 1 in 2,000."""
    inside = int((np.abs(error) < norm.ppf(0.5 + level / 2)).sum())
    low, high = binom.interval(0.9995, error.size, level)
    return bool(low <= inside <= high)


# Ejection near apogee


def kinked(seed: int) -> tuple[Model, Data]:
    """Flights with ejection a little before apogee, and their model."""
    rng = np.random.default_rng(seed)
    terms = model().terms
    drawn = np.array([term.mean for term in terms]) + 0.5 * rng.normal(size=len(terms)) * [term.sd for term in terms]
    truth = np.clip(drawn, [term.low for term in terms], [term.high for term in terms])[None]
    scatter = {kind.bends: rng.normal(size=(1, len(PLANS))) * kind.sd for kind in model().scatter}
    coast = shown(model(), truth, {})["coast_time"][0]
    plans = [plan.with_changes(delay=float(time) - 0.6) for plan, time in zip(PLANS, coast, strict=True)]
    early = base_model(history_of(plans, [catalogue().resolve(plan.motor) for plan in plans]), CERTIFIED_PRIOR)
    shows = shown(early, truth, scatter)
    raw = np.stack([shows[name][0] for name in OBSERVED_READOUTS], axis=-1)
    named = (dict(zip(OBSERVED_READOUTS, map(float, row), strict=True)) for row in raw)
    flown = [plan.with_changes(**row) for plan, row in zip(plans, named, strict=True)]
    return early, observe(history_of(flown, early.found, used_in_fit=[True] * len(flown)), CERTIFIED_PRIOR)


@pytest.mark.sampled
@pytest.mark.parametrize("seed", [0, 1])
def test_a_fit_converges_if_ejection_is_near_apogee(seed: int) -> None:
    early, data = kinked(seed)
    after_five, after_nine = (fit(early, data, rounds=rounds).log_evidence for rounds in (5, 9))
    assert after_five == pytest.approx(after_nine, abs=0.1)


def test_fits_at_the_same_point_are_continued_once() -> None:
    one, data = model(), seasons()[0]
    start, every = np.array([term.mean for term in one.terms]), tuple(range(len(one.terms)))
    with patch.object(shapes, "jaxtyping_disable", True):
        found = list(fit_lanes(one, data, [Lane(every, start)] * 2, launch_angle_slope(one, start)))
    assert found[0] is found[1]


def test_a_fit_stored_without_its_solution_is_solved_to_the_same() -> None:
    solved = fit(model(), seasons()[0], outlier_flights=True)
    stored = solved.unsolved()
    assert stored.solution is None
    pairs = zip(stored.moments(), solved.moments(), strict=True)
    pairs = [*pairs, (stored.mean, solved.mean), (stored.covariance, solved.covariance)]
    for one, other in [*pairs, (stored.evidence.sharpness, solved.evidence.sharpness)]:
        np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.thorough
def test_a_step_that_reverses_direction_is_halved() -> None:
    settled = fits()[0]
    walk = DampedSteps(settled.tangent.at)
    wanted = settled.mean[int(np.argmax(settled.log_weight))]
    walk.at, sd = wanted - 0.5 * term_sds(model())[0], term_sds(model())[0]
    assert walk.advance(settled)
    np.testing.assert_allclose(walk.at, wanted, atol=1e-12)
    walk.at = wanted + 0.4 * sd
    assert walk.advance(settled)
    free = [term.low == -np.inf for term in model().terms]
    np.testing.assert_allclose(((walk.at - wanted) / sd)[free], 0.2, atol=1e-9)
    assert walk.advance(settled)
    np.testing.assert_allclose(((walk.at - wanted) / sd)[free], 0.0, atol=1e-9)
    assert not walk.advance(settled)


# Recovery


def test_the_fit_recovers_the_drag() -> None:
    drag = model().names.index(TermName("drag"))
    means, sds = np.array([result.moments() for result in fits()])[:, :, drag].T
    assert np.corrcoef(truths()[:, drag], means)[0, 1] > 0.97
    assert np.all(sds < 0.4 * model().terms[drag].sd)


@pytest.mark.parametrize("level", [0.5, 0.9])
def test_every_terms_interval_has_its_stated_coverage(level: float) -> None:
    error = errors(fits())
    poor = [name for name, one in zip(model().names, error.T, strict=True) if not calibrated(one, level)]
    assert not poor


def test_errors_are_neither_biased_nor_too_large() -> None:
    error = errors(fits())
    assert np.abs(error.mean(axis=0)).max() < 4 / np.sqrt(SETS)
    assert 0.85 < error.std() < 1.15


@pytest.mark.parametrize(
    "distort",
    [lambda error: 3 * error, lambda error: error / 4, lambda error: error + 2],
    ids=["too sure", "too timid", "shifted"],
)
def test_a_distorted_posterior_is_noticed(distort: Callable[[Any], Any]) -> None:
    drag = errors(fits())[:, model().names.index(TermName("drag"))]
    assert calibrated(drag, 0.5)
    assert not calibrated(distort(drag), 0.5)


def test_large_scatter_is_recognized() -> None:
    """Sets with large scatter have more weight on large scales than sets with small scatter."""
    pair = np.random.default_rng(22).choice(
        len(CERTIFIED_PRIOR.scales()[2]), SETS, p=np.exp(CERTIFIED_PRIOR.scales()[2])
    )
    true = np.log(CERTIFIED_PRIOR.scales()[0][pair])
    found = np.array([result.weights @ np.log(CERTIFIED_PRIOR.scales()[0]) for result in fits()])
    assert np.corrcoef(true, found)[0, 1] > 0.5


# Leaving out


def without(data: Data, flight: int) -> Data:
    seen = data.seen.copy()
    seen[flight] = False
    return replace(data, seen=seen, values=np.where(seen, data.values, 0.0), sd=np.where(seen, data.sd, 1.0))


def inside_bounds(fit: Fit) -> Array:
    """Log ratio of posterior to prior mass inside the bounds of the terms, for every pair of scales."""
    bounded = [i for i, term in enumerate(fit.model.terms) if np.isfinite([term.low, term.high]).any()]
    variance = np.diagonal(fit.covariance, axis1=1, axis2=2)
    return log_inside(fit.model, fit.mean[:, bounded], variance[:, bounded])


@pytest.mark.parametrize("flight", [0, 2, 7])
def test_leaving_a_flight_out_equals_solving_without_it(flight: int) -> None:
    result = fits()[0]
    left = leave_one_out(result)
    rest = solve(result.model, without(result.data, flight), result.tangent)
    slope = result.tangent.slope[flight, 0]
    mean = result.tangent.values[flight, 0] + (rest.mean - result.tangent.at) @ slope
    np.testing.assert_allclose(left.mean[:, flight], mean, atol=1e-9)
    spread = np.einsum("t,stu,u->s", slope, rest.covariance, slope)
    full = np.einsum("t,stu,u->s", slope, result.covariance, slope)
    own = left.variance[:, flight] - spread
    assert np.all(full <= spread)
    assert np.all(own > 0)
    assert np.all(np.diff(own.reshape(6, 3), axis=0) > 0), "more scatter, more spread"
    evidence = rest.log_weight - inside_bounds(rest)
    other = left.log_weight[:, flight] - inside_bounds(result)
    np.testing.assert_allclose(evidence, other, atol=1e-6)


def test_leaving_an_outlier_out_leaves_the_evidence_of_the_others() -> None:
    plain = fits()[0]
    weight = np.linspace(0.2, 1.3, len(plain.data.seen))
    data = replace(plain.data, seen=plain.data.seen & (np.arange(plain.data.seen.shape[1]) != 1))
    result = solve(plain.model, data, plain.tangent, weight)
    rest = solve(plain.model, without(data, 2), plain.tangent, weight)
    inside = [inside_bounds(one) for one in (rest, result)]
    left = leave_one_out(result).log_weight[:, 2]
    np.testing.assert_allclose(rest.log_weight - inside[0], left - inside[1], atol=1e-6)


def test_leaving_a_flight_out_is_close_to_refitting_without_it() -> None:
    for season in range(3):
        result = fits()[season]
        left = leave_one_out(result)
        weight = np.exp(left.log_weight - np.logaddexp.reduce(left.log_weight, axis=0))
        mean = (weight * left.mean).sum(axis=0)
        sd = np.sqrt((weight * (left.variance + (left.mean - mean) ** 2)).sum(axis=0))
        for flight in (0, 3):
            rest = fit(model(), without(result.data, flight), start=result.tangent.at)
            terms = rest.tangent.slope[flight, 0] @ (rest.weights @ rest.mean - rest.tangent.at)
            again = rest.tangent.values[flight, 0] + terms
            assert abs(again - mean[flight]) < 0.25 * sd[flight]


def test_leave_one_out_forecasts_are_calibrated() -> None:
    error = []
    for result in fits():
        left = leave_one_out(result)
        weight = np.exp(left.log_weight - np.logaddexp.reduce(left.log_weight, axis=0))
        mean = (weight * left.mean).sum(axis=0)
        sd = np.sqrt((weight * (left.variance + (left.mean - mean) ** 2)).sum(axis=0))
        error.append((result.data.values[:, 0] - mean) / sd)
    assert calibrated(np.array(error)[:, 0], 0.5)
    assert calibrated(np.array(error), 0.9)


@pytest.mark.parametrize("flight", [1, 3, 7])
def test_a_fit_extended_flight_by_flight_equals_the_fit_of_those_flights(flight: int) -> None:
    result = fits()[0]
    before, near = slice(flight), result.tangent
    part = Tangent(near.at, near.values[before], near.slope[before], near.scatter_slope[before])
    whole = result.data
    data = Data(whole.values[before], whole.sd[before], whole.seen[before], whole.trust[before])
    again, grown = solve(result.model.part(before), data, part), growing(result)
    np.testing.assert_allclose(grown.mean[:, flight], again.mean, atol=1e-9)
    np.testing.assert_allclose(grown.covariance[:, flight], again.covariance, atol=1e-12)
    np.testing.assert_allclose(grown.log_weight[:, flight], again.log_weight, atol=1e-7)


# Evidence


def toy(rng: np.random.Generator, hyperprior: Hyperprior = CERTIFIED_PRIOR) -> tuple[Model, Data, Tangent]:
    """A linear model of three terms and five flights, one readout not seen."""
    doubtful = hyperprior.kind == "learned"
    scaled: tuple[Literal["", "scatter", "reading"], ...] = ("", "scatter", "reading") if doubtful else ("", "", "")
    terms = tuple(
        Term(TermName(str(i)), "drag", mean, sd, np.ones(5), scaled_by=scaled[i])
        for i, (mean, sd) in enumerate([(0, 1), (2, 0.3), (-1, 2)])
    )
    shape = (5, len(OBSERVED_READOUTS))
    seen = np.ones(shape, bool)
    seen[2, 3] = False
    data = Data(
        rng.normal(size=shape),
        rng.uniform(0.2, 1.0, shape),
        seen,
        rng.uniform(0.2, 1.0, shape) if doubtful else np.ones(shape),
    )
    own = (*shape, len(scatter_of(hyperprior)))
    near = Tangent(rng.normal(size=3), rng.normal(size=shape), rng.normal(size=(*shape, 3)), rng.normal(size=own) * 0.3)
    return Model(history_of([Flight()] * 5, [catalogue().resolve("F24")] * 5), terms, hyperprior), data, near


def dense(model: Model, data: Data, near: Tangent, scale: int) -> tuple[Any, Any, Any]:
    """Expectation, covariance and slope of all observations, written out in full for one pair of scales."""
    scatter, reading = (values[scale] for values in model.hyperprior.scales()[:2])
    single = np.hypot(model.hyperprior.sd("apogee", "flight"), model.hyperprior.sd("apogee", "day"))
    own = np.array([scatter * single, *[0.0] * (len(OBSERVED_READOUTS) - 1)])
    every = np.array([1.0, *[reading] * (len(OBSERVED_READOUTS) - 1)])
    seen = data.seen.ravel()
    slope = near.slope.reshape(len(seen), -1)
    prior = np.array([term.mean for term in model.terms])
    noise = np.zeros((len(seen), len(seen)))
    width = len(OBSERVED_READOUTS)
    for flight in range(len(near.values)):
        block = slice(flight * width, (flight + 1) * width)
        motors = model.hyperprior.motor_scales()[scale]
        own_scale = [motors if one.bends in model.hyperprior.scaled_by_motors else scatter for one in model.scatter]
        spread = near.scatter_slope[flight] * own_scale
        noise[block, block] = spread @ spread.T + np.diag(
            ((every * data.sd[flight]) ** 2 + own**2) / data.trust[flight]
        )
    mean = near.values.ravel() + slope @ (prior - near.at)
    covariance = slope @ prior_covariance(model, scale) @ slope.T + noise
    return mean[seen], covariance[np.ix_(seen, seen)], slope[seen]


def prior_covariance(model: Model, scale: int) -> Any:
    """Prior covariance of the terms, for one pair of scales."""
    covariance = np.diag(term_sds(model)[scale] ** 2)
    if model.shared is not None:
        rows = [model.names.index(name) for name in model.shared.names]
        covariance[np.ix_(rows, rows)] = model.shared.covariance
    return covariance


SHARED = SharedPrior((TermName("1"), TermName("0")), np.array([0.3, -0.4]), np.array([[0.5, 0.2], [0.2, 0.4]]))
"""Indices of two terms of the toy model, in another order."""


@pytest.mark.parametrize("shared", [None, SHARED], ids=["alone", "with other rockets"])
@pytest.mark.parametrize("kind", ["certified", "learned"])
@pytest.mark.parametrize("scale", [0, 7, 17])
def test_evidence_and_posterior_are_those_of_the_dense_normal_distribution(
    scale: int, kind: str, shared: SharedPrior | None
) -> None:
    model, data, near = toy(np.random.default_rng(5), CERTIFIED_PRIOR if kind == "certified" else learned())
    model = with_shared(model, shared)
    result = solve(model, data, near)
    mean, covariance, slope = dense(model, data, near, scale)
    seen = data.values.ravel()[data.seen.ravel()]
    exact = multivariate_normal(mean, covariance).logpdf(seen)
    assert result.log_weight[scale] - model.hyperprior.scales()[2][scale] == pytest.approx(exact, abs=1e-7)
    prior = prior_covariance(model, scale)
    gain = prior @ slope.T @ np.linalg.inv(covariance)
    expected = np.array([term.mean for term in model.terms]) + gain @ (seen - mean)
    np.testing.assert_allclose(result.mean[scale], expected, atol=1e-9)
    np.testing.assert_allclose(result.covariance[scale], prior - gain @ slope @ prior, atol=1e-9)


def test_missing_readouts_are_not_used_in_the_fit() -> None:
    model, data, near = toy(np.random.default_rng(6))
    values = data.values.copy()
    values[2, 3] = 1e6
    here, there = solve(model, data, near), solve(model, replace(data, values=values), near)
    np.testing.assert_allclose(here.mean, there.mean, rtol=1e-12)
    assert here.log_evidence == pytest.approx(there.log_evidence)


def test_an_unconstrained_term_does_not_change_the_evidence_and_keeps_its_prior() -> None:
    model, data, near = toy(np.random.default_rng(7))
    idle = model.with_terms(Term(TermName("idle"), "drag", 0.5, 0.2, np.zeros(5)))
    wider = replace(
        near, at=np.append(near.at, 0.1), slope=np.dstack([near.slope, np.zeros((5, len(OBSERVED_READOUTS)))])
    )
    plain, more = solve(model, data, near), solve(idle, data, wider)
    assert more.log_evidence == pytest.approx(plain.log_evidence)
    mean, sd = more.moments()
    assert mean[-1] == pytest.approx(0.5)
    assert sd[-1] == pytest.approx(0.2)


def test_refits_keep_the_scatter_of_the_launch_angle() -> None:
    halved = replace(model(), hyperprior=CERTIFIED_PRIOR.with_sds(tilt__flight=0.5))
    whole = fit(halved, fits()[0].data)
    (rest,) = refits_without(whole, [0])
    kinds = [kind.bends for kind in halved.scatter]
    slopes = [one.tangent.scatter_slope[:, 0, kinds.index("tilt")] for one in (rest, whole)]
    assert np.abs(slopes[1]).min() > 1e-4
    np.testing.assert_allclose(slopes[0], slopes[1])


def test_fits_without_one_flight_are_the_same_whether_few_or_all_are_run_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, rows = fits()[0], [0, 1, 2]
    together = list(refits_without(whole, rows))
    monkeypatch.setattr(fitting, "PARALLEL_REFITS", 2)
    for one, other in zip(refits_without(whole, rows), together, strict=True):
        np.testing.assert_allclose(one.mean, other.mean, rtol=1e-9, atol=1e-12)

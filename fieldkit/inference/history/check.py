"""Check a quick forecast against the model, by importance sampling with the simulator.

Draws of the linear pass are weighted by the model's posterior density over the density they were drawn from (Robert and
Casella, Monte Carlo Statistical Methods, 2004, chapter 3), and the readouts of every draw are simulated. The terms are
drawn from the linear fits, slightly widened. The posterior density of a draw is, up to a constant, its prior times its
likelihood, with multivariate Student t noise for each flight or any cause of a one-off, summed over the scales of
scatter and reading. The weighted draws are the model's forecast of the plan's apogee; the same draws without
simulations and weights are the linear pass's. The apogees of the answer are weighted by the density of the one over
that of the other.

Weights are unreliable if the largest follow a generalized Pareto distribution of shape k > 0.7 (Vehtari, Simpson,
Gelman, Yao and Gabry, Pareto smoothed importance sampling, Journal of Machine Learning Research 25, 2024): then the
draws do not cover the model's answer. For the apogee both densities are known, and the effective fraction of the
answer's apogees measures their overlap.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.random import Generator

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.moments import own_variance
from fieldkit.inference.history.quick_forecast import QuickAnswer
from fieldkit.inference.history.response import slopes
from fieldkit.inference.history.usual_flights import Cases, signatures_at
from fieldkit.inference.laplace.importance import (
    INFLATION,
    MORE_DRAWS,
    RELIABLE_PARETO_K,
    log_likelihood,
    log_prior,
    summed,
)
from fieldkit.inference.laplace.one_offs import one_offs
from fieldkit.inference.laplace.pareto import smoothed
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.causes import USUAL_PROBABILITY
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import shown
from fieldkit.shapes import Array, Float, Int, Integers

DRAWS = 400
"""Number of weighted draws: the shape is then fitted to a tail of 60. [1]"""
LEAST_EFFECTIVE = 0.5
"""Both forecasts agree if at least this fraction of the apogee's draws is effective. [1]"""


@dataclass(frozen=True, slots=True)
class Check:
    """The model's check of a linear pass's draws of the parameters and of the planned apogee.

    `pareto_k` is the shape of the tail of the parameters' weights; `parameters_effective` and `apogee_effective` are
    effective fractions of draws [1], and `draws` is their number.
    """

    pareto_k: float
    parameters_effective: float
    apogee_effective: float
    draws: int

    @property
    def agrees(self) -> bool:
        """Whether the weights of the parameters are reliable and at least `LEAST_EFFECTIVE` of the apogee's draws are
        effective."""
        return self.pareto_k <= RELIABLE_PARETO_K and self.apogee_effective >= LEAST_EFFECTIVE


def check(answer: QuickAnswer, draws: int = DRAWS, seed: int = 0) -> Check:
    """Weight the draws for the plan of a history by the forecast model, with more draws if the check of the first
    fails. An answer without an apogee, of a rocket that may not lift, does not agree.

    Raises ValueError for a history of several plans, ImpossibleFlight for a flight without a dry mass.
    """
    linear = answer.linear
    if len(linear.model.flights) != linear.flown + 1:
        raise ValueError(f"found {len(linear.model.flights) - linear.flown} plans, expected one")
    if not (np.isfinite(answer.apogees) & (answer.apogees > 0)).all():
        return Check(np.inf, 0.0, 0.0, draws)
    rng = np.random.default_rng(seed)
    first = _check(answer, rng, draws)
    return first if first.agrees else _check(answer, rng, MORE_DRAWS * draws)


def _check(answer: QuickAnswer, rng: Generator, draws: int) -> Check:
    linear = answer.linear
    terms, which, log_density = _drawn(answer.cases, rng, draws)
    model = replace(linear.model.with_terms(*linear.fresh), coarse=True)
    flown = _flown(model, terms)
    scales = np.arange(len(linear.fit.weights))
    data = replace(linear.fit.data, trust=np.ones_like(linear.fit.data.trust), normal=None)
    usual = log_likelihood(replace(linear.fit, data=data), scales, flown[:, :-1])
    log_causes = one_offs(linear.fit, known=signatures_at(linear.fit)).log_causes
    likelihood = np.logaddexp(log(USUAL_PROBABILITY) + usual, log_causes)
    past = replace(linear.fit.model, terms=(*linear.fit.model.terms, *linear.fresh))
    total, parts = summed(log_prior(past, scales, terms) + likelihood.sum(axis=-1))
    smooth, pareto_k = smoothed(total - log_density)
    weights = _normalized(smooth)
    near, plan = linear.near, linear.flown
    row = np.concatenate([near.slope[plan, 0], slopes(linear.fresh, linear.moved)[plan, 0]])
    at = np.concatenate([near.at, np.zeros(len(linear.fresh))])
    middle = near.values[plan, 0] + (terms - at) @ row
    apogees = np.log(answer.apogees)
    own_density = _log_forecast(linear, middle, np.eye(len(scales))[which] / draws, apogees)
    by_apogee = _log_forecast(linear, flown[:, -1, 0], weights[:, None] * parts, apogees) - own_density
    return Check(float(pareto_k), _effective(weights), _effective(_normalized(by_apogee)), draws)


def _normalized(log_weight: Float[Array, "draw"]) -> Float[Array, "draw"]:
    """Weights normalized to sum to one; zeros if all are zero, or one is not a number."""
    largest = log_weight.max(initial=-np.inf)
    if not np.isfinite(largest):  # also if one is nan
        return np.zeros(len(log_weight))
    weights = np.exp(log_weight - largest)
    return np.asarray(weights / weights.sum())


def _effective(weights: Float[Array, "draw"]) -> float:
    """Effective fraction of draws (Kish): 1 for equal weights, 0 if all are zero. [1]"""
    return float(1 / (weights**2).sum() / len(weights)) if weights.any() else 0.0


def _flown(model: Model, terms: Float[Array, "draw term"]) -> Float[Array, "draw flight readout"]:
    """The readouts of every draw in the form that a fit compares."""
    low, high = (np.array([getattr(term, name) for term in model.terms]) for name in ("low", "high"))
    readings = shown(model, np.clip(terms, low, high), {})
    return compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))


def _drawn(
    cases: Cases, rng: Generator, draws: int
) -> tuple[Float[Array, "draw term"], Int[Integers, "draw"], Float[Array, "draw"]]:
    """Draws of the terms, the scale that each is from, and their log density up to a constant."""
    fits, fresh = [linear.fit for _, linear in cases], cases[0][1].fresh
    means = np.concatenate([fit.mean for fit in fits])
    weights = np.concatenate([chance * linear.fit.weights for chance, linear in cases])
    known, count = means.shape[1], means.shape[1] + len(fresh)
    mean = np.concatenate([means, np.tile([term.mean for term in fresh], (len(means), 1))], axis=1)
    covariance = np.zeros((len(mean), count, count))
    covariance[:, :known, :known] = np.concatenate([fit.covariance for fit in fits])
    new = np.arange(known, count)
    new_sds = term_sds(replace(fits[0].model, terms=fresh, shared=None))
    covariance[:, new, new] = np.tile(new_sds**2, (len(fits), 1))
    roots = np.linalg.cholesky(INFLATION * covariance)
    which = rng.choice(len(mean), size=draws, p=weights)
    terms = mean[which] + np.einsum("dtu,du->dt", roots[which], rng.normal(size=(draws, count)))
    scaled = np.linalg.solve(roots, np.moveaxis(terms[:, None] - mean, 0, -1))
    by_scale = -0.5 * (scaled**2).sum(axis=1) - np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)[:, None]
    log_weight = np.log(np.maximum(weights, 1e-300))
    return terms, which % len(fits[0].weights), np.asarray(np.logaddexp.reduce(log_weight[:, None] + by_scale, axis=0))


def _log_student(square: Float[Array, "..."], freedom: float) -> Float[Array, "..."]:
    """Log density of a standard Student t distribution at points of this square."""
    from scipy.special import gammaln  # takes 0.18 s to import

    constant = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
    return np.asarray(constant - 0.5 * (freedom + 1) * np.log1p(square / freedom))


def _log_forecast(
    linear: LinearFit,
    middle: Float[Array, "draw"],
    by_scale: Float[Array, "draw scale"],
    apogees: Float[Array, "apogee"],
) -> Float[Array, "apogee"]:
    """Log density of the model's forecast of the plan's log apogee: a Student t around every draw that leaves the
    pad."""
    flies = np.isfinite(middle)
    nu = linear.model.hyperprior.tail
    constant = _log_student(np.zeros(()), nu)
    square = (apogees[:, None] - middle[flies]) ** 2 / nu
    each = zip(own_variance(linear)[:, 0], by_scale[flies].T, strict=True)
    # the tails of a Student t are powers, so the densities do not underflow
    density = sum((1 + square / own) ** (-(nu + 1) / 2) @ (weight / np.sqrt(own)) for own, weight in each)
    with np.errstate(divide="ignore"):
        return np.asarray(constant + np.log(density))

"""Check the network's forecast of a plan against the model, by importance sampling.

The network's draws are weighted by the model's posterior density over the density they were drawn from (Robert and
Casella, Monte Carlo Statistical Methods, 2004, chapter 3), and the readouts of every draw are simulated. Log Cd and log
alpha of the plan are drawn from the network's normal distribution; the other terms are drawn from the linear fit given
those two, slightly widened. The posterior density of a draw is, up to a constant, its prior times its likelihood, with
multivariate Student t noise for each flight, summed over the scales of scatter and reading. The weighted draws are the
model's forecast of the plan's apogee. The network's draws of the apogee, with tails of that Student t beyond its last
quantiles, are weighted by the density of this forecast over their own.

Weights are unreliable if the largest follow a generalized Pareto distribution of shape k > 0.7 (Vehtari, Simpson,
Gelman, Yao and Gabry, Pareto smoothed importance sampling, Journal of Machine Learning Research 25, 2024): then the
network's draws do not cover the model's answer. For the apogee both densities are known, and the effective fraction of
the network's draws measures their overlap.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.moments import acting, own_variance
from fieldkit.inference.laplace.importance import (
    INFLATION,
    MORE_DRAWS,
    RELIABLE_PARETO_K,
    log_likelihood,
    log_prior,
    summed,
)
from fieldkit.inference.laplace.pareto import smoothed
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.inference.network.history import QuickAnswer
from fieldkit.inference.network.history_parts import LEVELS, STANDARD
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import shown
from fieldkit.shapes import Array, Float

DRAWS = 400
"""Number of weighted draws: the shape is then fitted to a tail of 60. [1]"""
LEAST_EFFECTIVE = 0.5
"""Both forecasts agree if at least this fraction of the apogee's draws is effective. [1]"""
LEAST_SD = 1e-4
"""Minimum standard deviation of log Cd and log alpha. [1]"""


@dataclass(frozen=True, slots=True)
class Check:
    """The model's check of the network's draws of the parameters and of the planned apogee.

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
    """Weight the network's draws for the plan of a history by the forecast model, with more draws if the check of the
    first fails.

    Raises ValueError for a history of several plans, ImpossibleFlight for a flight without a dry mass.
    """
    linear = answer.summary.forecast
    if len(linear.model.flights) != linear.flown + 1:
        raise ValueError(f"found {len(linear.model.flights) - linear.flown} plans, expected one")
    rng = np.random.default_rng(seed)
    first = _check(answer, linear, rng, draws)
    return first if first.agrees else _check(answer, linear, rng, MORE_DRAWS * draws)


def _check(answer: QuickAnswer, linear: LinearFit, rng: Generator, draws: int) -> Check:
    terms, log_density = _drawn(answer, linear, rng, draws)
    model = replace(linear.model.with_terms(*linear.fresh), coarse=True)
    flown = _flown(model, terms)
    scales = np.arange(len(linear.fit.weights))
    data = replace(linear.fit.data, trust=np.ones_like(linear.fit.data.trust))
    likelihood = log_likelihood(replace(linear.fit, data=data), scales, flown[:, :-1])
    past = replace(linear.fit.model, terms=(*linear.fit.model.terms, *linear.fresh))
    joint = log_prior(past, scales, terms) + likelihood.sum(axis=-1)
    total, parts = summed(joint)
    smooth, pareto_k = smoothed(total - log_density)
    weights = _normalized(smooth)
    by_scale = weights[:, None] * parts
    apogees, own_density = _apogees(answer.log_apogee, draws, linear.model.hyperprior.tail)
    by_apogee = _normalized(_log_forecast(linear, flown[:, -1, 0], by_scale, apogees) - own_density)
    return Check(float(pareto_k), _effective(weights), _effective(by_apogee), draws)


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
    answer: QuickAnswer, linear: LinearFit, rng: Generator, draws: int
) -> tuple[Float[Array, "draw term"], Float[Array, "draw"]]:
    """Draws of the terms, with the network's log Cd and log alpha of the plan, and their log density."""
    fit, fresh = linear.fit, linear.fresh
    known, count = fit.mean.shape[1], fit.mean.shape[1] + len(fresh)
    mean = np.concatenate([fit.mean, np.tile([term.mean for term in fresh], (len(fit.mean), 1))], axis=1)
    covariance = np.zeros((len(mean), count, count))
    covariance[:, :known, :known] = fit.covariance
    new = np.arange(known, count)
    covariance[:, new, new] = term_sds(replace(fit.model, terms=fresh, shared=None)) ** 2
    covariance *= INFLATION
    every = linear.model.with_terms(*fresh).terms
    plan = np.stack([acting(every, kind, linear.flown + 1)[:, -1] for kind in ("drag", "thrust")])
    open_ = plan @ covariance @ plan.T + LEAST_SD**2 * np.eye(2)
    gain = covariance @ plan.T @ np.linalg.inv(open_)
    which = rng.choice(len(mean), size=draws, p=fit.weights)
    roots = np.linalg.cholesky(covariance)
    terms = mean[which] + np.einsum("dtu,du->dt", roots[which], rng.normal(size=(draws, count)))
    middle, sds = np.array([answer.log_cd[0], answer.log_alpha[0]]), np.array([answer.log_cd[1], answer.log_alpha[1]])
    sds = np.hypot(sds, LEAST_SD)
    wanted = np.diag(sds**2) + answer.correlation * sds[0] * sds[1] * (1 - np.eye(2))
    drawn = middle + rng.normal(size=(draws, 2)) @ np.linalg.cholesky(wanted).T
    free = terms @ plan.T + LEAST_SD * rng.normal(size=(draws, 2))
    terms = terms + np.einsum("dtk,dk->dt", gain[which], drawn - free)
    at = terms @ plan.T
    by_scale = np.stack(
        [
            _log_normal(terms - mean[s], covariance[s]) - _log_normal(at - plan @ mean[s], open_[s])
            for s in range(len(mean))
        ],
        axis=1,
    )
    log_density = np.logaddexp.reduce(np.log(np.maximum(fit.weights, 1e-300)) + by_scale, axis=1)
    return terms, np.asarray(log_density + _log_normal(at - middle, wanted))


def _apogees(
    quantiles: Float[Array, "level"], count: int, freedom: float
) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Equally likely log apogees from the network's quantiles, with Student t tails beyond the last, and their log
    density."""
    from scipy.special import ndtri, stdtrit  # `scipy.stats` would take 0.5 s and 26 MB in the app

    levels = np.asarray((np.arange(count) + 0.5) / count)
    piece = np.clip(np.searchsorted(LEVELS, levels) - 1, 0, len(LEVELS) - 2)
    outside = (levels < LEVELS[0]) | (levels > LEVELS[-1])
    knots, tail_knots = np.array(STANDARD), stdtrit(freedom, np.asarray(LEVELS))
    standard = np.where(outside, stdtrit(freedom, levels), ndtri(levels))
    start = np.where(outside, tail_knots[piece], knots[piece])
    slope = np.diff(quantiles)[piece] / np.where(outside, np.diff(tail_knots)[piece], np.diff(knots)[piece])
    normal = -0.5 * (standard**2 + np.log(2 * np.pi))
    density = np.where(outside, _log_student(standard**2, freedom), normal) - np.log(slope)
    return quantiles[piece] + slope * (standard - start), density


def _log_student(square: Float[Array, "..."], freedom: float) -> Float[Array, "..."]:
    """Log density of a standard Student t distribution at points of this square."""
    from scipy.special import gammaln  # takes 0.18 s to import

    constant = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
    return np.asarray(constant - 0.5 * (freedom + 1) * np.log1p(square / freedom))


def _log_normal(off: Float[Array, "draw n"], covariance: Float[Array, "n n"]) -> Float[Array, "draw"]:
    """Log density of a normal distribution of mean zero, without the constant of 2 pi."""
    root = np.linalg.cholesky(covariance)
    scaled = np.linalg.solve(root, off.T)
    return np.asarray(-0.5 * (scaled**2).sum(axis=0) - np.log(np.diagonal(root)).sum())


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

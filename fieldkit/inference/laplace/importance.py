"""Check of a fit with the simulator: evidence and leave-one-out forecasts by importance sampling.

Terms are drawn from the fit's normal posterior and simulated. The weight of a draw is its prior times its likelihood,
divided by the density it was drawn from (Robert and Casella, Monte Carlo Statistical Methods, 2004, chapter 3); the
noise of each flight is a multivariate Student t, and both scales are summed over. The mean weight is the evidence.
Divided by the likelihood of a flight, the weights represent the posterior without that flight. The largest weights are
smoothed by a generalized Pareto distribution, whose shape k shows whether they are reliable (Vehtari, Simpson, Gelman,
Yao and Gabry, Pareto smoothed importance sampling, Journal of Machine Learning Research 25, 2024).
"""

from dataclasses import dataclass
from math import log, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator

from fieldkit.inference.laplace.leave_one_out import own_variance
from fieldkit.inference.laplace.one_offs import one_offs
from fieldkit.inference.laplace.outlier_flights import readouts_used
from fieldkit.inference.laplace.pareto import smoothed
from fieldkit.inference.laplace.posterior import Fit, FlightEvidence, bounds_log_mass, flight_evidence, prior_precision
from fieldkit.model.causes import USUAL_PROBABILITY
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import shown
from fieldkit.shapes import Array, Float, Int, Integers

DRAWS = 500
"""Draws simulated for each fit; if one in four is effective, the log evidence has an error of 0.1 nat. [1]"""
BATCH = 125
"""Number of draws whose likelihoods are computed together, to save memory. [1]"""
MORE_DRAWS = 3
"""Factor on `DRAWS` if they are not enough. [1]"""
INFLATION = 1.15
"""Ratio of the variance of the draws to the fit's, so that their tails cover those of the posterior. [1]"""
RELIABLE_PARETO_K = 0.7
"""Weights are reliable up to this shape of their tail (Vehtari et al., 2024). [1]"""
NEGLIGIBLE_SCALE_WEIGHT = 1e-3
"""Scales below this posterior weight are left out: together about 1%, a tenth of the error of the draws. [1]"""
NO_FLIGHT_MISS = 20.0
"""Residual of a readout for a draw that stays on the pad, as a log ratio. [1]"""


@dataclass(frozen=True, slots=True)
class Sampled:
    """A fit checked by importance sampling.

    `fit` is the fit from which terms were drawn; sums are over its scales. `log_evidence` has the standard error
    `error`; `pareto_k` is the shape of the tail of its weights. For every left-out flight: `log_without`, the log
    evidence of the others, `pareto_k_without`, and the forecast of its compared apogee as a mixture over scales: mean,
    variance due to the uncertain parameters of the rocket, variance due to the flight's scatter and reading, and the
    weight of each of the `scales` with any weight.
    """

    fit: Fit
    log_evidence: float
    error: float
    pareto_k: float
    log_without: Float[Array, "flight"]
    pareto_k_without: Float[Array, "flight"]
    mean: Float[Array, "scale flight"]
    known: Float[Array, "scale flight"]
    own: Float[Array, "scale flight"]
    weight: Float[Array, "scale flight"]
    scales: Int[Integers, "scale"]


def sampled(fit: Fit, rng: Generator, draws: int = DRAWS, *, causes: bool = False) -> Sampled:
    """A fit's evidence and leave-one-out forecasts by importance sampling with the simulator; more draws are made if
    the weights of the first are unreliable.

    With `causes`, every flight may also be a one-off: its likelihood is a mixture (`OneOffs.log_causes`). Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    scales = np.flatnonzero(fit.weights > NEGLIGIBLE_SCALE_WEIGHT)
    log_causes = one_offs(fit).log_causes if causes else None
    flown = _flown(fit, scales, rng, draws, log_causes)
    first = _weighed(fit, scales, flown)
    if first.pareto_k < RELIABLE_PARETO_K:
        return first
    more = _flown(fit, scales, rng, (MORE_DRAWS - 1) * draws, log_causes)
    return _weighed(fit, scales, flown.with_more(more))


class _Flown(NamedTuple):
    """Simulated draws of a fit. The likelihood is in batches of draws and in single precision, of which a millionth of
    a nat is lost, because all in one array take much memory."""

    log_density: Float[Array, "draw"]
    likelihood: tuple[Float[Array, "batch scale flight"], ...]
    apogee: Float[Array, "draw flight"]
    target: Float[Array, "draw scale"]

    def with_more(self, more: "_Flown") -> "_Flown":
        """These draws and more of the same fit."""
        log_density, apogee, target = (
            np.concatenate([getattr(self, name), getattr(more, name)]) for name in ("log_density", "apogee", "target")
        )
        return _Flown(log_density, self.likelihood + more.likelihood, apogee, target)


def _flown(
    fit: Fit, scales: Int[Integers, "scale"], rng: Generator, draws: int, log_causes: Float[Array, "flight"] | None
) -> _Flown:
    terms, log_density = _drawn(fit, scales, rng, draws)
    flown, apogee = _simulated(fit, terms)
    batches = np.array_split(flown, -(-draws // BATCH))
    likelihood: list[Any] = []
    target = log_prior(fit.model, scales, terms)
    evidence = flight_evidence(fit.model, fit.data, fit.tangent, which=scales)
    for batch, joint in zip(batches, np.array_split(target, len(batches)), strict=True):
        own = _with_causes(_given(fit, evidence, batch), log_causes)
        joint += own.sum(axis=-1)
        likelihood.append(np.asarray(own, np.float32))
    return _Flown(log_density, tuple(likelihood), apogee, target)


def _with_causes(
    likelihood: Float[Array, "draw scale flight"], log_causes: Float[Array, "flight"] | None
) -> Float[Array, "draw scale flight"]:
    """The log likelihood of flights that may also be one-offs, in place of that of usual ones."""
    if log_causes is not None:
        likelihood += log(USUAL_PROBABILITY)
        np.logaddexp(likelihood, log_causes, out=likelihood)
    return likelihood


def _weighed(fit: Fit, scales: Int[Integers, "scale"], flown: _Flown) -> Sampled:
    log_density, likelihood, apogee, target = flown
    draws = len(target)
    log_weight = summed(target)[0] - log_density
    smooth, pareto_k = smoothed(log_weight)
    log_evidence = float(np.logaddexp.reduce(smooth)) - log(draws)
    normalized = np.exp(smooth - np.logaddexp.reduce(smooth))
    error = sqrt(float((normalized**2).sum()))
    flights = apogee.shape[-1]
    log_without, ks = np.empty(flights), np.empty(flights)
    by_scale, mean, square = np.empty((3, target.shape[-1], flights))
    for row, flown_apogee in enumerate(apogee.T):  # the weights of all flights at once would take much memory
        of_flight = np.concatenate([batch[..., row] for batch in likelihood])
        log_without[row], ks[row], weights = _without(target, of_flight, log_density)
        by_scale[:, row] = weights.sum(axis=0)
        safe = np.maximum(by_scale[:, row], 1e-300)
        mean[:, row] = flown_apogee @ weights / safe
        square[:, row] = flown_apogee**2 @ weights / safe
    known = np.maximum(square - mean**2, 0.0)
    own = own_variance(fit)[scales]
    return Sampled(fit.unsolved(), log_evidence, error, pareto_k, log_without, ks, mean, known, own, by_scale, scales)


def _drawn(
    fit: Fit, scales: Int[Integers, "scale"], rng: Generator, draws: int
) -> tuple[Float[Array, "draw term"], Float[Array, "draw"]]:
    """Draws of the terms from the slightly widened posterior, and their log density."""
    weights = fit.weights[scales] / fit.weights[scales].sum()
    roots = np.linalg.cholesky(fit.covariance_at(scales)) * sqrt(INFLATION)
    which = rng.choice(len(scales), size=draws, p=weights)
    z = rng.normal(size=(draws, fit.mean.shape[1]))
    terms = fit.mean[scales][which] + np.einsum("dtu,du->dt", roots[which], z)
    precision = np.asarray(np.linalg.inv(fit.covariance_at(scales)), float) / INFLATION
    square = _squared(terms, fit.mean[scales], precision)
    log_det = 2 * np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    return terms, np.asarray(np.logaddexp.reduce(np.log(weights) - 0.5 * (square + log_det), axis=1))


def _squared(
    terms: Float[Array, "draw term"], means: Float[Array, "#scale term"], precision: Float[Array, "scale term term"]
) -> Float[Array, "draw scale"]:
    """Squared Mahalanobis distance of each draw from the mean of each scale, or of all. [1]

    One scale at a time: all at once take a hundred megabytes.
    """
    square = np.empty((len(terms), len(precision)))
    for scale, own in enumerate(precision):
        off = terms - means[scale if len(means) > 1 else 0]
        square[:, scale] = np.einsum("dt,dt->d", off @ own, off)
    return square


def log_prior(
    model: Model, scales: Int[Integers, "scale"], terms: Float[Array, "draw term"]
) -> Float[Array, "draw scale"]:
    """Log prior density of the terms and of each pair of scales, up to the constant of `_drawn`. [nat]"""
    low, high, mean = (np.array([getattr(term, name) for term in model.terms]) for name in ("low", "high", "mean"))
    precision, log_det = (part[scales] for part in prior_precision(model))
    square = _squared(terms, mean[None], precision)
    inside = ((terms >= low) & (terms <= high)).all(axis=1)
    density = model.hyperprior.scales()[2][scales] + 0.5 * (log_det - square) - bounds_log_mass(model)
    return np.where(inside.reshape(-1, 1), density, -np.inf)


def _simulated(
    fit: Fit, terms: Float[Array, "draw term"]
) -> tuple[Float[Array, "draw flight readout"], Float[Array, "draw flight"]]:
    """The compared readouts of every draw, and its apogee, which is that of the fit if it cannot be simulated."""
    model, near = fit.model, fit.tangent
    low, high = (np.array([getattr(term, name) for term in model.terms]) for name in ("low", "high"))
    readings = shown(model, np.clip(terms, low, high), {})
    flown = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
    return flown, np.where(np.isfinite(flown[..., 0]), flown[..., 0], near.values[:, 0])


def log_likelihood(
    fit: Fit, scales: Int[Integers, "scale"], flown: Float[Array, "draw flight readout"]
) -> Float[Array, "draw scale flight"]:
    """Log likelihood of every flight of a fit, with multivariate Student t noise around the compared readouts of each
    draw, up to the constant of a normal. [nat]"""
    return _given(fit, flight_evidence(fit.model, fit.data, fit.tangent, which=scales), flown)


def _given(
    fit: Fit, evidence: FlightEvidence, flown: Float[Array, "draw flight readout"]
) -> Float[Array, "draw scale flight"]:
    """As `log_likelihood`, given the information in each flight's readouts."""
    from scipy.special import gammaln  # takes 0.18 s to import

    model, near = fit.model, fit.tangent
    usable = fit.data.seen & np.isfinite(near.values)
    miss = np.where(usable, np.where(np.isfinite(flown), fit.data.values - flown, NO_FLIGHT_MISS), 0.0)
    square = _squares(miss[..., evidence.readouts], evidence.sharpness)
    nu, count = model.hyperprior.tail, readouts_used(fit.data, fit.tangent)
    constant = gammaln((nu + count) / 2) - gammaln(nu / 2) - count / 2 * np.log(nu / 2)
    square /= nu
    likelihood = np.log1p(square, out=square)
    likelihood *= -(nu + count) / 2
    likelihood += constant - 0.5 * evidence.log_det
    # a flight that cannot be compared has the density of readouts without any information, as in a fit
    likelihood[..., ~fit.data.seen.any(axis=1)] = 0.0
    return likelihood


def _squares(
    miss: Float[Array, "draw flight readout"], sharpness: Float[Array, "scale flight readout readout"]
) -> Float[Array, "draw scale flight"]:
    """Squared Mahalanobis distance of each flight. [1]"""
    first, second = np.triu_indices(miss.shape[-1])
    products = np.swapaxes(miss[..., first] * miss[..., second], 0, 1)
    both = np.where(first == second, 1.0, 2.0)
    return np.moveaxis(products @ np.moveaxis(both * sharpness[..., first, second], 0, -1), 0, -1)


def _without(
    target: Float[Array, "draw scale"], likelihood: Float[Array, "draw scale"], log_density: Float[Array, "draw"]
) -> tuple[float, float, Float[Array, "draw scale"]]:
    """Log evidence without a flight, the Pareto k of its weights, and the weights by draw and scale."""
    total, scale_share = summed(target - likelihood)
    smooth, pareto_k = smoothed(total - log_density)
    log_evidence = np.logaddexp.reduce(smooth)
    return float(log_evidence) - log(len(total)), pareto_k, np.exp(smooth - log_evidence)[:, None] * scale_share


def summed(joint: Float[Array, "draw scale"]) -> tuple[Float[Array, "draw"], Float[Array, "draw scale"]]:
    """The logarithm of the sum of exponentials over the scales [nat], and the part of each scale in the sum [1]; zeros
    for a draw outside the bounds of a term."""
    highest = joint.max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        each = np.nan_to_num(np.exp(joint - highest))
    total = each.sum(axis=1, keepdims=True)
    return (highest + np.log(np.maximum(total, 1.0)))[:, 0], each / np.maximum(total, 1.0)

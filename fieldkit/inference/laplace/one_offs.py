"""The probability that a flight is one of its rocket's usual ones, and of each cause if it is not.

Each flight is compared with the prediction of its readouts from the others: with a linear model the fit without the
flight follows in closed form (Woodbury's identity). A usual flight has the scatter and the Student t tails of the
model. Under a cause with some strength, its readouts are shifted as the simulator shifts them; the strength is summed
over a grid, and Bayes' rule gives the probability of every cause.

Two faulty flights may hide each other. So the fit is repeated with every flight weighted by its probability of being a
usual one, which is expectation-maximization for a mixture (Dempster, Laird and Rubin, 1977; with the probabilities from
the other flights alone, a flight does not vouch for itself).

What lasts is not a one-off. The alternative is a change of the rocket where the apogees before and after differ most,
with the evidence of two rockets that share nothing but their prior; the later flights then are the usual ones.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import log, pi

import numpy as np

from fieldkit.inference.batched_inverse import inverses
from fieldkit.inference.evidence import distinct_columns
from fieldkit.inference.laplace.outlier_flights import log_tail
from fieldkit.inference.laplace.outlier_weights import outlier_weights
from fieldkit.inference.laplace.posterior import Fit, flight_evidence, residual_variance, solve
from fieldkit.model.causes import NAMES, USUAL_PROBABILITY, Signatures, signatures
from fieldkit.model.readout_data import IS_LOGARITHMIC, Data
from fieldkit.shapes import Array, Flags, Float, Int, Integers

TAIL_DRAWS = 32
"""Draws of the precisions of a flight's residuals, which make their normal distributions Student t. [1]"""
MAX_SCALES = 4
"""Number of pairs of scales that are kept for a flight. [1]"""
LEAST_WEIGHT = 1e-3
"""Lowest weight of a flight in a fit. [1]"""
CHANGE_PROBABILITY = 0.1
"""Prior probability that a rocket changes for good between two of its flights, a round judgment. [1]"""
DOUBTFUL = 0.9
"""A change is considered if all flights on one side of it are usual ones with less than this probability. [1]"""
MAX_SHIFT = 2.0
"""Largest miss of a single flight that counts where apogees before and after are compared. [standard deviations]"""
MAX_RELATIVE_ERROR = 0.1
"""Largest relative error that is nearly the error of the logarithm. [1]"""
CHANGE_ROUNDS = 2
"""Updates of the weights of outliers in the fits before and after a change. [1]"""


@dataclass(frozen=True, slots=True)
class OneOffs:
    """Flights compared with the others of their rocket.

    `miss` is each readout as compared minus its prediction from the other flights, and `sd` the standard deviation of
    the prediction for a usual flight, nan if not recorded [1] or [s]. `normal` is the probability that a flight is a
    usual one, 1 for a flight without readouts, `cause` that of each of `NAMES`, and `strength` its expectation, as in
    `Signatures`. `weight` is the weight of each flight in the next fit: less than `normal` for flights before a
    lasting change, which has probability `changed` [1]. `log_causes` is the log of prior probability times likelihood
    of all causes together, and `log_mixture` what each flight adds to the log evidence of a fit with these weights.
    [nat]
    """

    miss: Float[Array, "flight readout"]
    sd: Float[Array, "flight readout"]
    normal: Float[Array, "flight"]
    cause: Float[Array, "flight cause"]
    strength: Float[Array, "flight cause"]
    weight: Float[Array, "flight"]
    log_causes: Float[Array, "flight"]
    log_mixture: Float[Array, "flight"]
    changed: float = 0.0


@dataclass(frozen=True, slots=True)
class _Given:
    """Residuals of every flight, and the covariance of its predicted readouts, given all flights, for every pair of
    scales: `sharper` is 1 / (N - G) as in `_left_out`, 0 for flights that the fit does not use."""

    readouts: Int[Integers, "used"]
    residual: Float[Array, "scale flight used"]
    known: Float[Array, "scale flight used used"]
    sharper: Float[Array, "scale flight used used"]
    log_weight: Float[Array, "scale flight"]


@dataclass(frozen=True, slots=True)
class _LeftOut:
    """Predictions of flights with the same readouts from the others, for the likeliest pairs of scales of each: the
    error of the prediction, its covariance without the flight's own scatter, and the log weight of the scales."""

    scales: Int[Integers, "flight scale"]
    error: Float[Array, "flight scale own"]
    known: Float[Array, "flight scale own own"]
    log_weight: Float[Array, "flight scale"]


def one_offs(fit: Fit, data: Data | None = None, known: Signatures | None = None) -> OneOffs:
    """The probabilities of all flights in a fit; with `data`, also of flights that the fit does not use.

    `known` are the signatures at the point of the fit, if they were computed before. Raises ImpossibleFlight for a
    flight without a dry mass.
    """
    data = data or fit.data
    if known is None:
        known = signatures(fit.model, fit.tangent.at, fit.tangent.values, data.seen)
    every = _left_out(fit, data)
    usable = data.seen & np.isfinite(fit.tangent.values)
    shape = usable.shape
    miss, sd = np.full(shape, np.nan), np.full(shape, np.nan)
    normal, log_causes = np.ones(len(usable)), np.full(len(usable), -np.inf)
    cause, strength = np.zeros((len(usable), len(NAMES))), np.zeros((len(usable), len(NAMES)))
    scatter = fit.model.scatter_scales() ** 2
    variance, error_ratio = residual_variance(fit.model, data), _as_expected(data, fit.tangent.values)
    for rows, own in _by_readouts(usable):
        left_out = _left_out_at(every, rows, own)
        weight = np.exp(left_out.log_weight)[..., None]
        spread = fit.tangent.scatter_slope[rows[:, None], own]
        joint = np.einsum("fsk,fok,fpk->fsop", scatter[left_out.scales], spread, spread)
        reading = variance[left_out.scales, rows[:, None]][..., own]
        likely = _Likelihood.of(left_out, joint, reading, fit.model.hyperprior.tail)
        mean = (weight * left_out.error).sum(axis=1)
        between = (left_out.error - mean[:, None]) ** 2
        around = np.diagonal(left_out.known + joint, axis1=2, axis2=3)
        around = around + reading * error_ratio[rows[:, None], own][:, None] ** 2
        miss[rows[:, None], own] = mean
        sd[rows[:, None], own] = np.sqrt((weight * (around + between)).sum(axis=1))
        for row, flight in zip(rows.tolist(), likely, strict=True):
            normal[row], cause[row], strength[row], log_causes[row] = _probabilities(flight, known, row, own)
    weight = np.maximum(normal, LEAST_WEIGHT)
    found = OneOffs(miss, sd, normal, cause, strength, weight, log_causes, _log_mixture(weight, log_causes))
    return _with_change(fit, found)


def _as_expected(data: Data, expected: Float[Array, "flight readout"]) -> Float[Array, "flight readout"]:
    """The error of each readout were it as expected, relative to that of the reading: less than 1 for one that is too
    low for its relative error to be that of its log. [1]

    An altimeter that shows 0.2 m instead of 200 m may be off by several times its reading, the next one is not.
    """
    too_low = IS_LOGARITHMIC & data.seen & (data.sd > MAX_RELATIVE_ERROR) & np.isfinite(expected)
    return np.asarray(np.exp(np.minimum(np.where(too_low, data.values - expected, 0.0), 0.0)))


def _log_mixture(weight: Float[Array, "flight"], log_causes: Float[Array, "flight"]) -> Float[Array, "flight"]:
    """What each flight adds to the lower bound of the log evidence of a mixture, beside its weighted log likelihood as
    a usual flight, from the log of prior probability times likelihood of all causes. [nat]"""
    rest = np.maximum(1 - weight, 1e-300)
    usual = weight * (log(USUAL_PROBABILITY) - np.log(weight))
    return np.where(np.isfinite(log_causes), usual + rest * (log_causes - np.log(rest)), 0.0)


def _with_change(fit: Fit, found: OneOffs) -> OneOffs:
    """The same with the probability of a lasting change where the apogees before and after differ most, with two
    flights at least on either side."""
    flown = np.flatnonzero(fit.data.seen[:, 0] & np.isfinite(found.miss[:, 0]))
    # a single flight, however far off, is no change
    off, count = np.clip(found.miss[flown, 0] / found.sd[flown, 0], -MAX_SHIFT, MAX_SHIFT), len(flown)
    if count < 4:
        return found
    cuts = np.arange(2, count - 1)
    means = np.cumsum(off)[cuts - 1] / cuts, (off.sum() - np.cumsum(off)[cuts - 1]) / (count - cuts)
    shift = np.abs(means[0] - means[1]) * np.sqrt(cuts * (count - cuts) / count)
    cut = int(cuts[np.argmax(shift)])
    sides = flown[:cut], flown[cut:]
    odd = min(sides, key=lambda side: float(found.normal[side].mean()))
    if (found.normal[odd] > DOUBTFUL).any():
        return _with_changed_last(fit, found, flown)
    odds = (
        _log_evidence_of_two(fit, flown[:cut], flown[cut:])
        + log(CHANGE_PROBABILITY / (count - 1))
        - log(1 - CHANGE_PROBABILITY)
    )
    odds -= fit.log_evidence + found.log_mixture.sum()
    changed = float(1 / (1 + np.exp(-np.clip(odds, -500, 500))))
    run, before = (np.isin(np.arange(len(found.normal)), side) for side in (odd, sides[0]))
    normal = np.where(run, changed + (1 - changed) * found.normal, found.normal)
    cause = np.where(run[:, None], (1 - changed) * found.cause, found.cause)
    weight = np.where(before, (1 - changed) * found.weight, np.where(run, normal, found.weight))
    return replace(found, normal=normal, cause=cause, weight=np.maximum(weight, LEAST_WEIGHT), changed=changed)


def _with_changed_last(fit: Fit, found: OneOffs, flown: Integers) -> OneOffs:
    """The same with the probability that the rocket changed for good before its last flight: one more cause of that
    flight, whose readouts then are those of a rocket of which only the prior is known."""
    last, normal = int(flown[-1]), float(found.normal[flown[-1]])
    if normal > DOUBTFUL or not np.isfinite(found.log_causes[last]):
        return found
    beside = found.log_causes[last] - log(max(1 - normal, 1e-12))  # of the readouts, changes aside
    odds = log(CHANGE_PROBABILITY / (len(flown) - 1)) + _log_evidence_of_two(fit, flown[-1:]) - beside
    changed = float(1 / (1 + np.exp(-np.clip(odds, -500, 500))))
    is_last = np.arange(len(found.normal)) == last
    usual = np.where(is_last, changed + (1 - changed) * normal, found.normal)
    cause = np.where(is_last[:, None], (1 - changed) * found.cause, found.cause)
    weight = np.where(is_last, usual, (1 - changed) * found.weight)
    return replace(found, normal=usual, cause=cause, weight=np.maximum(weight, LEAST_WEIGHT), changed=changed)


def _log_evidence_of_two(fit: Fit, *parts: Integers) -> float:
    """Log evidence of some flights and others as those of two rockets, with the cost of their outliers. [nat]"""
    total = 0.0
    for rows in parts:
        seen = np.zeros_like(fit.data.seen)
        seen[rows] = fit.data.seen[rows]
        result = solve(fit.model, replace(fit.data, seen=seen, trust=np.ones(seen.shape), normal=None), fit.tangent)
        for _ in range(CHANGE_ROUNDS):
            result = solve(fit.model, replace(result.data, trust=outlier_weights(result)), fit.tangent)
        compared = seen & np.isfinite(fit.tangent.values)
        tail = log_tail(result.data.trust.ravel(), compared.ravel().astype(int), fit.model.hyperprior.tail)
        total += result.log_evidence + float(tail.sum())
    return total


def _by_readouts(usable: Flags) -> Iterator[tuple[Int[Integers, "flight"], Int[Integers, "own"]]]:
    """The flights that have the same readouts, and these; without flights that have none."""
    patterns, which = np.unique(usable, axis=0, return_inverse=True)
    for place, pattern in enumerate(patterns):
        if pattern.any():
            yield np.flatnonzero(which.ravel() == place), np.flatnonzero(pattern)


def _left_out(fit: Fit, data: Data) -> _Given:
    """What predicts every flight from all the others; those that the fit does not use are predicted from all.

    With a flight's noise N in the fit and the covariance G of its predicted readouts given all flights, M = 1 / (N - G)
    and the residual r give the error r + G M r of the prediction without it and the covariance G + G M G.
    """
    data = replace(data, trust=fit.data.trust, normal=fit.data.normal)
    evidence = flight_evidence(fit.model, data, fit.tangent, fit.flight_weight)
    offset = fit.mean - np.array([term.mean for term in fit.model.terms])
    residual = evidence.miss - np.moveaxis(evidence.slope @ offset.T, -1, 0)
    slope, sums = distinct_columns(evidence.slope)
    known = slope @ fit.covariance_of(sums)[:, None] @ np.swapaxes(slope, 1, 2)
    noise, log_sharpness = inverses(evidence.sharpness)
    used = np.asarray(fit.data.seen.any(axis=1))
    sharper, log_det = inverses(noise - np.where(used[:, None, None], known, 0.0))
    distance = (residual * (sharper @ residual[..., None])[..., 0]).sum(axis=-1)
    own = -0.5 * (distance - log_sharpness - log_det + evidence.log_det)
    log_weight = fit.log_weight[:, None] - np.where(used, own, 0.0)
    sharper = np.where(used[:, None, None], sharper, 0.0)
    return _Given(evidence.readouts, residual, known, sharper, log_weight)


def _left_out_at(every: _Given, rows: Int[Integers, "flight"], own: Int[Integers, "own"]) -> _LeftOut:
    """The predictions of flights with the same readouts from all the others, at the likeliest scales of each."""
    log_weight = every.log_weight[:, rows].T
    scales = np.argsort(-log_weight, axis=1)[:, :MAX_SCALES]
    log_weight = np.take_along_axis(log_weight, scales, axis=1)
    log_weight = log_weight - np.logaddexp.reduce(log_weight, axis=1, keepdims=True)
    residual, known, sharper = (part[scales, rows[:, None]] for part in (every.residual, every.known, every.sharper))
    taken = known @ sharper
    error = residual + (taken @ residual[..., None])[..., 0]
    without = known + taken @ known
    place = np.searchsorted(every.readouts, own)
    return _LeftOut(scales, error[..., place], without[..., place[:, None], place], log_weight)


@dataclass(frozen=True, slots=True)
class _Likelihood:
    """The likelihood of one flight's readouts as a mixture of normal distributions, one for each pair of scales and
    each draw of the precisions of scatter and residuals: both are Student t, and a flight may be as far off as any
    outlier.

    `coefficients` are the inverse covariance, each pair of readouts once, and its product with the error of the
    prediction; `constant` is the log density of the error times the weight. [nat]
    """

    coefficients: Float[Array, "normal coefficient"]
    constant: Float[Array, "normal"]

    @classmethod
    def of(
        cls,
        predicted: _LeftOut,
        scatter: Float[Array, "flight scale own own"],
        reading: Float[Array, "flight scale own"],
        tail: float,
    ) -> "list[_Likelihood]":
        """The likelihoods of flights with the same readouts, from the covariance of the scatter and the
        variances of the residuals of each."""
        flights, _, own = predicted.error.shape
        precision = _precisions(tail, 1 + own)
        diagonal = np.arange(own)
        covariance = predicted.known[:, :, None] + scatter[:, :, None] / precision[:, :1, None]
        covariance[..., diagonal, diagonal] += reading[:, :, None] / precision[:, 1:]
        sharpness, log_det = inverses(covariance)
        error = predicted.error[:, :, None, None]
        weighed = (error @ sharpness)[..., 0, :]
        square = (weighed * error[..., 0, :]).sum(axis=-1)
        constant = predicted.log_weight[..., None] - log(len(precision)) - own / 2 * log(2 * pi)
        constant = constant - 0.5 * (square + log_det)
        coefficients = np.concatenate([sharpness[..., *np.triu_indices(own)], weighed], axis=-1)
        flat = coefficients.reshape(flights, -1, coefficients.shape[-1])
        return [cls(*each) for each in zip(flat, constant.reshape(flights, -1), strict=True)]

    def log_likelihoods(
        self, shift: Float[Array, "strength own"], spread: Float[Array, "strength own"]
    ) -> Float[Array, "strength"]:
        """Log likelihood of the flight if a cause shifts its readouts. [nat]

        The inverse and determinant with the added rank of the spread v follow from those without: Sherman and
        Morrison's formula and the matrix determinant lemma. A quadratic form in the inverse S is linear in S: all forms
        of all strengths follow from one product.
        """
        first, second = np.triu_indices(shift.shape[1])
        of_pair = np.where(first == second, 0.5, 1.0)

        def products(one: Float[Array, "strength own"], other: Float[Array, "strength own"]) -> Array:
            return of_pair * (one[:, first] * other[:, second] + one[:, second] * other[:, first])

        forms = (
            np.hstack([products(shift, shift), -2 * shift]),
            np.hstack([-products(shift, spread), spread]),
            np.hstack([products(spread, spread), np.zeros_like(spread)]),
        )
        square, along, added = np.split(self.coefficients @ np.concatenate(forms).T, 3, axis=1)
        added = added + 1.0
        each = self.constant[:, None] - 0.5 * (square - along**2 / added + np.log(added))
        highest = each.max(axis=0)
        return np.asarray(highest + np.log(np.exp(each - highest).sum(axis=0)))


@cache
def _precisions(tail: float, count: int) -> Float[Array, "draw own"]:
    """Precisions of the scatter and the residuals of a flight, Gamma distributed with mean one: every draw has a
    stratum of each (Latin hypercube; McKay, Beckman and Conover, 1979)."""
    from scipy.special import gammaincinv  # takes 0.18 s to import

    level = (np.arange(TAIL_DRAWS) + 0.5) / TAIL_DRAWS
    strata = np.random.default_rng(0).permuted(np.tile(level, (count, 1)), axis=1).T
    return np.asarray(gammaincinv(tail / 2, strata) / (tail / 2))


def _probabilities(
    flight: _Likelihood, known: Signatures, row: int, own: Int[Integers, "own"]
) -> tuple[float, Float[Array, "cause"], Float[Array, "cause"], float]:
    """The probability that a flight is a usual one, that of each cause, the expected strengths, and the log of prior
    times likelihood of all causes."""
    possible = np.flatnonzero(np.isfinite(known.log_prior[:, row]))
    shift, spread = (
        np.vstack([np.zeros(len(own)), part[possible, row][:, own]]) for part in (known.shift, known.spread)
    )
    log_joint = flight.log_likelihoods(shift, spread)
    log_joint += np.concatenate([[np.log(USUAL_PROBABILITY)], known.log_prior[possible, row]])
    chance = np.exp(log_joint - np.logaddexp.reduce(log_joint))
    of = np.eye(len(NAMES))[known.cause[possible]]
    cause = chance[1:] @ of
    strength = (chance[1:] * known.strength[possible, row]) @ of / np.maximum(cause, 1e-300)
    return float(chance[0]), cause, strength, float(np.logaddexp.reduce(log_joint[1:], initial=-np.inf))

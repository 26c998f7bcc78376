"""The evidence of linear models with normal priors and noise, in closed form.

Readouts that are linear in some terms, with normal noise and a normal prior, have a normal posterior, and the evidence
follows by completing the square (Bishop, Pattern Recognition and Machine Learning, 2006, sections 2.3 and 3.5). Terms
added to a fitted model only need the products of their columns after the model's own terms are refitted, by Woodbury's
identity. Bounds on a term add the logarithm of the ratio of the probabilities within them, posterior to prior.
"""

from dataclasses import dataclass, replace
from math import erfc
from typing import NamedTuple

import numpy as np

from fieldkit.shapes import Array, Float, Int, Integers

INSIDE_SDS = 7.0
"""At this distance inside a bound, in standard deviations, the probability beyond it is numerically zero. [1]"""
MIN_MASS = 1e-250
"""Minimum probability between two bounds, so that its logarithm is finite. [1]"""
MIN_DETERMINANT = 1e-9
"""Minimum determinant of the precision of two strengths, relative to the product of its diagonal. [1]"""
_ERFC = np.frompyfunc(erfc, 1, 1)  # `scipy.special` would take 0.18 s to import


class NormalPosterior(NamedTuple):
    """A normal posterior: `mean` from the prior mean, `covariance`, and the log ratio of the evidence to the density of
    the readouts at the prior mean. [nat]"""

    mean: Float[Array, "*batch term"]
    covariance: Float[Array, "*batch term term"]
    log_bayes: Float[Array, "*batch"]


def normal_posterior(
    information: Float[Array, "*batch term term"],
    score: Float[Array, "*batch term"],
    prior: Float[Array, "*prior term term"],
    log_det_prior: Float[Array, "*prior"],
) -> NormalPosterior:
    """The posterior of terms from the information matrix of the readouts, the derivative of their log likelihood at the
    prior mean (`score`), and the precision of the prior with the logarithm of its determinant; in the
    units of the terms."""
    precision = information + prior
    covariance = np.asarray(np.linalg.inv(precision), float)
    mean = (covariance @ score[..., None])[..., 0]
    log_bayes = 0.5 * ((score * mean).sum(axis=-1) - np.linalg.slogdet(precision)[1] + log_det_prior)
    return NormalPosterior(mean, covariance, np.asarray(log_bayes))


@dataclass(frozen=True, slots=True, eq=False)
class NormalPrior:
    """A normal prior of terms for several scales: independent with these variances, 0 for the terms in `joint`, which
    have the covariance `block` at every scale; in the units of the terms, squared."""

    variance: Float[Array, "scale term"]
    joint: Int[Integers, "joint"]
    block: Float[Array, "joint joint"]

    def along(self, sums: Float[Array, "sum term"]) -> Float[Array, "scale sum term"]:
        """The covariance of sums of terms with each term, in their units, squared."""
        found = sums * self.variance[:, None]
        found[..., self.joint] += sums[:, self.joint] @ self.block
        return np.asarray(found)

    def covariance(self) -> Float[Array, "scale term term"]:
        """The covariance of all terms, in their units, squared."""
        return self.along(np.eye(self.variance.shape[1]))


@dataclass(frozen=True, slots=True, eq=False)
class TermPosterior:
    """A normal posterior of terms on which the readouts depend only by sums, for several scales.

    `offset` is the mean less that of the prior, in the units of the terms, `along` the prior covariance of the sums
    with the terms, and `known` the reduction of the covariance of the terms is `along`' `known` `along`. `log_bayes` is
    as in `NormalPosterior`.
    """

    prior: NormalPrior
    offset: Float[Array, "scale term"]
    along: Float[Array, "scale sum term"]
    known: Float[Array, "scale sum sum"]
    log_bayes: Float[Array, "scale"]

    def covariance(self, scales: Int[Integers, "some"] | slice = slice(None)) -> Float[Array, "some term term"]:
        """The covariance of the terms for all or `some` scales, in their units, squared."""
        along, prior = self.along[scales], replace(self.prior, variance=self.prior.variance[scales])
        return np.asarray(prior.covariance() - np.swapaxes(along, 1, 2) @ self.known[scales] @ along)

    def covariance_of(self, sums: Float[Array, "other term"]) -> Float[Array, "scale other other"]:
        """The covariance of sums of the terms, in their units, squared."""
        along = self.along @ sums.T
        return np.asarray(self.prior.along(sums) @ sums.T - np.swapaxes(along, 1, 2) @ self.known @ along)

    def variance(self, terms: Int[Integers, "some"]) -> Float[Array, "scale some"]:
        """The variances of some terms, in their units, squared."""
        along, before = self.along[..., terms], self.prior.variance.copy()
        before[:, self.prior.joint] += np.diagonal(self.prior.block)
        return np.asarray(before[:, terms] - (along * (self.known @ along)).sum(axis=1))


def term_posterior(
    information: Float[Array, "scale sum sum"],
    score: Float[Array, "scale sum"],
    prior: NormalPrior,
    sums: Float[Array, "sum term"],
) -> TermPosterior:
    """The posterior of terms from the information matrix of the readouts about some of their sums, and the derivative
    of the log likelihood at the prior mean (`score`), in the units of the terms.

    Derivation: with the information W, and the prior covariance V of the sums, the reduction of the covariance is that
    of a Kalman filter, (W^-1 + V)^-1 = (1 + W V)^-1 W.
    """
    along = prior.along(sums)
    own = along @ sums.T
    wider = np.eye(len(sums)) + information @ own
    inverse = np.asarray(np.linalg.inv(wider), float)
    moved = inverse @ score[..., None]
    offset = (np.swapaxes(along, 1, 2) @ moved)[..., 0]
    distance = (score * (own @ moved)[..., 0]).sum(axis=-1)
    log_bayes = np.asarray(0.5 * (distance - np.linalg.slogdet(wider)[1]))
    return TermPosterior(prior, offset, along, inverse @ information, log_bayes)


def distinct_columns(
    slope: Float[Array, "*entry term"],
) -> tuple[Float[Array, "*entry sum"], Float[Array, "sum term"]]:
    """The distinct columns of slopes, in their units, without those that are 0 throughout, and for each 1 for the terms
    that have it [1]: the readouts depend on the sum of these terms."""
    columns = np.ascontiguousarray(slope.reshape(-1, slope.shape[-1]).T + 0.0)
    places: dict[bytes, list[int]] = {}
    for term in np.flatnonzero(columns.any(axis=1)).tolist():
        places.setdefault(columns[term].tobytes(), []).append(term)
    sums = np.zeros((len(places), len(columns)))
    for row, terms in enumerate(places.values()):
        sums[row, terms] = 1.0
    return slope[..., [terms[0] for terms in places.values()]], sums


@dataclass(frozen=True, slots=True, eq=False)
class StrengthPrior:
    """Truncated normal priors of strengths, in their units: mean and standard deviation without the bounds `low` and
    `high`, and the log probability between these."""

    mean: Array
    sd: Array
    low: Array
    high: Array
    log_mass: Array


def strength_posterior(a: Array, b: Array, prior: StrengthPrior) -> tuple[Array, Array, Array]:
    """Log Bayes factor against a strength of zero [nat], posterior mean and standard deviation of a strength with a
    truncated normal prior, in its unit; elementwise.

    `a` is the precision with which the readouts determine the strength, and `b` is `a` times their estimate of it. The
    mean is clipped to the bounds; the standard deviation is that of the normal distribution without them.
    """
    mean, sd, low, high = prior.mean, prior.sd, prior.low, prior.high
    precision = a + 1 / sd**2
    middle = (b + mean / sd**2) / precision
    spread = 1 / np.sqrt(precision)
    bayes = 0.5 * (middle**2 * precision - mean**2 / sd**2 - np.log(precision * sd**2)) - prior.log_mass
    return bayes + log_mass(middle, spread, low, high), np.clip(middle, low, high), spread


def pair_evidence(
    between: Float[Array, "one other"], precision: Float[Array, "one"], score: Float[Array, "one #other"]
) -> Float[Array, "one other"]:
    """The part of the log evidence of two strengths that depends on the readouts, for every pair. [nat]

    `precision` is that of each strength alone, `between` the inner products of their columns, and `score` that of the
    row's strength with the column's at its prior mean. Derivation: determinant and inverse of the 2 x 2 precision
    written out.
    """
    product = np.multiply.outer(precision, precision)
    det = np.maximum(product - between**2, MIN_DETERMINANT * product)
    score = np.broadcast_to(score, det.shape)
    one = precision * score**2
    return np.asarray(0.5 * ((one + one.T - 2 * between * score * score.T) / det - np.log(det)))


def log_mass(mean: Array, sd: Array, low: Array, high: Array) -> Array:
    """Log of the probability of a normal distribution between two bounds, elementwise. [nat]

    Derivation: the difference of its distribution function at the bounds, mirrored where both values would be near 1.
    """
    mean, sd, low, high = np.broadcast_arrays(mean, sd, low, high)
    found = np.zeros(mean.shape)
    near = np.minimum(mean - low, high - mean) < INSIDE_SDS * sd
    if near.any():
        above, below = ((end[near] - mean[near]) / sd[near] for end in (high, low))
        mirrored = below > 0  # where both would be near 1
        above, below = np.where(mirrored, -below, above), np.where(mirrored, -above, below)
        mass = 0.5 * (_ERFC(-above * np.sqrt(0.5)) - _ERFC(-below * np.sqrt(0.5))).astype(float)
        found[near] = np.log(np.maximum(mass, MIN_MASS))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Regressors:
    """Changes of the readouts, a column each, with their products with the noise and with the terms of a fitted model.

    `plain` are the changes, `weighed` the inverse covariance of single flights times them, `along` the products of
    these with the model's slopes, and `absorbed` the change of the model's terms that absorbs them.
    """

    plain: Float[Array, "entry column"]
    weighed: Float[Array, "scale entry column"]
    along: Float[Array, "scale term column"]
    absorbed: Float[Array, "scale term column"]

    def every(self, first: int, step: int) -> "Regressors":
        """Every `step`-th column."""
        rows = slice(first, None, step)
        return Regressors(*(part[..., rows] for part in (self.plain, self.weighed, self.along, self.absorbed)))

    def products(self, other: "Regressors") -> Float[Array, "scale column"]:
        """Inner product of each column with that of another, the model's terms refitted. [1]"""
        return np.asarray(
            np.einsum("ec,sec->sc", self.plain, other.weighed) - np.einsum("stc,stc->sc", self.along, other.absorbed)
        )

    def gram(self) -> Float[Array, "scale column other"]:
        """Inner products of all columns, the model's terms refitted. [1]"""
        return np.asarray(self.plain.T @ self.weighed - np.swapaxes(self.along, 1, 2) @ self.absorbed)


@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """A fitted linear model, to which terms can be added: the slopes of its terms, the inverse covariance of the
    readouts of each flight given the terms, and the covariance of the terms, for some pairs of scales."""

    slope: Float[Array, "flight used term"]
    sharpness: Float[Array, "scale flight used used"]
    covariance: Float[Array, "scale term term"]

    def regressors(self, change: Float[Array, "flight used column"]) -> Regressors:
        """Changes of the readouts as columns to add. [1] or [s]"""
        weighed = (self.sharpness @ change).reshape(len(self.sharpness), -1, change.shape[-1])
        along = self.slope.reshape(weighed.shape[1], -1).T @ weighed
        return Regressors(change.reshape(weighed.shape[1], -1), weighed, along, self.covariance @ along)

    def weighed(self, columns: Regressors, scale: int) -> Float[Array, "entry column"]:
        """The inverse covariance of all readouts times columns, at one pair of scales (Woodbury's identity), in the
        inverse of their units."""
        moved = self.sharpness[scale] @ (self.slope @ columns.absorbed[scale])
        return np.asarray(columns.weighed[scale] - moved.reshape(columns.plain.shape))

"""Closed-form evidence for additions to a model, from one linear fit of the model without them.

A strength s with a normal prior adds s times a known shift of the readouts. With the model's inverse covariance M of
the readouts, the log Bayes factor follows from a = shift' M shift and b = shift' M miss.

Derivation: `fieldkit.inference.evidence`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.inference.evidence import StrengthPrior, normal_posterior, pair_evidence, strength_posterior
from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.placed_effects import Directions, Placed, PlacedEffect, directions
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.shapes import Array, Flags, Float, Int, Integers

_NUMBERS = ("log_fraction", "log_bayes", "robust", "mean", "sd", "prior_mean", "prior_sd", "unit", "gradient")
"""Scalar fields of trials."""


@dataclass(frozen=True, slots=True)
class Trials:
    """Candidates added to a linear fit, one entry each; a candidate with several starts has several entries.

    `candidate` is the number of the candidate, and `family` its name in a verdict. `log_bayes` includes no prior;
    `log_fraction` is the candidate's part of its effect's log prior. `robust` is `log_bayes` without the flight that
    contributes most to it. `shift` has the effect of a unit of strength on the flown flights as columns, and `weighed`
    is the same times the inverse covariance at the most likely scales. `gradient` is the derivative of the log
    likelihood with respect to the strength, at zero and the same scales. `unit` is the value of the effect's parameter
    at a strength of 1.
    """

    candidate: tuple[int, ...]
    family: tuple[str, ...]
    log_fraction: Float[Array, "trial"]
    log_bayes: Float[Array, "trial"]
    robust: Float[Array, "trial"]
    mean: Float[Array, "trial"]
    sd: Float[Array, "trial"]
    prior_mean: Float[Array, "trial"]
    prior_sd: Float[Array, "trial"]
    unit: Float[Array, "trial"]
    shift: Float[Array, "entry trial"]
    weighed: Float[Array, "entry trial"]
    gradient: Float[Array, "trial"]

    @property
    def weight(self) -> Float[Array, "trial"]:
        """Log evidence with the candidate's own prior. [nat]"""
        return np.asarray(self.log_bayes + self.log_fraction)


@dataclass(frozen=True, slots=True, eq=False)
class _Weights:
    """What turns shifts of the flown flights' readouts into evidence, for every pair of scales.

    `used` are the indices of the readouts of any flight and of the apogee; `usable` marks those that a flight has.
    `weighted_residual` is the inverse covariance of all readouts times the residual.
    """

    fit: Fit
    used: Int[Integers, "readout"]
    usable: Flags
    weighted_residual: Float[Array, "scale flight readout"]
    log_weight: Float[Array, "scale"]

    @property
    def best(self) -> int:
        """The most likely pair of scales."""
        return int(np.argmax(self.log_weight))

    def shift(self, linear: LinearFit, columns: Directions) -> Float[Array, "flight readout column"]:
        """Shifts of the observed readouts by each direction."""
        shift = columns.shift(linear.moved, self.used)[: len(self.usable)]
        return np.where(self.usable[..., None], shift, 0.0)


def _weights(fit: Fit) -> _Weights:
    flights, prior_mean = fit.evidence, np.array([term.mean for term in fit.model.terms])
    miss = flights.miss - np.moveaxis(flights.slope @ (fit.mean - prior_mean).T, -1, 0)
    usable = (fit.data.seen & np.isfinite(fit.tangent.values))[:, flights.readouts]
    residual = (flights.sharpness @ miss[..., None])[..., 0]
    return _Weights(fit, flights.readouts, usable, residual, fit.log_weight - fit.log_evidence)


def weigh(linear: LinearFit, candidates: Sequence[PlacedEffect]) -> Trials:
    """The evidence for every candidate added to a linear fit."""
    return weigh_placed(linear, directions(candidates))


def weigh_placed(linear: LinearFit, placed: Placed) -> Trials:
    """As `weigh`, for candidates as directions."""
    weights = _weights(linear.fit)
    parts = [_single(linear, weights, placed.single)] if placed.single else []
    several = (_several(linear, weights, columns) for columns in placed.several)
    return _joined([*parts, *several], weights.usable.size)


def _single(linear: LinearFit, weights: _Weights, columns: Directions) -> Trials:
    """Candidates with one strength."""
    shift, best, own = weights.shift(linear, columns), weights.best, weights.fit.linear()
    flat = own.regressors(shift)
    a = flat.products(flat)
    b = weights.weighted_residual.reshape(len(a), -1) @ flat.plain
    bayes, mean, sd = strength_posterior(a, b, columns.prior)
    joint = weights.log_weight[:, None] + bayes
    log_bayes = np.logaddexp.reduce(joint, axis=0)
    fraction = np.exp(joint - log_bayes)
    middle = (fraction * mean).sum(axis=0)
    weighed = own.weighed(flat, best)
    own_a = (shift * weighed.reshape(shift.shape)).sum(axis=1)
    own_b = (shift * weights.weighted_residual[best][..., None]).sum(axis=1)
    without = strength_posterior(np.maximum(a[best] - own_a, 0.0), b[best] - own_b, columns.prior)[0]
    return Trials(
        candidate=columns.number,
        family=columns.family,
        log_fraction=columns.log_fraction,
        log_bayes=log_bayes,
        robust=log_bayes - np.maximum(bayes[best] - without, 0.0).max(axis=0),
        mean=middle,
        sd=np.sqrt((fraction * (sd**2 + (mean - middle) ** 2)).sum(axis=0)),
        prior_mean=columns.prior.mean,
        prior_sd=columns.prior.sd,
        unit=columns.unit,
        shift=flat.plain,
        weighed=weighed,
        gradient=b[best],
    )


def _several(linear: LinearFit, weights: _Weights, columns: Directions) -> Trials:
    """A candidate with a separate strength in each of several groups; its strength is their root mean square.

    Its `robust` evidence leaves out no flight, bounds are ignored, and it does not change the forecasts of plans.
    """
    own, sds = weights.fit.linear(), columns.prior.sd
    flat = own.regressors(weights.shift(linear, columns))
    b = weights.weighted_residual.reshape(len(weights.log_weight), -1) @ flat.plain
    log_det = np.array(-2 * np.log(sds).sum())
    middle, covariance, bayes = normal_posterior(flat.gram(), b, np.diag(1 / sds**2), log_det)
    joint = weights.log_weight + bayes
    log_bayes = np.array([np.logaddexp.reduce(joint)])
    best = int(np.argmax(joint))
    size = float(np.sqrt((middle[best] ** 2).mean()))
    along = middle[best] / max(size, 1e-9)
    return Trials(
        candidate=columns.number[:1],
        family=columns.family[:1],
        log_fraction=columns.log_fraction[:1],
        log_bayes=log_bayes,
        robust=log_bayes,
        mean=np.array([size]),
        sd=np.array([np.sqrt(np.diagonal(covariance[best]).mean())]),
        prior_mean=np.zeros(1),
        prior_sd=np.array([sds.mean()]),
        unit=np.ones(1),
        shift=(flat.plain @ along)[:, None],
        weighed=(own.weighed(flat, weights.best) @ along)[:, None],
        gradient=np.array([b[weights.best] @ along]),
    )


def _joined(parts: Sequence[Trials], entries: int) -> Trials:
    """All trials in one."""

    def column(name: str, *shape: int) -> Array:
        empty = np.empty((*shape, 0))
        return np.concatenate([empty, *(getattr(part, name) for part in parts)], axis=-1)

    return Trials(
        candidate=tuple(number for part in parts for number in part.candidate),
        family=tuple(name for part in parts for name in part.family),
        **{name: column(name) for name in _NUMBERS},
        shift=column("shift", entries),
        weighed=column("weighed", entries),
    )


def conditional(trials: Trials, rows: Sequence[int]) -> Float[Array, "row row"]:
    """Log Bayes factor of each trial given each other trial; on the diagonal, of the trial alone. [nat]

    Strengths are treated as normal, without bounds.
    """
    some = list(rows)
    gram = trials.shift[:, some].T @ trials.weighed[:, some]
    b, mean, sd = trials.gradient[some], trials.prior_mean[some], trials.prior_sd[some]
    a = np.diagonal(gram)
    unbounded = np.full(len(some), np.inf)
    alone = strength_posterior(a, b, StrengthPrior(mean, sd, -unbounded, unbounded, np.zeros(len(some))))[0]
    p, q = a + 1 / sd**2, b + mean / sd**2
    prior = 0.5 * (mean / sd) ** 2 + np.log(sd)
    both = pair_evidence(gram, p, q[:, None]) - np.add.outer(prior, prior)
    beside = both - alone[None, :]
    beside[np.diag_indices(len(some))] = alone
    return np.asarray(beside)

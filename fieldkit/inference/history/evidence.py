"""Closed-form evidence for additions to a model, from one linear fit of the model without them.

A strength s with a normal prior adds s times a known shift of the readouts. With the model's inverse covariance M of
the readouts, a = shift' M shift and b = shift' M miss, the log Bayes factor is that of a normal mean (Bishop, Pattern
Recognition and Machine Learning, 2006, section 3.5), plus the log ratio of posterior to prior mass inside the bounds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.inference.history.bounded_strength import strength_posterior
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
    likelihood with respect to the strength, at zero and the same scales. `forecast_gain` is the effect of a unit on the
    log apogee of each plan, net of what the other terms absorb. `unit` is the value of the effect's parameter at a
    strength of 1.
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
    forecast_gain: Float[Array, "plan trial"]

    @property
    def weight(self) -> Float[Array, "trial"]:
        """Log evidence with the candidate's own prior. [nat]"""
        return np.asarray(self.log_bayes + self.log_fraction)


@dataclass(frozen=True, slots=True, eq=False)
class _Weights:
    """Matrices that turn shifts of the flown flights' readouts into evidence, for every pair of scales.

    `used` are the indices of the readouts of any flight and of the apogee; `usable` marks those that a flight has.
    `sharp` is the inverse covariance of single flights, and `weighted_residual` the inverse covariance of all readouts
    times the residual.
    """

    fit: Fit
    used: Int[Integers, "readout"]
    usable: Flags
    slope: Float[Array, "flight readout term"]
    sharp: Float[Array, "scale flight readout readout"]
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

    def absorbed(
        self, shift: Float[Array, "flight readout column"]
    ) -> tuple[
        Float[Array, "scale entry column"], Float[Array, "scale term column"], Float[Array, "scale term column"]
    ]:
        """The inverse covariance of single flights times shifts, its sum along the terms, and the change of the terms
        that absorbs it."""
        first = (self.sharp @ shift).reshape(len(self.sharp), self.usable.size, -1)
        taken = self.slope.reshape(self.usable.size, -1).T @ first
        return first, taken, self.fit.covariance @ taken

    def weighed(self, shift: Float[Array, "flight readout column"]) -> Float[Array, "scale flight readout column"]:
        """The inverse covariance of all readouts times shifts (Woodbury's identity)."""
        first, _, back = self.absorbed(shift)
        moved = (self.slope.reshape(self.usable.size, -1) @ back).reshape(len(back), *shift.shape)
        return np.asarray(first.reshape(moved.shape) - self.sharp @ moved)


def _weights(fit: Fit) -> _Weights:
    flights = fit.evidence
    used, sharp, slope = flights.readouts, flights.sharpness, flights.slope
    prior_mean = np.array([term.mean for term in fit.model.terms])
    miss = flights.miss - np.moveaxis(slope @ (fit.mean - prior_mean).T, -1, 0)
    usable = (fit.data.seen & np.isfinite(fit.tangent.values))[:, used]
    return _Weights(
        fit, used, usable, slope, sharp, (sharp @ miss[..., None])[..., 0], fit.log_weight - fit.log_evidence
    )


def weigh(linear: LinearFit, candidates: Sequence[PlacedEffect]) -> Trials:
    """The evidence for every candidate added to a linear fit."""
    return weigh_placed(linear, directions(candidates))


def weigh_placed(linear: LinearFit, placed: Placed) -> Trials:
    """As `weigh`, for candidates as directions."""
    weights = _weights(linear.fit)
    plans = len(linear.model.flights) - linear.flown
    parts = [_single(linear, weights, placed.single)] if placed.single else []
    several = (_several(linear, weights, columns, plans) for columns in placed.several)
    return _joined([*parts, *several], weights.usable.size, plans)


def _single(linear: LinearFit, weights: _Weights, columns: Directions) -> Trials:
    """Candidates with one strength."""
    shift, best, count = weights.shift(linear, columns), weights.best, len(columns.number)
    flat = shift.reshape(-1, count)
    first, taken, back = weights.absorbed(shift)
    a = np.einsum("ec,sec->sc", flat, first) - np.einsum("stc,stc->sc", taken, back)
    b = weights.weighted_residual.reshape(len(first), -1) @ flat
    prior = columns.mean, columns.sd, columns.low, columns.high, columns.log_prior_mass
    bayes, mean, sd = strength_posterior(a, b, *prior)
    joint = weights.log_weight[:, None] + bayes
    log_bayes = np.logaddexp.reduce(joint, axis=0)
    fraction = np.exp(joint - log_bayes)
    middle = (fraction * mean).sum(axis=0)
    weighed = first[best].reshape(shift.shape) - weights.sharp[best] @ (weights.slope @ back[best])
    own_a = (shift * weighed).sum(axis=1)
    own_b = (shift * weights.weighted_residual[best][..., None]).sum(axis=1)
    without = strength_posterior(np.maximum(a[best] - own_a, 0.0), b[best] - own_b, *prior)[0]
    ahead = columns.shift(linear.moved, np.zeros(1, int))[linear.flown :, 0]
    return Trials(
        candidate=columns.number,
        family=columns.family,
        log_fraction=columns.log_fraction,
        log_bayes=log_bayes,
        robust=log_bayes - np.maximum(bayes[best] - without, 0.0).max(axis=0),
        mean=middle,
        sd=np.sqrt((fraction * (sd**2 + (mean - middle) ** 2)).sum(axis=0)),
        prior_mean=prior[0],
        prior_sd=prior[1],
        unit=columns.unit,
        shift=flat,
        weighed=weighed.reshape(flat.shape),
        gradient=b[best],
        forecast_gain=ahead - linear.near.slope[linear.flown :, 0] @ back[best],
    )


def _several(linear: LinearFit, weights: _Weights, columns: Directions, plans: int) -> Trials:
    """A candidate with a separate strength in each of several groups; its strength is their root mean square.

    Its `robust` evidence leaves out no flight, bounds are ignored, and it does not change the forecasts of plans.
    """
    shift, sds = weights.shift(linear, columns), columns.sd
    weighed = weights.weighed(shift)
    flat = shift.reshape(-1, len(sds))
    a = flat.T @ weighed.reshape(len(weighed), *flat.shape)
    b = weights.weighted_residual.reshape(len(weighed), -1) @ flat
    precision = a + np.diag(1 / sds**2)
    covariance = np.linalg.inv(precision)
    middle = (covariance @ b[..., None])[..., 0]
    bayes = 0.5 * ((b * middle).sum(axis=1) - np.linalg.slogdet(precision * np.outer(sds, sds))[1])
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
        shift=(shift @ along).reshape(-1, 1),
        weighed=(weighed[weights.best] @ along).reshape(-1, 1),
        gradient=np.array([((shift @ along) * weights.weighted_residual[weights.best]).sum()]),
        forecast_gain=np.zeros((plans, 1)),
    )


def _joined(parts: Sequence[Trials], entries: int, plans: int) -> Trials:
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
        forecast_gain=column("forecast_gain", plans),
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
    alone = strength_posterior(a, b, mean, sd, -unbounded, unbounded, np.zeros(len(some)))[0]
    p, q = a + 1 / sd**2, b + mean / sd**2
    det = p[:, None] * p[None, :] - gram**2
    det = np.maximum(det, 1e-9 * p[:, None] * p[None, :])
    square = p[None, :] * q[:, None] ** 2 + p[:, None] * q[None, :] ** 2 - 2 * gram * q[:, None] * q[None, :]
    prior = (mean / sd) ** 2
    both = 0.5 * (square / det - prior[:, None] - prior[None, :] - np.log(det * (sd[:, None] * sd[None, :]) ** 2))
    beside = both - alone[None, :]
    beside[np.diag_indices(len(some))] = alone
    return np.asarray(beside)

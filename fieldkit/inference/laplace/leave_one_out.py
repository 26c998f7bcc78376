"""Leave-one-out predictions of a fit, and the scatter of apogees that their errors show.

A fit describes the scatter of all readouts by two scales, so the scatter of speeds and times affects the apogee too.
The errors of leave-one-out forecasts show how much the scatter of the apogee differs: they give a factor on its
standard deviation, with a prior around one and a Student t likelihood.

Derivation: Woodbury's identity; see `leave_one_out`.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.batched_inverse import inverses
from fieldkit.inference.evidence import distinct_columns
from fieldkit.inference.laplace.outlier_flights import log_tail, readouts_used
from fieldkit.inference.laplace.posterior import Fit, density_constant, residual_variance
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.documents import SEARCH_PRIOR
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import OBSERVED_READOUTS, reading_sd
from fieldkit.shapes import Array, Flags, Float

TAIL = CERTIFIED_PRIOR.tail
"""Degrees of freedom of the assumed distribution of single flights. [1]"""
FACTORS = np.geomspace(0.5, 3.5, 16)
"""The ratio of the apogee's scatter to that of the fit. [1]"""
_LOG_PRIOR = -0.5 * (np.log(FACTORS) / 0.4) ** 2


@dataclass(frozen=True, slots=True)
class ScatterWeights:
    """Posterior weights of `FACTORS` from all flights, and from all flights but each one."""

    weight: Float[Array, "factor"]
    weight_without: Float[Array, "factor flight"]

    @property
    def mean_square_without(self) -> Float[Array, "flight"]:
        """Mean square of the factor from all flights but each one. [1]"""
        return np.asarray(FACTORS**2 @ self.weight_without)


@dataclass(frozen=True, slots=True)
class LeaveOneOut:
    """The leave-one-out prediction of each flight.

    For every pair of scales: mean and variance of the compared (log) apogee [1], and the log weight of the pair (times
    the evidence of the other flights). The variance is scaled by the scatter of the other flights' apogees (`spread`);
    `known` is its part due to the uncertain terms.
    `residual` is the standardized residual of each readout, flown minus expected.
    """

    mean: Float[Array, "scale flight"]
    variance: Float[Array, "scale flight"]
    known: Float[Array, "scale flight"]
    log_weight: Float[Array, "scale flight"]
    residual: Float[Array, "scale flight readout"]
    spread: ScatterWeights | None


def leave_one_out(result: Fit) -> LeaveOneOut:
    """Predictions of every flight from all the others, exact if the readouts are linear.

    With a flight's slopes A, its noise N and the covariance P of the terms, G = A P A' is the covariance of its
    predicted readouts given all flights, including this one. With the residual r of the mean and M = 1 / (N - G),
    Woodbury's identity gives the error of the leave-one-out prediction, e = N M r, its covariance N M N, and the mean
    and covariance of every other prediction, without solving for the terms again.
    """
    near, evidence = result.tangent, result.evidence
    prior_mean = np.array([term.mean for term in result.model.terms])
    offset = result.mean - prior_mean
    columns, sums = distinct_columns(np.concatenate([evidence.slope, near.slope[:, :1]], axis=1))
    slope, apogee, covariance = columns[:, :-1], columns[:, -1], result.covariance_of(sums)
    spread = slope @ covariance[:, None]
    noise = evidence.noise()
    sharper, log_det = inverses(noise - spread @ np.swapaxes(slope, 1, 2))
    missed = evidence.miss - np.moveaxis(evidence.slope @ offset.T, -1, 0)
    weighed = _applied(sharper, missed)
    distance = (missed * weighed).sum(axis=-1)
    constant = density_constant(result.data.seen[:, evidence.readouts])
    own = -0.5 * (distance + 2 * evidence.log_det - log_det - constant)
    if result.flight_weight is not None:
        own += log_tail(result.flight_weight, readouts_used(result.data, near), result.model.hyperprior.tail)
    residual = np.zeros((len(noise), *result.data.seen.shape))
    residual[..., evidence.readouts] = _applied(noise, weighed) / np.sqrt(((noise @ sharper) * noise).sum(axis=-1))
    log_weight = result.log_weight[:, None] - own

    ties = (spread @ apogee[:, :, None])[..., 0]
    mean = near.values[:, 0] + (prior_mean - near.at + offset) @ near.slope[:, 0].T - (ties * weighed).sum(axis=-1)
    known = ((apogee @ covariance) * apogee).sum(axis=-1) + (ties * _applied(sharper, ties)).sum(axis=-1)
    scattered = own_variance(result)
    lies = _apogee_spread(result, mean, known, scattered, log_weight)
    variance = known + (1.0 if lies is None else lies.mean_square_without) * scattered
    return LeaveOneOut(mean, variance, known, log_weight, residual, lies)


def _applied(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _apogee_spread(result: Fit, mean: Array, known: Array, own: Array, log_weight: Array) -> ScatterWeights | None:
    """The scatter of apogees relative to the scales, from leave-one-out errors; None if the model includes it."""
    if result.model.hyperprior.sd("apogee", "flight"):
        return None
    data = result.data
    weight = np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0))
    middle = (weight * mean).sum(axis=0)
    between = (weight * (mean - middle) ** 2).sum(axis=0)
    seen = data.seen[:, 0]
    error = np.where(seen, data.values[:, 0] - middle, 0.0)
    return apogee_spread(error, (weight * known).sum(axis=0) + between, (weight * own).sum(axis=0), seen)


def own_variance(result: Fit) -> Float[Array, "scale flight"]:
    """Variance of a flight's compared apogee around its expectation: scatter and reading. [1]"""
    spread = result.model.scatter_scales() ** 2 @ result.tangent.scatter_slope[:, 0].T ** 2
    expected = replace(result.data, sd=_expected_sd(result))
    return np.asarray(spread + residual_variance(result.model, expected)[..., 0])


def _expected_sd(result: Fit) -> Float[Array, "flight readout"]:
    """Expected error of each readout; for the apogee, the model's value instead of the recorded one."""
    sd = result.data.sd.copy()
    sd[:, 0] = own_reading_sd(np.exp(result.tangent.values[:, 0]), result.model.hyperprior)
    return sd


def own_reading_sd(apogee: Float[Array, "*draw"], hyperprior: Hyperprior = SEARCH_PRIOR) -> Float[Array, "*draw"]:
    """Expected relative error of an apogee [m] as read off the altimeter. [1]"""
    raw = np.full((*apogee.shape, len(OBSERVED_READOUTS)), 1.0)
    raw[..., 0] = apogee
    return reading_sd(raw, hyperprior)[..., 0]


def apogee_spread(
    error: Float[Array, "flight"], known: Float[Array, "flight"], own: Float[Array, "flight"], seen: Flags
) -> ScatterWeights:
    """The posterior of the factor from the errors of leave-one-out forecasts.

    `error` is the log of flown over predicted apogee [1], `known` the variance of the forecast due to the uncertain
    parameters of the rocket, and `own` the variance due to the scatter of single flights. Flights not `seen` are
    ignored.
    """
    variance = known + FACTORS[:, None] ** 2 * own
    unit = (TAIL - 2) * variance
    likelihood = np.where(seen, -0.5 * (TAIL + 1) * np.log1p(error**2 / unit) - 0.5 * np.log(variance), 0.0)
    total = _LOG_PRIOR + likelihood.sum(axis=1)
    return ScatterWeights(_weights(total[:, None])[:, 0], _weights(total[:, None] - likelihood))


def _weights(log_weight: Array) -> Array:
    return np.asarray(np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0)))

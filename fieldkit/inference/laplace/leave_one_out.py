"""What a fit predicts for flights left out of it."""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.apogee_scatter import ScatterWeights, apogee_spread
from fieldkit.inference.laplace.batched_inverse import inverses
from fieldkit.inference.laplace.posterior import Fit, residual_variance
from fieldkit.model.hyperprior import CERTIFIED_PRIOR, Hyperprior
from fieldkit.model.readout_data import OBSERVED_READOUTS, reading_sd
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class LeaveOneOut:
    """What a fit says of each flight when that flight is left out of it.

    For every pair of scales: mean and variance of the compared apogee, and the log weight of the pair
    (times the evidence of the other flights). The variance is scaled as the others' apogees ask (`spread`).
    `distance` is how far the flight's readouts lie from what the others say of them, squared, in standard
    deviations (Mahalanobis), `residual` each readout's own distance, flown less expected.
    """

    mean: Float[Array, "scale flight"]
    variance: Float[Array, "scale flight"]
    log_weight: Float[Array, "scale flight"]
    distance: Float[Array, "scale flight"]
    residual: Float[Array, "scale flight readout"]
    spread: ScatterWeights | None


def leave_one_out(result: Fit) -> LeaveOneOut:
    """Predictions of every flight from all the others, exactly as far as the readouts are linear.

    With a flight's slopes A, its noise N and the covariance P of the terms, G = A P A' is what all flights, itself
    included, leave open of its readouts. From r, the miss of the mean, and M = 1 / (N - G) follow without another
    solution in the terms: the error of the others' forecast, e = N M r, its covariance N M N, and the mean and
    covariance of anything else that the others say (Woodbury's identity).
    """
    near, told, covariance = result.tangent, result.told, result.covariance
    prior_mean = np.array([term.mean for term in result.model.terms])
    offset = result.mean - prior_mean
    flat = told.slope.reshape(told.miss.size, len(prior_mean))
    spread = (flat @ covariance).reshape(len(covariance), *told.slope.shape)
    sharper, log_det = inverses(told.noise - spread @ np.swapaxes(told.slope, 1, 2))
    missed = told.miss - np.moveaxis(told.slope @ offset.T, -1, 0)
    weighed = _applied(sharper, missed)
    distance = (missed * weighed).sum(axis=-1)
    own = -0.5 * (distance + 2 * told.log_det - log_det)
    residual = _applied(told.noise, weighed) / np.sqrt(((told.noise @ sharper) * told.noise).sum(axis=-1))
    log_weight = result.log_weight[:, None] - own

    apogee = near.slope[:, 0]
    ties = (spread @ apogee[:, :, None])[..., 0]
    mean = near.values[:, 0] + apogee @ (prior_mean - near.at) + offset @ apogee.T - (ties * weighed).sum(axis=-1)
    known = ((apogee @ covariance) * apogee).sum(axis=-1) + (ties * _applied(sharper, ties)).sum(axis=-1)
    scattered = own_variance(result)
    lies = _apogee_spread(result, mean, known, scattered, log_weight)
    variance = known + (1.0 if lies is None else lies.mean_square_without) * scattered
    return LeaveOneOut(mean, variance, log_weight, distance, residual, lies)


def _applied(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _apogee_spread(result: Fit, mean: Array, known: Array, own: Array, log_weight: Array) -> ScatterWeights | None:
    """The scatter of apogees beside what the scales make of it, by flights left out; none if the model has it."""
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
    """Variance of a flight's compared apogee about its expectation: scatter and reading."""
    scatter = result.model.hyperprior.scales()[0]
    spread = result.tangent.scatter_slope[:, 0]
    expected = replace(result.data, sd=_expected_sd(result))
    return np.asarray(
        scatter[:, None] ** 2 * (spread**2).sum(axis=-1) + residual_variance(result.model, expected)[..., 0]
    )


def _expected_sd(result: Fit) -> Float[Array, "flight readout"]:
    """Expected error of each readout, of an apogee as the model and not the flight has it."""
    sd = result.data.sd.copy()
    sd[:, 0] = own_reading_sd(np.exp(result.tangent.values[:, 0]), result.model.hyperprior)
    return sd


def own_reading_sd(apogee: Float[Array, "*draw"], hyperprior: Hyperprior = CERTIFIED_PRIOR) -> Float[Array, "*draw"]:
    """Expected error of reading an apogee [m] off the altimeter, as a ratio."""
    raw = np.full((*apogee.shape, len(OBSERVED_READOUTS)), 1.0)
    raw[..., 0] = apogee
    return reading_sd(raw, hyperprior)[..., 0]

"""Weights of flights and readouts in a fit with Student t noise: smaller for outliers.

Source: Lange, Little and Taylor, Robust Statistical Modeling Using the t Distribution, 1989.
"""

import numpy as np

from fieldkit.inference.evidence import distinct_columns
from fieldkit.inference.laplace.outlier_flights import readouts_used
from fieldkit.inference.laplace.posterior import Fit, residual_variance
from fieldkit.shapes import Array, Float

NEGLIGIBLE_SCALE_WEIGHT = 0.01
"""Pairs of scales below this posterior weight are ignored in the weights of flights. [1]"""


def flight_weights(result: Fit) -> Float[Array, "flight"]:
    """Expected precision of each flight relative to an ordinary one, from a fit. [1]"""
    weight = np.ones(len(result.data.seen)) if result.flight_weight is None else result.flight_weight
    scales = np.flatnonzero(result.weights > NEGLIGIBLE_SCALE_WEIGHT)
    nu, evidence, sharpness = result.model.hyperprior.tail, result.evidence, result.evidence.sharpness[scales]
    offset = result.mean[scales] - np.array([term.mean for term in result.model.terms])
    left = evidence.miss - np.moveaxis(evidence.slope @ offset.T, -1, 0)
    square = (left * (sharpness @ left[..., None])[..., 0]).sum(axis=-1)
    slope, sums = distinct_columns(evidence.slope)
    spread = slope @ result.covariance_of(sums)[scales][:, None]
    open_square = ((sharpness @ slope) * spread).sum(axis=(-2, -1))
    expected = result.weights[scales] / result.weights[scales].sum() @ (square + open_square) / weight
    count = readouts_used(result.data, result.tangent)
    return np.asarray((nu + count) / (nu + expected))


def outlier_weights(result: Fit) -> Float[Array, "flight readout"]:
    """Expected precision of every residual relative to an ordinary one, from a fit. [1]"""
    nu = result.model.hyperprior.tail
    square = np.tensordot(result.weights, standardized_squares(result), 1)
    return np.where(result.data.seen, (nu + 1) / (nu + square), 1.0)


def standardized_squares(result: Fit) -> Float[Array, "scale flight readout"]:
    """Posterior mean square of every residual, over its variance before outliers count for less; 0 if unobserved. [1]

    With the noise N = S S' + D of a flight's readouts, D the part of the residuals, and the difference r that the terms
    leave, the residual has the mean D N^-1 r and the covariance D - D N^-1 D + D N^-1 A C A' N^-1 D.
    """
    evidence, data, used = result.evidence, result.data, result.evidence.readouts
    scales = slice(None) if result.scales is None else result.scales
    variance = residual_variance(result.model, data, scales)[..., used]
    own = np.where(data.seen[:, used], variance / data.trust[:, used], 0.0)
    offset = result.mean - np.array([term.mean for term in result.model.terms])
    left = evidence.miss - np.moveaxis(evidence.slope @ offset.T, -1, 0)
    sharpness = evidence.sharpness if data.normal is None else evidence.sharpness / data.normal[:, None, None]
    gain = own[..., None] * sharpness  # D N^-1
    mean = (gain @ left[..., None])[..., 0]
    slope, sums = distinct_columns(evidence.slope)
    spread = gain @ slope
    flat = spread.reshape(len(spread), evidence.miss.size, len(sums))
    known = np.einsum("sft,sft->sf", flat @ result.covariance_of(sums), flat).reshape(mean.shape)
    unexplained = own - np.diagonal(gain, axis1=-2, axis2=-1) * own
    found = np.zeros((len(variance), *data.seen.shape))
    found[..., used] = (mean**2 + unexplained + known) / variance
    return found

"""Flights that lie further off than others: the noise of a flight's readouts together follows a Student t.

A multivariate Student t is a normal whose precision is multiplied by a factor that is Gamma distributed, one factor a
flight, with mean one. The factors are integrated by variational Bayes (Lange, Little and Taylor, 1989; Bishop, Pattern
Recognition and Machine Learning, 2006, section 10.1), so that one odd flight says little for or against an effect.
"""

from typing import TYPE_CHECKING

import numpy as np

from fieldkit.shapes import Array, Float, Int, Integers

if TYPE_CHECKING:
    from fieldkit.inference.laplace.posterior import Fit

NEGLIGIBLE_SCALE_WEIGHT = 0.01
"""Posterior weight of a pair of scales below which it has no part in the weights of flights. [1]"""


def readouts_used(fit: "Fit") -> Int[Integers, "flight"]:
    """Number of readouts of each flight that a fit compares. [1]"""
    return np.asarray((fit.data.seen & np.isfinite(fit.tangent.values)).sum(axis=1))


def flight_weights(fit: "Fit") -> Float[Array, "flight"]:
    """Expected precision of each flight over that of an ordinary one, as a fit has it. [1]"""
    weight = np.ones(len(fit.data.seen)) if fit.flight_weight is None else fit.flight_weight
    scales = np.flatnonzero(fit.weights > NEGLIGIBLE_SCALE_WEIGHT)
    nu, told, sharpness = fit.model.hyperprior.tail, fit.told, fit.told.sharpness[scales]
    offset = fit.mean[scales] - np.array([term.mean for term in fit.model.terms])
    left = told.miss - np.moveaxis(told.slope @ offset.T, -1, 0)
    square = (left * (sharpness @ left[..., None])[..., 0]).sum(axis=-1)
    spread = (told.slope.reshape(told.miss.size, -1) @ fit.covariance[scales]).reshape(len(left), *told.slope.shape)
    open_square = ((sharpness @ told.slope) * spread).sum(axis=(-2, -1))
    expected = fit.weights[scales] / fit.weights[scales].sum() @ (square + open_square) / weight
    count = readouts_used(fit)
    return np.asarray((nu + count) / (nu + expected))


def log_tail(weight: Float[Array, "flight"], count: Int[Integers, "flight"], nu: float) -> Float[Array, "flight"]:
    """What the lower bound of the log evidence has for each flight beside that of a normal one of this weight. [nat]"""
    from scipy.special import digamma, gammaln

    a, a0 = (nu + count) / 2, nu / 2
    b = a / weight
    jensen = count / 2 * (digamma(a) - np.log(b) - np.log(weight))
    divergence = (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * (np.log(b) - np.log(a0)) + a * (a0 - b) / b
    return np.where(count > 0, jensen - divergence, 0.0)

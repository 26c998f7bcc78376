"""Flights that lie further off than others: the noise of a flight's readouts together follows a Student t.

A multivariate Student t is a normal whose precision is multiplied by a factor that is Gamma distributed, one factor a
flight, with mean one. The factors are integrated by variational Bayes (Lange, Little and Taylor, 1989; Bishop, Pattern
Recognition and Machine Learning, 2006, section 10.1), so that one outlier says little for or against an effect.
"""

import numpy as np

from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.model.readout_data import Data
from fieldkit.shapes import Array, Float, Int, Integers


def readouts_used(data: Data, tangent: Tangent) -> Int[Integers, "flight"]:
    """Number of readouts of each flight that a fit about a point compares. [1]"""
    return np.asarray((data.seen & np.isfinite(tangent.values)).sum(axis=1))


def log_tail(weight: Float[Array, "flight"], count: Int[Integers, "flight"], nu: float) -> Float[Array, "flight"]:
    """What the lower bound of the log evidence has for each flight beside that of a normal one of this weight. [nat]"""
    from scipy.special import digamma, gammaln

    a, a0 = (nu + count) / 2, nu / 2
    b = a / weight
    jensen = count / 2 * (digamma(a) - np.log(b) - np.log(weight))
    divergence = (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * (np.log(b) - np.log(a0)) + a * (a0 - b) / b
    return np.where(count > 0, jensen - divergence, 0.0)

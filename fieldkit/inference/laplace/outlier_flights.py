"""Outlier flights: the joint noise of a flight's readouts follows a Student t.

A multivariate Student t is a normal whose precision is multiplied by a Gamma distributed factor with mean one, one
factor per flight. The factors are integrated by variational Bayes (Lange, Little and Taylor, 1989; Bishop, Pattern
Recognition and Machine Learning, 2006, section 10.1), so that one outlier has little influence on the evidence for an
effect.
"""

import numpy as np

from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.model.readout_data import Data
from fieldkit.shapes import Array, Float, Int, Integers


def readouts_used(data: Data, tangent: Tangent) -> Int[Integers, "flight"]:
    """Number of readouts of each flight that are compared at a point. [1]"""
    return np.asarray((data.seen & np.isfinite(tangent.values)).sum(axis=1))


def log_tail(weight: Float[Array, "flight"], count: Int[Integers, "flight"], nu: float) -> Float[Array, "flight"]:
    """The term of each flight in the lower bound of the log evidence, in addition to a normal one of this weight.
    [nat]"""
    from scipy.special import digamma, gammaln  # takes 0.18 s to import

    a, a0 = (nu + count) / 2, nu / 2
    b = a / weight
    jensen = count / 2 * (digamma(a) - np.log(b) - np.log(weight))
    divergence = (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * (np.log(b) - np.log(a0)) + a * (a0 - b) / b
    return np.where(count > 0, jensen - divergence, 0.0)

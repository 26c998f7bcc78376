"""The logarithm of the Gamma function and the quantiles of Gamma distributions.

`scipy.special` has both; a forecast needs nothing else of it, and importing it takes a tenth of a forecast's time.
"""

import math

import numpy as np

from fieldkit.shapes import Array, Float

MAX_STEPS = 100
"""Newton steps for a quantile, which converges in about ten. [1]"""


def log_gamma(values: Float[Array, "*value"]) -> Float[Array, "*value"]:
    """Logarithm of the Gamma function of each value above zero. [1]"""
    return np.asarray(np.vectorize(math.lgamma, otypes=[float])(values))


def gamma_quantiles(shape: float, level: Float[Array, "level"]) -> Float[Array, "level"]:
    """Quantiles of the Gamma distribution of this shape and unit rate at levels between 0 and 1. [1]

    The distribution function is the series 8.11.4 of the NIST Digital Library of Mathematical Functions. Its logarithm
    is concave in that of the quantile, so Newton's method converges from below, where it starts: at the series' first
    term.
    """
    order = np.arange(1, 200 + 20 * math.ceil(math.sqrt(shape)))
    log_level = np.log(level) + math.lgamma(shape + 1)
    log_x = log_level / shape
    for _ in range(MAX_STEPS):
        x = np.exp(log_x)
        series = 1.0 + np.cumprod(x[:, None] / (shape + order), axis=1).sum(axis=1)
        step = (log_level - shape * log_x + x - np.log(series)) * series / shape
        log_x += step
        if np.abs(step).max(initial=0.0) < 1e-14:
            break
    return np.exp(log_x)

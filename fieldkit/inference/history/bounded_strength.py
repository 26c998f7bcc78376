"""The closed-form posterior of a strength with a truncated normal prior and a linear effect on the readouts."""

from math import erfc

import numpy as np

from fieldkit.shapes import Array

INSIDE_SDS = 5.0
"""At this distance inside a bound, in standard deviations, the probability beyond it is taken as zero. [1]"""
MIN_MASS = 1e-250
"""Minimum probability between two bounds, so that its logarithm is finite. [1]"""
_ERFC = np.frompyfunc(erfc, 1, 1)


def strength_posterior(
    a: Array, b: Array, mean: Array, sd: Array, low: Array, high: Array, log_prior_mass: Array
) -> tuple[Array, Array, Array]:
    """Log Bayes factor [nat], posterior mean and standard deviation of a strength, in its unit; elementwise.

    `a` is the precision with which the readouts determine the strength, and `b` is `a` times their estimate of it.
    `log_prior_mass` is the log probability of its prior between the bounds `low` and `high`. The mean is clipped to the
    bounds; the standard deviation is that of the normal distribution without them.

    Derivation: the product of two normal densities, by completing the square; the bounds add the logarithm of the ratio
    of the probabilities within them, posterior to prior.
    """
    precision = a + 1 / sd**2
    middle = (b + mean / sd**2) / precision
    bayes = 0.5 * (middle**2 * precision - mean**2 / sd**2 - np.log(precision * sd**2))
    spread = 1 / np.sqrt(precision)
    near = np.minimum(middle - low, high - middle) < INSIDE_SDS * spread
    bayes = bayes - log_prior_mass
    if near.any():
        ends = [np.broadcast_to(end, near.shape)[near] for end in (low, high)]
        bayes[near] += log_mass(middle[near], spread[near], *ends)
        middle[near] = np.clip(middle[near], *ends)
    return bayes, middle, spread


def log_mass(mean: Array, sd: Array, low: Array, high: Array) -> Array:
    """Log of the probability of a normal distribution between two bounds, elementwise. [nat]

    Derivation: the difference of its distribution function at the bounds, mirrored where both values would be near 1.
    """
    above, below = (high - mean) / sd, (low - mean) / sd
    mirrored = below > 0  # where both would be near 1
    above, below = np.where(mirrored, -below, above), np.where(mirrored, -above, below)
    mass = 0.5 * (_ERFC(-above * np.sqrt(0.5)) - _ERFC(-below * np.sqrt(0.5))).astype(float)
    return np.asarray(np.log(np.maximum(mass, MIN_MASS)))

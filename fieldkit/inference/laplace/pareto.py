"""Importance weights with the largest smoothed by a generalized Pareto distribution.

Source: Vehtari, Simpson, Gelman, Yao and Gabry, Pareto smoothed importance sampling, Journal of Machine Learning
Research 25, 2024; the distribution is fitted as in Zhang and Stephens, Technometrics 51, 2009, with the prior of
Vehtari et al.
"""

import numpy as np

from fieldkit.shapes import Array, Float

MIN_TAIL = 5
"""Minimum number of weights in the tail for a fit. [1]"""


def smoothed(log_weight: Float[Array, "draw"]) -> tuple[Float[Array, "draw"], float]:
    """Log weights with the tail replaced by the expected order statistics of the fitted Pareto distribution, and its
    shape k: infinity if too few draws have any weight, minus infinity if the largest weights are equal. [log 1],
    [1]"""
    count = len(log_weight)
    tail = int(min(0.2 * count, 3 * np.sqrt(count)))
    order = np.argsort(log_weight)
    cut = log_weight[order[-tail - 1]]
    if tail < MIN_TAIL or not np.isfinite(cut):
        return log_weight, np.inf
    largest = float(log_weight[order[-1]])
    excess = np.exp(log_weight[order[-tail:]] - largest) - np.exp(cut - largest)
    if excess[-1] <= 0:
        return log_weight, -np.inf
    k, sigma = _fitted(np.maximum(excess, 1e-300))
    level = (np.arange(tail) + 0.5) / tail
    quantile = sigma * np.expm1(-k * np.log1p(-level)) / k if abs(k) > 1e-8 else -sigma * np.log1p(-level)
    found = log_weight.copy()
    found[order[-tail:]] = np.minimum(np.log(quantile + np.exp(cut - largest)), 0.0) + largest
    return found, float(k)


def _fitted(excess: Float[Array, "tail"]) -> tuple[float, float]:
    """Shape and scale of the generalized Pareto distribution fitted to values in ascending order."""
    count = len(excess)
    grid = 30 + int(np.sqrt(count))
    quarter = excess[int(count / 4 + 0.5) - 1]
    theta = 1 / excess[-1] + (1 - np.sqrt(grid / (np.arange(grid) + 0.5))) / (3 * max(quarter, 1e-300))
    shape = np.log1p(-theta[:, None] * excess).mean(axis=1)
    profile = count * (np.log(-theta / shape) - shape - 1)
    weight = np.exp(profile - np.logaddexp.reduce(profile))
    mean = float((theta * weight).sum())
    k = float(np.log1p(-mean * excess).mean())
    sigma = -k / mean
    return (k * count + 5) / (count + 10), sigma

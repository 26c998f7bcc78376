"""Grids of scales around their posterior, on which the evidence of a fit is accurate.

Some twenty flights determine a scale within 10%, but the grids used during a fit have steps of 60%. On them nearly
all weight is on one value, and the log evidence has an error of up to several nats, depending on how far that value is
from the mode. Derivation: the midpoint rule on an even grid, whose error falls exponentially for a normal density
(Trefethen and Weideman, SIAM Review 56, 2014).
"""

from dataclasses import replace
from statistics import NormalDist

import numpy as np

from fieldkit.inference.laplace.outlier_weights import flight_weights
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.scale import Scale
from fieldkit.shapes import Array, Float

ROUNDS = 2
"""Number of times the grids are moved; the first time from a grid too coarse to be accurate. [1]"""
TAIL = 1e-3
"""Posterior probability of a scale beyond each end of its grid. [1]"""
LATTICE = 1000
"""Number of points for the quantiles of a scale. [1]"""


def around_mode(result: Fit) -> Fit:
    """A fit with all scales integrated on grids around their mode, at the same point of linearization."""
    for _ in range(ROUNDS):
        hyperprior = result.model.hyperprior
        scales = hyperprior.unknown_scales
        weight = result.log_weight.reshape([len(one.grid) for one in scales])
        axes = range(len(scales))
        alone = [np.logaddexp.reduce(weight, axis=tuple(other for other in axes if other != own)) for own in axes]
        moved = hyperprior.with_scales(*(_moved(one, own) for one, own in zip(scales, alone, strict=True)))
        outliers = None if result.flight_weight is None else flight_weights(result)
        result = solve(replace(result.model, hyperprior=moved), result.data, result.tangent, outliers)
    return result


def _moved(scale: Scale, log_weight: Float[Array, "value"]) -> Scale:
    """The scale on a grid around its mode; a known scale keeps its only value."""
    known = scale.range[0] == scale.range[1]
    return scale if known else scale.between(*_interval(scale, log_weight))


def _interval(scale: Scale, log_weight: Float[Array, "value"]) -> tuple[float, float]:
    """The quantiles of a scale at `TAIL` and 1 - `TAIL`, with its log density linear between the values of the grid and
    beyond them."""
    if len(log_weight) == 1:
        return _prior_interval(scale)
    if not np.isfinite(log_weight).all():  # a flight cannot be simulated at this point
        return scale.range
    x, slope = np.log(scale.values), np.diff(log_weight) / np.diff(np.log(scale.values))
    first, last = scale.range
    at = np.log(np.geomspace(first, last, LATTICE))
    segment = np.clip(np.searchsorted(x, at) - 1, 0, len(slope) - 1)
    log_density = log_weight[segment] + slope[segment] * (at - x[segment])
    below = np.cumsum(np.exp(log_density - log_density.max()))
    low, high = np.interp([TAIL, 1 - TAIL], below / below[-1], at)
    return float(np.exp(low)), float(np.exp(high))


def _prior_interval(scale: Scale) -> tuple[float, float]:
    """The quantiles of a scale at `TAIL` and 1 - `TAIL` before any flight, within its range."""
    low, high = scale.median * np.exp(scale.log_sd * NormalDist().inv_cdf(1 - TAIL) * np.array([-1.0, 1.0]))
    return max(float(low), scale.range[0]), min(float(high), scale.range[1])

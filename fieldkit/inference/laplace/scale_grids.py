"""Grids of scales around their posterior, on which the evidence of a fit is accurate.

Some twenty flights determine a scale within 10%, but the grids used during a fit have steps of 60%. On them nearly
all weight is on one value, and the log evidence has an error of up to several nats, depending on how far that value is
from the mode. Derivation: the midpoint rule on an even grid, whose error falls exponentially for a normal density
(Trefethen and Weideman, SIAM Review 56, 2014).
"""

from dataclasses import replace

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
    """A fit with both scales integrated on grids around their mode, at the same point of linearization."""
    for _ in range(ROUNDS):
        hyperprior = result.model.hyperprior
        scatter, reading = hyperprior.scatter, hyperprior.reading
        weight = result.log_weight.reshape(len(scatter.grid), len(reading.grid))
        moved = replace(
            hyperprior,
            scatter=scatter.between(*_interval(scatter, np.logaddexp.reduce(weight, axis=1))),
            reading=reading.between(*_interval(reading, np.logaddexp.reduce(weight, axis=0))),
        )
        outliers = None if result.flight_weight is None else flight_weights(result)
        result = solve(replace(result.model, hyperprior=moved), result.data, result.tangent, outliers)
    return result


def _interval(scale: Scale, log_weight: Float[Array, "value"]) -> tuple[float, float]:
    """The quantiles of a scale at `TAIL` and 1 - `TAIL`, with its log density linear between the values of the grid and
    beyond them."""
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

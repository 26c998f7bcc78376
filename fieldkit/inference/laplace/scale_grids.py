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

MIN_ROUNDS, MAX_ROUNDS = 2, 5
"""Number of times the grids are moved: the first time from grids too coarse to be accurate, then until they contain
the mode. [1]"""
TAIL = 1e-3
"""Posterior probability of a scale beyond each end of its grid. [1]"""
LATTICE = 1000
"""Number of points for the quantiles of a scale. [1]"""

Known = dict[float, float]
"""Values of a scale [1] with their log posterior density [nat]."""


def around_mode(result: Fit, *, documents: bool = True) -> Fit:
    """A fit with all scales integrated on grids around their mode, at the same point of linearization; that of
    documents only if `documents`."""
    known: list[Known] = [{} for _ in result.model.hyperprior.unknown_scales]
    for number in range(MAX_ROUNDS):
        scales, alone = result.model.hyperprior.unknown_scales, _marginals(result)
        if number >= MIN_ROUNDS and all(map(_contains_mode, scales, alone)):
            break
        known = [_updated(*some) for some in zip(known, scales, alone, strict=True)]
        grids = [*map(_moved, scales, known)]
        if result.model.hyperprior.documents:  # few terms depend on it, so its posterior is as wide as its prior
            grids[-1] = scales[-1]
        moved = result.model.hyperprior.with_scales(*grids)
        outliers = None if result.flight_weight is None else flight_weights(result)
        result = solve(replace(result.model, hyperprior=moved), result.data, result.tangent, outliers)
    if result.model.hyperprior.documents is None or not documents:
        return result
    hyperprior = result.model.hyperprior.with_refined_documents()
    outliers = None if result.flight_weight is None else flight_weights(result)
    return solve(replace(result.model, hyperprior=hyperprior), result.data, result.tangent, outliers)


def with_probable_motors(result: Fit) -> Fit:
    """A fit whose scale of motors, one value during a fit, is the most probable one at its point of linearization."""
    hyperprior = result.model.hyperprior
    if hyperprior.motors is None:
        return result
    fine = around_mode(result)
    best = float(fine.model.hyperprior.motor_scales()[np.argmax(fine.log_weight)])
    moved = replace(hyperprior, motors=replace(hyperprior.motors, grid=(best,)))
    return solve(replace(result.model, hyperprior=moved), result.data, result.tangent, result.flight_weight)


def flyer_scatter(result: Fit) -> Float[Array, "node"]:
    """The log likelihood of the flyer's scale of scatter at its `nodes` from one rocket's flights: its posterior over
    its prior, linear between the values of the grid and beyond them; empty if rockets do not share it. [nat]"""
    scale = result.model.hyperprior.scatter
    if not scale.within or not scale.spread or len(scale.grid) < 2:
        return np.zeros(0)
    known = np.array(list(_log_density(scale, _marginals(result)[0]).values())) - scale.log_density
    x, slope = np.log(scale.values), np.diff(known) / np.diff(np.log(scale.values))
    segment = np.clip(np.searchsorted(x, scale.nodes) - 1, 0, len(slope) - 1)
    return scale.of_flyer((known - known.max())[segment] + slope[segment] * (scale.nodes - x[segment]))


def _marginals(result: Fit) -> list[Float[Array, "value"]]:
    """The log weight of every value of each scale, summed over the others. [nat]"""
    scales = result.model.hyperprior.unknown_scales
    weight = result.log_weight.reshape([len(one.grid) for one in scales])
    axes = range(len(scales))
    return [np.logaddexp.reduce(weight, axis=tuple(other for other in axes if other != own)) for own in axes]


def _contains_mode(scale: Scale, log_weight: Float[Array, "value"]) -> bool:
    """Whether the most probable value is inside the grid, or the grid ends there because the prior does."""
    best, (first, last) = int(np.argmax(log_weight)), scale.range
    half = np.exp(scale.step / 2) * (1 + 1e-9)
    ends = {0: scale.grid[0] <= first * half, len(scale.grid) - 1: scale.grid[-1] * half >= last}
    return bool(ends.get(best, True))


def _log_density(scale: Scale, log_weight: Float[Array, "value"]) -> Known:
    """The log posterior density of the logarithm of a scale at every value of its grid, the same up to a constant for
    all grids. [nat]"""
    known = scale.log_prior - (0.0 if scale.step else np.logaddexp.reduce(scale.log_prior))
    density = log_weight - known + scale.log_density
    return dict(zip(scale.grid, density.tolist(), strict=True))


def _updated(known: Known, scale: Scale, log_weight: Float[Array, "value"]) -> Known:
    """The values of this grid, and if it does not contain the mode, those of earlier grids, whose density is less
    accurate."""
    fresh = _log_density(scale, log_weight)
    return fresh if _contains_mode(scale, log_weight) else known | fresh


def _moved(scale: Scale, known: Known) -> Scale:
    """The scale on a grid around its mode; a known scale keeps its only value."""
    return scale if scale.range[0] == scale.range[1] else scale.between(*_interval(scale, known))


def _interval(scale: Scale, known: Known) -> tuple[float, float]:
    """The quantiles of a scale at `TAIL` and 1 - `TAIL`, with its log density linear between the known values and
    beyond them."""
    if len(known) == 1:
        return _prior_interval(scale)
    values = np.array(sorted(known))
    log_weight = np.array([known[value] for value in values])
    if not np.isfinite(log_weight).all():  # a flight cannot be simulated at this point
        return scale.range
    x, slope = np.log(values), np.diff(log_weight) / np.diff(np.log(values))
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

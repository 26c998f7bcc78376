"""Stacking: forecasts as a mixture of the model's and its rivals', weighted by how each did on earlier flights.

The weights maximize the summed log score of the mixture over forecasts made before their flights (Yao, Vehtari, Simpson
and Gelman, Using Stacking to Average Bayesian Predictive Distributions, Bayesian Analysis 13, 2018) plus the logarithm
of a Dirichlet prior. The prior counts as `PRIOR_FLIGHTS` flights, `PRIOR_OWN` of them forecast by the model alone.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.shapes import Array, Float

STACKED_RIVALS = ("fleet_ratio", "scalar")
"""Rivals that are stacked: those with a spread. A single number has no density."""
PRIOR_FLIGHTS = 10.0
"""What the prior of the weights counts as: after as many flights, these have half the say. [1]"""
PRIOR_OWN = 0.9
"""Prior weight of the model, the rest shared evenly by the rivals. [1]"""
MIN_FORECASTS_TO_STACK = 10
"""Forecasts of earlier flights from which on forecasts are stacked. [1]"""
ITERATIONS, TOLERANCE = 500, 1e-6
FREEDOM = 4.0
"""Of the Student t about each draw, whose tails keep the density of a surprise above zero. [1]"""


def log_density(draws: Float[Array, "draw"], flown: float) -> float:
    """Log density of the logarithm of an apogee, by a kernel about the logarithm of each draw; -inf without a spread.

    The width is Silverman's (Density Estimation, 1986, equation 3.31).
    """
    logs = np.log(draws[draws > 0])
    if len(logs) < 2 or not np.ptp(logs) > 0 or not flown > 0:
        return float("-inf")
    from scipy.special import gammaln

    low, high = np.quantile(logs, (0.25, 0.75))
    width = 0.9 * min(logs.std(), (high - low) / 1.34 or np.inf) * len(logs) ** -0.2
    kernel = -0.5 * (FREEDOM + 1) * np.log1p(((np.log(flown) - logs) / width) ** 2 / FREEDOM)
    constant = gammaln((FREEDOM + 1) / 2) - gammaln(FREEDOM / 2) - 0.5 * np.log(FREEDOM * np.pi) - np.log(width)
    return float(np.logaddexp.reduce(kernel) + constant - np.log(len(draws)))


def prior_counts(ways: int) -> Float[Array, "way"]:
    """The prior in flights: the model first, then its rivals."""
    rivals = np.full(ways - 1, PRIOR_FLIGHTS * (1 - PRIOR_OWN) / max(ways - 1, 1))
    return np.asarray(np.r_[PRIOR_FLIGHTS - rivals.sum(), rivals])


def stacking_weights(log_scores: Float[Array, "flight way"], prior: Float[Array, "way"]) -> Float[Array, "way"]:
    """Weights of the ways to forecast, from the log density that each gave to flights, by expectation maximization.

    They maximize sum log(sum w exp(score)) + sum prior log w; a Dirichlet distribution of concentration 1 + `prior`.
    """
    weights = prior / prior.sum()
    best = log_scores.max(axis=1, keepdims=True)
    density = np.exp(log_scores - np.where(np.isfinite(best), best, 0.0))
    density = density[density.sum(axis=1) > 0]
    for _ in range(ITERATIONS):
        part = weights * density
        new = (prior + (part / part.sum(axis=1, keepdims=True)).sum(axis=0)) / (prior.sum() + len(density))
        if np.abs(new - weights).max() < TOLERANCE:
            return np.asarray(new)
        weights = new
    return np.asarray(weights)


def log_scores(
    draws: Float[Array, "draw"], rivals: Mapping[str, Float[Array, "_"]], flown: float
) -> Float[Array, "way"]:
    """Log density of a flight in the model's forecast and in each of `STACKED_RIVALS`; one that is absent gets the
    model's."""
    own = log_density(draws, flown)
    found = [log_density(rivals[name], flown) if _spread(rivals, name) else own for name in STACKED_RIVALS]
    return np.asarray([own, *found], float)


def weights_after(earlier: Sequence[Float[Array, "way"]]) -> Float[Array, "way"]:
    """Weights of the model and of each of `STACKED_RIVALS` after the log scores of earlier flights; while few, the
    model's alone."""
    if len(earlier) < MIN_FORECASTS_TO_STACK:
        return np.asarray(np.eye(1 + len(STACKED_RIVALS))[0])
    return stacking_weights(np.array(earlier), prior_counts(1 + len(STACKED_RIVALS)))


def mixed_in(
    draws: Float[Array, "draw"], rivals: Mapping[str, Float[Array, "_"]], weights: Float[Array, "way"]
) -> Float[Array, "draw"]:
    """The stacked forecast, where the weight of an absent rival goes to the model."""
    return stacked(draws, [rivals[name] if _spread(rivals, name) else draws for name in STACKED_RIVALS], weights)


def stacked(
    draws: Float[Array, "draw"], rivals: Sequence[Float[Array, "_"]], weights: Float[Array, "way"]
) -> Float[Array, "draw"]:
    """As many equally likely values of the mixture as the model has draws, in order.

    Each method gets a number of them in proportion to its weight, to the nearest whole number, at evenly spaced
    levels of its own distribution.
    """
    ends = np.rint(np.cumsum(weights) / np.sum(weights) * len(draws)).astype(int)
    counts = np.diff(ends, prepend=0).tolist()
    parts = [_even(way, count) for way, count in zip((draws, *rivals), counts, strict=True)]
    return np.sort(np.concatenate(parts))


def _even(draws: Float[Array, "_"], count: int) -> Float[Array, "_"]:
    """So many of some draws, evenly spaced in rank."""
    ranks = ((np.arange(count) + 0.5) / max(count, 1) * len(draws)).astype(int)
    return np.asarray(np.sort(draws)[ranks])


def _spread(rivals: Mapping[str, Float[Array, "_"]], name: str) -> bool:
    return name in rivals and len(rivals[name]) > 1

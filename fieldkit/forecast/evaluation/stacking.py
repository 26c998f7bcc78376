"""Stacking: forecasts as a mixture of the model's and its rivals', weighted by their results on earlier flights.

The weights maximize the summed log score of the mixture over forecasts made before their flights (Yao, Vehtari, Simpson
and Gelman, Using Stacking to Average Bayesian Predictive Distributions, Bayesian Analysis 13, 2018) plus the logarithm
of a Dirichlet prior. The prior counts as `PRIOR_FLIGHTS` flights, `PRIOR_OWN` of them forecast by the model alone.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import lgamma
from typing import Any

import numpy as np

from fieldkit.forecast.conformal import are_numbers
from fieldkit.shapes import Array, Float

STACKED_RIVALS = ("fleet_ratio", "scalar", "last_flight")
"""Rivals in the mixture: those with a spread, because a single number has no density."""
MODEL_ALONE = (1.0, *(0.0 for _ in STACKED_RIVALS))
"""The weights of a forecast that is not mixed. [1]"""
PRIOR_FLIGHTS = 10.0
"""Number of flights that the prior of the weights counts as. [1]"""
PRIOR_OWN = 0.9
"""Prior weight of the model; the rivals share the rest equally. [1]"""
MIN_FORECASTS_TO_STACK = 10
"""Minimum number of forecasts of earlier flights for stacking. [1]"""
ITERATIONS, TOLERANCE = 500, 1e-6
FREEDOM = 4.0
"""Degrees of freedom of the Student t kernel around each draw, whose tails keep the density of a surprise above zero.
[1]"""


def log_density(draws: Float[Array, "draw"], flown: float) -> float:
    """Log density of the logarithm of an apogee, from a kernel around the logarithm of each draw; -inf without a
    spread. [nat]

    The bandwidth is Silverman's (Density Estimation, 1986, equation 3.31).
    """
    logs = np.log(draws[draws > 0])
    if len(logs) < 2 or not np.ptp(logs) > 0 or not flown > 0:
        return float("-inf")

    low, high = np.quantile(logs, (0.25, 0.75))
    width = 0.9 * min(logs.std(), (high - low) / 1.34 or np.inf) * len(logs) ** -0.2
    kernel = -0.5 * (FREEDOM + 1) * np.log1p(((np.log(flown) - logs) / width) ** 2 / FREEDOM)
    constant = lgamma((FREEDOM + 1) / 2) - lgamma(FREEDOM / 2) - 0.5 * np.log(FREEDOM * np.pi) - np.log(width)
    return float(np.logaddexp.reduce(kernel) + constant - np.log(len(draws)))


def prior_counts(ways: int) -> Float[Array, "way"]:
    """The prior in units of flights: the model first, then its rivals."""
    rivals = np.full(ways - 1, PRIOR_FLIGHTS * (1 - PRIOR_OWN) / max(ways - 1, 1))
    return np.asarray(np.r_[PRIOR_FLIGHTS - rivals.sum(), rivals])


def stacking_weights(log_scores: Float[Array, "flight way"], prior: Float[Array, "way"]) -> Float[Array, "way"]:
    """Weights of the methods from their log densities of the flights, by expectation-maximization. [1]

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


def log_scores(draws: Float[Array, "draw"], rivals: Mapping[str, Float[Array, "_"]], flown: float) -> tuple[float, ...]:
    """Log density of a flight in the forecasts of the model and of each of `STACKED_RIVALS`; a missing rival gets the
    model's. [nat]"""
    own = log_density(draws, flown)
    found = [log_density(rivals[name], flown) if _spread(rivals, name) else own for name in STACKED_RIVALS]
    return (own, *found)


@dataclass(frozen=True, slots=True)
class ScoredForecast:
    """The log scores of the forecasts of one flight by the model and by each of `STACKED_RIVALS` [nat], and whether it
    was the first of its rocket."""

    first: bool
    log_scores: tuple[float, ...]


def weights_after(earlier: Iterable[ScoredForecast], *, first: bool) -> tuple[float, ...]:
    """Weights of the model and of each of `STACKED_RIVALS` for a rocket's first or a later flight, from the earlier
    flights of that kind. [1]

    The model has all the weight until there are enough flights and a rival has a higher total than the model.
    """
    scores = np.array([one.log_scores for one in earlier if one.first is first], float)
    if len(scores) < MIN_FORECASTS_TO_STACK or not (scores[:, 1:].sum(axis=0) > scores[:, 0].sum()).any():
        return MODEL_ALONE
    return tuple(stacking_weights(scores, prior_counts(len(MODEL_ALONE))).tolist())


def saved_scores(saved: Iterable[Mapping[str, Any]]) -> list[ScoredForecast]:
    """The scores of forecasts saved in a ledger; those without, from an older version, and damaged ones are left
    out."""
    return [
        ScoredForecast(not one.get("earlier"), tuple(one["log_scores"]))
        for one in saved
        if are_numbers(one.get("log_scores"), len(MODEL_ALONE))
    ]


def mixed_in(
    draws: Float[Array, "draw"], rivals: Mapping[str, Float[Array, "_"]], weights: Sequence[float]
) -> Float[Array, "draw"]:
    """The stacked forecast; the weight of a missing rival goes to the model. [m]"""
    if tuple(weights) == MODEL_ALONE:
        return draws
    return stacked(draws, [rivals[name] if _spread(rivals, name) else draws for name in STACKED_RIVALS], weights)


def stacked(
    draws: Float[Array, "draw"], rivals: Sequence[Float[Array, "_"]], weights: Sequence[float]
) -> Float[Array, "draw"]:
    """Equally likely values of the mixture in ascending order, as many as the model's draws. [m]

    Each method contributes values in proportion to its weight, rounded, at evenly spaced levels of its distribution.
    """
    ends = np.rint(np.cumsum(weights) / np.sum(weights) * len(draws)).astype(int)
    counts = np.diff(ends, prepend=0).tolist()
    parts = [_even(way, count) for way, count in zip((draws, *rivals), counts, strict=True)]
    return np.sort(np.concatenate(parts))


def _even(draws: Float[Array, "_"], count: int) -> Float[Array, "_"]:
    """This number of the draws, evenly spaced in rank."""
    ranks = ((np.arange(count) + 0.5) / max(count, 1) * len(draws)).astype(int)
    return np.asarray(np.sort(draws)[ranks])


def _spread(rivals: Mapping[str, Float[Array, "_"]], name: str) -> bool:
    return name in rivals and len(rivals[name]) > 1

"""The fits of a rocket's first flights: to all of them, and without the one that may have been a one-off.

A fit weights every flight by its probability of being one of the rocket's usual ones. With few flights the posterior
is not that of a flight that is mostly usual but a mixture: the flight was a usual one, or it says next to nothing of
the rocket.

Derivation: by Bayes' rule the odds of the two are those of the flight given the others (`OneOffs.normal`). That two of
so few flights are one-offs has the square of a small prior probability and is neglected.
"""

from dataclasses import replace

import numpy as np

from fieldkit.inference.laplace.one_offs import LEAST_WEIGHT, one_offs
from fieldkit.inference.laplace.outlier_weights import outlier_weights
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.causes import Signatures
from fieldkit.shapes import Array, Float

MAX_FLIGHTS = 3
"""Number of flights up to which a fit is a mixture; among more, the others show whether one is a usual one. [1]"""


def with_and_without_one_off(result: Fit, known: Signatures | None = None) -> list[tuple[float, Fit]]:
    """The fit to all flights, then those without each of them, with their probabilities [1]; a fit to more than
    `MAX_FLIGHTS` flights, or to flights that all are usual ones, stands for itself. `known` as in `one_offs`.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    flown = np.flatnonzero(result.data.seen.any(axis=1))
    if result.data.normal is None or not 0 < len(flown) <= MAX_FLIGHTS:
        return [(1.0, result)]
    usual = np.ones(len(result.data.seen))
    every = _weighted(result, usual)
    normal = np.maximum(one_offs(every, known=known).normal[flown], 1e-300)
    odds = np.append(1.0, 1 / normal - 1)
    without = [_weighted(result, np.where(np.arange(len(usual)) == row, LEAST_WEIGHT, usual)) for row in flown]
    return list(zip((odds / odds.sum()).tolist(), [every, *without], strict=True))


def _weighted(result: Fit, normal: Float[Array, "flight"]) -> Fit:
    """The fit with other weights of the flights, linear around the same point."""
    found = solve(result.model, replace(result.data, normal=normal), result.tangent)
    return solve(result.model, replace(found.data, trust=outlier_weights(found)), result.tangent)

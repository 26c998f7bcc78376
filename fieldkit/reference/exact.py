"""The exact posterior given an apogee alone, on a grid over the paper's prior."""

from collections.abc import Callable
from typing import Any

import numpy as np

from fieldkit.model.paper_prior_predictive import ALPHA_RANGE, APOGEE_NOISE, CD_RANGE
from fieldkit.physics import paper
from fieldkit.physics.flight import apogees
from fieldkit.physics.thrust_steps import Burns
from fieldkit.reference.flights import Reference, heights
from fieldkit.shapes import Array, Float

ApogeesOf = Callable[[Float[Array, "*draw flight"], Float[Array, "*draw flight"]], Float[Array, "*draw flight"]]
"""Apogees of all flights, given a Cd and an alpha for each. [m]"""


def cells(ends: tuple[float, float], count: int) -> Float[Array, "cell"]:
    """Midpoints of equal cells between two ends, in the unit of both."""
    return np.linspace(*ends, 2 * count + 1)[1::2]


def exact_means(
    flights: Reference, heights: ApogeesOf, count: int = 40
) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
    """Exact posterior mean of Cd and alpha of each flight, given its apogee and nothing else. [1]

    `heights` simulates every flight with a separate Cd and alpha. The prior is uniform, the noise normal with the
    paper's 3 m, and the quadrature Gauss-Legendre with `count` nodes per axis, which cluster at the prior's ends, where
    the posterior of a low flight is.
    """
    node, weights = np.polynomial.legendre.leggauss(count)
    cd, alpha = (low + (high - low) * (node + 1) / 2 for low, high in (CD_RANGE, ALPHA_RANGE))
    shape = (count, count, len(flights))
    grid = heights(np.broadcast_to(cd[:, None, None], shape), np.broadcast_to(alpha[:, None], shape))
    misfit = 0.5 * ((grid - flights.apogee) / APOGEE_NOISE) ** 2
    weight = np.exp(misfit.min(axis=(0, 1)) - misfit) * weights[:, None, None] * weights[:, None]
    weight /= weight.sum(axis=(0, 1))
    return cd @ weight.sum(axis=1), alpha @ weight.sum(axis=0)


def reconstructions(flights: Reference, curves: Burns, count: int = 40) -> Float[Array, "flight"]:
    """Apogee at the exact posterior mean of Cd and alpha given the apogee, in the paper's physics. [m]"""

    def fly(cd: Float[Array, "*draw flight"], alpha: Float[Array, "*draw flight"]) -> Float[Array, "*draw flight"]:
        return apogees(paper.paper_setup(flights.motor, flights.dry_mass, cd, alpha, curves=curves))

    return fly(*exact_means(flights, fly, count))


def lowest(flights: Reference, curves: Burns) -> Float[Array, "flight"]:
    """The lowest apogee that the prior can produce: most drag, least thrust. [m]"""
    most, least = np.full(len(flights), CD_RANGE[1]), np.full(len(flights), ALPHA_RANGE[0])
    return heights(flights, most, least, curves)


def lowest_in(flights: Reference, fly: ApogeesOf) -> Float[Array, "flight"]:
    """The lowest apogee that the prior can produce, with any simulator `fly`. [m]"""
    return fly(np.full(len(flights), CD_RANGE[1]), np.full(len(flights), ALPHA_RANGE[0]))


def bayes_limit(count: int = 90, step: float = 1.5) -> dict[str, float]:
    """Smallest possible mean absolute errors of Cd and alpha from the apogee alone, over the paper's prior. [1]

    For each motor and configuration, and each possible apogee reading in steps of `step` meters, the estimate is the
    posterior median, which is optimal for this error; its errors are averaged over a grid of `count` cells each of Cd
    and alpha.
    """
    cd, alpha = cells(CD_RANGE, count), cells(ALPHA_RANGE, count)
    pairs = [(motor, mass) for motor in range(len(paper.MOTORS)) for mass in paper.DRY_MASS.values()]
    total = np.zeros(2)
    for motor, mass in pairs:
        grid = apogees(paper.paper_setup(np.asarray(motor), np.asarray(mass), cd[:, None], alpha[None]))
        shown = np.arange(grid.min() - 4 * APOGEE_NOISE, grid.max() + 4 * APOGEE_NOISE, step)
        weight = np.exp(-0.5 * ((grid - shown[:, None, None]) / APOGEE_NOISE) ** 2)
        weight *= step / (APOGEE_NOISE * np.sqrt(2 * np.pi) * grid.size * len(pairs))
        total += _least_miss(weight.sum(axis=2), cd), _least_miss(weight.sum(axis=1), alpha)
    return {"cd_mae": float(total[0]), "alpha_mae": float(total[1])}


def _least_miss(weight: Float[Array, "shown cell"], value: Float[Array, "cell"]) -> Any:
    """Sum of weighted errors if the estimate of each row is its median."""
    passed = (weight.cumsum(axis=1) - 0.5 * weight) / weight.sum(axis=1, keepdims=True)
    median = np.array([np.interp(0.5, row, value) for row in passed])
    return (weight * np.abs(value - median[:, None])).sum()

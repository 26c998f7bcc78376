"""Factors on standard deviations that vary from rocket to rocket: of its flights, their motors, and its readings.

A heavy-tailed prior has a hyperbolic secant distribution of the logarithm, with exponential tails; with a standard
deviation of pi / 2 it is half-Cauchy (Gelman, Prior distributions for variance parameters, Bayesian Analysis 1, 2006).
The rockets of one flyer have similar scales: normal around the flyer's in the logarithm, so the flights of one rocket
say what to expect of another.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import erf, log, pi, sqrt

import numpy as np

from fieldkit.shapes import Array, Float

HALF_CAUCHY = pi / 2
"""Standard deviation of the logarithm of a half-Cauchy variable. [1]"""
HALF_CAUCHY_GRID = np.geomspace(0.12, 2.5, 4)
"""A grid over the bulk of a half-Cauchy prior, relative to its median. [1]"""
NODES = 41
"""Number of values of a scale at which rockets of a fleet are compared. [1]"""


@dataclass(frozen=True, slots=True)
class Scale:
    """A factor between the ends of a grid, on which it is integrated: log-normal, or heavy-tailed with a `spread`. [1]

    `spread` is the standard deviation of the logarithm of a heavy-tailed prior, and `within` the part of it among the
    rockets of one flyer. `table` is the log density at `nodes` that follows from other rockets of the flyer. A grid
    around a posterior is even in the logarithm with a `step`, and its weights are prior density times step. Without a
    step, the weights of the grid add to one. `ends` are those of the prior, by default those of the grid. `points` is
    the number of points of a grid around a posterior.
    """

    grid: tuple[float, ...]
    median: float
    log_sd: float
    step: float = 0.0
    ends: tuple[float, float] | None = None
    points: int = 5
    spread: float = 0.0
    within: float = 0.0
    table: tuple[float, ...] = ()

    @property
    def values(self) -> Float[Array, "scale"]:
        """The grid. [1]"""
        return np.array(self.grid)

    def refined(self) -> "Scale":
        """The same on a grid twice as fine; of a heavy-tailed scale, from a tenth to twice its median."""
        if self.spread:
            return replace(self, grid=tuple((self.median * HALF_CAUCHY_GRID).tolist()))
        values = self.values
        return replace(self, grid=tuple(np.sort(np.r_[values, np.sqrt(values[1:] * values[:-1])]).tolist()))

    @property
    def range(self) -> tuple[float, float]:
        """The ends of the prior, which is truncated there. [1]"""
        return self.ends or (self.grid[0], self.grid[-1])

    def between(self, low: float, high: float) -> "Scale":
        """The same on a grid of midpoints of even intervals of the logarithm, from `low` to `high`. [1]"""
        edges = np.linspace(np.log(low), np.log(high), self.points + 1)
        grid = np.exp((edges[1:] + edges[:-1]) / 2)
        return replace(self, grid=tuple(grid.tolist()), step=float(edges[1] - edges[0]), ends=self.range)

    @property
    def log_density(self) -> Float[Array, "scale"]:
        """Log prior density of the logarithm at each value of the grid, up to a constant. [nat]"""
        if self.table:
            return np.interp(np.log(self.values), self.nodes, self.table)
        x = np.log(self.values / self.median)
        return _log_secant(x, self.spread) if self.spread else np.asarray(-0.5 * (x / self.log_sd) ** 2)

    @property
    def _width(self) -> float:
        return self.log_sd * sqrt(2)

    @property
    def log_prior(self) -> Float[Array, "scale"]:
        """Log prior weight of each value of the grid, not normalized without a step. [nat]"""
        log_density = self.log_density
        if not self.step:
            return np.asarray(log_density)
        low, high = np.array(self.range) / self.median
        if self.table:
            inside = 1.0
        elif self.spread:
            width = 2 * self.spread / pi
            inside = width * float(np.diff(np.arctan(np.array([low, high]) ** (1 / width)))[0])
        else:
            inside = self.log_sd * sqrt(pi / 2) * (erf(log(high) / self._width) - erf(log(low) / self._width))
        return np.asarray(log_density + log(self.step / inside))

    @property
    def nodes(self) -> Float[Array, "node"]:
        """The logarithm of a scale at evenly spaced values of its range. [1]"""
        low, high = np.log(self.range)
        return np.linspace(low, high, NODES)

    @property
    def _log_kernel(self) -> Float[Array, "node node"]:
        """Log probability of every node as a rocket's scale, given every node as the flyer's."""
        off = -0.5 * (np.subtract.outer(self.nodes, self.nodes) / self.within) ** 2
        return np.asarray(off - np.logaddexp.reduce(off, axis=1, keepdims=True))

    def of_flyer(self, log_likelihood: Float[Array, "node"]) -> Float[Array, "node"]:
        """Log likelihood of the flyer's scale at `nodes` from that of one rocket's scale. [nat]"""
        return np.asarray(np.logaddexp.reduce(self._log_kernel + log_likelihood, axis=1))

    def pooled(self, log_likelihood: Sequence[float]) -> "Scale":
        """The same given the flights of the flyer's other rockets: the log likelihood of the flyer's scale. [nat]"""
        own = _log_secant(self.nodes - log(self.median), sqrt(self.spread**2 - self.within**2)) + log_likelihood
        table = np.logaddexp.reduce(self._log_kernel + own[:, None], axis=0)
        table -= np.logaddexp.reduce(table) + log(self.nodes[1] - self.nodes[0])
        return replace(self, table=tuple(table.tolist()))


def _log_secant(x: Float[Array, "value"], sd: float) -> Float[Array, "value"]:
    """Log density of a hyperbolic secant distribution, up to a constant. [nat]"""
    return np.asarray(-np.logaddexp(pi / (2 * sd) * x, -pi / (2 * sd) * x))


@cache
def scale_grid(scales: tuple[Scale, ...]) -> tuple[Float[Array, "scale"], ...]:
    """The value of each scale [1] for every combination of their grids, and the log prior weights [nat]; the arrays are
    read-only.

    Derivation: the scales are independent a priori, so the log prior of a combination is their sum.
    """
    values = np.meshgrid(*(one.values for one in scales), indexing="ij")
    own = [one.log_prior - (0.0 if one.step else np.logaddexp.reduce(one.log_prior)) for one in scales]
    log_prior = sum(np.meshgrid(*own, indexing="ij"))
    found = tuple(np.ravel(one) for one in (*values, log_prior))
    for one in found:
        one.flags.writeable = False
    return found

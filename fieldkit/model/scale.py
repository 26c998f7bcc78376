"""Factors on standard deviations that vary from rocket to rocket: of its flights, their motors, and its readings."""

from dataclasses import dataclass, replace
from functools import cache
from math import erf, log, pi, sqrt

import numpy as np

from fieldkit.shapes import Array, Float

HALF_CAUCHY_GRID = np.geomspace(0.12, 2.5, 4)
"""A grid over the bulk of a half-Cauchy prior, relative to its median. [1]"""


@dataclass(frozen=True, slots=True)
class Scale:
    """A factor between the ends of a grid, on which it is integrated: log-normal, or half-Cauchy around its median. [1]

    A grid around a posterior is even in the logarithm with a `step`, and its weights are prior density times step.
    Without a step, the weights of the grid add to one. `ends` are those of the prior, by default those of the grid.
    `points` is the number of points of a grid around a posterior.
    """

    grid: tuple[float, ...]
    median: float
    log_sd: float
    step: float = 0.0
    ends: tuple[float, float] | None = None
    points: int = 5
    half_cauchy: bool = False

    @property
    def values(self) -> Float[Array, "scale"]:
        """The grid. [1]"""
        return np.array(self.grid)

    def refined(self) -> "Scale":
        """The same on a grid twice as fine; of a half-Cauchy scale, from a tenth to twice its median."""
        if self.half_cauchy:
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
        """Log prior density of the logarithm at each value of the grid, up to a constant. [nat]

        Source: Gelman, Prior distributions for variance parameters, Bayesian Analysis 1, 2006, for the half-Cauchy.
        """
        ratio = self.values / self.median
        if self.half_cauchy:
            return np.asarray(np.log(ratio) - np.log1p(ratio**2))
        return np.asarray(-0.5 * (np.log(ratio) / self.log_sd) ** 2)

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
        if self.half_cauchy:
            inside = float(np.arctan(high) - np.arctan(low))
        else:
            inside = self.log_sd * sqrt(pi / 2) * (erf(log(high) / self._width) - erf(log(low) / self._width))
        return np.asarray(log_density + log(self.step / inside))


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

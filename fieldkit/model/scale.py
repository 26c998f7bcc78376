"""Factors on standard deviations that differ from rocket to rocket: how noisy its flights are, and its readings."""

from dataclasses import dataclass, replace
from functools import cache
from math import log, pi, sqrt

import numpy as np

from fieldkit.shapes import Array, Float

POSTERIOR_STEP_SDS = 1.3
"""Step of a grid about a posterior, in standard deviations of that. [1]"""
POSTERIOR_POINTS = 5
"""Points of a grid about a posterior. [1]"""


@dataclass(frozen=True, slots=True)
class Scale:
    """A factor on standard deviations that differs from rocket to rocket: log-normal, integrated on a grid. [1]

    A grid `about` where a posterior lies is a part of an even one, whose `step` is that of the logarithm; `whole` is
    then the grid from which it was found.
    """

    grid: tuple[float, ...]
    median: float
    log_sd: float
    step: float = 0.0
    whole: tuple[float, ...] = ()

    @property
    def values(self) -> Float[Array, "scale"]:
        """The grid. [1]"""
        return np.array(self.grid)

    def refined(self) -> "Scale":
        """The same on a grid twice as fine."""
        values = self.values
        return replace(self, grid=tuple(np.sort(np.r_[values, np.sqrt(values[1:] * values[:-1])]).tolist()))

    def about(self, log_mode: float, log_sd: float) -> "Scale":
        """The same on an even grid about the mode of a posterior with that standard deviation of the logarithm.

        For a normal density its sum times the step is the integral to 0.2 %: less than 2e-5 for the step, the rest for
        the tails (Trefethen and Weideman, SIAM Review 56, 2014).
        """
        step = POSTERIOR_STEP_SDS * log_sd
        grid = np.exp(log_mode + step * (np.arange(POSTERIOR_POINTS) - POSTERIOR_POINTS // 2))
        return replace(self, grid=tuple(grid.tolist()), step=step, whole=self.whole or self.grid)

    def everywhere(self) -> "Scale":
        """The same on the grid that it had before it was put about a posterior."""
        return replace(self, grid=self.whole, step=0.0, whole=()) if self.whole else self

    @property
    def log_prior(self) -> Float[Array, "scale"]:
        """Log prior weight of each value of the grid; not normalized where the grid is all there is."""
        log_density = -0.5 * (np.log(self.values / self.median) / self.log_sd) ** 2
        return np.asarray(log_density + (log(self.step / (self.log_sd * sqrt(2 * pi))) if self.step else 0.0))


@cache
def scale_pairs(
    scatter: Scale, reading: Scale
) -> tuple[Float[Array, "scale"], Float[Array, "scale"], Float[Array, "scale"]]:
    """Scatter scale, reading scale and log prior of every pair on two grids, normalized where a grid is all there is;
    the arrays are read-only."""
    values = np.meshgrid(scatter.values, reading.values, indexing="ij")
    own = [one.log_prior - (0.0 if one.step else np.logaddexp.reduce(one.log_prior)) for one in (scatter, reading)]
    found = values[0].ravel(), values[1].ravel(), (own[0][:, None] + own[1]).ravel()
    for one in found:
        one.flags.writeable = False
    return found

"""Factors on standard deviations that vary from rocket to rocket: one for its flights, one for its readings."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Scale:
    """A log-normal factor, integrated on a grid. [1]"""

    grid: tuple[float, ...]
    median: float
    log_sd: float

    @property
    def values(self) -> Float[Array, "scale"]:
        """The grid. [1]"""
        return np.array(self.grid)

    def refined(self) -> "Scale":
        """The same on a grid twice as fine."""
        values = self.values
        return replace(self, grid=tuple(np.sort(np.r_[values, np.sqrt(values[1:] * values[:-1])]).tolist()))

    @property
    def log_prior(self) -> Float[Array, "scale"]:
        """Log prior weight of each value of the grid, not normalized. [nat]"""
        return np.asarray(-0.5 * (np.log(self.values / self.median) / self.log_sd) ** 2)


@cache
def scale_pairs(
    scatter: Scale, reading: Scale
) -> tuple[Float[Array, "scale"], Float[Array, "scale"], Float[Array, "scale"]]:
    """The scatter scale, reading scale and normalized log prior of every pair on two grids; the arrays are
    read-only. Derivation: the scales are independent a priori, so the log prior of a pair is the sum of both."""
    values = np.meshgrid(scatter.values, reading.values, indexing="ij")
    prior = (scatter.log_prior[:, None] + reading.log_prior).ravel()
    found = values[0].ravel(), values[1].ravel(), prior - np.logaddexp.reduce(prior)
    for one in found:
        one.flags.writeable = False
    return found

"""Quality of forecasts: errors and coverage on flights that were not used in the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from fieldkit.inference.laplace.leave_one_out import LeaveOneOut
from fieldkit.shapes import Array, Flags, Float

_NODES, _NODE_WEIGHTS = 0.5 * np.array(np.polynomial.legendre.leggauss(32)) + [[0.5], [0.0]]
"""Nodes and weights of the integral of a score on each side of the value, from 0 to 1 (Gauss and Legendre). [1]"""


@dataclass(frozen=True, slots=True)
class Forecasts:
    """Forecast of each flight's log apogee as a mixture of normals. [log m]"""

    mean: Float[Array, "part flight"]
    sd: Float[Array, "part flight"]
    weight: Float[Array, "part flight"]

    @property
    def apogee(self) -> Float[Array, "flight"]:
        """The point forecast: the exponential of the mean logarithm, which is close to the median. [m]"""
        return np.asarray(np.exp((self.weight * self.mean).sum(axis=0)))

    def below(self, values: Float[Array, "flight"]) -> Float[Array, "flight"]:
        """Cumulative probability of a log apogee. [1]"""
        return np.asarray((self.weight * ndtr((values - self.mean) / self.sd)).sum(axis=0))

    def crps(self, values: Float[Array, "flight"]) -> Float[Array, "flight"]:
        """The continuous ranked probability score of each log apogee, the integral of the squared difference of both
        cumulative distributions: about a relative error. [1]

        Source: Gneiting and Raftery, Strictly Proper Scoring Rules, Prediction, and Estimation, 2007, section 4.2.
        """
        middle = (self.weight * self.mean).sum(axis=0)
        spread = np.sqrt((self.weight * (self.sd**2 + (self.mean - middle) ** 2)).sum(axis=0))
        inside = np.clip(values, middle - 6 * spread, middle + 6 * spread)  # beyond, the distribution is 0 or 1
        low, high = inside - (middle - 6 * spread), (middle + 6 * spread) - inside
        total = abs(values - inside)
        for node, weight in zip(_NODES.tolist(), _NODE_WEIGHTS.tolist(), strict=True):
            total += weight * low * self.below(inside - node * low) ** 2
            total += weight * high * (1 - self.below(inside + node * high)) ** 2
        return total

    @staticmethod
    def pick(options: Sequence["Forecasts"]) -> "Forecasts":
        """Take the first flight from the first option, the second from the second, and so on."""
        longest = max(len(option.mean) for option in options)

        def column(name: str, fill: float) -> Array:
            columns = [getattr(option, name)[:, number] for number, option in enumerate(options)]
            return np.stack([np.pad(c, (0, longest - len(c)), constant_values=fill) for c in columns], axis=1)

        return Forecasts(column("mean", 0.0), column("sd", 1.0), column("weight", 0.0))


def mixed(
    mean: Float[Array, "part flight"], variance: Float[Array, "part flight"], log_weight: Float[Array, "part flight"]
) -> Forecasts:
    """A mixture of normals of the log apogee, each component weighted by its likelihood on the other flights; mean
    [log m], variance [log m squared]."""
    weight = np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0))
    return Forecasts(mean, np.sqrt(variance), weight)


def forecasts_of(left_out: LeaveOneOut) -> Forecasts:
    """Forecasts of left-out flights, with the scales weighted by the other flights."""
    return mixed(left_out.mean, left_out.variance, left_out.log_weight)


@dataclass(frozen=True, slots=True)
class Score:
    """Errors of forecasts, predicted minus flown [m], and the fraction of flights in the 90% interval [1]."""

    mae: float
    rmse: float
    bias: float
    coverage90: float

    def json(self) -> dict[str, float]:
        """The keys of the contract."""
        return {"mae_m": self.mae, "rmse_m": self.rmse, "bias_m": self.bias, "coverage90": self.coverage90}


def score(forecasts: Forecasts, truth: Float[Array, "flight"], seen: Flags) -> Score:
    """The score of forecasts of log apogee on the flights with an apogee. `truth` has the flown apogees. [log m]"""
    if not seen.any():
        return Score(np.nan, np.nan, np.nan, np.nan)
    error = (forecasts.apogee - np.exp(truth))[seen]
    below = forecasts.below(truth)[seen]
    inside = (below > 0.05) & (below < 0.95)
    greatest = max(float(np.abs(error).max()), 1e-9)  # the square of an absurd error would overflow
    rmse = greatest * float(np.sqrt(((error / greatest) ** 2).mean()))
    return Score(float(np.abs(error).mean()), rmse, float(error.mean()), float(inside.mean()))

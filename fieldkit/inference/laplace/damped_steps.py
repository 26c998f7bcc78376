"""Damped Gauss-Newton: the steps of a point of linearization to the posterior mean."""

import numpy as np

from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.shapes import Array

CONVERGENCE_TOLERANCE = 0.03
"""Convergence tolerance of a step, in prior standard deviations: evidence is needed to a tenth of a nat. [1]"""
FORECAST_TOLERANCE = 0.2
"""Convergence tolerance for a forecast, in posterior standard deviations: hundredths of its interval. [1]"""


class DampedSteps:
    """The damped iteration of one lane's point toward its posterior mean.

    Readouts have a kink when ejection is at apogee, and a point could oscillate across it indefinitely. So the step of
    a term is halved when it changes direction, and doubled, up to the full step, while it does not. Biases of readouts
    are exactly linear and converge in one step.
    """

    def __init__(self, at: Array) -> None:
        self.at = at
        self._last, self._share = np.zeros_like(at), np.ones_like(at)

    def advance(self, result: Fit | None, *, near: bool = False) -> bool:
        """Move the point toward the posterior mean; False if it is at the mean."""
        assert result is not None
        terms = result.model.terms
        sds = np.array([term.sd for term in terms])
        best = int(np.argmax(result.log_weight))
        wanted = result.mean[best]
        target = np.clip(wanted, [term.low for term in terms], [term.high for term in terms])
        bent = np.array([term.bends not in OBSERVED_READOUTS for term in terms])
        sd = np.sqrt(np.diagonal(result.covariance_at(slice(best, best + 1))[0]))
        close = FORECAST_TOLERANCE * sd if near else CONVERGENCE_TOLERANCE * sds
        move = np.where(bent, np.clip(target - self.at, -2 * sds, 2 * sds), target - self.at)
        turned = np.sign(move * self._last)
        self._share = np.minimum(self._share * 2.0**turned, 1.0)
        move = self._last = self._share * move
        if np.all(np.abs(move) < close, where=bent):
            return False
        self.at = self.at + move
        return True

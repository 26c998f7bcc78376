"""The scatter of apogees relative to the scatter that the fit of all readouts expects.

A fit describes the scatter of all readouts by two scales, so the scatter of speeds and times affects the apogee too.
The errors of leave-one-out forecasts show how much the scatter of the apogee differs: they give a factor on its
standard deviation, with a prior around one and a Student t likelihood.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.shapes import Array, Flags, Float

TAIL = CERTIFIED_PRIOR.tail
"""Degrees of freedom of the assumed distribution of single flights. [1]"""
FACTORS = np.geomspace(0.5, 3.5, 16)
"""The ratio of the apogee's scatter to that of the fit. [1]"""
_LOG_PRIOR = -0.5 * (np.log(FACTORS) / 0.4) ** 2


@dataclass(frozen=True, slots=True)
class ScatterWeights:
    """Posterior weights of `FACTORS` from all flights, and from all flights but each one."""

    weight: Float[Array, "factor"]
    weight_without: Float[Array, "factor flight"]

    @property
    def mean_square_without(self) -> Float[Array, "flight"]:
        """Mean square of the factor from all flights but each one. [1]"""
        return np.asarray(FACTORS**2 @ self.weight_without)


def apogee_spread(
    error: Float[Array, "flight"], known: Float[Array, "flight"], own: Float[Array, "flight"], seen: Flags
) -> ScatterWeights:
    """The posterior of the factor from the errors of leave-one-out forecasts.

    `error` is the log of flown over predicted apogee [1], `known` the variance of the forecast due to the uncertain
    parameters of the rocket, and `own` the variance due to the scatter of single flights. Flights not `seen` are
    ignored.
    """
    variance = known + FACTORS[:, None] ** 2 * own
    unit = (TAIL - 2) * variance
    likelihood = np.where(seen, -0.5 * (TAIL + 1) * np.log1p(error**2 / unit) - 0.5 * np.log(variance), 0.0)
    total = _LOG_PRIOR + likelihood.sum(axis=1)
    return ScatterWeights(_weights(total[:, None])[:, 0], _weights(total[:, None] - likelihood))


def _weights(log_weight: Array) -> Array:
    return np.asarray(np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0)))

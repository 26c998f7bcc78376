"""The scatter of apogees, compared with what the fit of all readouts makes of it.

Two scales stand for the scatter of every readout in a fit, so that speeds and times that are steadier or wilder than
expected speak for the apogee too. What was forecast of flights left out says how much the apogee's own scatter differs:
a factor on its standard deviation, with a prior about one, weighed by a Student t likelihood of their errors.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.model.hyperprior import CERTIFIED_PRIOR
from fieldkit.shapes import Array, Flags, Float

TAIL = CERTIFIED_PRIOR.tail
"""Degrees of freedom of the distribution that single flights are taken to have. [1]"""
FACTORS = np.geomspace(0.5, 3.5, 16)
"""The apogee's own scatter over what the fit says. [1]"""
_LOG_PRIOR = -0.5 * (np.log(FACTORS) / 0.4) ** 2


@dataclass(frozen=True, slots=True)
class ScatterWeights:
    """Posterior weights of `FACTORS`, by all flights, and by all but each one."""

    weight: Float[Array, "factor"]
    weight_without: Float[Array, "factor flight"]

    @property
    def mean_square_without(self) -> Float[Array, "flight"]:
        """Mean square of the factor by all flights but each one. [1]"""
        return np.asarray(FACTORS**2 @ self.weight_without)

    def draw(self, draws: int, rng: np.random.Generator) -> Float[Array, "draw"]:
        """Draws of the factor. [1]"""
        return np.asarray(rng.choice(FACTORS, draws, p=self.weight))


def apogee_spread(
    error: Float[Array, "flight"], known: Float[Array, "flight"], own: Float[Array, "flight"], seen: Flags
) -> ScatterWeights:
    """The apogee's own scatter by how flights left out came to lie.

    `error` is the log of flown over forecast apogee, `known` the variance of the forecast for what is not known of
    the rocket, `own` that for the scatter of single flights. Flights not `seen` say nothing.
    """
    variance = known + FACTORS[:, None] ** 2 * own
    unit = (TAIL - 2) * variance
    likelihood = np.where(seen, -0.5 * (TAIL + 1) * np.log1p(error**2 / unit) - 0.5 * np.log(variance), 0.0)
    total = _LOG_PRIOR + likelihood.sum(axis=1)
    return ScatterWeights(_weights(total[:, None])[:, 0], _weights(total[:, None] - likelihood))


def _weights(log_weight: Array) -> Array:
    return np.asarray(np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0)))

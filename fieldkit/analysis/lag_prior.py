"""How late barometers of altimeters are, before a log is read."""

import numpy as np

from fieldkit.shapes import Array, Float

TYPICAL_LAG = 0.05
"""Scale of the half-Cauchy prior of a lag: half of all loggers are below it, one in six has more than 0.2 s. [s]"""


def lag_density(lags: Float[Array, "lag"]) -> Float[Array, "lag"]:
    """Prior density of lags, up to a constant. [1/s]

    Derivation: the Cauchy distribution, of which a lag has the positive half.
    """
    return np.asarray(1 / (1 + (lags / TYPICAL_LAG) ** 2))

"""Integrals of sampled curves by the trapezoidal rule, which is exact for piecewise linear ones.

`scipy.integrate.cumulative_trapezoid` gives the same, but importing it takes as long as measuring a log.
"""

import numpy as np

from fieldkit.shapes import Array, Float


def running_integral(values: Float[Array, "*curve time"], time: Float[Array, "time"]) -> Float[Array, "*curve time"]:
    """Integral of each curve from its first sample to every sample, in the product of both units."""
    pieces = np.diff(time) * (values[..., 1:] + values[..., :-1]) / 2
    return np.concatenate([np.zeros((*values.shape[:-1], 1)), np.cumsum(pieces, axis=-1)], axis=-1)

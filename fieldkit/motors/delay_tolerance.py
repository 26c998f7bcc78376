"""The spread of an ejection delay around its printed value, the same in every forecast and on every page.

Source: NFPA 1125, as cited in openrocket#3041: a delay may be off by 20% or 1.5 s, whichever is greater, but by no more
than 3 s. Derivation: makers comply with it, so these limits are taken as two standard deviations of a normal
distribution.
"""

import numpy as np

from fieldkit.shapes import Array, Float

RELATIVE_DELAY_TOLERANCE, MIN_DELAY_TOLERANCE, MAX_DELAY_TOLERANCE = 0.2, 1.5, 3.0
"""Largest deviation of a delay from its printed value: this fraction of it [1], within these bounds [s]."""
_LEAST_DELAY_RATIO = 0.05
"""Shortest delay as a fraction of the printed one: a charge never fires before the delay has burned. [1]"""


def delay_tolerance(delays: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Largest deviation of delays from their printed values [s]; nan for nan. [s]"""
    return np.asarray(np.clip(RELATIVE_DELAY_TOLERANCE * delays, MIN_DELAY_TOLERANCE, MAX_DELAY_TOLERANCE))


def delay_sd(delays: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Standard deviation of delays around their printed values [s]; nan for nan. [s]"""
    return delay_tolerance(delays) / 2


def log_delay_ratio(delays: Float[Array, "flight"], normal: Float[Array, "draw flight"]) -> Float[Array, "draw flight"]:
    """Log of flown over printed delays [s] for standard normal draws; 0 without a delay or with one of zero. [1]"""
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = np.where(delays > 0, delay_sd(delays) / delays, 0.0)
    return np.asarray(np.log(np.maximum(1 + relative * normal, _LEAST_DELAY_RATIO)))

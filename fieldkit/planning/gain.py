"""The gain of a change in points per flight, and whether it is clear enough to advise the change.

Derivation: the standard error of a mean of independent values is their standard deviation over the root of their
number.
"""

from typing import Any

import numpy as np

from fieldkit.shapes import Array, Float

CLEAR_ERRORS, LEAST_GAIN = 2.0, 1.0
"""Minimum gain in points, in standard errors and as a number of points. [1]"""


def gain_of(saved: Float[Array, "..."], flights: int) -> tuple[float, float]:
    """Mean of the points that a change saves, in draws common to both plans, and its standard error with a number of
    flights: the difference scatters from flight to flight, and that number of flights determines its mean. [1]"""
    return float(saved.mean()), float(saved.std() / np.sqrt(max(flights, 1)))


def is_clear(gain: float, error: float) -> bool:
    """Whether a mean gain with a standard error justifies a change. [1]"""
    return gain > max(CLEAR_ERRORS * error, LEAST_GAIN)


def gain_json(gain: float | None, error: float | None, change: bool) -> dict[str, Any]:
    """Ready for JSON, with the unit in the key; `change` is whether the change is advised."""
    return {"gain_points": gain, "gain_error_points": error, "change": change}

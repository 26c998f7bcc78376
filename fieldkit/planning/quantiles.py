"""Distributions as three numbers: 5, 50 and 95%."""

import math

import numpy as np

from fieldkit.forecast.prediction import LEVELS, quantiles
from fieldkit.shapes import Array, Float

Three = tuple[float, float, float]
"""5, 50 and 95%; nan if there are no draws."""


def three(draws: Float[Array, "draw"]) -> Three:
    """Quantiles of the draws that are not nan, in their unit."""
    known = draws[np.isfinite(draws)]
    if not known.size:
        return (math.nan,) * 3
    low, middle, high = quantiles(known, LEVELS)
    return float(low), float(middle), float(high)


def named(quantiles: Three) -> dict[str, float | None]:
    """Ready for JSON, None for nan."""
    values = (value if math.isfinite(value) else None for value in quantiles)
    return dict(zip(("p05", "p50", "p95"), values, strict=True))

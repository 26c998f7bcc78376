"""Distributions as three numbers: 5, 50 and 95%.

Some figures have no value in some draws, such as the duration of a flight that never leaves the pad; the quantiles of a
figure without a value in any draw are None, so that a caller that shows them has to decide what to print instead.
"""

import numpy as np

from fieldkit.forecast.prediction import LEVELS, quantiles
from fieldkit.shapes import Array, Float

Three = tuple[float, float, float]
"""5, 50 and 95%, all finite."""


def three(draws: Float[Array, "draw"]) -> Three | None:
    """Quantiles of the draws with a value, in their unit; None without any."""
    known = draws[np.isfinite(draws)]
    if not known.size:
        return None
    low, middle, high = quantiles(known, LEVELS)
    return float(low), float(middle), float(high)


def three_of_all(draws: Float[Array, "draw"]) -> Three:
    """Quantiles of draws that all have a value, such as an apogee, which is zero on the pad, in their unit."""
    low, middle, high = quantiles(draws, LEVELS).tolist()
    assert np.isfinite(high)  # what is not finite is sorted last
    return low, middle, high


def named(quantiles: Three | None) -> dict[str, float | None]:
    """Ready for JSON."""
    return dict(zip(("p05", "p50", "p95"), quantiles or (None, None, None), strict=True))

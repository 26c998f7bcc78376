"""Duration and mean acceleration of a boost, with standard deviations that hold for few samples and short boosts.

Derivation: a rocket that accelerates evenly from lift-off to burnout reaches half of burnout speed times burn time. So
the coast, extrapolated back to the pad, starts in the middle of the boost: it shows when the boost was, not how long.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import median_step
from fieldkit.shapes import Array, Float

SHORTEST_BOOST = 0.15
"""Duration of the shortest boosts. [s]"""
_TWO_SD_PART = 0.9545
"""Part of a normal distribution within two standard deviations. [1]"""
_MIN_BOOST_SAMPLES = 2.0
"""Number of samples in a boost below which they do not show its length. [1]"""


def burn_time(burn: Figure, lift: Event, burnout: Event, time: Float[Array, "time"]) -> Figure:
    """A burn time from samples at given times [s]; if they are few, lift-off and burnout have opposite errors, whose
    standard deviations add up. [s]"""
    near = time[(time > lift.time - burn.value) & (time < burnout.time + burn.value)]
    if near.size < 2 or burn.value >= _MIN_BOOST_SAMPLES * median_step(near):
        return burn
    return Figure(burn.value, lift.sd + burnout.sd, burn.source)


def mean_acceleration(
    value: float, speeds: Sequence[Figure], burns: Sequence[Figure], weights: Sequence[float]
) -> Figure:
    """A top speed divided by a burn time, net of gravity, if both have a mixture of normal distributions. [m/s^2]

    A burn time shorter by half doubles the acceleration, and one longer by half only reduces it by a third. So the
    standard deviation is half of the distance from the value that 95% of the distribution are within: more than that of
    the usual errors, which are on the short side.
    """
    each = np.linspace(-4, 4, 161)
    lasts = np.array([burn.value + burn.sd * each for burn in burns])
    likely = np.exp(-(each**2) / 2) * np.array(weights)[:, None] * (lasts > SHORTEST_BOOST)
    if not likely.any():
        return Figure(value, float("inf"), burns[0].source)
    speed, sd = (np.array([[getattr(one, part)] for one in speeds]) for part in ("value", "sd"))
    lasts = np.maximum(lasts, SHORTEST_BOOST)
    away = np.abs(speed / lasts - value).ravel()
    order = np.argsort(away)
    within = np.cumsum(likely.ravel()[order]) / likely.sum()
    by_burn = float(away[order][np.searchsorted(within, _TWO_SD_PART)]) / 2
    by_speed = float(np.sqrt((likely * (sd / lasts) ** 2).sum() / likely.sum()))
    return Figure(value, float(np.hypot(by_burn, by_speed)), burns[0].source)

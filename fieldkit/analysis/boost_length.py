"""Duration and mean acceleration of a boost, with standard deviations that hold for few samples and short boosts.

Derivation: a rocket that accelerates evenly from lift-off to burnout reaches half of burnout speed times burn time. So
the coast, extrapolated back to the pad, starts in the middle of the boost: it shows when the boost was, not how long.
"""

import numpy as np

from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import median_step
from fieldkit.shapes import Array, Float

SHORTEST_BOOST = 0.15
"""Duration of the shortest boosts. [s]"""
_MIN_BOOST_SAMPLES = 2.0
"""Number of samples in a boost below which they do not show its length. [1]"""


def burn_time(burn: Figure, lift: Event, burnout: Event, time: Float[Array, "time"]) -> Figure:
    """A burn time from samples at given times [s]; if they are few, lift-off and burnout have opposite errors, whose
    standard deviations add up. [s]"""
    near = time[(time > lift.time - burn.value) & (time < burnout.time + burn.value)]
    if near.size < 2 or burn.value >= _MIN_BOOST_SAMPLES * median_step(near):
        return burn
    return Figure(burn.value, lift.sd + burnout.sd, burn.source)


def mean_acceleration(speed: Figure, burn: Figure) -> Figure:
    """Top speed divided by burn time, net of gravity. [m/s^2]

    Its standard deviation is the root mean square deviation over the normal distribution of the burn time, because a
    burn time shorter by half doubles the acceleration, and one longer by half only reduces it by a third.
    """
    value = speed.value / burn.value
    burns = burn.value + burn.sd * np.linspace(-4, 4, 801)
    weight = np.exp(-(((burns - burn.value) / max(burn.sd, 1e-9)) ** 2) / 2)[burns > SHORTEST_BOOST]
    burns = burns[burns > SHORTEST_BOOST]
    if not burns.size:
        return Figure(value, float("inf"), burn.source)
    square = weight @ (((speed.value / burns - value) ** 2) + (speed.sd / burns) ** 2) / weight.sum()
    return Figure(value, float(np.sqrt(square)), burn.source)

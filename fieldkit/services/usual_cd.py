"""The drag coefficient of a rocket that is known only by its size: that of other rockets.

Derivation: its logarithm is normal, with the mean and the summed variances of the hyperprior's random effects.
"""

import math

from fieldkit.model.hyperprior import learned

LEVELS = ("rocket", "config", "flight")
"""Levels at which drag differs between rockets, besides that of a flyer's fleet."""
Z90 = 1.645
"""Half width of a central 90% interval of the normal distribution. [1]"""


def usual_cd() -> tuple[float, float, float]:
    """The Cd of other rockets at 5, 50 and 95%. [1] Raises DamagedModel for an unreadable hyperprior."""
    prior = learned()
    spread = math.hypot(prior.fleet_sd("drag"), *(prior.sd("drag", level) for level in LEVELS))
    low, middle, high = (math.exp(prior.mean("drag") + z * spread) for z in (-Z90, 0.0, Z90))
    return low, middle, high

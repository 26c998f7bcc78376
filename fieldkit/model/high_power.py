"""Flights on high-power motors, which depart less from their simulation than those of model rockets."""

from collections.abc import Sequence

import numpy as np

from fieldkit.model.hyperprior import Hyperprior
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float

HIGH_POWER_IMPULSE = 160.0
"""Total impulse above which a motor is high power (NFPA 1125). [N s]"""
CLOSER_AT_HIGH_POWER = ("mass", "thrust", "apogee")
"""Quantities whose random effects `Hyperprior.high_power` scales."""


def departures(found: Sequence[Found], hyperprior: Hyperprior) -> Float[Array, "flight"]:
    """How far each flight departs from its simulation in mass, thrust and apogee, relative to a model rocket. [1]

    Flights on high-power motors depart less: each type is certified by test, and rockets are usually weighed as flown.
    Source: the flights that `fieldkit learn --high-power` was given.
    """
    impulses = np.array([max(one.total_impulse for one in item.motor.parts or (item.motor,)) for item in found])
    return np.where(impulses > HIGH_POWER_IMPULSE, hyperprior.high_power, 1.0)

"""A logger that moves the zero of its altitudes in flight, as its own pressures show.

Derivation: a level has one pressure, so altitudes from pressure and those above the pad differ by the pad's height.
"""

import numpy as np

from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import pressure_height

_SAME_LEVEL, _ZERO_MOVED = 20.0, 5.0
"""Pressure heights this close are the same level; if two altitudes at the same level differ by more than this, their
zero has moved. [m]"""
_SAMPLES = 12
"""Fewest samples that show a level. [1]"""


def zero_moved(series: Series) -> bool:
    """Whether a logger moved the zero of its altitudes during the log, as its own pressures show.

    Equal pressures then have one altitude at the beginning and another one later. A logger that corrects for the
    temperature has altitudes on another scale, which changes little near the ground.
    """
    level = pressure_height(series.pressure) if series.pressure is not None else series.altitude_msl
    if series.altitude is None or level is None:
        return False
    both = np.flatnonzero(np.isfinite(level) & np.isfinite(series.altitude))
    if both.size < 2 * _SAMPLES:
        return False
    level, zero = level[both], level[both] - series.altitude[both]
    ground, own = np.median(level[:_SAMPLES]), np.median(zero[:_SAMPLES])
    if np.ptp(level) < _SAME_LEVEL:  # a sensor that is stuck shows no level
        return False
    again = np.abs(level - ground) < _SAME_LEVEL
    again[: both.size // 2] = False
    return bool(again.sum() >= _SAMPLES and abs(np.median(zero[again]) - own) > _ZERO_MOVED)

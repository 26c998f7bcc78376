"""What the flags of a log, and its accelerometer at rest on the pad, say."""

from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.shapes import Array, Flags, Float
from fieldkit.units import STANDARD_GRAVITY

REST = (0.8, 1.15)
"""How much of gravity an accelerometer at rest may show: tilted with its rail, or badly calibrated. [g]"""


def first_time(time: Float[Array, "row"], marked: Flags) -> float | None:
    """When a flag is first set, or None if it never is. [s]"""
    rows = np.flatnonzero(marked)
    return float(time[rows[0]]) if len(rows) else None


def marks(time: Float[Array, "row"], flags: Mapping[str, Float[Array, "row"] | None]) -> dict[str, float]:
    """The events whose flag is ever set, each with the time of its first row. [s]"""
    found = {name: first_time(time, flag > 0) for name, flag in flags.items() if flag is not None}
    return {name: when for name, when in found.items() if when is not None}


def scale_at_rest(magnitude: Float[Array, "row"], scales: Sequence[float]) -> float | None:
    """The one of some scales that makes a magnitude at rest about one g, or None. [m/s^2 per unit]"""
    if not np.isfinite(magnitude).any():
        return None
    level = float(np.nanmedian(magnitude))
    fitting = [s for s in scales if REST[0] <= level * s / STANDARD_GRAVITY <= REST[1]]
    return fitting[0] if len(fitting) == 1 else None


def upright(axes: Float[Array, "axis row"], rest: Flags) -> Float[Array, "row"] | None:
    """Of three axes the one that carries gravity while the rocket stands on its pad, nose up positive, or None."""
    if not rest.any() or not np.isfinite(axes[:, rest]).any(axis=1).all():
        return None
    levels = np.nanmedian(axes[:, rest], axis=1) / STANDARD_GRAVITY
    axis = int(np.argmax(np.abs(levels)))
    if not REST[0] <= abs(levels[axis]) <= REST[1]:
        return None
    felt: Float[Array, "row"] = axes[axis] * np.sign(levels[axis])
    return felt

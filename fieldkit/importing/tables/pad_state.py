"""Use the flags of a log, and its accelerometer at rest on the pad."""

from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.analysis.channels import Push, is_clipped
from fieldkit.integrals import running_integral
from fieldkit.shapes import Array, Bool, Flags, Float
from fieldkit.units import STANDARD_GRAVITY

REST = (0.8, 1.15)
"""Reading of an accelerometer at rest: tilted with its rail, or badly calibrated. [g]"""


def first_time(time: Float[Array, "row"], marked: Flags) -> float | None:
    """When a flag is first set; None if it never is, or was already set when the log began. [s]"""
    rows = np.flatnonzero(marked)
    if not len(rows) or (len(marked) > 1 and marked[:2].all()):
        return None
    return float(time[rows[0]])


def marks(time: Float[Array, "row"], flags: Mapping[str, Float[Array, "row"] | None]) -> dict[str, float]:
    """The events whose flag is set after the log began, each with the time of its first row. [s]"""
    found = {name: first_time(time, flag > 0) for name, flag in flags.items() if flag is not None}
    return {name: when for name, when in found.items() if when is not None}


def scale_at_rest(magnitude: Float[Array, "row"], scales: Sequence[float]) -> float | None:
    """The scale that makes a magnitude at rest about one g; None if none or several do. [m/s^2 per unit]"""
    if not np.isfinite(magnitude).any():
        return None
    level = float(np.nanmedian(magnitude))
    fitting = [s for s in scales if REST[0] <= level * s / STANDARD_GRAVITY <= REST[1]]
    return fitting[0] if len(fitting) == 1 else None


def upright(axes: Float[Array, "axis row"], rest: Flags) -> Float[Array, "row"] | None:
    """The axis that measures gravity on the pad, positive with the nose up; None if there is none. [m/s^2]"""
    if not rest.any() or not np.isfinite(axes[:, rest]).any(axis=1).all():
        return None
    levels = np.nanmedian(axes[:, rest], axis=1) / STANDARD_GRAVITY
    axis = int(np.argmax(np.abs(levels)))
    if not REST[0] <= abs(levels[axis]) <= REST[1]:
        return None
    felt: Float[Array, "row"] = axes[axis] * np.sign(levels[axis])
    return felt


BOOST = 0.4
"""Averaging time that distinguishes a boost from the shock of a charge, which is stronger and shorter. [s]"""
BOOST_FORCE = 2.0 * STANDARD_GRAVITY
"""Smallest specific force of a boost. [m/s^2]"""
_LEAST_SEEN = 0.1
"""Smallest part of the acceleration, squared, along the axes that are not saturated, for which they show it: their
noise counts up to three times. [1]"""
ONE_G_RANGE = (0.6, 1.2)
"""Reading of an accelerometer on the pad along the direction of the later thrust. [g]"""


def along_thrust(time: Float[Array, "row"], axes: Float[Array, "axis row"]) -> Float[Array, "row"] | None:
    """Acceleration along the rocket from three axes in any mounting: along the strongest sustained thrust. [m/s^2]

    Where an axis is at the end of its range, the others show the acceleration, by their parts of its direction; if they
    are nearly across it, it is the largest that all three show. None if there is no such thrust, or if gravity on the
    pad is not along it.
    """
    full = _is_full(time, axes)
    whole = np.isfinite(axes).all(axis=0) & np.isfinite(time)
    samples = whole & ~full.any(axis=0)
    thrust = _thrust(time[samples], axes[:, samples])
    if thrust is None:  # the whole boost is saturated
        samples = whole
        thrust = _thrust(time[samples], axes[:, samples])
    if thrust is None:
        return None
    begin, direction = thrust
    before = samples & (time < begin - 1.0)
    if before.sum() >= 5:
        level = float(direction @ np.median(axes[:, before], axis=1)) / STANDARD_GRAVITY
        if not ONE_G_RANGE[0] <= level <= ONE_G_RANGE[1]:
            return None
    along: Float[Array, "row"] = direction @ axes
    seen = direction**2 @ np.where(full, 0.0, 1.0)
    others = (direction @ np.where(full, 0.0, axes)) / np.maximum(seen, _LEAST_SEEN)
    hidden = full.any(axis=0)
    along[hidden] = np.where(seen >= _LEAST_SEEN, others, np.nanmax(along[hidden], initial=0.0))[hidden]
    return along


def _thrust(
    time: Float[Array, "sample"], felt: Float[Array, "axis sample"]
) -> tuple[float, Float[Array, "axis"]] | None:
    """When the strongest sustained thrust begins [s], and its direction [1]; None if there is none."""
    if time.size < 20:
        return None
    total = running_integral(felt, time)
    after = np.minimum(np.searchsorted(time, time + BOOST), time.size - 1)
    lasts = np.maximum(time[after] - time, 1e-9)
    push = np.where(lasts > BOOST / 2, np.linalg.norm(total[:, after] - total, axis=0) / lasts, 0.0)
    strongest = int(np.argmax(push))
    if push[strongest] < BOOST_FORCE:
        return None
    direction = (total[:, after[strongest]] - total[:, strongest]) / lasts[strongest] / push[strongest]
    return float(time[strongest]), direction


def _is_full(time: Float[Array, "row"], axes: Float[Array, "axis row"]) -> Bool[Array, "axis row"]:
    """Which axes are at the end of their range, by sample."""
    full = np.zeros(axes.shape, bool)
    for place, axis in enumerate(axes):
        magnitude = np.abs(axis)
        there = np.isfinite(magnitude) & np.isfinite(time)
        pushed = magnitude[there].max(initial=0.0) > BOOST_FORCE
        if pushed and is_clipped(Push(time[there], magnitude[there], False, ""), -np.inf, np.inf):
            full[place] = magnitude >= np.nanmax(magnitude)
    return full

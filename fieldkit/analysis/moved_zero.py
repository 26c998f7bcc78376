"""A logger that moves the zero of its altitudes, as its own pressures or a step show, or whose first ones have none.

Derivation: a level has one pressure, so altitudes from pressure and those above the pad differ by the pad's height. A
logger that sets its zero when it notices the flight has a step there that no rocket flies, and comes to rest as far
from where it began.
"""

import numpy as np

from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.shapes import Array, Float

_SAME_LEVEL, _ZERO_MOVED = 20.0, 5.0
"""Pressure heights this close are the same level; if two altitudes at the same level differ by more than this, their
zero has moved. [m]"""
_SAMPLES = 12
"""Fewest samples that show a level. [1]"""
_STEP_SPEED, _AT_REST = 700.0, 5.0
"""Speed that no such rocket has [m/s], and largest range of heights at rest [m]."""
_START_UP, _MANY_STEPS, _REST_TIME = 20.0, 10, 1.0
"""Smallest jump after a sensor began to work [m], also in steps of its resolution, which differ tenfold in pressures of
few digits [1], and how long the log has to rest after it [s]."""
_CURVE = 8
"""Number of samples before and after a step through which a curve shows its size. [1]"""
_LOW_PART, _CLEAR_STEP, _CLEAR_NOISES = 0.15, 10.0, 8.0
"""Part of the climb below which a logger notices a flight [1], and the smallest step that shows there without such a
speed, in meters and in the noise of the heights around it: above it the gas of a charge makes such steps."""
_LEVELS, _TERRAIN, _EXPLAINED = 0.1, 20.0, 0.5
"""Largest difference of a step and of the levels at rest: as a fraction of the step [1] and of the terrain [m] in sum,
and as a fraction of the step alone, because a step by a shock or a charge leaves the levels as they were [1]."""


def on_one_zero(time: Float[Array, "row"], height: Float[Array, "row"]) -> Float[Array, "row"]:
    """Heights on the zero that a logger set in flight, before it too; unchanged if it set none. [s], [m]"""
    known = np.flatnonzero(np.isfinite(height) & np.isfinite(time))
    when, high = time[known], height[known]
    last = int(np.argmax(np.abs(np.diff(high)))) if known.size > 1 else 0
    if not 2 * _SAMPLES <= last <= known.size - 2 * _SAMPLES:
        return height
    step, lasts = float(high[last + 1] - high[last]), float(when[last + 1] - when[last])
    begin, end = high[:_SAMPLES], high[-_SAMPLES:]
    moved = float(np.median(end) - np.median(begin))
    rests = max(np.ptp(begin), np.ptp(end)) < _AT_REST
    shown, noise = _step_beside_a_curve(when, high, last)
    low = abs(float(high[last]) - float(np.median(begin))) < _LOW_PART * float(np.ptp(high))
    clear = low and abs(shown) > max(_CLEAR_STEP, _CLEAR_NOISES * noise)
    size = abs(shown if clear else step)
    most = min(_LEVELS * size + _TERRAIN, _EXPLAINED * size)
    unexplained = abs((shown if clear else step) - moved) > most
    if not rests or unexplained or (abs(step) < _STEP_SPEED * lasts and not clear):
        return height
    return np.where(np.arange(height.size) <= known[last], height + shown, height)


def _step_beside_a_curve(time: Float[Array, "row"], height: Float[Array, "row"], last: int) -> tuple[float, float]:
    """The step of heights after a row beside one curve through those around it, and their noise. [s], [m]"""
    around = np.r_[last - _CURVE + 1 : last + 1 + _CURVE]
    curve = np.column_stack([np.vander(time[around] - time[last], 4), np.arange(around.size) >= _CURVE])
    shape, *_ = np.linalg.lstsq(curve, height[around], rcond=None)
    return float(shape[-1]), float(np.std(height[around] - curve @ shape))


def without_start_up(time: Float[Array, "row"], height: Float[Array, "row"], resolution: float) -> Float[Array, "row"]:
    """Heights without the value that a sensor returned before it worked, a receiver without a fix, or a filter before
    its first reading: a log begins with it and jumps from it to a level at rest. [s], [m]"""
    changes = np.flatnonzero(np.diff(height) != 0)
    first = int(changes[0]) + 1 if changes.size else 0
    until = max(first + _SAMPLES, int(np.searchsorted(time, time[first] + _REST_TIME)))
    if not first or until >= height.size:
        return height
    rest = height[first:until]
    jump = abs(float(np.median(rest)) - float(height[0]))
    moves = jump > max(_START_UP, _MANY_STEPS * resolution) and float(np.ptp(rest)) < jump / 10
    return np.where(np.arange(height.size) < first, np.nan, height) if moves else height


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

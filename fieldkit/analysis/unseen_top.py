"""An apogee that no sample recorded: a radio lost its rocket, or a logger its power, around the top.

The last samples before the gap give the rocket's height and speed. From there it coasted: without drag it would have
risen by another v²/2g, with the drag at that time by less, and with an early ejection by less still. So the apogee lies
between the highest sample and that bound.

Derivation: with drag in proportion to v², D times the weight at speed v, the rise is ln(1 + D)/D times v²/2g and takes
arctan(sqrt(D))/sqrt(D) times v/g.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Event, Figure
from fieldkit.physics.standard_atmosphere import GRAVITY

_SILENT, _STEPS = 2.0, 5.0
"""Shortest time without a sample [s], and number of typical sample intervals [1], that form a gap around the top."""
_MAX_TIME_FROM_SILENCE = 1.0
"""Largest time between the highest smoothed sample and the gap for the gap to contain the top. [s]"""
_RISE_WINDOW, _LEAST_RISE_SAMPLES, _RISE_SDS = 1.5, 6, 3.0
"""How long after a gap the heights show whether they still rise [s], in how many samples, and how many standard
deviations the climb rate must be above zero [1]."""
_LARGEST_SD, _COASTED = 0.01, 0.5
"""Largest standard deviation of an apogee after the end of a log, as a fraction of it [1]. Shortest coast that shows
that the end was not in the boost [s]."""
_RISING_SPEED = 3.0
"""If the rocket was slower than this when the gap began, it was already at apogee. [m/s]"""
_SPEED_ERROR = 0.02
"""Smallest relative error of a speed. [1]"""
_DRAG = 0.35
"""Relative error of the duration of this coast. [1]"""
_DRAG_WINDOW = 1.0
"""Length of the window before the gap in which the drag is measured, if it coasted that long. [s]"""
_THRUST_WINDOW = 0.3
"""Length of the window before the gap in which it is determined whether the rocket still accelerates. [s]"""


def silence(track: Heights, seen: Outline) -> tuple[float, float] | None:
    """Start and end of a gap in the heights around the top of a climb; None if the top was recorded. [s]"""
    steps = np.diff(track.time)
    after = np.flatnonzero(track.time[:-1] > (seen.lift if seen.lift is not None else seen.fastest))
    if not after.size:
        return None
    usual = float(np.median(steps[max(0, after[0] - 20) : after[0] + 20]))
    long = after[steps[after] > max(_SILENT, _STEPS * usual)]
    near = [
        place
        for place in long.tolist()
        if track.time[place] - _MAX_TIME_FROM_SILENCE <= seen.top <= track.time[place + 1] + _MAX_TIME_FROM_SILENCE
        and not _rises(track, float(track.time[place + 1]))
    ]
    if not near:
        return None
    return float(track.time[near[0]]), float(track.time[near[0] + 1])


def _rises(track: Heights, begin: float) -> bool:
    """Whether the heights clearly still rise when a gap ends, so that the top follows: by the slope there of a parabola
    through the samples of the next moments."""
    inside = (track.time >= begin) & (track.time < begin + _RISE_WINDOW)
    if inside.sum() < _LEAST_RISE_SAMPLES:
        return False
    since = track.time[inside] - begin
    design = np.stack([np.ones(since.size), since, since**2], axis=1)
    values, *_ = np.linalg.lstsq(design, track.height[inside], rcond=None)
    left = track.height[inside] - design @ values
    noise = max(track.noise, float(np.sqrt(left @ left / (since.size - 3))))
    error = noise * float(np.sqrt(np.linalg.inv(design.T @ design)[1, 1]))
    return bool(values[1] > _RISE_SDS * error)


def accelerates(ascent: Ascent, moment: float) -> bool:
    """Whether the rocket is still under thrust at a time [s]: it speeds up, while a coast only slows down."""
    before = (ascent.time > moment - _THRUST_WINDOW) & (ascent.time <= moment)
    return not before.any() or float(ascent.acceleration[before].mean()) > 0


def unseen_apogee(
    track: Heights, seen: Outline, ascent: Ascent, gap: tuple[float, float], slowest: float = _RISING_SPEED
) -> tuple[Event, Figure, tuple[float, float]] | None:
    """Apogee in a gap, and the heights that it lies between [m]; None if the rocket had reached its top before: it was
    slower than `slowest` [m/s].

    The figure assumes a coast with the last measured drag; its standard deviation covers both bounds. The upper one
    allows for the error of the speed: static ports that are off by s v²/2g of height are off by s a/g of a speed v that
    decreases by a.
    """
    begin, end = gap
    until = ascent.time <= begin
    burnout = ascent.time[int(np.argmax(np.where(until, ascent.speed, -np.inf)))]
    before = until & (ascent.time > max(begin - _DRAG_WINDOW, min(burnout, begin - _THRUST_WINDOW)))
    if before.sum() < 3:
        return None
    speed = float(np.interp(begin, ascent.time, ascent.speed))
    if speed < slowest:
        return None
    height = float(np.interp(begin, ascent.time, ascent.height))
    slows = max(-float(ascent.acceleration[before].mean()), GRAVITY) / GRAVITY
    ports = STATIC_SD * slows if track.is_barometric else 0.0
    speed_sd = float(np.hypot(ascent.speeds[:, before][:, -1].std(), speed * np.hypot(ports, _SPEED_ERROR)))
    drag = max(slows - 1, 0.0)
    free = speed**2 / (2 * GRAVITY)
    rise = free * float(np.log1p(drag) / drag) if drag > 1e-3 else free
    lasts = speed / GRAVITY * float(np.arctan(np.sqrt(drag)) / np.sqrt(drag)) if drag > 1e-3 else speed / GRAVITY
    back = np.interp(end, track.time, seen.calm) - seen.pad
    low = max(height, float(back))
    top = max(height + rise, low)
    high = max(height + (max(speed, 0.0) + 2 * speed_sd) ** 2 / (2 * GRAVITY), top)
    spread = max(height + free - top, min(top - low, rise), 0.0) / 2
    sd = float(np.sqrt(spread**2 + (speed * speed_sd / GRAVITY) ** 2 + track.noise**2 + seen.pad_sd**2))
    moment = min(begin + lasts, end)
    return Event(moment, max(0.2, _DRAG * abs(lasts)), track.source), Figure(top, sd, track.source), (low, high)


def apogee_after_end(track: Heights, seen: Outline, ascent: Ascent) -> tuple[Event, Figure, tuple[float, float]] | None:
    """Apogee of a log that ends shortly before it, or just after, as for one in a gap; None if the rocket may still
    have gone far. Returns its time [s], its height [m], and the heights that it lies between [m]."""
    end = min(float(track.time[-1]), float(ascent.time[-1]))
    fastest = float(ascent.time[int(np.argmax(ascent.speed))])
    if end - fastest < _COASTED or accelerates(ascent, end):
        return None
    found = unseen_apogee(track, seen, ascent, (end, np.inf), slowest=-_RISING_SPEED)
    return found if found is not None and found[1].sd < _LARGEST_SD * found[1].value else None

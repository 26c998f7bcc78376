"""An apogee that no sample saw: a radio lost its rocket, or a logger its power, about the top.

The last samples before the silence say how high and how fast the rocket was. From there it coasted: without drag it
would have risen by v²/2g more, with the drag that slowed it then by less, and if a charge went early by less still.
So the apogee lies between the highest sample and that bound.

Derivation: with drag in proportion to v², D times the weight at speed v, the rise is ln(1 + D)/D times v²/2g and takes
arctan(sqrt(D))/sqrt(D) times v/g.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event, Figure
from fieldkit.physics.standard_atmosphere import GRAVITY

_SILENT, _STEPS = 2.0, 5.0
"""No sample for so long [s], and for so many of their usual steps [1], about its top is a silence."""
_MAX_TIME_FROM_SILENCE = 1.0
"""The highest of smoothed samples is so near to a silence that has the top. [s]"""
_RISING = 3.0
"""A rocket that was slower when the silence began was at its top. [m/s]"""
_DRAG = 0.35
"""How far the time of such a coast is off, to itself. [1]"""
_DRAG_WINDOW = 1.0
"""So long before it the drag is looked at. [s]"""


def silence(track: Heights, seen: Outline) -> tuple[float, float] | None:
    """From when to when no height was taken about the top of a climb, None if it was seen. [s]"""
    steps = np.diff(track.time)
    after = np.flatnonzero(track.time[:-1] > seen.fastest)
    if not after.size:
        return None
    usual = float(np.median(steps[max(0, after[0] - 20) : after[0] + 20]))
    long = after[steps[after] > max(_SILENT, _STEPS * usual)]
    near = [
        place
        for place in long.tolist()
        if track.time[place] - _MAX_TIME_FROM_SILENCE <= seen.top <= track.time[place + 1] + _MAX_TIME_FROM_SILENCE
    ]
    if not near:
        return None
    return float(track.time[near[0]]), float(track.time[near[0] + 1])


def unseen_apogee(
    track: Heights, seen: Outline, ascent: Ascent, hole: tuple[float, float]
) -> tuple[Event, Figure, tuple[float, float]] | None:
    """Apogee in a silence, and the heights that it lies between [m]; None if the rocket was at its top before.

    The figure is the coast with the drag that slowed the rocket last; its standard deviation spans from there to
    either bound.
    """
    begin, end = hole
    before = (ascent.time > begin - _DRAG_WINDOW) & (ascent.time <= begin)
    if before.sum() < 3:
        return None
    speed = float(np.interp(begin, ascent.time, ascent.speed))
    if speed < _RISING:
        return None
    height = float(np.interp(begin, ascent.time, ascent.height))
    speeds = ascent.speeds[:, before][:, -1]
    drag = max(-float(ascent.acceleration[before].mean()) / GRAVITY - 1, 0.0)
    free = speed**2 / (2 * GRAVITY)
    rise = free * float(np.log1p(drag) / drag) if drag > 1e-3 else free
    lasts = speed / GRAVITY * float(np.arctan(np.sqrt(drag)) / np.sqrt(drag)) if drag > 1e-3 else speed / GRAVITY
    back = np.interp(end, track.time, seen.calm) - seen.pad
    low = max(height, float(back))
    top = max(height + rise, low)
    high = max(height + free, top)
    spread = max(high - top, min(top - low, rise)) / 2
    sd = float(np.sqrt(spread**2 + (speed * speeds.std() / GRAVITY) ** 2 + track.noise**2 + seen.pad_sd**2))
    moment = min(begin + lasts, end)
    return Event(moment, max(0.2, _DRAG * lasts), track.source), Figure(top, sd, track.source), (low, high)

"""Heights that no rocket can have reached: steps faster than any thrust, and falls faked by shocks.

A sensor, its converter or a radio may report a wrong level for seconds, too long for a filter of single samples. Near
the speed of sound, shocks sit on a rocket's static ports: the pressure behind them is that of another height for as
long as the rocket is near that speed. These samples are removed before anything is measured.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fieldkit.analysis.channels import MIN_SAMPLES, Heights
from fieldkit.analysis.robust_statistics import running_median, running_median_over
from fieldkit.shapes import Flags

_MAX_ACCELERATION = 2000.0
"""Acceleration that no hobby airframe survives. [m/s^2]"""
_LASTING_TIME = 15.0
"""A level that lasts longer than this is not a temporary fault. [s]"""
_BACK = 0.5
"""A fault's return step equals its first step to within this fraction. [1]"""
_MAX_STEP_GAP = 3
"""Steps of one sign within this many samples count as one. [1]"""
_REST_TIME, _NOTICED = 2.0, 0.5
"""Time before a step in which a rocket that waits stays at one height, but for the time in which a logger notices a
flight. [s]"""
_MIN_STEP = 10.0
"""Smaller steps are left to the fit. [m]"""
_SCATTER_WINDOW = 2.0
"""Time around a step whose other samples show how much heights scatter there, as under a parachute that swings. [s]"""
_SPEED_OF_SOUND = 335.0
_NEAR_SONIC_SPEED = 0.4 * _SPEED_OF_SOUND
"""Mean speed from before an apparent fall to after it above which the rocket was near the speed of sound. The mean over
such a climb is lower than the speed of sound. [m/s]"""
_CLIMB_RATE_TIME = 0.5
"""Time before and after a step over which the climb rate shows whether the rocket was near the speed of sound. [s]"""
_MARGIN = 0.15
"""How long before and after an apparent fall shocks disturb the pressure. [s]"""
_MIN_FALL_SDS = 12.0
"""Smallest apparent fall, as a multiple of the noise of a sample. [1]"""
_FALL = 5.0
"""Smallest apparent fall, however small the noise. [m]"""


def undisturbed(track: Heights) -> Heights:
    """Heights without those faked by steps and shocks; `disturbed` if shocks faked some.

    If hardly any samples would remain, the heights are returned unchanged.
    """
    track = _on_one_zero(track)
    kept = ~_steps(track)
    if not kept.all() and kept.sum() >= MIN_SAMPLES:
        track = replace(track, time=track.time[kept], height=track.height[kept])
    fallen = _shocks(track)
    if fallen.any() and (~fallen).sum() >= MIN_SAMPLES:
        return replace(track, time=track.time[~fallen], height=track.height[~fallen], disturbed=True)
    return track


def _on_one_zero(track: Heights) -> Heights:
    """Heights of a logger that sets its zero while it waits or when it notices the flight: what it recorded at rest
    before a step down toward zero, which no rocket makes and no later step reverses, is moved to zero."""
    jumps = list(_jumps(track))
    for n, (place, size) in enumerate(jumps):
        since = track.time - track.time[place]
        before = track.height[(since > -_REST_TIME) & (since < -_NOTICED)]
        rests = before.size > 2 and float(np.ptp(before)) < max(_MIN_STEP, _MIN_FALL_SDS * track.noise)
        lasts = not any(_reverses(track, (place, size), one) for one in jumps[n + 1 :])
        if size < -2 * _MIN_STEP and rests and lasts and abs(track.height[place + 1]) < np.median(before) / 2:
            return replace(track, height=track.height - np.where(since <= 0, np.median(before), 0.0))
    return track


def _steps(track: Heights) -> Flags:
    """Samples between a step and the one that reverses it, or from a last step that is not reversed to the end."""
    wrong = np.zeros(track.time.size, bool)
    jumps = list(_jumps(track))
    place = 0
    while place < len(jumps):
        begin, size = jumps[place]
        back = next((n for n in range(place + 1, len(jumps)) if _cancels(track, jumps[place], jumps[n])), None)
        if back is not None:
            wrong[begin + 1 : jumps[back][0] + 1] = True
            place = back + 1
            continue
        if place == len(jumps) - 1 and size > 0 and track.time[-1] - track.time[begin] < _LASTING_TIME:
            wrong[begin + 1 :] = True
        place += 1
    return wrong


def _cancels(track: Heights, there: tuple[int, float], back: tuple[int, float]) -> bool:
    """Whether a later step reverses an earlier one. Disturbances by shocks in a fast climb do not count."""
    before, after = there[0], back[0] + 1
    climbs = track.height[after] - track.height[before] > _NEAR_SONIC_SPEED * (track.time[after] - track.time[before])
    return _reverses(track, there, back) and not climbs


def _reverses(track: Heights, there: tuple[int, float], back: tuple[int, float]) -> bool:
    """Whether a later step is about as large as an earlier one, and opposite. Its height is in m."""
    lasts = track.time[back[0] + 1] - track.time[there[0]]
    opposite = abs(there[1] + back[1]) < _BACK * max(abs(there[1]), abs(back[1]))
    return bool(lasts < _LASTING_TIME and there[1] * back[1] < 0 and opposite)


def lasting_step(track: Heights, begin: float, end: float) -> tuple[float, float] | None:
    """Time [s] and size [m] of the largest upward step between two times that no later step reverses; None without one.

    Derivation: by Bernoulli's equation, a bay that opens in flight shows a pressure that is lower by a fraction of the
    dynamic pressure. So the heights before and after the step are not of one climb. Near the speed of sound shocks
    cause steps, so those of fast climbs do not count.
    """
    jumps = list(_jumps(track))
    lasting = [
        (float(track.time[place]), size)
        for n, (place, size) in enumerate(jumps)
        if begin <= track.time[place] <= end
        and size > 0
        and not any(_reverses(track, (place, size), later) for later in jumps[n + 1 :])
        and not _is_fast_around(track, place)
    ]
    return max(lasting, key=lambda one: one[1], default=None)


def _is_fast_around(track: Heights, place: int) -> bool:
    """Whether the heights climb near the speed of sound shortly before or after a step."""
    time, height = track.time, track.height
    before, after = max(place - _MAX_STEP_GAP, 0), min(place + 1 + _MAX_STEP_GAP, time.size - 1)
    ends = np.interp((time[before] - _CLIMB_RATE_TIME, time[after] + _CLIMB_RATE_TIME), time, height)
    return bool(max(height[before] - ends[0], ends[1] - height[after]) > _NEAR_SONIC_SPEED * _CLIMB_RATE_TIME)


def _jumps(track: Heights) -> Iterator[tuple[int, float]]:
    """The sample before each step, and the size of the step beyond what the surrounding heights do. [m]"""
    step, change = np.diff(track.time), np.diff(track.height)
    usual = running_median(change / step, 9) * step
    excess = change - usual
    usual_excess = 1.4826 * running_median_over(track.time[1:], np.abs(excess), _SCATTER_WINDOW, 11, 201)
    noise = np.maximum(track.noise, usual_excess)
    beyond = np.abs(excess) > np.maximum(_MAX_ACCELERATION * step**2 + 8 * noise, _MIN_STEP)
    last, total = -1, 0.0
    for place in np.flatnonzero(beyond).tolist():
        size = float(excess[place])
        if last >= 0 and place - last <= _MAX_STEP_GAP and size * total > 0:
            last, total = place, total + size
            continue
        if last >= 0:
            yield last, total
        last, total = place, size
    if last >= 0:
        yield last, total


def _shocks(track: Heights) -> Flags:
    """Samples of the climb in which the rocket appears to fall though it rises near the speed of sound."""
    time, height = track.time, track.height
    calm = running_median_over(time, height, 1.0, 3, 201)
    top = int(np.argmax(calm))
    wrong = np.zeros(time.size, bool)
    if top < 3:
        return wrong
    climb = height[: top + 1]
    highest = np.maximum.accumulate(climb)
    for first, last in _runs(highest - climb > max(_MIN_FALL_SDS * track.noise, _FALL)):
        before = int(np.searchsorted(highest, highest[first]))
        after = min(last + 1, top)
        if climb[after] - climb[before] > _NEAR_SONIC_SPEED * (time[after] - time[before]):
            begin = np.searchsorted(time, time[before] - _MARGIN)
            wrong[begin : np.searchsorted(time, time[after] + _MARGIN)] = True
    return wrong


def _runs(marked: Flags) -> Iterator[tuple[int, int]]:
    """First and last index of each run of marked samples."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], marked.astype(np.int8), [0]))))
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        yield begin, end - 1

"""When the charge that ejects a parachute fired: as the logger marked it, as it was felt, or as it braked a fall.

Derivation: a fall that nothing brakes gains speed at nearly one g, and a parachute ends that at once.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fieldkit.analysis.channels import Heights, Push
from fieldkit.analysis.forces import CHERNOFF_SD
from fieldkit.analysis.records import Event
from fieldkit.analysis.robust_statistics import local_slopes, mad_sd, median_step
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_CHARGES = ("ejection", "drogue")
"""Logger events that mark the first charge to deploy a parachute."""
_MARK_SD, _SAME_TIME = 0.1, 0.3
"""Standard deviation of the time of a logger's event, and the longest time from it to what its own charge does. [s]"""
EARLIEST_CHARGE, _UNSEEN_SD = 1.2, 0.65
"""Longest time from a charge to an apogee that follows it, because the parachute ends the climb (of 58 flights in one
journal none took longer), and the standard deviation of a time from then to a second after apogee, until which a fall
is too slow for its braking to be seen. [s]"""
_SHOCK = 4 * GRAVITY
"""An acceleration this strong after burnout is not drag but a charge or a line going taut. [m/s^2]"""
_AT_ITS_END = 0.999
"""Fraction of the end of a range above which an accelerometer is saturated. [1]"""
_CLIMB_LEFT = 3.0
"""Longest climb after a charge: even under a streamer that falls at v = 15 m/s drag ends it within pi/2 v/g. [s]"""
_RISE, _CHARGE_LASTS = 0.02, 0.02
"""Longest rise time of a shock: the charge fired anything up to that earlier; and for how long the gas of a charge
pushes the airframe (in four real logs of 100 samples per second one or two samples show it). [s]"""
_LATEST_OPENING, _OPENING_WAY = 1.0, 8.0
"""Longest time from a charge to the shock of the parachute [s], and the longest way until then: by the physics of
`fieldkit.physics.descent`, eight diameters of a canopy of one meter [m]."""
_FREE_FALL = 0.55
"""Least mean acceleration of a fall that nothing brakes but the air around the rocket, as a fraction of gravity. [1]"""
_FALL_WINDOW, _BRAKED_WITHIN = 0.8, 1.5
"""Time over which the speed of a fall is taken, and time within which a parachute takes half of it away. [s]"""
_LEVEL_TIME, _SEEN_FALL = 0.3, 5.0
"""Time over which heights show where a fall began and ended [s], and the least difference that shows a free one [m]."""
_FEWEST_LEVELS = 5
"""Fewest heights of a coarse resolution through which a fall shows where its speed ended. [1]"""
_LEAST_BRAKING = 4.0
"""Least of the strongest braking by a parachute that opens, as a multiple of gravity. [1]"""
_HOLE = 3.5
"""Least number of sample intervals without a sample in which a charge may have fired unseen. [1]"""
_BASELINE_TIME = 0.4
"""Length of the window before a shock that gives the drag from which the shock stands out. [s]"""


def shock(push: Push | None, burnout: float, top: float) -> Event | None:
    """The first shock that an accelerometer felt around apogee, given the times of `burnout` and `top` [s]. One that
    was saturated in the boost shows no more of a shock than the end of its range."""
    if push is None or push.vertical:
        return None
    near = (push.time > max(burnout + 0.7, top - _CLIMB_LEFT)) & (push.time < top + 15)
    time, felt = push.time[near], push.felt[near]
    if time.size < 8:
        return None
    away = np.minimum(np.abs(felt - np.median(felt)), np.abs(felt - _before(time, felt)))
    shocks = np.flatnonzero((away > max(_SHOCK, 8 * mad_sd(felt))) | (felt > _AT_ITS_END * push.range_end))
    if shocks.size == 0:
        return None
    begin, end = time[max(int(shocks[0]) - 1, 0)], time[shocks[0]]
    return Event(
        float((begin + end) / 2), float(np.hypot((end - begin) / np.sqrt(12), _RISE / np.sqrt(3))), push.source
    )


def perhaps_of_opening(shocks: Event, push: Push, speed: float) -> Event:
    """A shock that may be that of the parachute, because the charge before it was not felt, at a speed [m/s].

    Derivation: a charge that is over between two samples is not felt, with the probability that none of them is within
    its duration. Then it fired at any time before the shock in which a parachute opens, with the root mean square of an
    even distribution; the faster the rocket, the sooner it has gone the way on which a parachute fills.
    """
    first = int(np.clip(np.searchsorted(push.time, shocks.time), 1, push.time.size - 1))
    unfelt = max(1 - _CHARGE_LASTS / float(push.time[first] - push.time[first - 1]), 0.0)
    opens = min(_LATEST_OPENING, _OPENING_WAY / max(abs(speed), 1e-3))
    return replace(shocks, sd=float(np.hypot(shocks.sd, opens * np.sqrt(unfelt / 3))))


def _before(time: Float[Array, "sample"], felt: Float[Array, "sample"]) -> Float[Array, "sample"]:
    """Median of what was felt just before each sample: the drag of a fast coast, which fades but does not jump."""
    width = max(3, round(_BASELINE_TIME / median_step(time)))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(felt, (width, 0), mode="edge")[:-1], width)
    return np.asarray(np.median(windows, axis=1))


def ejection(
    stated: Mapping[str, float], shocks: Event | None, track: Heights, apogee: Event, landed: Event | None
) -> Event | None:
    """When the first charge fired in the air: as the logger marked it, as it was felt, or when the fall was braked.

    A logger marks when it switched its output on, whether a charge is connected or the motor ejects. So a shock, or a
    braking after a free fall, is believed more than a mark that is not at its time. If the samples show neither, the
    mark is as probable as any other time at which a charge would not have been seen.
    """
    marked = next((stated[name] for name in _CHARGES if name in stated), np.inf)
    if marked >= (landed.time if landed else np.inf):
        return _seen(shocks, track, apogee, landed)
    event = Event(float(marked), _MARK_SD, "drogue event of the logger")
    if shocks and shocks.time < apogee.time - EARLIEST_CHARGE:
        shocks = None  # no parachute opened then: the climb did not end
    seen = _seen(shocks, track, apogee, landed)
    if seen is None:
        return replace(event, sd=float(np.hypot(_MARK_SD, _UNSEEN_SD / np.sqrt(2))))
    return event if abs(seen.time - event.time) < _SAME_TIME else seen


def _seen(shocks: Event | None, track: Heights, apogee: Event, landed: Event | None) -> Event | None:
    """When a charge was felt, or a parachute braked a free fall; None if the samples show neither."""
    if shocks and (landed is None or shocks.time < landed.time - 3 * landed.sd):
        return None if _hangs(track, apogee, shocks) else shocks
    return _braked(track, apogee, landed.time - 1 if landed else np.inf)


def _hangs(track: Heights, apogee: Event, shocks: Event) -> bool:
    """Whether a rocket fell so slowly before its first shock that it hung from a parachute, whose charge was not felt:
    it is over between two samples."""
    falls = shocks.time - apogee.time - apogee.sd
    just = (track.time > shocks.time - _LEVEL_TIME) & (track.time <= shocks.time)
    high = np.abs(track.time - apogee.time) < _LEVEL_TIME
    if falls <= 0 or not just.any() or not high.any():
        return False
    fell = float(np.median(track.height[high]) - np.median(track.height[just]))
    freely = _FREE_FALL * GRAVITY * max(falls - _LEVEL_TIME / 2, 0.0) ** 2 / 2
    return fell < freely - max(_SEEN_FALL, 3 * track.noise)


def _braked(track: Heights, apogee: Event, down: float) -> Event | None:
    """When a free fall of some length became a steady descent in the air; None if it did not.

    If the fall was braked before it became faster than the parachute allows, it cannot be distinguished from ejection
    at apogee, and nothing is reported. Nor is it if the fall was slower at any earlier time than a free one: then it is
    the swinging of a rocket that a parachute already brakes; nor if it stays as fast: then a drogue was open, which
    allows that speed, and a main braked it later.

    Derivation: the slope of heights over a window of 2h is a mean of the speeds there, with the weights of a parabola.
    It is highest when the speed is if the braking is as strong as gravity, and earlier if it is stronger: evenly
    distributed in between, this has the root mean square of the largest shift over sqrt(3). Around its maximum the mean
    falls by at least 2g 3/4h t²/2, and noise n of heights d apart adds a Brownian motion of variance 72 n² d/(2h)^4 t,
    whose maximum has Chernoff's distribution. Behind a first-order lag T, a speed that gains g and then loses d g is
    highest where both speeds meet: about T/(1 + d) late, and not T late as the top of a coast is.
    """
    span = (track.time > apogee.time - 0.5) & (track.time < min(apogee.time + 15, down))
    time, height = track.time[span], track.height[span]
    if time.size < 20:
        return None
    step = median_step(time)
    even = np.arange(time[0], time[-1], max(step, 0.05))
    width = max(5, round(_FALL_WINDOW / max(step, 0.05))) | 1
    if even.size < 2 * width:
        return None
    speed = local_slopes(np.interp(even, time, height), width, even[1] - even[0])
    middle = even[width // 2 : -(width // 2)]
    after = middle > apogee.time
    fall, when = -speed[after], middle[after]
    final_speed = float(np.median(fall[-len(fall) // 3 :]))
    fastest = int(np.argmax(fall))
    fell = float(np.interp(apogee.time, time, height) - np.interp(when[fastest], time, height))
    if fell < _FEWEST_LEVELS * track.held:  # of so few levels the heights show no acceleration
        return None
    blur = 3 * track.noise / (width * (even[1] - even[0]))
    freely = _FREE_FALL * GRAVITY * (when - apogee.time)
    late = when[fastest] - apogee.time
    if (
        fall[fastest] < 1.5 * final_speed + max(2.0, blur)
        or fall[fastest] < _FREE_FALL * GRAVITY * late
        or fastest > 0.8 * fall.size
        or float(np.interp(when[fastest] + _BRAKED_WITHIN, when, fall)) > (fall[fastest] + final_speed) / 2
        or (fall[:fastest] < freely[:fastest] - max(2.0, blur) - GRAVITY * apogee.sd).any()
    ):
        return None
    half = width * (even[1] - even[0]) / 2
    sharp = 2 * GRAVITY * 0.75 / half
    walk = float(np.sqrt(72 * median_step(time))) * track.noise / (2 * half) ** 2
    moved = CHERNOFF_SD * (2 * walk / sharp) ** (2 / 3)
    braking = max((float(fall[fastest]) / max(final_speed, 1.0)) ** 2 - 1, _LEAST_BRAKING)
    early = half * _shift(braking)
    fired = float(when[fastest]) + track.shift - track.bend / (1 + braking)
    behind = float(np.hypot(track.bend / (1 + braking) / 2, track.lag_sd * braking / (1 + braking)))
    braked = Event(fired, float(np.linalg.norm([early / np.sqrt(3), moved, behind, track.top_held])), track.source)
    return _in_hole(time[(time > when[fastest] - 2 * half) & (time < when[fastest])], step, braked)


def _in_hole(before: Float[Array, "_"], step: float, braked: Event) -> Event:
    """When a charge fired whose gas disturbed the heights so much that samples are missing before the fall is braked:
    at any time since, with equal probability. `before` are the times of the samples before it, usually a `step` apart.
    """
    holes = np.flatnonzero(np.diff(before) > _HOLE * step)
    if not holes.size:
        return braked
    since = braked.time - float(before[holes[0]])
    return replace(braked, time=braked.time - since / 2, sd=float(np.hypot(braked.sd, since / np.sqrt(12))))


def _shift(braking: float) -> float:
    """How much earlier than a speed its mean with the weights of a parabola is highest, as a fraction of half its
    width, if a parachute brakes by so many times gravity at once.

    Derivation: it is where the part 1/(1 + d) of the weights is after the highest speed, because gravity and a braking
    of d times gravity cancel there; d is the square of how many times faster than its final speed the rocket is, minus
    one, and four in an opening parachute at least.
    """
    before = np.linspace(-1.0, 0.0, 101)
    part = 0.5 + 0.75 * (before - before**3 / 3)
    return -float(np.interp(1 / (1 + braking), part, before))

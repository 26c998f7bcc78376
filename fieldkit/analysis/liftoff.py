"""Time of lift-off."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldkit.analysis.channels import MIN_SAMPLES, Heights, Push
from fieldkit.analysis.hard_boost import checked_by_climb
from fieldkit.analysis.phases import LEAST_GAIN, LONGEST_CLIMB, TERRAIN_SD, Outline
from fieldkit.analysis.records import Event
from fieldkit.analysis.robust_statistics import hole_at, mad_sd, median_step, running_median
from fieldkit.integrals import running_integral
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float, Int, Integers

_THRUST = 2 * GRAVITY
"""Specific force that a rocket does not feel before lift-off. [m/s^2]"""

_FEW_SAMPLES = 3
"""Fewest samples of an accelerometer that show thrust. [1]"""
_FIRST_TIME = 0.5
"""Time from the first sample of an accelerometer in which heights show a first speed. [s]"""
_IGNITION = 0.02
"""Longest time in which most motors rise from their rocket's weight to a fifth of their mean net thrust: lift-off is
earlier by anything up to that. Of the catalog, with the classes weighted equally, it is the root mean square, of a few
motors that rise slowly (a test recomputes it): so the usual error of a lift-off is smaller than its standard deviation.
[s]"""

_SPEED_AT_BOOST_START = 0.05
"""Fraction of the speed at burnout that a rocket has at the start of its boost. [1]"""

_LEAST_DIVE, _LONGEST_DIVE = 3.0, 3.0
"""Least depth [m] and longest duration [s] of a dive below the pad before the rise of a hard boost."""
_STEP, _QUICK_STEP = 0.01, 0.03
"""Steps between the lift-off times to try: for lift-off, and for how a lag shifts it. [s]"""
_RIDGE, _TINY = 1e-10, 1e-30
"""Regularization of a fit to columns of norm 1, and the smallest norm of a column that is not zero. [1]"""


def liftoff(track: Heights, push: Push | None, seen: Outline) -> Event | None:
    """Lift-off from the accelerometer if possible, otherwise from the rise off the pad; None if neither shows it."""
    felt = _by_push(push, track, seen) if push else None
    if felt is not None:
        return felt
    if seen.lift is None and seen.pad_sd >= TERRAIN_SD:  # the first heights are not above the pad
        return None
    corner = _by_rise(track, seen)
    if corner is not None and track.is_barometric:
        corner = _by_dive(corner, track, seen) or corner
    if corner is not None and push is not None and _is_under_way(push, corner):
        return None
    if corner is not None and push is not None and push.time[0] > corner.time:
        return _with_first_speed(corner, push, track)
    return checked_by_climb(corner, track, seen) if corner is not None and track.is_barometric else corner


def earlier_liftoffs(lift: Event, track: Heights, seen: Outline, lags: Sequence[float]) -> list[Event]:
    """A lift-off from heights, corrected for each of some lags by which they may be late. [s]"""
    if lift.source != track.source:
        return [lift] * len(lags)
    corners = [_by_rise(track, seen, lag, _QUICK_STEP) for lag in (0.0, *lags)]
    times = [one.time if one else lift.time for one in corners]
    return [replace(lift, time=lift.time - max(times[0] - one, 0.0)) for one in times[1:]]


def felt_boost(push: Push, seen: Outline) -> Outline | None:
    """The outline with the boost that an accelerometer felt on the way up: shocks and static ports may hide the start
    and the end of a fast one from the heights. None if it felt no thrust from a rest on."""
    climb = (push.time > seen.top - LONGEST_CLIMB) & (push.time < seen.top)
    time, net = push.time[climb], push.felt[climb] - GRAVITY
    if time.size < 8:
        return None
    pushed = _pushed(time, net)
    if pushed.start < 3 or float(np.median(net[pushed])) < _THRUST - GRAVITY:
        return None
    return replace(seen, lift=float(time[pushed.start]), fastest=float(time[pushed.stop - 1]))


def _is_under_way(push: Push, corner: Event) -> bool:
    """Whether the accelerometer felt thrust from its first sample on, so that lift-off was before a corner of the
    heights, which static ports may hold back; if few samples are before the corner, the first ones decide."""
    before = push.felt[push.time < corner.time - corner.sd]
    if not before.size and push.time[0] <= corner.time:
        before = push.felt[:_FEW_SAMPLES]
    return before.size > 0 and float(before.min()) > _THRUST


def _with_first_speed(corner: Event, push: Push, track: Heights) -> Event:
    """A lift-off before the first sample of an accelerometer by the first heights, averaged with that by their first
    speed, up to half of the difference: a logger that sets its zero in flight hides how high it was, not how fast.

    Derivation: heights are h + v t plus what the accelerometer felt, integrated twice, and a speed v under an
    acceleration a takes a time v/a.
    """
    begin = float(push.time[0])
    first = (push.time < begin + _FIRST_TIME) & np.isfinite(push.felt)
    inside = (track.time >= begin) & (track.time < begin + _FIRST_TIME)
    net = push.felt[first] - GRAVITY
    if first.sum() < _FEW_SAMPLES or inside.sum() < _FEW_SAMPLES or float(net.min()) < _THRUST - GRAVITY:
        return corner
    when = push.time[first]
    gained = np.interp(track.time[inside], when, running_integral(running_integral(net, when), when))
    speed = float(np.polyfit(track.time[inside] - begin, track.height[inside] - gained, 1)[0])
    other = begin - max(speed, 0.0) / float(net[:_FEW_SAMPLES].mean())
    half = (other - corner.time) / 2
    return replace(corner, time=corner.time + half, sd=float(np.hypot(corner.sd, half)))


def _by_push(push: Push, track: Heights, seen: Outline) -> Event | None:
    """Start of the acceleration that lasts until the fastest climb: between the samples where it crosses a fifth of its
    median, with equal probability, because thrust rises faster than most loggers sample."""
    about = _about(push, seen)
    near = (push.time > about - 3) & (push.time <= seen.fastest + 0.05)
    time, felt = push.time[near], push.felt[near] - GRAVITY
    if time.size < 8:
        return None
    quiet = felt[: max(1, min(int(np.searchsorted(time, about - 0.3)), _pushed(time, felt).start))]
    level, noise = float(np.median(quiet)), mad_sd(quiet)
    pushed = _pushed(time, felt - level)
    step, strong = median_step(time), float(np.median(felt[pushed]))
    time, felt = time[: pushed.stop], felt[: pushed.stop]
    bar = level + max(0.2 * (strong - level), 5 * noise, 2.0)
    on_pad = -_THRUST < level < _THRUST - GRAVITY and strong > 0  # otherwise it may begin in the boost or the coast
    if strong < bar + 1 or felt[0] >= bar or not on_pad:
        return None
    width = max(1, round(0.05 / step))
    lasting = np.convolve(felt >= bar, np.ones(width), "full")[width - 1 :] >= 0.8 * width
    crossing = np.flatnonzero(lasting[1:] & (felt[1:] >= bar) & (felt[:-1] < bar))
    if crossing.size == 0:
        return None
    first = crossing[_on_pad(_sustained(crossing, felt, bar), time[crossing], track, seen)]
    hole = float(time[first + 1] - time[first])
    blind = hole if hole > 1.5 * step else step
    sd = float(np.hypot(blind / np.sqrt(12), _IGNITION / np.sqrt(3)))
    return Event(float(time[first] + time[first + 1]) / 2, sd, "acceleration")


def _about(push: Push, seen: Outline) -> float:
    """A first estimate of lift-off: when its heights began to rise or, in a log with so little of the pad that they
    rise from the first sample on, when the accelerometer began to feel the boost. [s]"""
    if seen.lift is not None:
        return seen.lift
    felt = felt_boost(push, seen)
    return felt.lift if felt is not None and felt.lift is not None else seen.fastest - 1.5


def _pushed(time: Float[Array, "_"], net: Float[Array, "_"]) -> slice:
    """The samples in which a rocket gains its speed, by the net acceleration that it feels.

    Heights may show the start of a hard boost too late, or its end if they are few or shocks disturb them.
    """
    speed = running_integral(net, time)
    end = int(np.argmax(speed))
    slow = np.flatnonzero(speed[: end + 1] <= _SPEED_AT_BOOST_START * speed[end])
    return slice(int(slow[-1]) if slow.size else 0, end + 1)


def _sustained(crossing: Int[Integers, "_"], felt: Float[Array, "_"], bar: float) -> int:
    """Index of the crossing that begins the boost: the first after which most of the acceleration is above the bar."""
    for place, index in enumerate(crossing):
        if np.mean(felt[index + 1 :] > bar) > 0.6:
            return place
    return len(crossing) - 1


def _on_pad(chosen: int, crossed: Float[Array, "_"], track: Heights, seen: Outline) -> int:
    """Index of the lift-off among times at which thrust began, of which one was `chosen`. [s]

    If the heights show that the rocket had left the pad by then, as at the ignition of a second stage, it is the one on
    the pad closest to the rise.
    """
    left = np.interp(crossed, track.time, seen.calm) - seen.pad > max(LEAST_GAIN, 8 * track.noise)
    if seen.lift is None or not left[chosen] or left[: chosen + 1].all():
        return chosen
    return int(np.argmin(np.where(left, np.inf, np.abs(crossed - seen.lift))))


def _by_rise(track: Heights, seen: Outline, lag: float = 0.0, spacing: float = _STEP) -> Event | None:
    """The corner at which a flat pad becomes a rise with acceleration and jerk, by least squares.

    A log that begins low in the boost is extrapolated back to the pad's level if the logger recorded it.
    """
    known = seen.lift is not None
    if not known and not track.zeroed:
        return None
    about = seen.lift if seen.lift is not None else float(track.time[0])
    step = median_step(track.time[max(0, np.searchsorted(track.time, about) - 50) :][:100])
    rise = max(30 * track.noise, 0.04 * (seen.top_height - seen.pad), 6.0)
    until = min(_reached(track, seen, about, rise), seen.fastest + step)
    near = (track.time >= about - 2) & (track.time <= until)
    if (near & (track.time > about)).sum() < 4 and known:
        near = (track.time >= about - 2) & (track.time <= about + 4.5 * step)
    time, height = track.time[near], track.height[near] - seen.pad
    if time.size < 5 or (not known and height[0] > rise):
        return None
    corners = np.arange(
        about - (0.6 if known else 1.5), min(until, about + float(np.clip(3 * step, 1.0, 10.0))), spacing
    )
    misfit = _misfits(time, height, corners, known, lag)
    sigma = max(np.sqrt(misfit.min() / max(time.size - 4, 1)), track.noise)
    weight = np.exp(-0.5 * (misfit - misfit.min()) / sigma**2)
    weight /= weight.sum()
    mean = float(weight @ corners)
    sd = float(np.sqrt(weight @ (corners - mean) ** 2))
    if not known and (mean < time[0] - 1.2 or sd > 0.4):
        return None
    early = max(0.0, float(track.time[0]) - mean) / 2
    near_times = track.time[(track.time >= about) & (track.time <= until)]
    blind = max(step, hole_at(track.time, mean), np.diff(near_times).max(initial=0.0)) / 4
    return Event(mean, float(np.sqrt(sd**2 + 0.03**2 + blind**2 + early**2)), track.source)


def _by_dive(corner: Event, track: Heights, seen: Outline) -> Event | None:
    """Lift-off where heights leave the pad downward just before they rise; None if they do not, or if too little of the
    pad is before that to show its level.

    Derivation: static ports that are off by a fraction s of the dynamic pressure lower heights by s v²/2g, in a boost
    with acceleration a by s a/g of the height itself. Where that is more than 1 the heights dive below the pad until
    thrust decreases. Nothing else sinks right before a rocket climbs.
    """
    near = (track.time > corner.time - _LONGEST_DIVE) & (track.time < seen.fastest)
    time = track.time[near]
    if seen.lift is None or time.size < 5:
        return None
    calm = running_median(track.height[near], 5) - seen.pad
    lowest = int(np.argmin(calm))
    deep = max(_LEAST_DIVE, 8 * track.noise)
    on_pad = np.flatnonzero(calm[:lowest] > -3 * track.noise)
    climbed = calm[:lowest].max(initial=0.0) > deep  # heights that fall after a climb do not show its start
    if calm[lowest] > -deep or climbed or on_pad.size < MIN_SAMPLES or np.median(calm[on_pad]) > 3 * track.noise:
        return None
    mirrored = replace(
        seen,
        lift=float(time[on_pad[-1]]),
        fastest=float(time[lowest]),
        pad=-seen.pad,
        top_height=-float(calm[lowest]) - seen.pad,
        calm=-seen.calm,
    )
    return _by_rise(replace(track, height=-track.height), mirrored)


def _reached(track: Heights, seen: Outline, about: float, rise: float) -> float:
    """When the climb has reached a given height. [s]"""
    there = np.flatnonzero((track.time > about) & (track.height > seen.pad + rise))
    return float(track.time[there[0]]) if there.size else seen.fastest


def _misfits(
    time: Float[Array, "time"], height: Float[Array, "time"], corners: Float[Array, "corner"], level: bool, lag: float
) -> Float[Array, "corner"]:
    """Sum of squared residuals from the best rise after each corner; `level` if the pad's height is fitted too. [m^2]

    A rise that begins downward is excluded by a large sum.
    """
    after = np.maximum(time - corners[:, None], 0)
    square = after**2 / 2 - lag * _late_line(after, lag)
    columns = [square, after**3 / 6 - lag * square, *([np.ones_like(after)] if level else [])]
    design = np.stack(columns, axis=-1)
    design /= np.maximum(np.linalg.norm(design, axis=1, keepdims=True), _TINY)
    across = design.swapaxes(1, 2)
    normal = across @ design + _RIDGE * np.eye(len(columns))
    found = np.linalg.solve(normal, (across @ height)[..., None])
    left = height - (design @ found)[..., 0]
    return np.asarray((left**2).sum(axis=1) + np.where(found[:, 0, 0] < 0, 1e6, 0.0))


def _late_line(after: Float[Array, "_"], lag: float) -> Float[Array, "_"]:
    """What a first-order lag shows of a line that begins to rise at 0. [s]"""
    return after + lag * np.expm1(-after / lag) if lag > 0 else after

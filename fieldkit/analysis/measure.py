"""Measure the readouts of a flight from its samples: `measure` is the only entry point.

Derivation: a readout that is a time is the difference between two events.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.analysis.accelerometer_check import MAX_FILLED_DELAY, Agreement, agreement, shape_of_missed, unchecked
from fieldkit.analysis.ascent import Ascent, LaggedAscent, ascend
from fieldkit.analysis.boost_length import SHORTEST_BOOST
from fieldkit.analysis.burnout import felt_burnout
from fieldkit.analysis.channels import MIN_SAMPLES, Heights, Push, all_heights, at_its_end, heights, pushes
from fieldkit.analysis.disturbed_heights import undisturbed
from fieldkit.analysis.ejection import shock
from fieldkit.analysis.flight_parts import FittedLog, recorded_of
from fieldkit.analysis.height_lag import averaged, possible_lags, widened_by_filter, widened_by_unseen_lag
from fieldkit.analysis.initial_guess import MAX_SENSOR_GAP
from fieldkit.analysis.liftoff import felt_boost, liftoff
from fieldkit.analysis.notes import (
    CLIPPED_NOTE,
    EARLIER_FLIGHT,
    ENDS_IN_BOOST,
    FILLED_NOTE,
    FILTERED_NOTE,
    NO_FLIGHT,
    NO_HEIGHT,
    ONLY_CLOCK_NOTE,
    OTHER_FLIGHT,
    OTHER_SENSOR_NOTE,
    REJECTED_NOTE,
    SMOOTH_NOTE,
    UNCHECKED_NOTE,
    slanted_note,
)
from fieldkit.analysis.phases import Outline, after_hovering, is_similar, next_flight, outline, rest_in_climb
from fieldkit.analysis.records import Event, HeightTrack, Recorded
from fieldkit.analysis.robust_statistics import median_step, running_median
from fieldkit.analysis.satellites import sightings
from fieldkit.analysis.slanted_flight import SlantedFlight, slanted_flight
from fieldkit.analysis.unseen_top import silence
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

_MAX_MISS = 0.08
"""Largest difference between the apogee of the fused curve and that of the heights, smoothed over a second, as a
fraction of the climb. [1]"""
_LAST_FELT, _THRUST = 0.2, 2 * GRAVITY
"""If the last readings of an accelerometer, over this time [s], are above this value [m/s^2], they are thrust."""
_BETWEEN_EVENTS = {
    "burn_time": ("liftoff", "burnout"),
    "coast_to_apogee": ("burnout", "apogee"),
    "apogee_to_eject": ("apogee", "ejection"),
    "duration": ("liftoff", "landing"),
}
"""Readouts that are times between two events."""
_AT_OTHER_END, _SATURATED_SAMPLES = 0.97, 3
"""Fraction of a range beyond which a sensor is saturated at its other end, as its zero is off, and the fewest samples
there. [1]"""
_DRAG_RISE = 0.5
"""Error of a drag that is extrapolated to higher speeds, near that of sound: the part by which Cd rises there. [1]"""
_MOST_ANGLE = 1.5
"""Largest angle of a tangent in speeds of a coast: they are finite. [rad]"""
_NEXT_MARGIN = 1.0
"""How long before the lift-off of the next flight a log is cut. [s]"""
_MIN_COUNTS = 0.2
"""Least number of independent samples that one height is worth without a filter in the logger. [1]"""


def rises(clocks: Sequence[Series]) -> bool:
    """Whether something in a log rises like a rocket, from a quick look at its heights.

    In a log without heights, whether an accelerometer felt thrust.
    """
    if heights(clocks) is not None:
        return _first_flight(clocks) is not None
    channels = [(series, name) for series in clocks for name in ("felt", "acceleration", "felt_total")]
    return any(_feels_thrust(series.time, getattr(series, name)) for series, name in channels)


def by_device(clocks: Sequence[Series], recorded: Recorded, stated: Mapping[str, float]) -> dict[str, float]:
    """Readouts as the logger has them: the largest of its own speeds on the way up, if it has two that of its
    accelerometer, and the times between the events that it marked. [SI]"""
    found = {
        name: stated[end] - stated[begin]
        for name, (begin, end) in _BETWEEN_EVENTS.items()
        if begin in stated and end in stated
    }
    lift, top = recorded.events.get("liftoff"), recorded.events.get("apogee")
    for series in clocks if lift is not None and top is not None else ():
        speed = series.inertial_speed if series.inertial_speed is not None else series.speed
        if speed is not None and lift is not None and top is not None:
            climbs = speed[(series.time >= lift.time) & (series.time <= top.time) & np.isfinite(speed)]
            if climbs.size:
                found.setdefault("top_speed", float(climbs.max()))
    return found


def _first_flight(clocks: Sequence[Series]) -> tuple[Array, Heights, Outline] | None:
    """The best heights of a log that rise like a rocket: a channel that is stuck or empty does not hide another, nor
    does what hovered before. With the times of all of its samples [s] and its outline."""
    for every in all_heights(clocks):
        track = undisturbed(every)
        seen = outline(track)
        while seen is not None and (later := after_hovering(track, seen)) is not None:
            track, seen = later, outline(later) if later.time.size >= MIN_SAMPLES else None
        if seen is not None:
            return every.time, track, seen
    return None


def _feels_thrust(time: Float[Array, "_"], felt: Float[Array, "_"] | None) -> bool:
    """Whether an acceleration is far from rest for as long as the shortest boost."""
    if felt is None or time.size < MIN_SAMPLES:
        return False
    width = max(3, round(SHORTEST_BOOST / median_step(time)))
    return bool((running_median(np.nan_to_num(felt), width | 1) > _THRUST).any())


def measure(clocks: Sequence[Series], stated: Mapping[str, float] | None = None) -> Recorded:
    """Measure the events, figures and forces of one flight from its samples; omit what they do not show.

    `clocks` are the channels, a `Series` for each clock; `stated` are the events that the logger marked [s]. Each
    figure is based on many samples, never on one. Heights are those of an altimeter that assumes the standard
    atmosphere; their standard deviations cover the sensor, not the weather.
    """
    stated = stated or {}
    first = heights(clocks)
    if first is None:
        return Recorded(notes=(NO_HEIGHT,))
    flown = _first_flight(clocks)
    if flown is None:
        return Recorded(notes=(NO_FLIGHT,))
    every, track, seen = flown
    track, seen, others = _highest(track, seen)
    later = next_flight(track, seen) if seen.down else None
    if later is not None:
        track, seen = _before(later - _NEXT_MARGIN, track, seen)
    start = seen.lift if seen.lift is not None else seen.fastest
    trust, seen = _best_trusted(pushes(clocks, start - 15, seen.top + 20), track, seen, start)
    felt = trust.push or trust.clock_only
    slanted = trust.slanted
    track, seen = _sooner(trust.lag, replace(track, bend=trust.filtered, lag_sd=trust.lag_sd), seen)
    if slanted is not None:
        track, seen = _without(~slanted.agrees(track, seen.pad), track, seen)
    lift = liftoff(track, felt, seen)
    if lift is None and "liftoff" in stated and stated["liftoff"] <= seen.fastest:
        lift = Event(float(stated["liftoff"]), 0.2, "lift-off event of the logger")
    blow = shock(felt, seen.fastest, seen.top)
    shape = slanted.upward if slanted is not None else trust.push
    sighted = sightings(clocks, track, seen)
    gap = silence(track, seen)
    moments = (lift.time if lift else None, blow.time if blow else None, gap[0] if gap else stated.get("apogee"))
    lags = possible_lags(track, seen, lift)
    clock = trust.clock_only
    ended = felt_burnout(clock, lift.time, seen) if clock is not None and lift is not None else None
    ascents = _ascents(track, shape, seen, *moments, sighted, lags, ended)
    if ascents and ascents[0].ascent.fused and _misses_the_top(ascents[0].ascent, seen, track):
        trust, felt = _Trust(None, notes=(REJECTED_NOTE.format("is from a different climb than the heights"),)), None
        ascents = _ascents(track, None, seen, moments[0], None, moments[2], sighted, lags)
    if not ascents:
        return Recorded(notes=(NO_FLIGHT,))
    known = {"compared": trust.compared, "slanted": slanted is not None}
    log = FittedLog(track, every, seen, ascents[0].ascent, trust.push, felt, stated, **known)
    each = [_recorded(replace(log, drag=one is ascents[0]), one, clocks) for one in ascents]
    on_time = next(one for one, ascent in zip(each, ascents, strict=True) if not ascent.lag.lag)
    if NO_FLIGHT in on_time.notes:  # correcting a lag does not turn a drone into a rocket
        return on_time
    times = trust.push.time if trust.push is not None and log.ascent.fused else every
    weights = [0.0 if NO_FLIGHT in one.notes else ascent.weight for one, ascent in zip(each, ascents, strict=True)]
    found = averaged(each, weights if any(weights) else [float(one is on_time) for one in each], times)
    if track.is_barometric and not (trust.compared if log.ascent.fused else len(lags) > 1):
        found = widened_by_unseen_lag(found)
    if trust.filtered and log.ascent.fused:
        found = widened_by_filter(found, trust.filtered)
        others += (FILTERED_NOTE.format(trust.filtered),)
    if lags[0].counts < _MIN_COUNTS and not log.ascent.fused:
        seen_peak = {name: one for name, one in found.figures.items() if name != "peak_accel"}
        found = replace(found, figures=seen_peak)
        others += (SMOOTH_NOTE,)
    above = HeightTrack(track.time, seen.calm - seen.pad, track.source)
    others += () if later is None else (OTHER_FLIGHT.format(later - float(every[0])),)
    return replace(found, notes=(*found.notes, *trust.notes, *others), track=above)


def _ascents(*log: Any) -> list[LaggedAscent]:
    """The fitted ascents, as `ascend` returns them; none if samples are so noisy that no curve fits them."""
    try:
        return ascend(*log)
    except np.linalg.LinAlgError:
        return []


def _recorded(log: FittedLog, found: LaggedAscent, clocks: Sequence[Series]) -> Recorded:
    """Results of a fitted ascent whose heights have a lag."""
    track, seen = _sooner(found.lag.lag, log.track, log.seen)
    bend = max(found.lag.lag, log.track.lag, log.track.bend)
    on_time = replace(log, track=replace(track, lag=log.track.lag, bend=bend), seen=seen, ascent=found.ascent)
    return recorded_of(on_time, found.lag.lift, clocks)


@dataclass(frozen=True, slots=True, eq=False)
class _Trust:
    """The accelerometer to use, and what the check of it found.

    The trusted accelerometer, or None; the tilted climb computed from it, if any; the delay of the heights relative to
    it, from a filter or small vents, and its standard deviation [s]; the note for the user; an accelerometer whose
    clock alone is trusted, for the shocks that it felt; whether the accelerometer was compared with the heights; and
    the time constant of the filter that the heights are behind, if it shows one [s].
    """

    push: Push | None
    slanted: SlantedFlight | None = None
    lag: float = 0.0
    lag_sd: float = 0.0
    notes: tuple[str, ...] = ()
    clock_only: Push | None = None
    compared: bool = True
    filtered: float = 0.0


def _best_trusted(every: Iterable[Push], track: Heights, seen: Outline, start: float) -> tuple[_Trust, Outline]:
    """The first accelerometer of a log that agrees with the heights, and the outline that it shows; if none does, what
    the check of the first one found. `start` is about when the climb begins [s]."""
    found: list[tuple[_Trust, Outline]] = []
    for push in every:
        boost = felt_boost(push, seen)  # the heights may show its start late
        begin = min(start, boost.lift) if boost is not None and boost.lift is not None else start
        found.append(_trusted(push, at_its_end(push, begin, seen.fastest), track, seen))
        trust, shown = found[-1]
        if trust.push is not None:
            others = tuple(note for one, _ in found[:-1] for note in one.notes)
            instead = (OTHER_SENSOR_NOTE.format(push.source),) if others else ()
            return replace(trust, notes=(*trust.notes, *instead)), shown
    return found[0] if found else (_Trust(None), seen)


def _trusted(push: Push, full: Flags | None, track: Heights, seen: Outline) -> tuple[_Trust, Outline]:
    """Compare an accelerometer with the heights: whether it recorded the same climb, straight or tilted, or why not.

    A saturated accelerometer is used except for the samples in `full`. If only the boost that it felt itself, rather
    than that of the heights, makes both agree, the outline has that one.
    """
    if _ends_in_boost(push, seen):
        return _Trust(None, notes=(ENDS_IN_BOOST,), clock_only=push), seen
    push = _with_drag(push, full, seen) if full is not None else push
    rise = liftoff(track, None, seen)
    found = _agreement(track, push, seen, rise, full)
    if found is None or not found.is_consistent:
        slanted = _slanted(found, track, push, seen, rise) if full is None else None
        if slanted is not None:
            return _Trust(push, slanted, notes=(slanted_note(slanted.angle),)), seen
        felt = felt_boost(push, seen)
        again = _agreement(track, push, felt, None, full) if felt is not None else None
        if felt is not None and again is not None and again.is_consistent:
            found, seen = again, felt
    if full is not None:
        return _filled(push, full, found), seen
    if found is None and unchecked(push, seen, rise):
        return _Trust(None, notes=(REJECTED_NOTE.format(UNCHECKED_NOTE),)), seen
    if found is None:
        return _Trust(push, compared=rise is None), seen
    if found.is_consistent:
        kept = replace(push, scale=found.scale, scale_sd=found.scale_sd, blur=found.blur)
        return _Trust(kept, lag=found.lag, lag_sd=found.lag_sd, filtered=found.filtered), seen
    if found.keeps_time:
        return _Trust(None, notes=(ONLY_CLOCK_NOTE.format(found.why),), clock_only=push), seen
    return _Trust(None, notes=(REJECTED_NOTE.format(found.why),)), seen


def _slanted(
    found: Agreement | None, track: Heights, push: Push, seen: Outline, rise: Event | None
) -> SlantedFlight | None:
    """The tilted climb that an accelerometer shows if it disagrees with the heights; None if there is none."""
    if found is None or found.derived or found.is_smoothed or rise is None:
        return None
    return slanted_flight(track, push, seen, rise)


def _agreement(track: Heights, push: Push, seen: Outline, rise: Event | None, full: Flags | None) -> Agreement | None:
    """Comparison of an accelerometer with the heights from their lift-off or, if they differ, from its own: shocks and
    static ports may hide the start of a hard boost from the heights."""
    found = agreement(track, push, seen, rise, full) if rise is not None else None
    if found is not None and found.is_consistent:
        return found
    lift = liftoff(track, push, seen)
    sooner = lift is not None and (rise is None or lift.time < rise.time)
    again = agreement(track, push, seen, lift, full) if lift is not None and sooner else None
    return again if again is not None and again.is_consistent else found


def _ends_in_boost(push: Push, seen: Outline) -> bool:
    """Whether an accelerometer stopped while the climb was still accelerating, with thrust in its last samples."""
    last = push.felt[push.time > push.time[-1] - _LAST_FELT]
    return bool(push.time[-1] < seen.fastest - MAX_SENSOR_GAP and np.median(last) > _THRUST)


def _with_drag(push: Push, full: Flags, seen: Outline) -> Push:
    """An accelerometer whose other end of the range drag exceeds after the boost, with that drag.

    Derivation: at the end of the saturation drag is the range r, and the speed v is what the rest of the coast takes.
    Drag k u² with k = r/v² slows a speed u by k u² + g, which before was u = sqrt(g/k) tan(atan(v sqrt(k/g)) + s
    sqrt(g k)) a time s earlier.
    """
    end = float(push.felt[full].min()) if full.any() else np.inf
    coast = (push.time > seen.fastest) & (push.time < seen.top)
    low = np.flatnonzero(coast & (push.felt < -_AT_OTHER_END * end))
    if low.size < _SATURATED_SAMPLES:
        return push
    after = (push.time >= push.time[low[-1]]) & (push.time < seen.top)
    speed = float(np.trapezoid(GRAVITY - push.felt[after], push.time[after]))
    if speed <= 0:
        return push
    drag = end / speed**2
    earlier = (push.time[low[-1]] - push.time[low]) * np.sqrt(GRAVITY * drag)
    angle = np.minimum(np.arctan(speed * np.sqrt(drag / GRAVITY)) + earlier, _MOST_ANGLE)
    felt = push.felt.copy()
    felt[low] = np.minimum(-GRAVITY * np.tan(angle) ** 2, felt[low])
    return replace(push, felt=felt)


def _filled(push: Push, full: Flags, found: Agreement | None) -> _Trust:
    """An accelerometer with the saturated samples filled in, if the rest of it agrees with the heights."""
    if found is None or not found.is_consistent or abs(found.late) > MAX_FILLED_DELAY + found.step:
        return _Trust(None, notes=(CLIPPED_NOTE,), clock_only=None if found and found.is_off else push)
    felt = push.felt + found.missed * shape_of_missed(push, full, found.missed, found.decrease)
    lasts = float(full.sum()) * median_step(push.time)
    note = FILLED_NOTE.format(lasts, found.missed / GRAVITY)
    ends = float(push.felt[full].min())
    beyond = float(np.maximum(-push.felt - ends, 0.0).sum()) * median_step(push.time)
    unsure = float(np.hypot(found.missed_sd * lasts, _DRAG_RISE * beyond))
    filled = replace(
        push,
        felt=felt,
        full=full,
        missed=found.missed,
        missed_speed_sd=unsure,
        missed_drag_sd=_DRAG_RISE * beyond,
        range_end=ends,
    )
    return _Trust(filled, notes=(note,))


def _misses_the_top(ascent: Ascent, seen: Outline, track: Heights) -> bool:
    """Whether a curve shaped by an accelerometer is far from the apogee that the heights show."""
    if not seen.down or silence(track, seen):
        return False
    place = int(np.argmax(ascent.height))
    gained = seen.top_height - seen.pad
    far = abs(float(ascent.height[place]) - gained) > max(_MAX_MISS * gained, 20 * track.noise, 10.0)
    return far or place >= ascent.time.size - 2


def _sooner(lag: float, track: Heights, seen: Outline) -> tuple[Heights, Outline]:
    """Heights and their outline with a lag removed. [s]"""
    if not lag:
        return track, seen
    lift = None if seen.lift is None else seen.lift - lag
    earlier = replace(seen, lift=lift, fastest=seen.fastest - lag, top=seen.top - lag)
    return replace(track, time=track.time - lag, lag=lag, shift=lag), earlier


def _highest(track: Heights, seen: Outline) -> tuple[Heights, Outline, tuple[str, ...]]:
    """The highest flight of a log without the ones just before it, and a note if there are any."""
    rest = rest_in_climb(track, seen)
    if rest is None:
        return track, seen, ()
    place = int(np.searchsorted(track.time, rest))
    parts = [replace(track, time=track.time[part], height=track.height[part]) for part in np.s_[:place, place:]]
    earlier, found = (outline(part) if part.time.size >= MIN_SAMPLES else None for part in parts)
    if found is None:
        return track, seen, ()
    flew = earlier is not None and is_similar(earlier, found)
    return parts[1], found, (EARLIER_FLIGHT.format(rest - float(track.time[0])),) if flew else ()


def _before(end: float, track: Heights, seen: Outline) -> tuple[Heights, Outline]:
    """Heights up to a time, and their outline. [s]"""
    first = slice(0, int(np.searchsorted(track.time, end)))
    return replace(track, time=track.time[first], height=track.height[first]), replace(seen, calm=seen.calm[first])


def _without(wrong: Flags, track: Heights, seen: Outline) -> tuple[Heights, Outline]:
    """Heights without some samples, and the outline of the rest."""
    if not wrong.any():
        return track, seen
    kept = replace(track, time=track.time[~wrong], height=track.height[~wrong], disturbed=True)
    return kept, replace(seen, calm=seen.calm[~wrong])

"""From the samples of a flight to its readouts: `measure`, the one way in."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.flight import Series
from fieldkit.recording.ascent import Ascent, ascend
from fieldkit.recording.channels import SPOKEN, Heights, Push, heights, pushes
from fieldkit.recording.descent import descent_speed, ejection, height_at, landing, shock
from fieldkit.recording.forces import boost_event, climb_of, forces, peak_push
from fieldkit.recording.liftoff import liftoff
from fieldkit.recording.numbers import hole_at, mad_sd
from fieldkit.recording.outline import Outline, outline
from fieldkit.recording.records import Event, Figure, Recorded
from fieldkit.standard_air import pressure_height

_LATE, _FALL = 0.8, 1.0
"""So long after its top a curve must go on [s] and so far surely fall [m] before it counts as coming down."""
_LEAST_GPS = 1.0
"""Of the error of an apogee by satellites: what one receiver's height wanders within a minute. [m]"""
_LEAST = 0.15
"""Of the error of any apogee: what the air and a sensor's drift do within a flight. [m]"""
_BLIND = 1.3
"""Heights further apart than this do not show a boost: a receiver lost its satellites, or a radio its rocket.
Once a second is often enough, for the coast that follows shows how fast it began. [s]"""
NO_HEIGHT = "the log has no height or pressure to measure with"
NO_FLIGHT = "nothing in this log rises as a rocket does: no figure is taken from it"
NO_APOGEE = "no apogee in this log: it ends before the top"
NO_LIFTOFF = "the log begins after lift-off: no burn time, no times from lift-off"
NO_BOOST = "the boost is not in the log, or not as it was: no top speed, no burn time, no acceleration"
NO_PAD = "the log begins in flight and its heights do not count from the pad: no height above it"
NO_LANDING = "the log ends before landing: no duration"


def measure(clocks: Sequence[Series], stated: Mapping[str, float] | None = None) -> Recorded:
    """Events, figures and forces of one flight from its samples; what they do not show is left out.

    `clocks` are the channels, a `Series` for each clock; `stated` the events that the logger marked [s]. A figure
    rests on many samples, never on one. Heights are what an altimeter shows that believes in the standard
    atmosphere; their standard deviations are of reading the sensor, not of the weather.
    """
    stated = stated or {}
    track = heights(clocks)
    if track is None:
        return Recorded(notes=(NO_HEIGHT,))
    seen = outline(track)
    if seen is None:
        return Recorded(notes=(NO_FLIGHT,))
    start = seen.lift if seen.lift is not None else seen.fastest
    push = pushes(clocks, start - 15, seen.top + 20)
    lift = liftoff(track, push, seen)
    if lift is None and "liftoff" in stated and stated["liftoff"] <= seen.fastest:
        lift = Event(float(stated["liftoff"]), 0.2, "lift-off event of the logger")
    blow = shock(push, seen.fastest, seen.top)
    try:
        ascent = ascend(
            track, push, seen, lift.time if lift else None, blow.time if blow else None, stated.get("apogee")
        )
    except np.linalg.LinAlgError:  # samples so wild that no curve goes through them
        ascent = None
    if ascent is None:
        return Recorded(notes=(NO_FLIGHT,))
    return _told(track, seen, ascent, lift, push, clocks, stated)


def _told(
    track: Heights,
    seen: Outline,
    ascent: Ascent,
    lift: Event | None,
    push: Push | None,
    clocks: Sequence[Series],
    stated: Mapping[str, float],
) -> Recorded:
    """What a fitted ascent and the descent after it come to."""
    notes: list[str] = []
    source = track.source + (f" and {push.source}" if push and ascent.fused else "")
    begin = lift.time if lift else float(ascent.time[0])
    events: dict[str, Event] = {"liftoff": lift} if lift else {}
    figures: dict[str, Figure] = {}
    apogee = _apogee(ascent, seen, track) if seen.down or _falls(ascent) else None
    notes += [NO_APOGEE] if apogee is None else []
    end = apogee[0].time if apogee else float(ascent.time[-1])
    boost = boost_event(ascent, push, begin, end, source)
    lost = _lost(track, begin, boost[0].time) if boost else None
    if lift and lost is not None and lost < begin:
        lift = None
        del events["liftoff"]
    if boost and not ascent.fused and (lost is not None or _unseen(track, begin, boost[0].time) > _BLIND):
        notes.append(NO_BOOST)
        boost = None
    notes += [NO_LIFTOFF] if lift is None else []
    if boost and lift and boost[0].time < end - 0.2:
        events["burnout"], figures["top_speed"] = boost
        _boost_figures(figures, ascent, push, lift, boost, source)
    burnout = boost[0].time if boost and lift else begin
    free = end
    if apogee:
        events["apogee"], figures["apogee"] = apogee
        notes += [NO_PAD] if np.isinf(seen.pad_sd) else []
        if lift:
            figures["time_to_apogee"] = _between(lift, apogee[0], track.source)
            if "burnout" in events:
                figures["coast_to_apogee"] = _between(events["burnout"], apogee[0], source)
        free = _down(events, figures, notes, track, seen, ascent, push, apogee[0], lift, burnout, stated)
    climb = climb_of(ascent, begin, burnout, end, source)
    pressed = forces(climb, push, track, _elevation(clocks, lift), free) if lift and "burnout" in events else None
    known = {name: figure for name, figure in figures.items() if np.isfinite(figure.sd)}
    return Recorded(events, known, climb, pressed, tuple(notes))


def _unseen(track: Heights, begin: float, burnout: float) -> float:
    """The longest time without a height from lift-off to burnout. [s]"""
    inside = slice(*np.searchsorted(track.time, (begin, burnout)))
    between = float(np.diff(track.time[inside]).max(initial=0.0))
    return max(hole_at(track.time, begin), hole_at(track.time, burnout), between)


def _lost(track: Heights, begin: float, burnout: float) -> float | None:
    """When a receiver seems to fall about the boost, or None: it lost its satellites and went on along a course. [s]"""
    inside = slice(*np.searchsorted(track.time, (begin - 5, burnout + 1)))
    height = track.height[inside]
    if track.source != SPOKEN["gps_altitude_msl"] or not height.size:
        return None
    fallen = np.flatnonzero(np.maximum.accumulate(height) - height > max(12 * track.noise, 5.0))
    return float(track.time[inside][fallen[0]]) if fallen.size else None


def _falls(ascent: Ascent) -> bool:
    """Whether the curve surely comes down at its end, though the samples that show it are few."""
    late = ascent.time[-1] - ascent.time[int(np.argmax(ascent.height))]
    return bool(late > _LATE and np.quantile(ascent.heights.max(axis=1) - ascent.heights[:, -1], 0.05) > _FALL)


def _apogee(ascent: Ascent, seen: Outline, track: Heights) -> tuple[Event, Figure] | None:
    """The top of the curve, or None where it is still rising when the log ends."""
    place = int(np.argmax(ascent.height))
    if place >= ascent.time.size - 2 or place == 0:
        return None
    tops = ascent.heights.max(axis=1)
    moments = ascent.time[np.argmax(ascent.heights, axis=1)]
    near = np.abs(track.time - ascent.time[place]) < 1.0
    left = track.height[near] - seen.pad - np.interp(track.time[near], ascent.time, ascent.height)
    rough = mad_sd(left) / 2 if mad_sd(left) > 3 * track.noise else 0.0
    least = _LEAST_GPS if track.source == SPOKEN["gps_altitude_msl"] else _LEAST
    sd = float(np.sqrt(tops.std() ** 2 + seen.pad_sd**2 + rough**2 + least**2))
    spread = 1.4826 * np.median(np.abs(moments - ascent.time[place]))
    event = Event(float(ascent.time[place]), float(np.hypot(spread, 0.04 if ascent.fused else 0.06)), track.source)
    return event, Figure(float(ascent.height[place]), sd, track.source)


def _boost_figures(
    figures: dict[str, Figure],
    ascent: Ascent,
    push: Push | None,
    lift: Event,
    boost: tuple[Event, Figure],
    source: str,
) -> None:
    """Burn time, mean and peak acceleration."""
    burn, speed = _between(lift, boost[0], source), boost[1]
    if burn.value <= 0:
        return
    figures["burn_time"] = burn
    mean = speed.value / burn.value
    sd = mean * np.hypot(speed.sd / speed.value, burn.sd / burn.value)
    figures["avg_accel"] = Figure(mean, float(sd), source)
    peak = peak_push(push, ascent, lift.time, boost[0].time, source)
    if peak:
        figures["peak_accel"] = peak


def _down(
    events: dict[str, Event],
    figures: dict[str, Figure],
    notes: list[str],
    track: Heights,
    seen: Outline,
    ascent: Ascent,
    push: Push | None,
    apogee: Event,
    lift: Event | None,
    burnout: float,
    stated: Mapping[str, float],
) -> float:
    """Add what the way down tells, and say when the coast ended. [s]"""
    blow = shock(push, burnout, apogee.time)
    ejected = ejection(stated, blow, track, seen, apogee)
    if ejected:
        events["ejection"] = ejected
        figures["apogee_to_eject"] = _between(apogee, ejected, ejected.source)
        figures["eject_altitude"] = height_at(ascent, track, seen, ejected)
    landed, level = landing(track, seen, apogee.time)
    if landed:
        events["landing"] = landed
        if lift:
            figures["duration"] = _between(lift, landed, track.source)
    else:
        notes.append(NO_LANDING)
    speed = descent_speed(track, seen, ejected or replace(apogee, sd=2.0), landed, level)
    if speed:
        figures["descent_speed"] = speed
    return min(apogee.time, ejected.time if ejected else np.inf)


def _between(first: Event, second: Event, source: str) -> Figure:
    """The time from one event to another. [s]"""
    return Figure(second.time - first.time, float(np.hypot(first.sd, second.sd)), source)


def _elevation(clocks: Sequence[Series], lift: Event | None) -> float:
    """The pad above sea level, as its pressure or a channel above sea level has it; 0 where none does. [m]"""
    for name in ("pressure", "altitude_msl", "gps_altitude_msl"):
        for series in clocks:
            values = getattr(series, name)
            if values is not None and lift is not None:
                early = values[series.time <= lift.time + 0.2]
                early = early[np.isfinite(early)]
                if early.size:
                    level = np.median(early, keepdims=True)
                    return float((pressure_height(level) if name == "pressure" else level)[0])
    return 0.0

"""From the samples of a flight to its readouts: `measure`, the one way in."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.flight import Series
from fieldkit.recording.ascent import Ascent, ascend
from fieldkit.recording.channels import Heights, Push, heights, pushes
from fieldkit.recording.descent import descent_speed, ejection, height_at, landing, shock
from fieldkit.recording.forces import boost_event, climb_of, forces, peak_push
from fieldkit.recording.liftoff import liftoff
from fieldkit.recording.numbers import mad_sd
from fieldkit.recording.outline import Outline, outline
from fieldkit.recording.records import Event, Figure, Recorded
from fieldkit.standard_air import pressure_height

_LEAST = 0.15
"""Of the error of any apogee: what the air and a sensor's drift do within a flight. [m]"""
NO_HEIGHT = "the log has no height or pressure to measure with"
NO_FLIGHT = "nothing in this log rises as a rocket does: no figure is taken from it"
NO_APOGEE = "no apogee in this log: it ends before the top"
NO_LIFTOFF = "the log begins after lift-off: no burn time, no times from lift-off"
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
    apogee = _apogee(ascent, seen, track) if seen.down else None
    notes += [NO_APOGEE] if apogee is None else []
    notes += [NO_LIFTOFF] if lift is None else []
    end = apogee[0].time if apogee else float(ascent.time[-1])
    boost = boost_event(ascent, begin, end, source)
    if boost and lift and boost[0].time < end - 0.2:
        events["burnout"], figures["top_speed"] = boost
        _boost_figures(figures, ascent, push, lift, boost, source)
    burnout = boost[0].time if boost and lift else begin
    free = end
    if apogee:
        events["apogee"], figures["apogee"] = apogee
        if lift:
            figures["time_to_apogee"] = _between(lift, apogee[0], track.source)
            if "burnout" in events:
                figures["coast_to_apogee"] = _between(events["burnout"], apogee[0], source)
        free = _down(events, figures, notes, track, seen, ascent, push, apogee[0], lift, burnout, stated)
    climb = climb_of(ascent, begin, burnout, end, source)
    pressed = forces(climb, push, track, _elevation(clocks, lift), free) if lift else None
    return Recorded(events, figures, climb, pressed, tuple(notes))


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
    sd = float(np.sqrt(tops.std() ** 2 + seen.pad_sd**2 + rough**2 + _LEAST**2))
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

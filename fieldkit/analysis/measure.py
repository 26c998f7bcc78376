"""From the samples of a flight to its readouts: `measure`, the one way in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.analysis.accelerometer_check import agreement
from fieldkit.analysis.ascent import Ascent, ascend
from fieldkit.analysis.channels import CHANNEL_TITLES, Heights, Push, heights, is_clipped, pushes
from fieldkit.analysis.descent import descent_speed, ejection, height_at, landing, shock
from fieldkit.analysis.disturbed_heights import undisturbed
from fieldkit.analysis.drag_and_impulse import drag_and_impulse
from fieldkit.analysis.forces import boost_event, climb_of, forces, peak_push
from fieldkit.analysis.leaning_flight import LeaningFlight, leaning_flight
from fieldkit.analysis.liftoff import liftoff
from fieldkit.analysis.phases import Outline, outline
from fieldkit.analysis.possible import is_flight, possible
from fieldkit.analysis.records import Event, Figure, HeightTrack, Recorded
from fieldkit.analysis.robust_statistics import hole_at, mad_sd, median_step
from fieldkit.analysis.unseen_top import silence, unseen_apogee
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.shapes import Array, Flags, Float

_MIN_TIME_AFTER_TOP, _FALL = 0.8, 1.0
"""So long after its top a curve must go on [s] and so far surely fall [m] before it counts as coming down."""
_MIN_LAG = 0.08
"""Heights that are late by less beside an accelerometer are taken for in time. [s]"""
_LEAST_GPS = 1.0
"""Of the error of an apogee by satellites: what one receiver's height wanders within a minute. [m]"""
_MAX_HEARD_GAP = 2.0
"""Between samples that are further apart nothing is known of a top. [s]"""
_REST, _MAX_WANDER = 10.0, 20.0
"""The end of a log that is looked at for a rest [s], in which heights move by less [m]."""
_MIN_APOGEE_ERROR = 0.15
"""Of the error of any apogee: what the air and a sensor's drift do within a flight. [m]"""
_MAX_HEIGHT_GAP = 1.3
"""Heights further apart than this do not show a boost: a receiver lost its satellites, or a radio its rocket.
Once a second is often enough, for the coast that follows shows how fast it began. [s]"""
_BLIND_PART = 0.75
"""Nor does a log whose samples are further apart than this part of the boost. [1]"""
NO_HEIGHT = "the log has no height or pressure to measure with"
NO_FLIGHT = "nothing in this log rises as a rocket does: no figure is taken from it"
NO_APOGEE = "no apogee in this log: it ends before the top"
UNSEEN_TOP_NOTE = (
    "the top is in a silence of {:.0f} s: it lies between {:.0f} m, which was seen, and {:.0f} m, a coast without drag"
)
NO_LIFTOFF = "the log begins after lift-off: no burn time, no times from lift-off"
NO_BOOST = "the boost is not in the log, or not as it was: no top speed, no burn time, no acceleration"
NO_PAD = "the log begins in flight and its heights do not count from the pad: no height above it"
CLIPPED_NOTE = "the accelerometer was at the end of its range in the boost: heights alone tell of it"
DISBELIEVED = (
    "the acceleration {}: it is not taken for an accelerometer's along the axis, heights alone tell of the boost"
)
LEANED = "it climbed at some {:.0f} degrees from the vertical: so its accelerometer and its heights agree"
NO_LANDING = "the log ends before landing: no duration"


def rises(clocks: Sequence[Series]) -> bool:
    """Whether something in a log rises as a rocket does, as far as a look at its heights tells.

    Where it has none but an accelerometer that cannot be told, and it may.
    """
    track = heights(clocks)
    if track is not None:
        return outline(undisturbed(track)) is not None
    felt = (getattr(series, name) for series in clocks for name in ("felt", "acceleration", "felt_total"))
    return any(values is not None for values in felt)


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
    every = track.time
    track = undisturbed(track)
    seen = outline(track)
    if seen is None:
        return Recorded(notes=(NO_FLIGHT,))
    start = seen.lift if seen.lift is not None else seen.fastest
    push = pushes(clocks, start - 15, seen.top + 20)
    clipped = push is not None and is_clipped(push, start, seen.fastest)
    doubt: tuple[str, ...] = ()
    leaning: LeaningFlight | None = None
    if not clipped:
        trust = _trusted(push, track, seen)
        push, leaning, doubt = trust.push, trust.leaning, trust.notes
        track, seen = _sooner(trust.lag, track, seen)
    if leaning is not None:
        track, seen = _without(~leaning.agrees(track, seen.pad), track, seen)
    lift = liftoff(track, push, seen)
    if lift is None and "liftoff" in stated and stated["liftoff"] <= seen.fastest:
        lift = Event(float(stated["liftoff"]), 0.2, "lift-off event of the logger")
    blow = shock(push, seen.fastest, seen.top)
    shape = None if clipped else leaning.upward if leaning is not None else push
    try:
        ascent = ascend(
            track, shape, seen, lift.time if lift else None, blow.time if blow else None, stated.get("apogee")
        )
    except np.linalg.LinAlgError:  # samples so wild that no curve goes through them
        ascent = None
    if ascent is None:
        return Recorded(notes=(NO_FLIGHT,))
    told = _told(_Log(track, every, seen, ascent, None if clipped else push, push, stated), lift, clocks)
    if NO_FLIGHT in told.notes:
        return told
    above = HeightTrack(track.time, seen.calm - seen.pad, track.source)
    return replace(told, notes=(*told.notes, *((CLIPPED_NOTE,) if clipped else ()), *doubt), track=above)


@dataclass(frozen=True, slots=True, eq=False)
class _Trust:
    """An accelerometer that is believed, None for none; the leaning climb that it makes, if it made one; by how much
    the heights are late beside it, as behind a filter or small vents [s]; and what is to be said of it."""

    push: Push | None
    leaning: LeaningFlight | None = None
    lag: float = 0.0
    notes: tuple[str, ...] = ()


def _trusted(push: Push | None, track: Heights, seen: Outline) -> _Trust:
    """What the heights say of an accelerometer: that it tells of the same climb, straight or leaning, or why not."""
    rise = liftoff(track, None, seen) if push is not None else None
    if push is None or rise is None:
        return _Trust(push)
    found = agreement(track, push, seen, rise)
    if found is None or found.believed:
        lag = -found.late if found is not None and found.late < -_MIN_LAG - found.step else 0.0
        return _Trust(push, lag=lag)
    leaning = leaning_flight(track, push, seen, rise)
    if leaning is not None:
        return _Trust(push, leaning, notes=(LEANED.format(np.degrees(leaning.angle)),))
    return _Trust(None, notes=(DISBELIEVED.format(found.why),))


def _sooner(lag: float, track: Heights, seen: Outline) -> tuple[Heights, Outline]:
    """Heights and their outline without a lag. [s]"""
    if not lag:
        return track, seen
    lift = None if seen.lift is None else seen.lift - lag
    earlier = replace(seen, lift=lift, fastest=seen.fastest - lag, top=seen.top - lag)
    return replace(track, time=track.time - lag), earlier


def _without(wrong: Flags, track: Heights, seen: Outline) -> tuple[Heights, Outline]:
    """Heights without some samples, and the outline of the rest."""
    if not wrong.any():
        return track, seen
    kept = replace(track, time=track.time[~wrong], height=track.height[~wrong], disturbed=True)
    return kept, replace(seen, calm=seen.calm[~wrong])


@dataclass(frozen=True, slots=True, eq=False)
class _Log:
    """What a log holds, and the curve of its ascent. `push` is the acceleration that is believed for its size, `felt`
    that for its blows; `every` are the times of all samples [s], `stated` the events that the logger marked [s]."""

    track: Heights
    every: Float[Array, "time"]
    seen: Outline
    ascent: Ascent
    push: Push | None
    felt: Push | None
    stated: Mapping[str, float]

    @property
    def source(self) -> str:
        """The channels that shaped the curve."""
        return self.track.source + (f" and {self.push.source}" if self.push and self.ascent.fused else "")


@dataclass(frozen=True, slots=True)
class _FlightPart:
    """What one part of a flight tells."""

    events: Mapping[str, Event] = field(default_factory=dict)
    figures: Mapping[str, Figure] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def _told(log: _Log, lift: Event | None, clocks: Sequence[Series]) -> Recorded:
    """What a fitted ascent and the descent after it come to."""
    begin = lift.time if lift else float(log.ascent.time[0])
    hole = silence(log.track, log.seen)
    unseen = unseen_apogee(log.track, log.seen, log.ascent, hole) if hole else None
    notes: tuple[str, ...] = ()
    if unseen and hole:
        apogee: tuple[Event, Figure] | None = unseen[:2]
        notes = (UNSEEN_TOP_NOTE.format(hole[1] - hole[0], *unseen[2]),)
    else:
        apogee = _apogee(log.ascent, log.seen, log.track) if log.seen.down or _falls(log.ascent) else None
    end = apogee[0].time if apogee else float(log.ascent.time[-1])
    lift, boost = _boost(log, lift, begin, end)
    burnt = boost.events.get("burnout")
    burnout = burnt.time if burnt else begin
    top = _top(log, lift, burnt, apogee)
    down = _down(log, apogee[0], lift, burnout, hole[1] if unseen and hole else None) if apogee else _FlightPart()
    events = {**({"liftoff": lift} if lift else {}), **boost.events, **top.events, **down.events}
    figures = {**boost.figures, **top.figures, **down.figures}
    coasts_from = float(np.interp(burnt.time, log.ascent.time, log.ascent.height)) if burnt else None
    known = {name: figure for name, figure in figures.items() if np.isfinite(figure.sd)}
    if not is_flight(known, coasts_from, float(log.ascent.height.max()), log.seen.climbs):
        return Recorded(notes=(NO_FLIGHT,))
    climb = climb_of(log.ascent, begin, burnout, end, log.source)
    free = min(event.time for event in (*down.events.values(), Event(end, 0.0, "")))
    if lift and burnt and apogee:
        known |= drag_and_impulse(log.track, log.seen.pad, log.ascent, lift, burnt, free, log.source)
    known, impossible = possible({name: figure for name, figure in known.items() if np.isfinite(figure.sd)})
    pressed = forces(climb, log.push, log.track, _elevation(clocks, lift), free) if lift and burnt else None
    return Recorded(
        events, known, climb, pressed, (*notes, *top.notes[:1], *boost.notes, *top.notes[1:], *down.notes, *impossible)
    )


def _boost(log: _Log, lift: Event | None, begin: float, end: float) -> tuple[Event | None, _FlightPart]:
    """Lift-off, if it is believed, and what the boost tells."""
    found = boost_event(log.ascent, log.push, begin, end, log.source)
    lost = _lost(log.track, begin, found[0].time) if found else None
    notes: tuple[str, ...] = ()
    if lost is not None and lost < begin:
        lift = None
    blind = found is not None and (lost is not None or _is_unseen(log.every, begin, found[0].time))
    if blind and not log.ascent.fused:
        found, notes = None, (NO_BOOST,)
    if lift is None:
        notes += (NO_LIFTOFF,)
    if found is None or lift is None or found[0].time >= end - 0.2:
        return lift, _FlightPart(notes=notes)
    burnout, speed = found
    figures = {"top_speed": speed, **_burn(log, lift, burnout, speed)}
    return lift, _FlightPart({"burnout": burnout}, figures, notes)


def _burn(log: _Log, lift: Event, burnout: Event, speed: Figure) -> dict[str, Figure]:
    """Burn time, mean and peak acceleration."""
    burn = _between(lift, burnout, log.source)
    if burn.value <= 0:
        return {}
    mean = speed.value / burn.value
    sd = mean * np.hypot(speed.sd / speed.value, burn.sd / burn.value)
    figures = {"burn_time": burn, "avg_accel": Figure(mean, float(sd), log.source)}
    peak = peak_push(log.push, log.ascent, lift.time, burnout.time, figures["avg_accel"])
    return figures | ({"peak_accel": peak} if peak else {})


def _top(log: _Log, lift: Event | None, burnout: Event | None, apogee: tuple[Event, Figure] | None) -> _FlightPart:
    """Apogee, and the times to it."""
    if apogee is None:
        return _FlightPart(notes=(NO_APOGEE,))
    figures = {"apogee": apogee[1]}
    if lift:
        figures["time_to_apogee"] = _between(lift, apogee[0], log.track.source)
    if lift and burnout:
        figures["coast_to_apogee"] = _between(burnout, apogee[0], log.source)
    return _FlightPart({"apogee": apogee[0]}, figures, (NO_PAD,) if np.isinf(log.seen.pad_sd) else ())


def _down(log: _Log, apogee: Event, lift: Event | None, burnout: float, heard: float | None = None) -> _FlightPart:
    """What the way down tells; `heard` is when samples come again where the top was in a silence. [s]"""
    track, seen = log.track, log.seen
    landed, level = landing(track, seen, apogee.time)
    ejected = ejection(log.stated, shock(log.felt, burnout, apogee.time), track, apogee, landed)
    events: dict[str, Event] = {}
    figures: dict[str, Figure] = {}
    if ejected:
        events["ejection"] = ejected
        figures["apogee_to_eject"] = _between(apogee, ejected, ejected.source)
        figures["eject_altitude"] = height_at(log.ascent, track, seen, ejected)
    if landed:
        events["landing"] = landed
    if landed and lift:
        figures["duration"] = _between(lift, landed, track.source)
    begin = ejected or replace(apogee, sd=2.0)
    if heard is not None and begin.time < heard:
        begin = Event(heard, 0.1, track.source)
    speed = descent_speed(track, seen, begin, landed, level)
    if speed:
        figures["descent_speed"] = speed
    return _FlightPart(events, figures, () if landed else (NO_LANDING,))


def _is_unseen(time: Float[Array, "time"], begin: float, burnout: float) -> bool:
    """Whether heights were taken too far apart, from lift-off to burnout, to show a boost."""
    first, last = np.searchsorted(time, (begin, burnout))
    between = float(np.diff(time[first:last]).max(initial=0.0))
    longest = max(hole_at(time, begin), hole_at(time, burnout), between)
    usual = median_step(time[max(0, first - 5) : last + 5])
    return longest > _MAX_HEIGHT_GAP or usual > _BLIND_PART * (burnout - begin)


def _lost(track: Heights, begin: float, burnout: float) -> float | None:
    """When a receiver seems to fall about the boost, or None: it lost its satellites and went on along a course. [s]"""
    inside = slice(*np.searchsorted(track.time, (begin - 5, burnout + 1)))
    height = track.height[inside]
    if track.source != CHANNEL_TITLES["gps_altitude_msl"] or not height.size:
        return None
    fallen = np.flatnonzero(np.maximum.accumulate(height) - height > max(12 * track.noise, 5.0))
    return float(track.time[inside][fallen[0]]) if fallen.size else None


def _falls(ascent: Ascent) -> bool:
    """Whether the curve surely comes down at its end, though the samples that show it are few."""
    late = ascent.time[-1] - ascent.time[int(np.argmax(ascent.height))]
    return bool(
        late > _MIN_TIME_AFTER_TOP and np.quantile(ascent.heights.max(axis=1) - ascent.heights[:, -1], 0.05) > _FALL
    )


def _apogee(ascent: Ascent, seen: Outline, track: Heights) -> tuple[Event, Figure] | None:
    """The top of the curve, or None where it is still rising when the log ends."""
    heard = _heard(ascent.time, track)
    place = int(np.argmax(np.where(heard, ascent.height, -np.inf)))
    if place >= ascent.time.size - 2 or place == 0:
        return None
    drawn = np.where(heard, ascent.heights, -np.inf)
    tops = drawn.max(axis=1)
    moments = ascent.time[np.argmax(drawn, axis=1)]
    near = np.abs(track.time - ascent.time[place]) < 1.0
    left = track.height[near] - seen.pad - np.interp(track.time[near], ascent.time, ascent.height)
    rough = mad_sd(left) / 2 if mad_sd(left) > 3 * track.noise else 0.0
    satellites = track.source == CHANNEL_TITLES["gps_altitude_msl"]
    least = max(_LEAST_GPS, _wander(track, seen)) if satellites else _MIN_APOGEE_ERROR
    sd = float(np.sqrt(tops.std() ** 2 + seen.pad_sd**2 + rough**2 + least**2))
    spread = 1.4826 * np.median(np.abs(moments - ascent.time[place]))
    event = Event(float(ascent.time[place]), float(np.hypot(spread, 0.04 if ascent.fused else 0.06)), track.source)
    return event, Figure(float(ascent.height[place]), sd, track.source)


def _heard(time: Float[Array, "knot"], track: Heights) -> Flags:
    """Which knots of a curve lie among samples and not in a long silence, where a curve may swing as it likes."""
    after = np.clip(np.searchsorted(track.time, time), 1, track.time.size - 1)
    gap = track.time[after] - track.time[after - 1]
    heard = np.asarray(gap <= _MAX_HEARD_GAP)
    return heard if heard.any() else np.ones(time.size, bool)


def _wander(track: Heights, seen: Outline) -> float:
    """By how much a receiver's height moves on the ground, before lift-off or after landing: two such are apart by
    more, the pad's and the top's. [m]"""
    first, last = track.time[0], track.time[-1]
    rests = (
        track.height[(track.time < (seen.lift or first) - 0.5)],
        track.height[(track.time > max(seen.top + 5, last - _REST))],
    )
    still = [float(one.std()) for one in rests if one.size >= 8 and np.ptp(one) < _MAX_WANDER]
    return float(np.sqrt(2)) * max(still, default=0.0)


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

"""Results from each part of a flight once the ascent is fitted: boost, top and descent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.analysis.apogee import apogee_of, falls, height_at
from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, MIN_SAMPLES, Heights, Push
from fieldkit.analysis.descent import descent_speed, landing
from fieldkit.analysis.descent_stages import descent_stages
from fieldkit.analysis.disturbed_heights import lasting_step
from fieldkit.analysis.drag_and_impulse import drag_and_impulse
from fieldkit.analysis.ejection import ejection, perhaps_of_opening, shock
from fieldkit.analysis.forces import boost_event, climb_of, forces
from fieldkit.analysis.hard_boost import hidden_lead, speed_by_climb
from fieldkit.analysis.height_lag import MAX_HEIGHT_GAP
from fieldkit.analysis.initial_guess import levelled
from fieldkit.analysis.notes import (
    AFTER_END_NOTE,
    DIVES_NOTE,
    LOST_IN_BOOST,
    NO_APOGEE,
    NO_BOOST,
    NO_FLIGHT,
    NO_LANDING,
    NO_LIFTOFF,
    NO_PAD,
    STEP_NOTE,
    UNSEEN_TOP_NOTE,
)
from fieldkit.analysis.peak import peak_push
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.possible import by_energy, is_flight, known_well, possible
from fieldkit.analysis.records import Event, Figure, Recorded
from fieldkit.analysis.robust_statistics import hole_at, median_step
from fieldkit.analysis.unseen_top import accelerates, apogee_after_end, silence, unseen_apogee
from fieldkit.flight import Series
from fieldkit.messages import amount, message
from fieldkit.physics.standard_atmosphere import GRAVITY, pressure_height
from fieldkit.shapes import Array, Float

_COAST_BEGINS = 0.5
"""Time after burnout that shows how fast a coast begins to slow down. [s]"""
_STEP_REACH = 0.5
"""How long after the top speed of a curve a step of the heights may be that causes that speed. [s]"""
_BLIND_PART = 0.75
"""Largest spacing of samples that still show a boost, as a fraction of its duration. [1]"""
_FELT_SCALE_SD, _FELT_ZERO_SD = 0.045, 0.15
"""Error of a felt speed relative to that of heights in standard air, by 2% of the accelerometer's scale and 12 K of the
air [1], and of an accelerometer's zero since the pad [m/s^2]."""
_DIVE_BEFORE = 3.0
"""How long before the lift-off that heights show they may dive: it is then that of their return. [s]"""
_DIVES, _FROM_BOOST = (12.0, 5.0), ("burn_time", "avg_accel", "peak_accel", "coast_to_apogee")
"""How far below the pad heights of a climb are off, in their noise [1] and at least [m], and what they then hide."""
_RECEIVER_LAG, _FROM_JOLTS = 0.5, ("time_to_apogee", "coast_to_apogee", "apogee_to_eject", "duration")
"""How late the heights of a satellite receiver follow a boost or a braking by its own filter, more than smooth parts of
a flight [s], and the times that it lengthens or shortens."""


@dataclass(frozen=True, slots=True, eq=False)
class FittedLog:
    """The contents of a log and the fitted curve of its ascent.

    `push` is the acceleration trusted for its size, `felt` the one trusted for shocks; `every` are the times of all
    samples [s], `stated` the events that the logger marked [s]. `drag` if drag and impulse are to be measured;
    `compared` if `push` was compared with the heights; `slanted` if the rocket climbed at a large angle.
    """

    track: Heights
    every: Float[Array, "time"]
    seen: Outline
    ascent: Ascent
    push: Push | None
    felt: Push | None
    stated: Mapping[str, float]
    drag: bool = True
    compared: bool = True
    slanted: bool = False

    @property
    def source(self) -> str:
        """The channels that shaped the curve."""
        others = [self.push.source] if self.push and self.ascent.fused else []
        return " and ".join([self.track.source, *others])


@dataclass(frozen=True, slots=True)
class _FlightPart:
    """Events and figures of one part of a flight."""

    events: Mapping[str, Event] = field(default_factory=dict)
    figures: Mapping[str, Figure] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def recorded_of(log: FittedLog, lift: Event | None, clocks: Sequence[Series]) -> Recorded:
    """Results from a fitted ascent and the descent after it."""
    begin = lift.time if lift else float(log.ascent.time[0])
    gap = silence(log.track, log.seen)
    unseen = unseen_apogee(log.track, log.seen, log.ascent, gap) if gap else None
    notes: tuple[str, ...] = ()
    if gap and accelerates(log.ascent, gap[0]):
        return _lost_in_boost(log, lift, gap)
    if unseen and gap:
        apogee: tuple[Event, Figure] | None = unseen[:2]
        notes = (message(UNSEEN_TOP_NOTE.format(gap[1] - gap[0], *(amount(one, "m") for one in unseen[2]))),)
    elif log.seen.down or falls(log.ascent):
        apogee = apogee_of(log.ascent, log.seen, log.track)
    else:
        after = apogee_after_end(log.track, log.seen, log.ascent) if lift else None
        apogee = after[:2] if after else apogee_of(log.ascent, log.seen, log.track) if _turned(log.ascent) else None
        notes = (message(AFTER_END_NOTE.format(*(amount(one, "m") for one in after[2]))),) if after else ()
    end = apogee[0].time if apogee else float(log.ascent.time[-1])
    lift, boost = _boost(log, lift, begin, end)
    burnt = boost.events.get("burnout")
    burnout = burnt.time if burnt else begin
    top = _top(log, lift, burnt, apogee)
    down = _down(log, apogee[0], lift, burnout, gap[1] if unseen and gap else None) if apogee else _FlightPart()
    events = {**({"liftoff": lift} if lift else {}), **boost.events, **top.events, **down.events}
    figures = {**boost.figures, **top.figures, **down.figures}
    dive = _dive(log, lift.time, end) if lift and log.track.is_barometric and not log.ascent.fused else None
    if lift and dive is not None:
        hidden = max(lift.time - dive, 0.0)
        events["liftoff"] = replace(lift, sd=float(np.hypot(lift.sd, hidden)))
        figures = {name: one for name, one in figures.items() if name not in _FROM_BOOST}
        since = {name: figures[name] for name in ("time_to_apogee", "duration") if name in figures}
        figures |= {name: replace(one, sd=float(np.hypot(one.sd, hidden))) for name, one in since.items()}
        notes = (*notes, DIVES_NOTE)
    if log.track.source == CHANNEL_TITLES["gps_altitude_msl"] and not log.ascent.fused:
        late = {name: figures[name] for name in _FROM_JOLTS if name in figures}
        figures |= {name: replace(one, sd=float(np.hypot(one.sd, _RECEIVER_LAG))) for name, one in late.items()}
    coasts_from = float(np.interp(burnt.time, log.ascent.time, log.ascent.height)) if burnt else None
    known = {name: figure for name, figure in figures.items() if np.isfinite(figure.sd)}
    if not is_flight(known, coasts_from, float(log.ascent.height.max()), log.seen.climbs):
        return Recorded(notes=(NO_FLIGHT,))
    climb = climb_of(log.ascent, begin, burnout, end, log.source)
    free = min(event.time for event in (*down.events.values(), Event(end, 0.0, "")))
    if lift and burnt and apogee and log.drag:
        push = log.push if log.ascent.fused and not log.slanted else None
        known |= drag_and_impulse(log.track, log.seen.pad, log.ascent, push, (lift, burnt, free), log.source)
    known, wrong = by_energy({name: figure for name, figure in known.items() if np.isfinite(figure.sd)}, coasts_from)
    known, impossible = possible(known)
    known, unknown = known_well(known)
    pressed = forces(climb, log.push, _elevation(clocks, lift), free) if lift and burnt else None
    return Recorded(
        events,
        known,
        climb,
        pressed,
        (*notes, *top.notes[:1], *boost.notes, *top.notes[1:], *down.notes, *wrong, *impossible, *unknown),
        sighted=log.ascent.sighted.scale if log.ascent.sighted else None,
    )


def _dive(log: FittedLog, lift: float, top: float) -> float | None:
    """When heights begin to dive below the pad around lift-off or in the first half of a climb [s]: in a boost the
    error of static ports or of shocks is then larger than the climb, and hides its length. None if they do not.

    Derivation: ports that are off by s show h - s v²/2g, which falls while a rocket accelerates by more than g/s.
    """
    inside = np.flatnonzero((log.track.time > lift - _DIVE_BEFORE) & (log.track.time < (lift + top) / 2))
    below = log.seen.pad - log.seen.calm[inside]
    deep = np.flatnonzero(below > max(_DIVES[0] * log.track.noise, _DIVES[1]))
    if not deep.size:
        return None
    level = np.flatnonzero(below[: deep[0]] < 2 * log.track.noise)
    return float(log.track.time[inside[level[-1] if level.size else 0]])


def _turned(ascent: Ascent) -> bool:
    """Whether nearly all curves that fit the samples come down at their end."""
    return bool(np.quantile(ascent.speeds[:, -1], 0.95) < 0)


def _lost_in_boost(log: FittedLog, lift: Event | None, gap: tuple[float, float]) -> Recorded:
    """Results from a log with a gap from the boost to the descent: without a coast, nothing bounds the apogee.

    The time of apogee is anywhere in the gap, with equal probability.
    """
    begin, end = gap
    apogee = Event((begin + end) / 2, (end - begin) / float(np.sqrt(12)), log.track.source)
    down = _down(log, apogee, lift, begin, end)
    known, unknown = known_well({name: one for name, one in down.figures.items() if np.isfinite(one.sd)})
    events = {**({"liftoff": lift} if lift else {}), **down.events}
    return Recorded(events, known, notes=(LOST_IN_BOOST.format(end - begin), *down.notes, *unknown))


def _boost(log: FittedLog, lift: Event | None, begin: float, end: float) -> tuple[Event | None, _FlightPart]:
    """Lift-off, if it is trusted, and the results from the boost.

    Derivation: behind a first-order filter, an acceleration a that becomes a deceleration d at once is zero ln(1 + a/d)
    time constants later.
    """
    whole = speed_by_climb(lift, log.track, log.seen) if lift is not None and _shows_ports(log, lift) else None
    found = boost_event(log.ascent, log.push, begin, end, log.source, whole)
    lost = _lost(log.track, begin, found[0].time) if found else None
    notes: tuple[str, ...] = ()
    if lost is not None and lost < begin:
        lift = None
    felt = log.push if log.ascent.fused else None
    times = felt.time if felt else log.every
    unseen = found is not None and ((lost is not None and not felt) or _is_unseen(times, begin, found[0].time))
    if found is not None and (unseen or found[1].value <= 0):
        found, notes = None, (NO_BOOST,)
    step = lasting_step(log.track, begin, found[0].time + _STEP_REACH) if found is not None and not felt else None
    if step is not None:
        found, notes = None, (message(STEP_NOTE.format(amount(step[1], "m"))),)
    if lift is None:
        notes += (NO_LIFTOFF,)
    if found is None or lift is None or found[0].time >= end - 0.2:
        return lift, _FlightPart(notes=notes)
    burnout, speed = found
    if log.track.is_barometric and lift.source == log.track.source and burnout.time > lift.time:
        lead = hidden_lead(speed.value, burnout.time - lift.time, log.track.noise, lift.sd)
        lift = replace(lift, sd=max(lift.sd, lead))
    if felt:
        slows = _slowing(log.ascent, burnout.time)
        late = felt.blur * float(np.log1p(max(speed.value / max(burnout.time - begin, 0.1), 0.0) / slows))
        speed = replace(speed, sd=float(np.hypot(speed.sd, felt.blur * slows)))
        burnout = replace(burnout, sd=float(np.hypot(burnout.sd, late)))
    if felt is not None and not log.compared:
        speed = _doubted(speed, felt, lift.time, burnout.time)
    if felt is not None and felt.full is not None and not log.slanted:
        charge = shock(log.felt, burnout.time, end)
        speed = _with_coast(speed, felt, log.ascent, burnout.time, min(end, charge.time) if charge else end)
    figures = {"top_speed": speed, **_burn(log, lift, burnout, speed)}
    return lift, _FlightPart({"burnout": burnout}, figures, notes)


def _shows_ports(log: FittedLog, lift: Event) -> bool:
    """Whether nothing but a barometer shows a boost, without a lag."""
    alone = not log.ascent.fused and log.ascent.ended is None and log.ascent.sighted is None
    return alone and log.track.is_barometric and lift.source == log.track.source and not log.track.shift


def _slowing(ascent: Ascent, burnout: float) -> float:
    """Deceleration at the beginning of the coast, in which a filter sees thrust fade; gravity if it is not seen. [s],
    [m/s^2]"""
    begins = (ascent.time > burnout) & (ascent.time < burnout + _COAST_BEGINS)
    return max(-float(np.median(ascent.acceleration[begins])), GRAVITY) if begins.any() else GRAVITY


def _doubted(speed: Figure, push: Push, begin: float, burnout: float) -> Figure:
    """A top speed whose error includes its difference from the speed that the accelerometer alone gives.

    Near the speed of sound too few undisturbed heights remain to compare the two, and in a boost an error of the static
    ports is not constant. So if a curve through both is far from the accelerometer, either may be wrong. [m/s]
    """
    inside = (push.time >= begin) & (push.time <= burnout)
    net = levelled(push, begin)
    if net is None or inside.sum() < MIN_SAMPLES:
        return speed
    time, net = push.time[inside], net[inside]
    gained = float(np.trapezoid(net, time))
    return replace(speed, sd=float(np.hypot(speed.sd, speed.value - gained)))


def _with_coast(speed: Figure, push: Push, ascent: Ascent, burnout: float, free: float) -> Figure:
    """A top speed averaged with what a saturated accelerometer felt from burnout until the rocket is free of its thrust
    and its charge [s], at nearly no speed. [m/s]

    What it missed was found from heights, which static ports move; the coast after it is within its range. If the two
    differ by more than their errors, both errors are larger by Birge's ratio.

    Derivation: v(burnout) = v(end) + integral of g - a.
    """
    inside = (push.time >= burnout) & (push.time <= free)
    level = levelled(push, float(ascent.time[0]))
    if level is None or inside.sum() < MIN_SAMPLES or (push.full is not None and push.full[inside].any()):
        return speed
    lost = -float(np.trapezoid(level[inside], push.time[inside]))
    value = lost + float(np.interp(free, ascent.time, ascent.speed))
    sd = float(np.linalg.norm([_FELT_SCALE_SD * lost, _FELT_ZERO_SD * (free - burnout), push.missed_drag_sd]))
    ratio = max(1.0, abs(value - speed.value) / float(np.hypot(sd, speed.sd)))
    part = speed.sd**2 / (speed.sd**2 + sd**2)
    return replace(speed, value=speed.value + part * (value - speed.value), sd=ratio * sd * float(np.sqrt(part)))


def _burn(log: FittedLog, lift: Event, burnout: Event, speed: Figure) -> dict[str, Figure]:
    """Burn time, mean and peak acceleration."""
    burn = _between(lift, burnout, log.source)
    if burn.value <= 0:
        return {}
    mean = speed.value / burn.value
    sd = mean * np.hypot(speed.sd / speed.value, burn.sd / burn.value)
    figures = {"burn_time": burn, "avg_accel": Figure(mean, float(sd), log.source)}
    peak = peak_push(log.push, log.ascent, lift.time, burnout.time, figures["avg_accel"])
    return figures | ({"peak_accel": peak} if peak else {})


def _top(log: FittedLog, lift: Event | None, burnout: Event | None, apogee: tuple[Event, Figure] | None) -> _FlightPart:
    """Apogee, and the times to it."""
    if apogee is None:
        return _FlightPart(notes=(NO_APOGEE,))
    figures = {"apogee": apogee[1]}
    if lift:
        figures["time_to_apogee"] = _between(lift, apogee[0], log.track.source)
    if lift and burnout:
        figures["coast_to_apogee"] = _between(burnout, apogee[0], log.source)
    return _FlightPart({"apogee": apogee[0]}, figures, (NO_PAD,) if np.isinf(log.seen.pad_sd) else ())


def _down(
    log: FittedLog, apogee: Event, lift: Event | None, burnout: float, resumed: float | None = None
) -> _FlightPart:
    """Results from the descent; `resumed` is when samples resume if the top fell in a gap. [s]"""
    track, seen = log.track, log.seen
    landed, level = landing(track, seen, apogee.time)
    blow = shock(log.felt, burnout, apogee.time)
    if blow is not None and log.felt is not None:
        moved = np.interp(blow.time, log.ascent.time, log.ascent.speed, right=GRAVITY * (blow.time - apogee.time))
        blow = perhaps_of_opening(blow, log.felt, float(moved))
    ejected = ejection(log.stated, blow, track, apogee, landed)
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
    if resumed is not None and begin.time < resumed:
        begin = Event(resumed, 0.1 if ejected else begin.sd, track.source)
    at = figures.get("eject_altitude") if begin is ejected else None
    speed = descent_speed(track, seen, begin, landed, level, at, known=begin is ejected or begin.time > apogee.time)
    if speed:
        figures["descent_speed"] = speed
    stages = descent_stages(track, seen, max(begin.time, apogee.time), landed.time if landed else None)
    if stages:
        figures |= {"descent_speed": stages.main, "drogue_speed": stages.drogue, "main_altitude": stages.main_altitude}
    return _FlightPart(events, figures, () if landed else (NO_LANDING,))


def _is_unseen(time: Float[Array, "time"], begin: float, burnout: float) -> bool:
    """Whether the samples that show a boost are too widely spaced from lift-off to burnout."""
    first, last = np.searchsorted(time, (begin, burnout))
    between = float(np.diff(time[first:last]).max(initial=0.0))
    longest = max(hole_at(time, begin), hole_at(time, burnout), between)
    usual = median_step(time[max(0, first - 5) : last + 5])
    return longest > MAX_HEIGHT_GAP or usual > _BLIND_PART * (burnout - begin)


def _lost(track: Heights, begin: float, burnout: float) -> float | None:
    """When a receiver appears to fall around the boost after losing its satellites; None if never. [s]"""
    inside = slice(*np.searchsorted(track.time, (begin - 5, burnout + 1)))
    height = track.height[inside]
    if track.source != CHANNEL_TITLES["gps_altitude_msl"] or not height.size:
        return None
    fallen = np.flatnonzero(np.maximum.accumulate(height) - height > max(12 * track.noise, 5.0))
    return float(track.time[inside][fallen[0]]) if fallen.size else None


def _between(first: Event, second: Event, source: str) -> Figure:
    """The time from one event to another. [s]"""
    return Figure(second.time - first.time, float(np.hypot(first.sd, second.sd)), source)


def _elevation(clocks: Sequence[Series], lift: Event | None) -> float:
    """The pad above sea level, from its pressure or a channel above sea level; 0 if there is none. [m]"""
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

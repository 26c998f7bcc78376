"""Speeds, burnout and events that a simulation states for its own flight, used unchanged.

An altimeter's heights must be smoothed and its boost estimated; a simulation states both directly. Its figures have no
noise: their standard deviation is the interval between two of its rows.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.analysis.channels import MIN_SAMPLES
from fieldkit.analysis.notes import NO_FLIGHT, NO_HEIGHT
from fieldkit.analysis.phases import LEAST_GAIN
from fieldkit.analysis.records import Event, Figure, HeightTrack, MeasuredClimb, Recorded
from fieldkit.flight import Series
from fieldkit.shapes import Array, Flags, Float

SOURCE = "simulation"
_MOVING_SPEED = 0.3
"""Vertical speed above which the rocket has left the pad. [m/s]"""


def simulated(clocks: Sequence[Series], stated: Mapping[str, float]) -> Recorded:
    """Events and figures of a simulated flight; `stated` are the events that the program wrote [s].

    If it wrote none, lift-off is the first movement, and burnout the end of the thrust or otherwise the top speed.
    """
    series = next((one for one in clocks if one.altitude is not None), None)
    if series is None or series.altitude is None:
        return Recorded(notes=(NO_HEIGHT,))
    there = np.isfinite(series.altitude) & np.isfinite(series.time)
    time, height = series.time[there], series.altitude[there]
    if time.size < MIN_SAMPLES or np.ptp(height) < LEAST_GAIN or (np.diff(time) <= 0).all():
        return Recorded(notes=(NO_FLIGHT,))
    speed = _channel(series, "speed", there)
    speed = np.gradient(height, _rising(time)) if speed is None else speed
    acceleration = _channel(series, "acceleration", there)
    acceleration = np.gradient(speed, _rising(time)) if acceleration is None else acceleration
    moments = {"apogee": float(time[np.argmax(height)])}
    moments |= {name: when for name, when in stated.items() if name != "apogee" or time[0] <= when <= time[-1]}
    moments.setdefault("liftoff", _first(time, speed > _MOVING_SPEED))
    moments.setdefault("burnout", _burnout(series, there, time, speed, moments["apogee"]))
    events = {name: Event(when, _step(time, when), SOURCE) for name, when in moments.items()}
    figures = _figures(time, height, speed, acceleration, events)
    climbs = (time >= moments["liftoff"]) & (time <= moments["apogee"])
    climb = _climb(time[climbs], height[climbs], speed[climbs], acceleration[climbs], moments["burnout"])
    return Recorded(events, figures, climb, track=HeightTrack(time, height, SOURCE))


def _channel(series: Series, name: str, there: Flags) -> Array | None:
    """A channel of the simulation without gaps, or None if it has none."""
    values = getattr(series, name)
    if values is None or np.isfinite(values[there]).sum() < MIN_SAMPLES:
        return None
    values, known = values[there], np.isfinite(values[there])
    return np.asarray(np.interp(np.arange(values.size), np.flatnonzero(known), values[known]))


def _rising(time: Float[Array, "time"]) -> Float[Array, "time"]:
    """Strictly increasing times: rows with the same time, as a program writes them around an event, are separated
    slightly. [s]"""
    return np.asarray(time + 1e-9 * np.arange(time.size))


def _first(time: Float[Array, "time"], marked: Flags) -> float:
    return float(time[int(np.argmax(marked))]) if marked.any() else float(time[0])


def _burnout(
    series: Series, there: Flags, time: Float[Array, "time"], speed: Float[Array, "time"], top: float
) -> float:
    """When the thrust ends, otherwise when the climb is fastest. [s]"""
    thrust = _channel(series, "thrust", there)
    if thrust is not None and (burning := np.flatnonzero(thrust > 0)).size:
        return float(time[min(int(burning[-1]) + 1, time.size - 1)])
    return float(time[int(np.argmax(np.where(time <= top, speed, -np.inf)))])


def _step(time: Float[Array, "time"], when: float) -> float:
    """Half of the interval between the rows around a moment. [s]"""
    after = int(np.clip(np.searchsorted(time, when), 1, time.size - 1))
    return float(time[after] - time[after - 1]) / 2


def _figures(
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    speed: Float[Array, "time"],
    acceleration: Float[Array, "time"],
    events: Mapping[str, Event],
) -> dict[str, Figure]:
    """The readouts for which there is an event."""
    liftoff, burnout, apogee = (events[name] for name in ("liftoff", "burnout", "apogee"))
    climbs, burns = time <= apogee.time, (time >= liftoff.time) & (time <= burnout.time)
    figures = {"apogee": Figure(float(height.max()), 0.0, SOURCE)}
    top = float(speed[climbs].max())
    burn = _between(liftoff, burnout)
    figures |= {"top_speed": Figure(top, 0.0, SOURCE), "burn_time": burn}
    if burn.value > 0 and burns.any():
        mean = top / burn.value
        figures["avg_accel"] = Figure(mean, mean * burn.sd / burn.value, SOURCE)
        figures["peak_accel"] = Figure(float(acceleration[burns].max()), 0.0, SOURCE)
    figures |= {"time_to_apogee": _between(liftoff, apogee), "coast_to_apogee": _between(burnout, apogee)}
    if ejected := events.get("ejection"):
        at = float(np.interp(ejected.time, time, height))
        figures |= {"apogee_to_eject": _between(apogee, ejected), "eject_altitude": Figure(at, 0.0, SOURCE)}
    if landed := events.get("landing"):
        figures["duration"] = _between(liftoff, landed)
        begin = ejected or apogee
        falls = float(np.interp(begin.time, time, height) - np.interp(landed.time, time, height))
        if landed.time > begin.time and falls > 0:
            figures["descent_speed"] = Figure(falls / (landed.time - begin.time), 0.0, SOURCE)
    return figures


def _between(first: Event, second: Event) -> Figure:
    """Time between two events. [s]"""
    return Figure(second.time - first.time, float(np.hypot(first.sd, second.sd)), SOURCE)


def _climb(
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    speed: Float[Array, "time"],
    acceleration: Float[Array, "time"],
    burnout: float,
) -> MeasuredClimb | None:
    """The simulated climb; None if it has too few rows."""
    if time.size < MIN_SAMPLES:
        return None
    none = np.zeros(time.size)
    return MeasuredClimb(time, height, speed, none, acceleration, none, time <= burnout, SOURCE)

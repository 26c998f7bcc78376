"""Measurements from the samples of a flight: figures, events and forces, each with its uncertainty."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fieldkit.shapes import Array, Flags, Float, Int, Integers


@dataclass(frozen=True, slots=True)
class Figure:
    """A measured value in SI units, its standard deviation, and the channel it was derived from."""

    value: float
    sd: float
    source: str


@dataclass(frozen=True, slots=True)
class Event:
    """Time of an event on the log's own clock [s], its standard deviation, and how it was found."""

    time: float
    sd: float
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredClimb:
    """The smoothed ascent from lift-off to apogee at regular time steps.

    `time` [s] is on the log's clock. Heights are above the pad [m], speeds vertical [m/s], accelerations vertical and
    net of gravity [m/s^2]; both have standard deviations. `burning` is true up to top speed.
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    speed_sd: Float[Array, "time"]
    acceleration: Float[Array, "time"]
    acceleration_sd: Float[Array, "time"]
    burning: Flags
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Forces:
    """Thrust and drag measured on the way up, per mass of the rocket, at regular time steps.

    `push` is thrust minus drag, divided by mass [m/s^2]: the acceleration with gravity removed, as an axial
    accelerometer feels it. While the rocket coasts it is only drag, and `drag_area` is Cd·A over mass [m^2/kg] with the
    density of the standard atmosphere at that height; nan while burning and when the rocket is too slow. `window` is
    the averaging time of an axial accelerometer [s]; None if derived from smoothed heights.
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    speed_sd: Float[Array, "time"]
    push: Float[Array, "time"]
    push_sd: Float[Array, "time"]
    burning: Flags
    drag_area: Float[Array, "time"]
    window: float | None
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class HeightTrack:
    """The cleaned heights of a whole log as used in the measurement: above the pad [m], on the log's clock [s]."""

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Satellite heights above the pad [m] and vertical speeds [m/s], on the barometer's clock and scale.

    `order` is 0 for a height and 1 for a speed; `variance` is that of one sample, adjusted as if the errors of
    neighbors were independent. `static` is the fraction of the dynamic pressure by which the airframe's pressure is too
    high according to both [1].
    """

    time: Float[Array, "sample"]
    value: Float[Array, "sample"]
    order: Int[Integers, "sample"]
    variance: Float[Array, "sample"]
    static: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    """Ratio of barometric to satellite heights, and its standard deviation. [1]"""


@dataclass(frozen=True, slots=True)
class Recorded:
    """All measurements from the samples of one flight.

    `events` are named as in `fieldkit.importing.reading.EVENTS`, on the log's clock; `figures` are the readouts by
    their names in `Flight`, and `time_to_apogee`. What the samples do not show is absent, and `notes` give the reason.
    """

    events: Mapping[str, Event] = field(default_factory=dict)
    figures: Mapping[str, Figure] = field(default_factory=dict)
    climb: MeasuredClimb | None = None
    forces: Forces | None = None
    notes: tuple[str, ...] = ()
    track: HeightTrack | None = None
    device: Mapping[str, float] = field(default_factory=dict)
    """Readouts by the logger's own speed and the events that it marked, for comparison. [SI]"""
    sighted: tuple[float, float] | None = None
    """Ratio of barometric to satellite heights and its standard deviation, if the log has both. [1]"""
    true_apogee: Figure | None = None
    """The true height of a barometric apogee, and what it rests on."""

    def height_at(self, time: float) -> float | None:
        """Height above the pad at a time on the log's clock, from the smoothed ascent if it covers that time. [m]"""
        for path in (self.climb, self.track):
            if path is not None and path.time[0] <= time <= path.time[-1]:
                return float(np.interp(time, path.time, path.height))
        return None

"""What is measured in the samples of a flight: figures, events and forces, each with its uncertainty."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fieldkit.shapes import Array, Flags, Float, Int, Integers


@dataclass(frozen=True, slots=True)
class Figure:
    """A measured value in SI, its standard deviation, and the channel it was made from."""

    value: float
    sd: float
    source: str


@dataclass(frozen=True, slots=True)
class Event:
    """When something happened, on the log's own clock [s], with its standard deviation, and how it was found."""

    time: float
    sd: float
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredClimb:
    """The ascent as the samples have it, smoothed: from lift-off to apogee, on an even clock.

    `time` [s] is the log's own. Heights are above the pad [m], speeds vertical [m/s], accelerations vertical and net
    of gravity [m/s^2]; each has its standard deviation. `burning` is true up to top speed.
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    height_sd: Float[Array, "time"]
    speed: Float[Array, "time"]
    speed_sd: Float[Array, "time"]
    acceleration: Float[Array, "time"]
    acceleration_sd: Float[Array, "time"]
    burning: Flags
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Forces:
    """Thrust and drag as they were measured on the way up, per mass of the rocket, on an even clock.

    `push` is thrust less drag over mass [m/s^2], that is acceleration with gravity taken out: what an axial
    accelerometer feels. While the rocket coasts it is drag alone, and `drag_area` is Cd·A over mass [m^2/kg], by
    the density of the standard atmosphere at that height; nan while burning and if the rocket is too slow to say.
    `window` is how long the push of an axial accelerometer was averaged [s]; None if smoothed heights were made
    into it.
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    speed_sd: Float[Array, "time"]
    push: Float[Array, "time"]
    push_sd: Float[Array, "time"]
    burning: Flags
    drag_area: Float[Array, "time"]
    drag_area_sd: Float[Array, "time"]
    window: float | None
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class HeightTrack:
    """The heights of a whole log as they were measured with, cleaned: above the pad [m], on the log's own clock [s]."""

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Heights above the pad [m] and vertical speeds [m/s] as satellites have them, on the barometer's clock and scale.

    `order` is 0 for a height and 1 for a speed, `variance` that of one sample as if its neighbors erred independently.
    `static` is the fraction of the dynamic pressure by which the airframe's is too high, according to both. [1]
    """

    time: Float[Array, "sample"]
    value: Float[Array, "sample"]
    order: Int[Integers, "sample"]
    variance: Float[Array, "sample"]
    static: float = 0.0


@dataclass(frozen=True, slots=True)
class Recorded:
    """All that the samples of one flight say.

    `events` are named as in `fieldkit.importing.reading.EVENTS`, on the log's own clock; `figures` are the readouts
    by their names in `Flight`, and `time_to_apogee`. What the samples do not show is not there, and `notes` say why.
    """

    events: Mapping[str, Event] = field(default_factory=dict)
    figures: Mapping[str, Figure] = field(default_factory=dict)
    climb: MeasuredClimb | None = None
    forces: Forces | None = None
    notes: tuple[str, ...] = ()
    track: HeightTrack | None = None

    def height_at(self, time: float) -> float | None:
        """The height above the pad at a time on the log's clock, by the smoothed ascent if it has that. [m]"""
        for path in (self.climb, self.track):
            if path is not None and path.time[0] <= time <= path.time[-1]:
                return float(np.interp(time, path.time, path.height))
        return None

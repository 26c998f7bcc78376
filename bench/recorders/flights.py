"""Flights to be recorded: rigid rockets in wind (`bench.fast_truth`), both subsonic and supersonic."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench import barrowman, fast_truth
from bench.air import GRAVITY, LAPSE, SEA_TEMPERATURE, station_pressure
from bench.altimeter import barometric_height
from bench.motors import motor, motors
from bench.rockets import CLASSES
from bench.vertical import climb
from bench.world import Air, Airframe, Drag, Launch, Motor, Track
from fieldkit.shapes import Array, Float

SONIC_MOTORS = ("AeroTech I211W", "AeroTech J350W", "AeroTech I357T", "AeroTech J570W", "AeroTech K550W")
"""Motors that take a slender rocket through the speed of sound."""
STEP = 0.005
"""Time step of the recorded path. [s]"""
PEAK_WINDOW = 0.05
"""Averaging window of the peak acceleration. [s]"""
GUST, GUST_TIME = 0.5, 3.0
"""Vertical gusts near the ground on a launch day [m/s], and the duration of one [s]."""
UNDER_WAY, EXTENSION = 1.0, 30.0
"""Time after apogee and ejection from which gusts act, and by how much they lengthen a flight at most. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """The path of a flight at regular time steps from lift-off, and the time of its charge. SI.

    `height` is the reading of a perfect barometer and `above` the true height, `speed` the true vertical speed, `push`
    the specific force along the axis.
    """

    time: Float[Array, "step"]
    height: Float[Array, "step"]
    above: Float[Array, "step"]
    speed: Float[Array, "step"]
    push: Float[Array, "step"]
    burnout: float
    ejection: float | None
    landing: float
    elevation: float
    station: float
    """Pressure on the pad. [Pa]"""

    @property
    def apogee_time(self) -> float:
        """Time of apogee. [s]"""
        return float(self.time[np.argmax(self.height)])

    def readouts(self, *, barometric: bool = True) -> dict[str, float]:
        """The readouts of a perfect device in SI units, with heights from pressure or from satellites; speeds are
        vertical, and those of the heights."""
        if not barometric:
            return replace(self, height=self.above).readouts()
        climbs = self.time <= self.apogee_time
        speed = np.gradient(self.height, STEP)
        fastest = int(np.argmax(np.where(climbs, speed, -np.inf)))
        burn, top = float(self.time[fastest]), int(np.argmax(self.height))
        width = max(1, round(PEAK_WINDOW / STEP))
        smooth = np.convolve(self.push[: fastest + 1], np.ones(width) / width, "same")
        found = {
            "apogee": float(self.height[top]),
            "top_speed": float(speed[fastest]),
            "burn_time": burn,
            "avg_accel": float(speed[fastest]) / burn,
            "peak_accel": float(smooth.max()) - GRAVITY,
            "time_to_apogee": self.apogee_time,
            "coast_to_apogee": self.apogee_time - burn,
            "duration": self.landing,
        }
        if self.ejection is not None and self.ejection < self.landing:
            at = float(np.interp(self.ejection, self.time, self.height))
            found |= {"apogee_to_eject": self.ejection - self.apogee_time, "eject_altitude": at}
            found["descent_speed"] = at / (self.landing - self.ejection)
        return found


def draw(rng: np.random.Generator, count: int, *, sonic: bool = False, launch_angle: float = 0.0) -> list[Path]:
    """Typical sport flights, or supersonic ones, from rails at the given angle, or at a random one. [rad]"""
    launches = [_sonic(rng) if sonic else sport_launch(rng) for _ in range(count)]
    return paths([replace(one, tilt=launch_angle or one.tilt) for one in launches], rng)


def paths(launches: Sequence[Launch], rng: np.random.Generator, tracks: Sequence[Track] | None = None) -> list[Path]:
    """The paths of launches, in their order, from their tracks in another simulator if given."""
    flown = fast_truth.fly(launches) if tracks is None else tracks
    return [_path(launch, track, rng) for launch, track in zip(launches, flown, strict=True)]


def sport_launch(rng: np.random.Generator) -> Launch:
    """A rocket of any size with a motor of sufficient thrust, and a delay that fits its coast."""
    while True:
        names, diameters, masses = CLASSES[str(rng.choice(list(CLASSES)))]
        diameter, mass = float(rng.uniform(*diameters)), float(rng.uniform(*masses))
        found = _launch(rng, motors()[str(rng.choice(list(names)))], diameter, mass)
        if found is not None:
            return found


def _sonic(rng: np.random.Generator) -> Launch:
    while True:
        burning = motor(str(rng.choice(list(SONIC_MOTORS))))
        diameter = burning.diameter * float(rng.uniform(1.08, 1.4))
        found = _launch(rng, burning, diameter, float(rng.uniform(1.0, 2.6)), fastest=370.0)
        if found is not None:
            return found


def _launch(
    rng: np.random.Generator, burning: Motor, diameter: float, mass: float, fastest: float = 0.0
) -> Launch | None:
    """A launch of a stable rocket; None if it would leave its rail too slowly, or be too slow."""
    frame = Airframe(
        diameter,
        diameter * float(rng.uniform(13, 22)),
        diameter * float(rng.uniform(3, 5)),
        int(rng.choice([3, 4])),
        diameter * float(rng.uniform(1.4, 2.0)),
        diameter * float(rng.uniform(0.7, 1.1)),
        diameter * float(rng.uniform(0.9, 1.2)),
        diameter * float(rng.uniform(0.5, 1.0)),
        0.0,
    )
    cg = barrowman.cg_for_margin(frame, mass, burning.total_mass, burning.length, float(rng.uniform(1.3, 2.2)))
    early = np.linspace(0, 0.4, 41)
    lift = float(np.interp(early, burning.time, burning.thrust).mean()) / (GRAVITY * (mass + burning.total_mass))
    if not (0.35 * frame.length < cg < 0.8 * frame.length and 4.0 < lift < 45.0):
        return None
    elevation = float(rng.uniform(0, 1500))
    kelvin = (
        SEA_TEMPERATURE - LAPSE * elevation + float(rng.normal(0, 5))
    )  # readouts describe the sensor, not the weather
    air = Air(elevation, kelvin, wind=float(rng.uniform(0, 6)))
    drag = Drag(float(rng.uniform(0.35, 0.8)), float(rng.uniform(0.9, 1.2)), float(rng.uniform(0.3, 0.8)))
    launch = Launch(
        replace(frame, dry_cg=cg),
        mass,
        burning,
        drag,
        air,
        float(rng.uniform(1.5, 3.0)),
        tilt=float(np.radians(abs(rng.normal(0, 4)))),
        heading=float(rng.uniform(0, 2 * np.pi)),
        chute_area=mass * float(rng.uniform(0.35, 0.9)),
        opening=float(rng.uniform(0.2, 0.6)),
    )
    quick = climb(launch)
    if quick.apogee < 60 or quick.top_speed < fastest:
        return None
    return replace(launch, delay=max(1.0, quick.coast + float(rng.normal(0.5, 1.0))))


def _path(launch: Launch, track: Track, rng: np.random.Generator) -> Path:
    begin = track.liftoff
    end = float(track.time[-1])
    time = np.arange(0.0, end - begin, STEP)
    above = np.interp(time + begin, track.time, track.height)
    if track.ejection is not None:
        time, above = _in_gusts(time, above, track.ejection - begin, rng)
        end = begin + float(time[-1])
    height = barometric_height(above, launch.air)
    push = np.interp(time + begin, track.time, np.where(np.isnan(track.push), GRAVITY, track.push))
    return Path(
        time,
        height,
        above,
        np.gradient(above, STEP),
        push,
        track.burnout - begin,
        None if track.ejection is None else track.ejection - begin,
        end - begin,
        launch.air.elevation,
        station_pressure(launch.air.qnh, launch.air.elevation),
    )


def _in_gusts(
    time: Float[Array, "step"], above: Float[Array, "step"], ejection: float, rng: np.random.Generator
) -> tuple[Float[Array, "step"], Float[Array, "step"]]:
    """Times [s] and heights [m] of a flight whose descent is changed by vertical gusts, until it reaches the ground."""
    top, second = float(time[np.argmax(above)]), round(1 / STEP)
    sinks = max(float(above[-second] - above[-1]), 1.0)
    later = np.arange(time[-1] + STEP, time[-1] + EXTENSION, STEP)
    longer = np.append(time, later)
    height = np.append(above, above[-1] - sinks * (later - time[-1]))
    height = height + _lifted(longer - max(ejection, top) - UNDER_WAY, rng)
    last = int(np.argmax((height <= 0) & (longer > top))) or longer.size - 1
    return longer[: last + 1], height[: last + 1]


def _lifted(since: Float[Array, "step"], rng: np.random.Generator) -> Float[Array, "step"]:
    """Height change of a rocket under a parachute from gusts that follow an Ornstein-Uhlenbeck process. [m]"""
    from scipy.signal import lfilter

    part = STEP / GUST_TIME
    gusts = lfilter([1.0], [1.0, part - 1], rng.normal(0, GUST * np.sqrt(2 * part), since.size))
    return np.asarray(np.cumsum(np.where(since > 0, gusts, 0.0)) * STEP)


def sampled(
    path: Path, when: Float[Array, "time"], values: Sequence[float] | Float[Array, "step"], rest: float
) -> Array:
    """A quantity of the flight at given times; before lift-off and after landing it has its value at rest."""
    return np.asarray(np.interp(when, path.time, values, left=rest, right=rest))

"""Flights that are known exactly, and their logs from imperfect sensors."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.flight import Series
from fieldkit.motors import Motor
from fieldkit.physics.standard_atmosphere import (
    GRAVITY,
    HYDROSTATIC_EXPONENT,
    LAPSE,
    STANDARD_TEMPERATURE,
    height_pressure,
    pressure_height,
)

STEP = 0.004
"""Time step of the true flight. [s]"""


@dataclass(frozen=True)
class Rocket:
    """A rocket that climbs straight up on a thrust with a rise, a sag and a tail."""

    thrust: float = 60.0
    burn: float = 1.2
    mass: float = 0.5
    area: float = 0.0014
    """Cd times frontal area at low speed. [m^2]"""
    delay: float = 6.0
    """Time from burnout to ejection. [s]"""
    sink: float = 5.0
    """Descent speed under the parachute near the ground. [m/s]"""
    elevation: float = 200.0
    opening: float = 0.4
    main_sink: float = 0.0
    """Descent speed under a main that opens below the first device; 0 for none."""
    main_height: float = 0.0
    """Height at which the main is released."""


SMALL = Rocket()
TINY = Rocket(thrust=9.0, burn=0.7, mass=0.07, area=0.0005, delay=4.0)
LARGE = Rocket(thrust=900.0, burn=2.4, mass=8.0, area=0.008, delay=17.5, sink=8.0)
FAST = Rocket(thrust=2600.0, burn=3.4, mass=15.0, area=0.006, delay=26.0, sink=12.0)
"""A rocket that flies supersonic."""


@dataclass(frozen=True)
class Truth:
    """A flight; `felt` is the specific force along the axis, and time 0 is lift-off."""

    time: Any
    height: Any
    speed: Any
    felt: Any
    burnout: float
    ejection: float
    elevation: float

    @property
    def acceleration(self) -> Any:
        return np.gradient(self.speed, self.time)

    @property
    def apogee_time(self) -> float:
        return float(self.time[np.argmax(self.height)])

    def readouts(self) -> dict[str, float]:
        """The ten readouts and the time to apogee, as an ideal device has them."""
        fast, top = int(np.argmax(self.speed)), int(np.argmax(self.height))
        burn, land = float(self.time[fast]), float(self.time[-1])
        at_ejection = float(np.interp(self.ejection, self.time, self.height))
        width = round(0.05 / STEP)
        smooth = np.convolve(self.felt[: fast + 1], np.ones(width) / width, "same")
        return {
            "apogee": float(self.height[top]),
            "top_speed": float(self.speed[fast]),
            "burn_time": burn,
            "avg_accel": float(self.speed[fast]) / burn,
            "peak_accel": float(smooth.max()) - GRAVITY,
            "coast_to_apogee": float(self.time[top]) - burn,
            "apogee_to_eject": self.ejection - float(self.time[top]),
            "eject_altitude": at_ejection,
            "descent_speed": at_ejection / (land - self.ejection),
            "duration": land,
            "time_to_apogee": float(self.time[top]),
        }


def fly(rocket: Rocket, motor: Motor | None = None, thrust_factor: float = 1.0) -> Truth:
    """The true flight, integrated in small steps of Heun's method, with drag that rises near the speed of sound. With a
    `motor`, the rocket has its thrust and burn, and its mass excludes it."""
    if motor is not None:
        rocket = replace(rocket, burn=float(motor.burnout))
    rise = 0.08 * rocket.burn
    spent = np.cumsum(np.diff(motor.time) * (motor.thrust[1:] + motor.thrust[:-1])) if motor is not None else np.ones(1)
    spent = np.append(0.0, spent / spent[-1])

    def thrust(t: float) -> float:
        if motor is not None:
            return thrust_factor * float(np.interp(t, motor.time, motor.thrust, right=0.0))
        if t >= rocket.burn:
            return 0.0
        shape = 1.25 - 0.35 * t / rocket.burn
        return rocket.thrust * shape * min(t / rise + 0.3, 1.0) * min((rocket.burn - t) / (0.5 * rise), 1.0)

    def mass(t: float) -> float:
        if motor is None:
            return rocket.mass
        left = 1 - float(np.interp(t, motor.time, spent))
        return rocket.mass + motor.casing_mass + motor.propellant_mass * left

    def felt(t: float, h: float, v: float) -> float:
        rho = 1.225 * (1 - LAPSE * (h + rocket.elevation) / STANDARD_TEMPERATURE) ** (HYDROSTATIC_EXPONENT - 1)
        mach = abs(v) / 335.0
        area = rocket.area * (1 + 0.6 / (1 + np.exp(-(mach - 0.98) / 0.03)))
        since = (t - rocket.burn - rocket.delay) / rocket.opening
        if since > 0:
            area += min(since, 1.0) * 2 * rocket.mass * GRAVITY / (1.2 * rocket.sink**2)
        if released:
            main = min((t - released[0]) / rocket.opening, 1.0)
            area += main * 2 * rocket.mass * GRAVITY / (1.2 * rocket.main_sink**2)
        return float((thrust(t) - 0.5 * rho * area * v * abs(v)) / mass(t))

    released: list[float] = []
    t, h, v, rows = 0.0, 0.0, 0.0, []
    step = STEP
    while h >= 0:
        if t > rocket.burn + rocket.delay + 5 * rocket.opening:
            step = 5 * STEP
        if rocket.main_sink and not released and v < 0 and h < rocket.main_height:
            released.append(t)
        if released:
            step = STEP
        f = felt(t, h, v)
        rows.append((t, h, v, f))
        a = f - GRAVITY
        if h == 0.0 and v == 0.0 and a <= 0 and t < rocket.burn:  # held by the pad
            t += step
            rows[-1] = (t, 0.0, 0.0, GRAVITY)
            continue
        later = felt(t + step, h + step * v, v + step * a) - GRAVITY
        h, v, t = h + step * v + step**2 * a / 2, v + step * (a + later) / 2, t + step
    time, height, speed, push = np.array(rows).T
    return Truth(time, height, speed, push, rocket.burn, rocket.burn + rocket.delay, rocket.elevation)


@dataclass(frozen=True)
class Logger:
    """A barometer and its errors; heights in meters, times in seconds."""

    rate: float = 20.0
    noise: float = 0.4
    resolution: float = 0.0
    """Resolution of heights."""
    channel: str = "altitude"
    wait: float = 3.0
    """Duration of samples before lift-off."""
    late: float = 0.0
    """Time after lift-off at which the log begins."""
    early: float = 0.0
    """The log ends at this fraction of the way to apogee; 0 for after landing."""
    spikes: float = 0.0
    """Fraction of samples that are spikes."""
    shock: float = 0.0
    """Height error from the ejection charge, for a fifth of a second."""
    dip: bool = False
    """Whether shocks near the speed of sound lower the heights."""
    drift: float = 0.0
    """Error of the zero at lift-off, and its growth per hour."""
    jitter: float = 0.0
    """Jitter of the clock, as a fraction of the step."""
    rest: float = 10.0
    """Duration of samples after landing."""
    accelerometer: float = 0.0
    """Sampling rate of the accelerometer; 0 for none."""
    scale: float = 1.01
    bias: float = 0.15
    start: float = 100.0
    """Lift-off, on the log's clock."""


def log(truth: Truth, logger: Logger, random: np.random.Generator) -> tuple[Series, ...]:
    """The log of a flight: heights, and the acceleration on a second clock."""
    end = logger.early * truth.apogee_time if logger.early else truth.time[-1] + logger.rest
    begin = logger.late if logger.late else -logger.wait
    time = np.arange(begin + random.uniform(0, 1 / logger.rate), end, 1 / logger.rate)
    time = np.sort(time + logger.jitter / logger.rate * random.standard_normal(time.size))
    height = np.interp(time, truth.time, truth.height, left=0.0, right=0.0)
    shown = pressure_height(height_pressure(height + truth.elevation)) - truth.elevation
    shown = shown + logger.noise * random.standard_normal(time.size) + logger.drift * (1 + time / 3600)
    shown = shown + logger.shock * np.exp(-(((time - truth.ejection - 0.1) / 0.08) ** 2))
    if logger.dip:
        mach = np.interp(time, truth.time, truth.speed, left=0, right=0) / 335.0
        shown = shown - 250 * np.exp(-(((mach - 1.0) / 0.05) ** 2))
    far = random.random(time.size) < logger.spikes
    shown = shown + far * random.choice([-1, 1], time.size) * random.uniform(30, 900, time.size)
    if logger.resolution:
        shown = np.round(shown / logger.resolution) * logger.resolution
    channel = {"altitude": shown, "pressure": height_pressure(shown + truth.elevation)}[logger.channel]
    series = Series(time=time + logger.start, **{logger.channel: channel})
    if not logger.accelerometer:
        return (series,)
    ticks = np.arange(begin, end, 1 / logger.accelerometer)
    felt = np.interp(ticks, truth.time, truth.felt, left=GRAVITY, right=GRAVITY)
    felt = np.where(ticks < 0, GRAVITY, felt)
    blow = np.exp(-(((ticks - truth.ejection) / 0.03) ** 2)) * 15 * GRAVITY
    hanging = ticks > truth.ejection + 0.2
    felt = (
        logger.scale * felt
        + logger.bias
        + blow
        + random.normal(0, np.where(hanging & (ticks < truth.time[-1]), 8, 0.3))
    )
    return (series, Series(time=ticks + logger.start, felt=felt))


def changed(rocket: Rocket, random: np.random.Generator) -> Rocket:
    """The same kind of rocket on another day."""
    factor = np.exp(0.15 * random.standard_normal(4))
    return replace(
        rocket,
        thrust=rocket.thrust * factor[0],
        burn=rocket.burn * factor[1],
        area=rocket.area * factor[2],
        delay=rocket.delay * factor[3],
        elevation=float(random.uniform(0, 1500)),
    )

"""The log that a recorder writes of a flight: a table with a header of names and units, as loggers write it."""

import io

import numpy as np

from bench.air import GRAVITY, pressure_altitude
from bench.recorders.flights import GUST_TIME, STEP, Path
from bench.recorders.models import Recorder
from fieldkit.physics.standard_atmosphere import height_pressure
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

SOUND, SHOCK_WIDTH, SHOCKED = 335.0, 0.05, (0.92, 1.12)
"""Speed of sound [m/s], width of the edges of the shock region, and its range [Mach]."""
BLOW, BLOW_LASTS = 15 * GRAVITY, 0.03
"""Acceleration from the shock of a charge [m/s^2], and how long after the charge it is strongest [s]."""
WIND_PRESSURE_SD = 0.15
"""Standard deviation of heights from the pressure of the wind, by Bernoulli's equation U u / g: of the gusts u of
`bench.recorders.flights` in a mean wind U of 3 m/s. [m]"""
DRIFT_TIME = 4.0
"""Correlation time of a receiver's height. [s]"""
SWING = 8.0
"""Acceleration from swinging under a parachute. [m/s^2]"""


def written(path: Path, recorder: Recorder, rng: np.random.Generator) -> bytes:
    """The log of one flight as CSV: a row for each time at which some sensor was read."""
    begin, end = -recorder.wait, path.landing + recorder.rest
    columns: dict[str, tuple[Array, Array]] = {}
    if recorder.baro:
        when = _clock(begin, end, recorder.baro, recorder.jitter, rng)
        height = _barometer(path, recorder, when, rng)
        columns |= _height_columns(path, recorder, when, height)
        if recorder.speed or recorder.derived:
            speed = _lagged(np.gradient(_lagged(height, when, 0.15), when), when, 0.25)
            columns |= {"speed (m/s)": (when, speed)} if recorder.speed else {}
            if recorder.derived:
                columns["acceleration (m/s2)"] = (when, _lagged(np.gradient(speed, when), when, 0.25))
    if recorder.accel:
        when = _clock(begin, end, recorder.accel, 0.0, rng)
        columns |= _accelerometer(path, recorder, when, rng)
    if recorder.gps:
        when = _clock(begin, end, recorder.gps, 0.0, rng)
        drift = receiver_drift(when, recorder, rng)
        height = np.interp(when, path.time, path.above, left=0, right=0) + path.elevation
        noise = rng.normal(0, recorder.gps_noise / 3, when.size) + drift
        columns["gps altitude (m)"] = (when, np.round(height + noise, 1))
    return _table(columns, recorder, path)


def _clock(begin: float, end: float, rate: float, jitter: float, rng: np.random.Generator) -> Float[Array, "time"]:
    when = np.arange(begin + rng.uniform(0, 1 / rate), end, 1 / rate)
    return np.sort(when + jitter / rate * rng.standard_normal(when.size))


def _barometer(
    path: Path, recorder: Recorder, when: Float[Array, "time"], rng: np.random.Generator
) -> Float[Array, "time"]:
    """Readings of the barometer above the pad. [m]"""
    time = np.arange(when[0] - 1, when[-1] + 1, STEP)
    height = np.interp(time, path.time, path.height, left=0, right=0)
    speed = np.interp(time, path.time, path.speed, left=0, right=0)
    height = height - rng.normal(0, recorder.static) * speed * np.abs(speed) / (2 * GRAVITY)
    mach = speed / SOUND
    depth = np.minimum((mach - SHOCKED[0]) / SHOCK_WIDTH, (SHOCKED[1] - mach) / SHOCK_WIDTH)
    height = height - recorder.shocks * np.clip(depth, 0, 1) * float(rng.uniform(0.6, 1.4))
    if path.ejection is not None:
        height = height + recorder.charge * np.exp(-(((time - path.ejection - 0.1) / 0.1) ** 2))
    shown = np.interp(when, time, _lagged(height, time, recorder.lag))
    shown = shown + recorder.baro_noise * rng.standard_normal(when.size) + recorder.drift * when
    shown = shown + np.interp(when, time, wind_pressure(time.size, rng))
    far = rng.random(when.size) < recorder.spikes
    return np.asarray(shown + far * rng.choice([-1, 1], when.size) * rng.uniform(30, 900, when.size))


def wind_pressure(count: int, rng: np.random.Generator) -> Float[Array, "time"]:
    """Heights from the pressure of gusts at steps of a path, an Ornstein-Uhlenbeck process. [m]"""
    from scipy.signal import lfilter

    part = STEP / GUST_TIME
    steps = rng.normal(0, WIND_PRESSURE_SD * np.sqrt(2 * part), count)
    return np.asarray(lfilter([1.0], [1.0, part - 1], steps, zi=[rng.normal(0, WIND_PRESSURE_SD)])[0])


def _height_columns(
    path: Path, recorder: Recorder, when: Float[Array, "time"], height: Float[Array, "time"]
) -> dict[str, tuple[Array, Array]]:
    step = recorder.resolution
    if recorder.column == "pressure_pa":
        ground = float(pressure_altitude(path.station))
        return {"pressure (Pa)": (when, np.round(height_pressure(height + ground) / step) * step)}
    unit = FOOT if recorder.column == "altitude_ft" else 1.0
    name = "altitude (ft)" if recorder.column == "altitude_ft" else "altitude (m)"
    return {name: (when, np.round(height / unit / step) * step)}


def _accelerometer(
    path: Path, recorder: Recorder, when: Float[Array, "time"], rng: np.random.Generator
) -> dict[str, tuple[Array, Array]]:
    """Readings of the accelerometer's axes. [g]"""
    late = when - recorder.late
    felt = np.interp(late, path.time, path.push, left=GRAVITY, right=0.0)
    if path.ejection is not None:
        felt = felt + BLOW * np.exp(-(((late - path.ejection - BLOW_LASTS) / BLOW_LASTS) ** 2))
        hangs = (late > path.ejection + 0.2) & (late < path.landing)
        felt = np.where(hangs, GRAVITY * rng.uniform(0.3, 1.0), felt) + hangs * rng.normal(0, SWING, when.size)
    scale = 0.5 if recorder.scale >= 0.5 else 1 + rng.normal(0, recorder.scale)
    direction = np.array([1.0]) if recorder.axes == 1 else rng.normal(size=3)
    direction = direction / np.linalg.norm(direction)
    names = ["acceleration (g)"] if recorder.axes == 1 else [f"accel {axis} (g)" for axis in "xyz"]
    found = {}
    for name, part in zip(names, direction, strict=True):
        axis = (
            scale * felt * part + rng.normal(0, recorder.bias) + rng.normal(0, recorder.accel_noise, when.size)
        ) / GRAVITY
        axis = np.clip(axis, -recorder.accel_range, recorder.accel_range) if recorder.accel_range else axis
        found[name] = (when, np.round(axis / recorder.accel_step) * recorder.accel_step)
    return found


def _lagged(values: Float[Array, "time"], when: Float[Array, "time"], over: float) -> Float[Array, "time"]:
    """Values after a first-order filter."""
    if over <= 0:
        return values
    from scipy.signal import lfilter

    part = 1 - float(np.exp(-float(np.median(np.diff(when))) / over))
    return np.asarray(lfilter([part], [1, part - 1], values, zi=[(1 - part) * values[0]])[0])


def receiver_drift(when: Float[Array, "time"], recorder: Recorder, rng: np.random.Generator) -> Float[Array, "time"]:
    """Drift of a receiver's height, which began long before the log. [m]"""
    earlier = round(5 * DRIFT_TIME * recorder.gps)
    every = np.concatenate([when[0] - np.arange(earlier, 0, -1) / recorder.gps, when])
    return _lagged(rng.normal(0, 4 * recorder.gps_noise, every.size), every, DRIFT_TIME)[earlier:]


def _table(columns: dict[str, tuple[Array, Array]], recorder: Recorder, path: Path) -> bytes:
    clock = np.unique(np.concatenate([when for when, _ in columns.values()]))
    rows = np.full((clock.size, len(columns)), np.nan)
    for place, (when, values) in enumerate(columns.values()):
        rows[np.searchsorted(clock, when), place] = values
    begin = path.apogee_time + recorder.gap[0] if recorder.gap[0] > -90 else 0.3
    in_range = (clock < begin) | (clock >= begin + recorder.gap[1])
    start = clock[0]
    out = io.StringIO()
    out.write(",".join(["time (s)", *columns]) + "\n")
    for moment, row in zip((clock[in_range] - start).tolist(), rows[in_range].tolist(), strict=True):
        out.write(",".join([f"{moment:.4f}", *("" if cell != cell else f"{cell:.6g}" for cell in row)]) + "\n")
    return out.getvalue().encode()

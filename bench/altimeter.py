"""An AltimeterTwo in the nose: what its display shows after a flight.

The height above the pad is computed from the pressure with the standard atmosphere, so it reads low in warm air. Speed
and accelerations come from the accelerometer.

Scatter: 1 m is 12 Pa, the noise and drift of a barometric sensor over a flight; 0.3% is a tenth of the absolute error
in the data sheets of such sensors, as the part that varies from flight to flight. Speed is an integrated acceleration:
1%. Accelerations: 2.5%, from vibration and the mounting. Times: 0.05 s, a sample of 20 Hz. The device computes the
average acceleration from its speed and time, with an additional 1%; with rounding this reproduces the spread in a
journal of 116 flights (10th to 90th percentile of the ratio 0.957 to 1.036).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from bench.air import GRAVITY, pressure, pressure_altitude, station_pressure
from bench.world import Air, Track
from fieldkit.shapes import Array, Float

FOOT, MPH = 0.3048, 0.44704
RESOLUTION = {
    "apogee_m": FOOT,
    "top_speed_mps": MPH,
    "burn_time_s": 0.1,
    "peak_accel_g": 0.1,
    "avg_accel_g": 0.1,
    "coast_to_apogee_s": 0.1,
    "apogee_to_eject_s": 0.1,
    "eject_altitude_m": FOOT,
    "descent_speed_mps": MPH,
    "duration_s": 0.1,
}
"""The ten readouts in the order of the display, with their resolutions."""
TAIL = 4.0
"""Degrees of freedom of the noise of a device with `sds`. [1]"""


@dataclass(frozen=True, slots=True)
class Altimeter:
    """A device: the gain of its barometer, and the scale of its noise (0 for an ideal device).

    `bias` and `sds` replace its own by readout: a bias, of the logarithm or [s] from apogee to ejection, and standard
    deviations of the noise, constant in the readout's unit and proportional. `given` is the probability that a flyer
    writes down a readout of those.
    """

    gain: float = 1.0
    noise: float = 1.0
    bias: Mapping[str, float] = field(default_factory=dict)
    sds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    given: float = 1.0


def exact_readouts(track: Track, air: Air, gain: float = 1.0) -> dict[str, float]:
    """The ten readouts of a device without noise or rounding; readouts of the ejection are missing if there was none.

    Burn time is from lift-off to top speed, the average acceleration is top speed over burn time, the peak acceleration
    is net of gravity and under thrust, and the coast is from top speed to apogee.
    """
    height = barometric_height(track.height, air) * gain
    top = int(np.nanargmax(track.speed))
    powered = track.time <= track.burnout
    burn = float(track.time[top]) - track.liftoff
    apogee, at_apogee = _summit(track.time, height)
    shown = {
        "apogee_m": apogee,
        "top_speed_mps": float(track.speed[top]),
        "burn_time_s": burn,
        "peak_accel_g": float(track.push[powered].max()) / GRAVITY - 1,
        "avg_accel_g": float(track.speed[top]) / (GRAVITY * burn),
        "coast_to_apogee_s": at_apogee - float(track.time[top]),
        "duration_s": float(track.time[-1]) - track.liftoff,
    }
    if track.ejection is not None:
        shown["apogee_to_eject_s"] = track.ejection - at_apogee
        shown["eject_altitude_m"] = float(np.interp(track.ejection, track.time, height))
        hanging = np.isnan(track.speed)
        if hanging.sum() > 1:
            lost, duration = height[hanging][0] - height[-1], track.time[hanging][0] - track.time[-1]
            shown["descent_speed_mps"] = float(-lost / duration)
    return {name: shown[name] for name in RESOLUTION if name in shown}


def readouts(track: Track, air: Air, device: Altimeter, rng: np.random.Generator) -> dict[str, float]:
    """The ten readouts as displayed, with noise and rounding."""
    true = exact_readouts(track, air, device.gain)
    jitter = dict(zip(RESOLUTION, rng.standard_normal(len(RESOLUTION)) * device.noise, strict=True))
    shown: dict[str, float] = {}
    for name, value in true.items():
        if name in device.sds:
            fixed, ratio = device.sds[name]
            error = float(rng.standard_t(TAIL))
            if name == "apogee_to_eject_s":
                value += device.bias[name] + fixed * error
            else:
                value *= np.exp(device.bias[name] + np.hypot(fixed / value, ratio) * error)
        elif name == "avg_accel_g":
            value = shown["top_speed_mps"] / (GRAVITY * max(shown["burn_time_s"], 0.05)) * (1 + 0.01 * jitter[name])
        elif name in ("apogee_m", "eject_altitude_m"):
            value += np.hypot(1.0, 0.003 * value) * jitter[name]
        elif name in ("top_speed_mps", "descent_speed_mps"):
            value *= 1 + 0.01 * jitter[name]
        elif name == "peak_accel_g":
            value *= 1 + 0.025 * jitter[name]
        else:
            value += 0.05 * jitter[name]
        shown[name] = value
    if shown.get("eject_altitude_m", 0.0) > shown["apogee_m"]:
        shown["eject_altitude_m"] = shown["apogee_m"]
    if device.given < 1:
        shown = {name: value for name, value in shown.items() if name not in device.sds or rng.random() < device.given}
    return {name: round(value / RESOLUTION[name]) * RESOLUTION[name] for name, value in shown.items()}


def barometric_height(height: Float[Array, "*n"], air: Air) -> Float[Array, "*n"]:
    """The height that a barometer zeroed at the pad shows at a true height. [m]"""
    station = station_pressure(air.qnh, air.elevation)
    return np.asarray(pressure_altitude(pressure(height, air.temperature, station)) - pressure_altitude(station))


def _summit(time: Float[Array, "step"], height: Float[Array, "step"]) -> tuple[float, float]:
    """The greatest height and its time, from a parabola through the three highest steps."""
    top = int(np.argmax(height))
    if top in (0, len(height) - 1):
        return float(height[top]), float(time[top])
    a, b, c = np.polyfit(time[top - 1 : top + 2] - time[top], height[top - 1 : top + 2], 2)
    if a >= 0:
        return float(height[top]), float(time[top])
    return float(c - b**2 / (4 * a)), float(time[top] - b / (2 * a))

"""Kinds of recorders: a barometer, an accelerometer, satellites, and the faults of each."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Recorder:
    """What a logger measures and how; a rate of 0 means no such sensor. SI unless stated otherwise."""

    baro: float = 20.0
    """Sampling rate of the barometer. [1/s]"""
    baro_noise: float = 0.4
    resolution: float = 0.1
    """Resolution of recorded heights or pressures. [m, Pa]"""
    column: str = "altitude_m"
    """`altitude_m`, `altitude_ft` or `pressure_pa`."""
    lag: float = 0.0
    """Time constant of the filter or vents. [s]"""
    static: float = 0.03
    """Standard deviation between rockets of the airframe's pressure error, as a fraction of the dynamic pressure. No
    static port is free of it: in real logs with an accelerometer and a barometer it is -0.06 to 0.04, and the drags of
    both differ by 0.21 (`python -m tools.drags`), four times an error of 0.05. [1]"""
    shocks: float = 0.0
    """Height error near the speed of sound. [m]"""
    spikes: float = 0.0
    """Fraction of samples that are spikes. [1]"""
    charge: float = 0.0
    """Height error from ejection gas, for a fifth of a second. [m]"""
    drift: float = 0.0
    """Drift of the zero during the log. [m/s]"""
    jitter: float = 0.0
    """Jitter of the clock, as a fraction of a time step. [1]"""
    accel: float = 0.0
    """Sampling rate of the accelerometer. [1/s]"""
    accel_noise: float = 0.5
    accel_range: float = 0.0
    """Range of the accelerometer; 0 for unlimited. [g]"""
    accel_step: float = 0.01
    """Resolution of the accelerometer. [g]"""
    axes: int = 1
    """Number of axes: 1 along the rocket's axis, or 3 in a random orientation."""
    scale: float = 0.01
    """Standard deviation of the accelerometer's scale. [1]"""
    bias: float = 0.15
    """Standard deviation of its zero. [m/s^2]"""
    late: float = 0.0
    """Delay of its clock. [s]"""
    derived: bool = False
    """Whether the acceleration is derived from the heights instead."""
    speed: bool = False
    """Whether it records a speed, derived from filtered heights."""
    gps: float = 0.0
    """Sampling rate of the satellite receiver. [1/s]"""
    gps_noise: float = 1.5
    wait: float = 3.0
    """Time on the pad before lift-off; negative if the log begins in flight. [s]"""
    rest: float = 12.0
    """Time after landing at which the log ends; negative if it ends in flight. [s]"""
    gap: tuple[float, float] = (0.0, 0.0)
    """Gap in the log: its start relative to apogee, and its length. [s]"""
    sonic: bool = False
    """Whether it flies beyond Mach 1."""
    launch_angle: float = 0.0
    """Angle of the launch rail; 0 for a few random degrees. [deg]"""


_PLAIN = {
    "1 Hz": Recorder(baro=1, resolution=0.3),
    "2 Hz": Recorder(baro=2),
    "5 Hz feet": Recorder(baro=5, resolution=1, column="altitude_ft"),
    "10 Hz": Recorder(baro=10, resolution=0.3),
    "20 Hz": Recorder(),
    "20 Hz feet": Recorder(resolution=1, column="altitude_ft"),
    "20 Hz meters": Recorder(resolution=1),
    "20 Hz quiet": Recorder(baro_noise=0.08, resolution=0.01),
    "20 Hz noisy": Recorder(baro_noise=1.5),
    "50 Hz": Recorder(baro=50, baro_noise=0.6),
    "100 Hz": Recorder(baro=100, baro_noise=0.8),
    "200 Hz": Recorder(baro=200, baro_noise=1.0),
    "500 Hz": Recorder(baro=500, baro_noise=1.2),
    "pressure 10 Hz": Recorder(baro=10, column="pressure_pa", resolution=10),
    "pressure 50 Hz": Recorder(baro=50, column="pressure_pa", resolution=1),
    "jittery clock": Recorder(jitter=0.3),
    "device speed": Recorder(speed=True),
}
_BAROMETERS = {
    "filter 0.1 s": Recorder(lag=0.1),
    "filter 0.25 s": Recorder(lag=0.25),
    "small vents 0.4 s": Recorder(lag=0.4),
    "static ports without error": Recorder(static=0.0),
    "static 4 %": Recorder(baro=50, static=0.04),
    "spikes 1 %": Recorder(spikes=0.01),
    "spikes 5 %": Recorder(baro=50, spikes=0.05),
    "charge 30 m up": Recorder(charge=30.0),
    "charge 60 m down": Recorder(charge=-60.0),
    "drift": Recorder(drift=0.02),
    "short wait": Recorder(wait=0.3),
    "no wait": Recorder(wait=0.02),
    "begins 0.3 s late": Recorder(wait=-0.3),
    "begins 1 s late": Recorder(wait=-1.0),
    "begins 2.5 s late": Recorder(wait=-2.5),
}
_ACCELEROMETERS = {
    "accel 20 Hz": Recorder(accel=20),
    "accel 50 Hz": Recorder(accel=50),
    "accel 100 Hz": Recorder(baro=50, accel=100),
    "accel 200 Hz": Recorder(accel=200),
    "accel 400 Hz": Recorder(baro=50, accel=400, accel_noise=1.0),
    "accel 500 Hz, baro 1 Hz": Recorder(baro=1, accel=500),
    "accel noisy": Recorder(accel=100, accel_noise=4.0),
    "accel coarse": Recorder(accel=50, accel_step=0.2),
    "accel scale 4 %": Recorder(accel=100, scale=0.04, bias=0.4),
    "accel bias 0.1 g": Recorder(accel=100, bias=1.0),
    "clipped 16 g": Recorder(accel=100, accel_range=16),
    "clipped 8 g": Recorder(accel=100, accel_range=8),
    "clipped 4 g": Recorder(accel=100, accel_range=4),
    "three axes": Recorder(accel=100, axes=3),
    "three axes clipped 16 g": Recorder(accel=100, axes=3, accel_range=16),
    "three axes 20 Hz": Recorder(accel=20, axes=3),
    "accel 1.6 s late": Recorder(accel=100, late=1.6),
    "accel 0.3 s early": Recorder(accel=100, late=-0.3),
    "accel of half scale": Recorder(accel=100, scale=0.5),
    "derived acceleration": Recorder(derived=True, speed=True),
    "accel, filtered baro": Recorder(accel=100, lag=0.25),
    "accel, static 4 %": Recorder(accel=100, static=0.04),
    "accel, begins 0.3 s late": Recorder(accel=100, wait=-0.3),
    "accel, short wait": Recorder(accel=100, wait=0.3),
    "accel, leaning 20 degrees": Recorder(accel=100, launch_angle=20.0),
    "accel, leaning 28 degrees": Recorder(accel=100, launch_angle=28.0),
    "barometer, leaning 20 degrees": Recorder(launch_angle=20.0),
    "accel, charge": Recorder(accel=100, charge=40.0),
}
_RADIO = {
    "radio 10 Hz, gap in boost": Recorder(baro=10, gap=(-99.0, 1.0)),
    "radio 10 Hz, gap 3 s in coast": Recorder(baro=10, gap=(-5.0, 3.0)),
    "radio 10 Hz, gap 4 s at the top": Recorder(baro=10, gap=(-2.0, 4.0)),
    "radio 10 Hz, gap 12 s at the top": Recorder(baro=10, gap=(-3.0, 12.0)),
    "radio 10 Hz with accel, gap 4 s": Recorder(baro=10, accel=10, gap=(-2.0, 4.0)),
    "satellites 1 Hz": Recorder(baro=0, gps=1),
    "satellites 5 Hz": Recorder(baro=0, gps=5),
    "satellites 10 Hz": Recorder(baro=0, gps=10, gps_noise=0.8),
    "barometer and satellites": Recorder(gps=5),
}
_SONIC = {
    "sonic 20 Hz": Recorder(sonic=True),
    "sonic 20 Hz, shocks 250 m": Recorder(sonic=True, shocks=250.0),
    "sonic 100 Hz, shocks 60 m": Recorder(baro=100, sonic=True, shocks=60.0),
    "sonic accel, shocks 250 m": Recorder(sonic=True, shocks=250.0, accel=100),
    "sonic three axes, shocks 120 m": Recorder(baro=50, sonic=True, shocks=120.0, accel=100, axes=3),
    "sonic accel clipped 16 g": Recorder(sonic=True, shocks=120.0, accel=100, accel_range=16),
    "sonic barometer and satellites": Recorder(sonic=True, shocks=250.0, gps=5),
    "sonic satellites 5 Hz": Recorder(sonic=True, baro=0, gps=5),
}
RECORDERS: Mapping[str, Recorder] = {**_PLAIN, **_BAROMETERS, **_ACCELEROMETERS, **_RADIO, **_SONIC}
"""All kinds of recorders by name."""

"""A vertical flight of a point mass, with which a flyer would choose motors and delays.

It is also a check of the rigid rocket, which must agree with it without wind on a vertical rail.
"""

import math
from dataclasses import dataclass

import numpy as np

from bench.air import GAS, GRAVITY, pressure, station_pressure, temperature
from bench.world import Launch


@dataclass(frozen=True, slots=True)
class Climb:
    """Summary of a vertical flight."""

    apogee: float
    top_speed: float
    coast: float
    """From burnout to apogee. [s]"""


def climb(launch: Launch, step: float = 0.01) -> Climb:
    """A vertical flight on constant drag, by the midpoint rule, with no ejection before apogee."""
    motor, air = launch.motor, launch.air
    station = station_pressure(air.qnh, air.elevation)
    area = math.pi / 4 * launch.airframe.diameter**2
    impulse = np.concatenate([[0], np.cumsum(np.diff(motor.time) * (motor.thrust[1:] + motor.thrust[:-1]) / 2)])

    def rate(time: float, height: float, speed: float) -> float:
        thrust = float(np.interp(time, motor.time, motor.thrust, right=0.0))
        spent = float(np.interp(time, motor.time, impulse / impulse[-1]))
        mass = launch.dry_mass + motor.total_mass - motor.propellant_mass * spent
        kelvin = float(temperature(np.asarray(height), air.temperature))
        rho = float(pressure(np.asarray(height), air.temperature, station)) / (GAS * kelvin)
        acceleration = (thrust - rho / 2 * area * launch.drag.cd * speed * abs(speed)) / mass - GRAVITY
        return max(acceleration, 0.0) if height <= 0 and speed <= 0 else acceleration

    time, height, speed, top = 0.0, 0.0, 0.0, 0.0
    while speed > 0 or time < motor.burn_time:
        first = rate(time, height, speed)
        middle = rate(time + step / 2, height + speed * step / 2, speed + first * step / 2)
        height += (speed + first * step / 2) * step
        speed += middle * step
        time += step
        top = max(top, speed)
    return Climb(height, top, time - motor.burn_time)

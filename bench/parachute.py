"""The descent: under the open parachute the rocket falls at its terminal speed."""

import numpy as np
from scipy.integrate import solve_ivp

from bench.air import GAS, GRAVITY, pressure, station_pressure, temperature, wind_speed
from bench.world import Air, Launch
from fieldkit.shapes import Array, Float

SLICES = 25


def sinking_speed(height: Float[Array, "*n"], mass: float, drag_area: float, air: Air) -> Float[Array, "*n"]:
    """Terminal descent speed, at which drag equals weight. [m/s]"""
    station = station_pressure(air.qnh, air.elevation)
    rho = pressure(height, air.temperature, station) / (GAS * temperature(height, air.temperature))
    return np.asarray(np.maximum(np.sqrt(2 * mass * GRAVITY / (rho * drag_area)) - air.updraft, 0.5))


def descent(
    height: float, mass: float, drag_area: float, air: Air
) -> tuple[Float[Array, "step"], Float[Array, "step"]]:
    """Time since the start of the descent and height, down to the ground."""
    heights = np.linspace(height, 0.0, SLICES + 1)
    speeds = sinking_speed(heights, mass, drag_area, air)
    seconds = np.cumsum((heights[:-1] - heights[1:]) * (1 / speeds[:-1] + 1 / speeds[1:]) / 2)
    return seconds, heights[1:]


def opening(
    start: Float[Array, "six"], since: float, ejected: float, launch: Launch
) -> tuple[Float[Array, "step"], Float[Array, "six step"]]:
    """Times and states (position, velocity) from `since` until the rocket descends steadily or lands.

    It is a point mass with gravity, wind, and from `ejected` on the drag of a parachute that fills within
    `launch.opening`.
    """
    air, mass = launch.air, launch.dry_mass + launch.motor.total_mass - launch.motor.propellant_mass
    body = launch.drag.cd * launch.drag.power_off * np.pi / 4 * launch.airframe.diameter**2
    station = station_pressure(air.qnh, air.elevation)

    def rates(time: float, state: Float[Array, "six"]) -> Float[Array, "six"]:
        kelvin = temperature(state[2], air.temperature)
        rho = pressure(state[2], air.temperature, station) / (GAS * kelvin)
        wind = wind_speed(state[2], air.wind, air.wind_height, air.shear)
        flow = state[3:] - np.array([float(wind), 0.0, air.updraft])
        filled = np.clip((time - ejected) / launch.opening, 0, 1) ** 2
        drag_rate = rho / 2 * np.sqrt(flow @ flow) * (body + launch.chute_area * filled) / mass
        return np.concatenate([state[3:], -drag_rate * flow - np.array([0.0, 0.0, GRAVITY])])

    def sinks(time: float, state: Float[Array, "six"]) -> float:
        return float(state[5] + 1.0) if time > ejected + launch.opening + 0.5 else 1.0

    def lands(time: float, state: Float[Array, "six"]) -> float:
        return float(state[2])

    sinks.terminal = lands.terminal = True  # type: ignore[attr-defined]
    events = (sinks, lands)
    path = solve_ivp(rates, (since, ejected + 60), start, events=events, max_step=0.02, rtol=1e-6, atol=1e-6)
    return np.asarray(path.t), np.asarray(path.y)

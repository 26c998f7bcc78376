"""The true air of a simulation, and the standard air that an altimeter assumes."""

import numpy as np

from fieldkit.shapes import Array, Float

GAS = 287.05287
"""Specific gas constant of dry air. [J/(kg K)]"""
GRAVITY = 9.80665
LAPSE = 0.0065
"""Temperature lapse rate in the troposphere. [K/m]"""
SEA_TEMPERATURE = 288.15
SEA_PRESSURE = 101325.0
POWER = GRAVITY / (GAS * LAPSE)


def station_pressure(qnh: float, elevation: float) -> float:
    """Pressure at a field from the pressure reduced to sea level by the standard atmosphere. [Pa]"""
    return float(qnh * (1 - LAPSE * elevation / SEA_TEMPERATURE) ** POWER)


def temperature(height: Float[Array, "*n"], ground: Float[Array, "*n"] | float) -> Float[Array, "*n"]:
    """Temperature at a height above the pad, from that at the pad and the standard lapse. [K]"""
    return np.asarray(ground - LAPSE * height)


def pressure(
    height: Float[Array, "*n"], ground: Float[Array, "*n"] | float, station: Float[Array, "*n"] | float
) -> Float[Array, "*n"]:
    """Pressure at a height above the pad, in hydrostatic balance. [Pa]"""
    return np.asarray(station * (temperature(height, ground) / ground) ** POWER)


def wind_speed(
    height: Float[Array, "*n"],
    wind: Float[Array, "*n"] | float,
    at: Float[Array, "*n"] | float,
    shear: Float[Array, "*n"] | float,
) -> Float[Array, "*n"]:
    """Wind at a height above the pad; constant in the lowest meter. [m/s]"""
    return np.asarray(wind * (np.maximum(height, 1.0) / at) ** shear)


def turned(
    speed: Float[Array, "*n"], height: Float[Array, "*n"], turn: Float[Array, "*n"] | float
) -> Float[Array, "2 *n"]:
    """A wind toward +x at the pad that turns with height, by `turn` at 300 m and above [rad]: its two parts. [m/s]"""
    angle = turn * np.clip(height / 300.0, 0.0, 1.0)
    return np.array([speed * np.cos(angle), speed * np.sin(angle)])


def pressure_altitude(pressure: Float[Array, "*n"] | float) -> Float[Array, "*n"]:
    """Height in the U.S. Standard Atmosphere 1976 at which a pressure is found. [m]"""
    return np.asarray(SEA_TEMPERATURE / LAPSE * (1 - (np.asarray(pressure) / SEA_PRESSURE) ** (1 / POWER)))

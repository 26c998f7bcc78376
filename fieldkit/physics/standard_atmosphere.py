"""The standard atmosphere: what an altimeter converts pressure with, and the default for the pad.

Source: U.S. Standard Atmosphere 1976, troposphere and lower stratosphere.
"""

import numpy as np

from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

GAS_CONSTANT = 287.05287
"""Specific gas constant of dry air. [J/(kg K)]"""
LAPSE = 0.0065
"""Temperature lapse rate. [K/m]"""
STANDARD_TEMPERATURE = 288.15
"""Temperature at sea level. [K]"""
STANDARD_PRESSURE = 101325.0
"""Pressure at sea level. [Pa]"""
GRAVITY = STANDARD_GRAVITY
"""Standard acceleration of gravity. [m/s^2]"""
HYDROSTATIC_EXPONENT = GRAVITY / (GAS_CONSTANT * LAPSE)
"""Exponent of the pressure law of the troposphere. [1]"""
TROPOPAUSE = 11_000.0
"""Height above which the temperature is constant. [m]"""
_STRATOSPHERE_TEMPERATURE = STANDARD_TEMPERATURE - LAPSE * TROPOPAUSE
_TOP = STANDARD_PRESSURE * (_STRATOSPHERE_TEMPERATURE / STANDARD_TEMPERATURE) ** HYDROSTATIC_EXPONENT
_SCALE_HEIGHT = GAS_CONSTANT * _STRATOSPHERE_TEMPERATURE / GRAVITY


def pressure_height(pressure: Float[Array, "time"]) -> Float[Array, "time"]:
    """Height above sea level with this pressure [Pa] in the standard atmosphere; nan if it is not positive. [m]"""
    ratio = np.asarray(pressure, float) / STANDARD_PRESSURE
    ratio[~(ratio > 0)] = np.nan
    height = STANDARD_TEMPERATURE / LAPSE * (1 - ratio ** (1 / HYDROSTATIC_EXPONENT))
    thin = ratio < _TOP / STANDARD_PRESSURE
    height[thin] = TROPOPAUSE - _SCALE_HEIGHT * np.log(ratio[thin] * (STANDARD_PRESSURE / _TOP))
    return height


def height_pressure(height: Float[Array, "time"]) -> Float[Array, "time"]:
    """Pressure of the standard atmosphere at a height above sea level [m]. [Pa]"""
    height = np.asarray(height, float)
    temperature_ratio = 1 - LAPSE / STANDARD_TEMPERATURE * np.minimum(height, TROPOPAUSE)
    above = np.exp(-np.maximum(height - TROPOPAUSE, 0) / _SCALE_HEIGHT)
    return np.asarray(STANDARD_PRESSURE * temperature_ratio**HYDROSTATIC_EXPONENT * above)


def standard_density(height: Float[Array, "time"]) -> Float[Array, "time"]:
    """Density of the standard atmosphere at a height above sea level [m]. [kg/m^3]"""
    temperature = np.maximum(STANDARD_TEMPERATURE - LAPSE * np.asarray(height, float), _STRATOSPHERE_TEMPERATURE)
    return np.asarray(height_pressure(height) / (GAS_CONSTANT * temperature))

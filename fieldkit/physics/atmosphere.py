"""The air a rocket flies in, and how it biases a barometric altimeter.

Source: U.S. Standard Atmosphere 1976, troposphere, with the pad's values in place of those at sea level; saturation
pressure of water after Buck (1981).
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.physics.standard_atmosphere import (
    GAS_CONSTANT,
    HYDROSTATIC_EXPONENT,
    LAPSE,
    STANDARD_PRESSURE,
    STANDARD_TEMPERATURE,
)
from fieldkit.physics.standard_atmosphere import GRAVITY as GRAVITY
from fieldkit.shapes import Array, Float

WIND_EXPONENT = 1 / 7
"""Exponent of the power law of the wind over open ground. [1]"""
WIND_HEIGHT = 2.0
"""Height at which a flyer holds an anemometer. [m]"""
VAPOUR_RATIO = 0.62198
"""Ratio of the molar masses of water and dry air. [1]"""


@dataclass(frozen=True, slots=True)
class Air:
    """Air at the pad, one entry per draw, and its density profile with height.

    `density` [kg/m^3] and `temperature` [K] are those at the pad. With `scale_height` [m] the density falls
    exponentially, as in the reference paper; without it, as in the troposphere.
    """

    density: Float[Array, "*#draw"]
    temperature: Float[Array, "*#draw"]
    scale_height: float | None = None

    def density_ratio(self, height: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
        """Ratio of the density at a height above the pad [m] to the density at the pad. [1]"""
        if self.scale_height is not None:
            exponent = np.asarray(height * (-1 / self.scale_height))
            return np.asarray(np.exp(exponent, out=exponent))
        exponent = np.asarray(np.maximum(height * (-LAPSE / self.temperature), -0.9))
        np.log1p(exponent, out=exponent)
        exponent *= HYDROSTATIC_EXPONENT - 1
        return np.asarray(np.exp(exponent, out=exponent))

    def sinking_path(self, height: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
        """Integral of the square root of the density ratio from the pad up to a height [m]. [m]

        Divided by the descent speed near the ground, it gives the descent time, because the speed grows as the air
        thins.
        """
        if self.scale_height is not None:
            scale = 2 * self.scale_height
            return np.asarray(-scale * np.expm1(-height / scale))
        power = 0.5 * (HYDROSTATIC_EXPONENT + 1)
        colder = np.log1p(np.maximum(height * (-LAPSE / self.temperature), -0.9))
        return np.asarray(self.temperature / (-LAPSE * power) * np.expm1(power * colder))

    def sound_speed(self, height: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
        """Speed of sound at a height above the pad. [m/s]"""
        result: Float[Array, "*draw"] = np.sqrt(
            1.4 * GAS_CONSTANT * np.maximum(self.temperature - LAPSE * height, 150.0)
        )
        return result


def standard_temperature(elevation: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
    """Temperature of the standard atmosphere at a height above sea level. [K]"""
    return STANDARD_TEMPERATURE - LAPSE * elevation


def station_pressure(pressure: Float[Array, "*#draw"], elevation: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
    """Pressure at the pad from the pressure a flyer wrote down [Pa]. [Pa]

    Weather reports reduce it to sea level (QNH); a barometer at the pad reads it directly. The value is interpreted as
    whichever of the two it is closer to at this elevation [m].
    """
    standard = (1 - LAPSE * elevation / STANDARD_TEMPERATURE) ** HYDROSTATIC_EXPONENT
    reduced = np.abs(pressure - STANDARD_PRESSURE) <= np.abs(pressure - STANDARD_PRESSURE * standard)
    result: Float[Array, "*draw"] = np.where(reduced, pressure * standard, pressure)
    return result


def pad_air(
    elevation: Float[Array, "*#draw"],
    temperature: Float[Array, "*#draw"],
    pressure: Float[Array, "*#draw"],
    humidity: Float[Array, "*#draw"],
) -> Air:
    """Air at the pad from the recorded conditions; nan means "not recorded" and is replaced by the standard value.

    Elevation above sea level [m], temperature [K], pressure [Pa], relative humidity [1]. The default pressure is the
    standard one at that elevation; the default humidity is 0.
    """
    elevation = np.nan_to_num(np.asarray(elevation, float), nan=0.0)
    kelvin = np.where(np.isnan(temperature), standard_temperature(elevation), temperature)
    pascal = station_pressure(np.where(np.isnan(pressure), STANDARD_PRESSURE, pressure), elevation)
    celsius = kelvin - 273.15
    saturation = 611.21 * np.exp((18.678 - celsius / 234.5) * celsius / (257.14 + celsius))
    vapour = np.nan_to_num(np.asarray(humidity, float), nan=0.0) * saturation
    return Air((pascal - (1 - VAPOUR_RATIO) * vapour) / (GAS_CONSTANT * kelvin), kelvin)


def density_altitude(density: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Height above sea level at which the standard troposphere has this density [kg/m^3]. [m]

    Density there is proportional to temperature to the power g/(R L) - 1.
    """
    sea_level = STANDARD_PRESSURE / (GAS_CONSTANT * STANDARD_TEMPERATURE)
    return np.asarray(STANDARD_TEMPERATURE / LAPSE * (1 - (density / sea_level) ** (1 / (HYDROSTATIC_EXPONENT - 1))))


def altimeter_gain(
    elevation: Float[Array, "*#draw"], temperature: Float[Array, "*#draw"], pressure: Float[Array, "*#draw"]
) -> Float[Array, "*draw"]:
    """Ratio of the height a barometric altimeter reads to the true height above the pad. [1]

    In a troposphere with this lapse rate, pressure to the power R L/g falls linearly with height, by L/T of its value
    at the pad per meter. An altimeter assumes the standard atmosphere and divides by the standard L/T at the same
    pressure. The gain is therefore the standard temperature at the pad's pressure divided by the true temperature: it
    is below 1 on a hot day.
    """
    elevation = np.nan_to_num(np.asarray(elevation, float), nan=0.0)
    kelvin = np.where(np.isnan(temperature), standard_temperature(elevation), temperature)
    pascal = station_pressure(np.where(np.isnan(pressure), STANDARD_PRESSURE, pressure), elevation)
    return STANDARD_TEMPERATURE * (pascal / STANDARD_PRESSURE) ** (1 / HYDROSTATIC_EXPONENT) / kelvin


def wind_at(
    height: Float[Array, "*#draw"],
    wind: Float[Array, "*#draw"],
    power: Float[Array, "*#draw"] | float = WIND_EXPONENT,
    top: Float[Array, "*#draw"] | float = np.inf,
) -> Float[Array, "*draw"]:
    """Horizontal wind at a height above the pad [m], from the wind at the pad; constant above a height `top` [m]. [m/s]

    Source: the power law with exponent 1/7 over open ground (e.g. Panofsky and Dutton, 1984).
    """
    below = np.minimum(np.maximum(height, 0.0), top)
    result: Float[Array, "*draw"] = wind * (1 + below / WIND_HEIGHT) ** power
    return result

"""The air a rocket flies in and the air an altimeter reads.

Source: U.S. Standard Atmosphere 1976, troposphere, with its ground values replaced by the pad's;
saturation pressure of water after Buck (1981).
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.physics.standard_atmosphere import (
    GAS_CONSTANT,
    HYDROSTATIC,
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
"""Molar mass of water over that of dry air. [1]"""


@dataclass(frozen=True, slots=True)
class Air:
    """Air at the pad, one entry a draw, and how it thins with height.

    `density` [kg/m^3] and `temperature` [K] are the pad's. With `scale_height` [m] the air thins
    exponentially, as in the reference paper; without, as in the troposphere.
    """

    density: Float[Array, "*#draw"]
    temperature: Float[Array, "*#draw"]
    scale_height: float | None = None

    def density_ratio(self, height: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
        """Density at a height above the pad over density at the pad. [1]"""
        if self.scale_height is not None:
            share = np.asarray(height * (-1 / self.scale_height))
            return np.asarray(np.exp(share, out=share))
        warmth = np.asarray(np.maximum(height * (-LAPSE / self.temperature), -0.9))
        np.log1p(warmth, out=warmth)
        warmth *= HYDROSTATIC - 1
        return np.asarray(np.exp(warmth, out=warmth))

    def sinking_path(self, height: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
        """Integral of the root of the density ratio from the pad up to a height. [m]

        Over a descent speed near the ground it is the time of the descent, for that speed grows as the air thins.
        """
        if self.scale_height is not None:
            scale = 2 * self.scale_height
            return np.asarray(-scale * np.expm1(-height / scale))
        power = 0.5 * (HYDROSTATIC + 1)
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
    """Pressure at the pad from the pressure a flyer wrote down. [Pa]

    Weather reports give it reduced to sea level (QNH), a barometer at the pad as it is; the figure is
    taken for whichever of the two it lies nearer to at this elevation [m].
    """
    standard = (1 - LAPSE * elevation / STANDARD_TEMPERATURE) ** HYDROSTATIC
    reduced = np.abs(pressure - STANDARD_PRESSURE) <= np.abs(pressure - STANDARD_PRESSURE * standard)
    result: Float[Array, "*draw"] = np.where(reduced, pressure * standard, pressure)
    return result


def pad_air(
    elevation: Float[Array, "*#draw"],
    temperature: Float[Array, "*#draw"],
    pressure: Float[Array, "*#draw"],
    humidity: Float[Array, "*#draw"],
) -> Air:
    """Air at the pad from what was recorded there; nan is "not recorded" and becomes the standard.

    Elevation above sea level [m], temperature [K], pressure [Pa], relative humidity [1]. Without a
    pressure it is the standard one of the elevation; without a humidity the air is dry.
    """
    elevation = np.nan_to_num(np.asarray(elevation, float), nan=0.0)
    warmth = np.where(np.isnan(temperature), standard_temperature(elevation), temperature)
    weight = station_pressure(np.where(np.isnan(pressure), STANDARD_PRESSURE, pressure), elevation)
    celsius = warmth - 273.15
    saturation = 611.21 * np.exp((18.678 - celsius / 234.5) * celsius / (257.14 + celsius))
    vapour = np.nan_to_num(np.asarray(humidity, float), nan=0.0) * saturation
    return Air((weight - (1 - VAPOUR_RATIO) * vapour) / (GAS_CONSTANT * warmth), warmth)


def density_altitude(density: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Height above sea level at which the standard troposphere is as thin as this [kg/m^3]. [m]

    There density falls with the temperature to the power g/(R L) - 1.
    """
    sea_level = STANDARD_PRESSURE / (GAS_CONSTANT * STANDARD_TEMPERATURE)
    return np.asarray(STANDARD_TEMPERATURE / LAPSE * (1 - (density / sea_level) ** (1 / (HYDROSTATIC - 1))))


def altimeter_gain(
    elevation: Float[Array, "*#draw"], temperature: Float[Array, "*#draw"], pressure: Float[Array, "*#draw"]
) -> Float[Array, "*draw"]:
    """Height shown by a barometric altimeter over true height above the pad. [1]

    In a troposphere with this lapse, pressure to the power R L/g falls linearly with height, by L/T of
    its pad value a meter; an altimeter that believes in the standard atmosphere divides by the standard's
    L/T at the same pressure. So the gain is the standard temperature at the pad's pressure over the true
    one: low on a hot day.
    """
    elevation = np.nan_to_num(np.asarray(elevation, float), nan=0.0)
    warmth = np.where(np.isnan(temperature), standard_temperature(elevation), temperature)
    weight = station_pressure(np.where(np.isnan(pressure), STANDARD_PRESSURE, pressure), elevation)
    return STANDARD_TEMPERATURE * (weight / STANDARD_PRESSURE) ** (1 / HYDROSTATIC) / warmth


def wind_at(
    height: Float[Array, "*#draw"],
    wind: Float[Array, "*#draw"],
    power: Float[Array, "*#draw"] | float = WIND_EXPONENT,
    top: Float[Array, "*#draw"] | float = np.inf,
) -> Float[Array, "*draw"]:
    """Horizontal wind at a height above the pad from the wind measured there, even above a height `top` [m]. [m/s]

    Source: the power law, one seventh over open ground (e.g. Panofsky and Dutton, 1984).
    """
    below = np.minimum(np.maximum(height, 0.0), top)
    result: Float[Array, "*draw"] = wind * (1 + below / WIND_HEIGHT) ** power
    return result

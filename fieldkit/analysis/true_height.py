"""The true height of an apogee that a barometer measured, by what the log knows of the air.

An altimeter converts pressure by the standard atmosphere; layers of warm air are thicker, in proportion to their
temperature. So the heights of all such altimeters agree on a hot day, and all are too low: by 0.35% per kelvin.

Source: the hypsometric equation, U.S. Standard Atmosphere 1976.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.analysis.labels import sensor_of
from fieldkit.analysis.records import Figure, Recorded
from fieldkit.flight import Series
from fieldkit.flight.columns import CONDITIONS
from fieldkit.flight.limits import possible
from fieldkit.physics.standard_atmosphere import (
    HYDROSTATIC_EXPONENT,
    STANDARD_PRESSURE,
    STANDARD_TEMPERATURE,
    height_pressure,
)

STANDARD_AIR = "standard air: the log has no temperature"
SATELLITES = "the satellites of the log"
MEASURED_AIR = "the temperature of the flight"
SENSOR_AIR = "the altimeter's own temperature, which is above that of the air"
_DAY_SD = 12.0
"""Standard deviation of the temperature on days of flights from the standard one, as that of the effect of hot and cold
days. [K]"""
_SENSOR_WARMER, _SENSOR_SD = 5.0, 6.0
"""How much warmer than the air a sensor on the pad is by its circuits and the sun on its tube, and the standard
deviation of that. [K]"""
_LAYER_SD = 2.0
"""Standard deviation between the mean temperature of a layer and that of the ground, each relative to the standard
ones: on a sunny day it falls by up to 9.8 K/km, not 6.5, and below an inversion it rises. [K]"""
_AIR = {column.name: column for column in CONDITIONS}


def true_apogee(
    recorded: Recorded, clocks: Sequence[Series], temperature: float | None, elevation: float | None
) -> Figure | None:
    """The true height of a barometric apogee [m], and what its scale rests on; None for an apogee that has none, or by
    another sensor.

    `temperature` is that of the air at the pad [K], and `elevation` of the pad [m], if known.
    """
    apogee = recorded.figures.get("apogee")
    if apogee is None or sensor_of(apogee.source) != "baro":
        return None
    scale, sd, source = _scale(recorded, clocks, temperature, elevation)
    return Figure(apogee.value * scale, float(np.hypot(apogee.sd * scale, apogee.value * sd)), source)


def _scale(
    recorded: Recorded, clocks: Sequence[Series], temperature: float | None, elevation: float | None
) -> tuple[float, float, str]:
    """Ratio of true to barometric heights, its standard deviation [1], and what it rests on."""
    if recorded.sighted is not None and temperature is None:
        value, sd = recorded.sighted
        return 1 / value, sd / value**2, SATELLITES
    lift = recorded.events.get("liftoff")
    pressure = _on_pad("pressure", clocks, lift.time if lift else None)
    if pressure is None:
        pressure = float(height_pressure(np.array([elevation or 0.0]))[0])
    standard = STANDARD_TEMPERATURE * (pressure / STANDARD_PRESSURE) ** (1 / HYDROSTATIC_EXPONENT)
    sensor = _on_pad("temperature", clocks, lift.time if lift else None)
    air, sd, source = standard, _DAY_SD, STANDARD_AIR
    if temperature is not None:
        air, sd, source = temperature, 0.0, MEASURED_AIR
    elif sensor is not None:
        known = _DAY_SD**2 / (_DAY_SD**2 + _SENSOR_SD**2)
        air, sd, source = standard + known * (sensor - _SENSOR_WARMER - standard), _SENSOR_SD * known**0.5, SENSOR_AIR
    return air / standard, float(np.hypot(sd, _LAYER_SD)) / standard, source


def _on_pad(name: str, clocks: Sequence[Series], lift: float | None) -> float | None:
    """The median of the air's `pressure` or `temperature` before lift-off, or its first value; None if no clock has one
    that is possible on a pad. [Pa] or [K]"""
    low, high = possible(_AIR[name])
    for series in clocks:
        values = getattr(series, name)
        if isinstance(values, np.ndarray):
            known = np.flatnonzero((values >= low) & (values <= high))
            before = known[series.time[known] < lift] if lift is not None else known[:1]
            if known.size:
                return float(np.median(values[before if before.size else known[:1]]))
    return None

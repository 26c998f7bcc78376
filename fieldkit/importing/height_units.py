"""Check the heights of a logger against its pressures: an export in feet may look exactly like one in meters."""

from dataclasses import replace

import numpy as np

from fieldkit.flight import Series
from fieldkit.importing.reading import Note, Reading
from fieldkit.importing.tables.unit_inference import height_of_ratio
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

CLIMB = 30.0
"""Smallest climb whose pressures determine the unit of heights. [m]"""
COMPARED_FRACTION = 0.3
"""Fraction of the climb above which heights are compared: below it, offsets count too much. [1]"""
TOLERANCE = 1.25
"""Largest factor between the heights and those of the standard atmosphere, in the right unit. [1]"""
IN_LENGTHS = ("altitude", "altitude_msl", "speed", "inertial_altitude", "inertial_speed")
"""Channels that a logger writes in its one unit of length."""


def with_proven_heights(reading: Reading) -> tuple[Reading, list[Note]]:
    """A logger's reading with heights and speeds in SI, and a note if its pressures prove another unit than usual."""
    if not reading.device:
        return reading, []
    factors = [_factor(series) for series in reading.clocks]
    factor = next((factor for factor in factors if factor != 1), 1.0)
    if factor == 1:
        return reading, []
    names = ("feet", "meters") if factor < 1 else ("meters", "feet")
    note = Note(
        f"has heights in {names[0]}, not in {names[1]} as usual in this format: its pressures prove it", reading.row
    )
    return replace(reading, series=tuple(_scaled(series, factor) for series in reading.clocks)), [note]


def _factor(series: Series) -> float:
    """The factor that turns the heights of a clock into meters: 1 unless its pressures prove another unit. [1]"""
    if series.pressure is None or series.altitude is None:
        return 1.0
    ratio = _ratio(height_of_ratio(series.pressure), series.altitude)
    found = (factor for factor in (FOOT, 1 / FOOT) if 1 / TOLERANCE < ratio * factor < TOLERANCE)
    return next(found, 1.0)


def _ratio(expected: Float[Array, "time"], altitude: Float[Array, "time"]) -> float:
    """Median ratio of heights by the altitude to those by the pressure in the upper part of the climb; nan if the climb
    is less than `CLIMB` or has too few samples. [1]"""
    both = np.isfinite(expected) & np.isfinite(altitude)
    if both.sum() < 10:
        return float("nan")
    expected, altitude = (heights[both] - np.median(heights[both][:5]) for heights in (expected, altitude))
    climb = float(np.quantile(expected, 0.98))
    high = expected > COMPARED_FRACTION * climb
    if climb < CLIMB or high.sum() < 5:
        return float("nan")
    return float(np.median(altitude[high] / expected[high]))


def _scaled(series: Series, factor: float) -> Series:
    lengths = {name: values * factor for name in IN_LENGTHS if (values := getattr(series, name)) is not None}
    return replace(series, **lengths)

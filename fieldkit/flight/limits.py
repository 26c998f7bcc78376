"""The bounds beyond which a number of a flight must be a typing error.

`Column.low` and `high` are the usual range; a value that is merely unusual is accepted.
"""

import math
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import Column
from fieldkit.messages import message, of_column
from fieldkit.spelled_units import rounded, with_unit

_EDGE: Mapping[str, tuple[float, float]] = {
    "dry_mass": (0.1, 1e6),
    "diameter": (1, 3000),
    "delay": (0, 60),
    "site_elevation": (-500, 9000),
    "temperature": (-90, 70),
    "pressure": (300, 1100),
    "humidity": (0, 100),
    "wind": (0, 60),
    "rail_length": (0.01, 100),
    "rail_angle": (-90, 90),
    "apogee": (0.1, 200_000),
    "top_speed": (0.1, 3000),
    "burn_time": (0.01, 120),
    "peak_accel": (0.01, 1000),
    "avg_accel": (0, 1000),
    "coast_to_apogee": (0, 900),
    "apogee_to_eject": (-900, 900),
    "eject_altitude": (-500, 200_000),
    "descent_speed": (0.1, 1000),
    "duration": (0.1, 86_400),
    "coast_drag": (0.001, 1000),
    "burn_impulse": (0.1, 5000),
}
LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType(_EDGE)
"""Lowest and highest possible value of each column, in the column's own unit."""


def possible(column: Column) -> tuple[float, float]:
    """The lowest and highest possible value of a column, in SI units."""
    low, high = LIMITS[column.name]
    own = _unit(column.quantity, column.unit)
    return own.to_si(low), own.to_si(high)


_unit = cache(units.unit)  # of the columns only; 275,000 figures are checked before a forecast among 25,000 flights


def check(column: Column, value: float, unit: str = "") -> float:
    """Return the SI value of a column if it is possible. Raises BadValue with the expected range, in `unit` (as it was
    typed) or in the column's own unit."""
    low, high = LIMITS[column.name]
    number = _unit(column.quantity, column.unit).from_si(value)
    slack = 1e-9 * (1 + abs(number))
    if not math.isfinite(value) or not low - slack <= number <= high + slack:
        least, most = possible(column)
        if not unit:
            raise BadValue(message(f"found {of_column(column, value)}, expected {of_column(column, least, most)}"))
        shown = units.unit(column.quantity, unit)
        found, first, last = (rounded(shown.from_si(one)) for one in (value, least, most))
        raise BadValue(f"found {with_unit(found, unit)}, expected {first} to {with_unit(last, unit)}")
    return value

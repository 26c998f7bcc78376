"""Titles, column names and units of measured figures for display and export."""

from collections.abc import Mapping
from types import MappingProxyType

from fieldkit import units
from fieldkit.flight import BY_NAME, MEASURED
from fieldkit.quantities import unit_of, with_sd, with_unit

TITLES: Mapping[str, str] = MappingProxyType({c.name: c.title for c in MEASURED} | {"time_to_apogee": "Time to apogee"})
"""Titles of the figures, in the order of the readouts."""


_SENSORS = {
    "barometric": "baro",
    "pressure": "baro",
    "GPS": "gps",
    "inertial": "accel",
    "acceleration": "accel",
    "of the logger": "device",
    "simulation": "simulation",
}
"""Words in the source of a figure or an event, and the sensor that they mean."""


def sensor_of(source: str) -> str:
    """The sensors behind a figure or an event: `baro`, `accel`, `gps`, `device`, or several such as `baro+accel`."""
    return "+".join(dict.fromkeys(sensor for word, sensor in _SENSORS.items() if word in source)) or "device"


def column_header(name: str) -> str:
    """Column name of a figure with its unit, such as `apogee_m`."""
    return BY_NAME[name].header if name in BY_NAME else f"{name}_s"


def in_column_unit(name: str, value: float) -> float:
    """An SI value, or a difference of two, in the unit of its column; no unit here has an offset."""
    column = BY_NAME.get(name)
    return value if column is None else units.unit(column.quantity, column.unit).from_si(value)


def figure_text(name: str, value: float, sd: float, system: str = "SI") -> str:
    """A figure [SI] as text in the units of a system: `553.70 ± 0.70 m`."""
    column = BY_NAME.get(name)
    unit = unit_of(column, system) if column else "s"
    scale = units.unit(column.quantity if column else "time", unit)
    return with_unit(with_sd(scale.from_si(value), scale.difference_from_si(sd)), unit)

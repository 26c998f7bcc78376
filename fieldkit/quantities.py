"""Numbers as flyers read them: in the units of their choice, with the digits that mean something."""

from collections.abc import Mapping
from types import MappingProxyType

from fieldkit import units
from fieldkit.flight import Column

SYSTEMS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "SI": {},
        "US": {"m": "ft", "m/s": "mph", "g": "oz", "mm": "in", "c": "f", "hpa": "inhg"},
        "mixed": {"m": "ft", "m/s": "mph", "c": "f"},
    }
)
"""The unit shown in place of a column's own; what is not named is shown as it is. Acceleration stays in g."""

DECIMALS: Mapping[str, int] = MappingProxyType(
    {"m": 1, "ft": 0, "m/s": 1, "mph": 1, "g": 0, "oz": 2, "mm": 0, "in": 2, "s": 2, "c": 0, "f": 0}
    | {"hpa": 0, "inhg": 2, "%": 0, "deg": 0, "1/km": 2}
)
"""Digits after the point that are worth reading, by unit."""


def counted(count: int, noun: str) -> str:
    """A count with its noun: `1 flight`, `2 flights`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def spelled(unit: str) -> str:
    """A unit as it is printed: `°C` for `c`."""
    return {"c": "°C", "f": "°F", "hpa": "hPa", "inhg": "inHg", "deg": "°"}.get(unit, unit)


def unit_of(column: Column, system: str) -> str:
    """The unit that a column is shown and typed in."""
    return column.unit if column.quantity == "acceleration" else SYSTEMS[system].get(column.unit, column.unit)


def number(column: Column, value: float, system: str) -> str:
    """A value [SI] without its unit: `923`."""
    unit = unit_of(column, system)
    places = 1 if column.quantity == "acceleration" else DECIMALS[unit]
    return f"{units.unit(column.quantity, unit).from_si(value):.{places}f}"


def measure(column: Column, value: float | None, system: str) -> str:
    """A value [SI] with its unit: `923 ft`; empty if there is none."""
    if value is None:
        return ""
    return f"{number(column, value, system)} {spelled(unit_of(column, system))}"

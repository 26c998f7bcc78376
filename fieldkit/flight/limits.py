"""The bounds beyond which a number of a flight must be a typing error.

`Column.low` and `high` are the usual range; a value that is merely unusual is accepted.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import Column, Flight
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
    own = units.unit(column.quantity, column.unit)
    return own.to_si(low), own.to_si(high)


def check(column: Column, value: float, unit: str = "") -> float:
    """Return the SI value of a column if it is possible. Raises BadValue with the expected range, in `unit` (as it was
    typed) or in the column's own unit."""
    low, high = LIMITS[column.name]
    number = units.unit(column.quantity, column.unit).from_si(value)
    slack = 1e-9 * (1 + abs(number))
    if not math.isfinite(value) or not low - slack <= number <= high + slack:
        least, most = possible(column)
        if not unit:
            raise BadValue(message(f"found {of_column(column, value)}, expected {of_column(column, least, most)}"))
        shown = units.unit(column.quantity, unit)
        found, first, last = (rounded(shown.from_si(one)) for one in (value, least, most))
        raise BadValue(f"found {with_unit(found, unit)}, expected {first} to {with_unit(last, unit)}")
    return value


NAMES = ("flight_id", "rocket", "config", "site")
"""Fields that name something and are printed in tables."""
MAX_NAME = 200
"""Longest name, many times as long as any that fits in a table. [characters]"""


def check_name(name: str) -> str:
    """Return a name if it is short enough to be printed in a table. Raises BadValue."""
    if len(name) > MAX_NAME:
        raise BadValue(f"found {name[:20] + '…'!r} of length {len(name)}, expected at most {MAX_NAME} characters")
    return name


def long_names(flight: Flight) -> list[str]:
    """Names and tags of a flight that no table can show in full, one phrase each. A flyer is not allowed to type them,
    but ledgers of earlier versions hold them, and what is exported can be imported."""
    named = {name: (getattr(flight, name),) for name in NAMES} | {"tags": flight.tags}
    return [
        f"{name}: found {text[:20] + '…'!r} of length {len(text)}, which tables shorten"
        for name, texts in named.items()
        for text in texts
        if len(text) > MAX_NAME
    ]


TEXTS = ("rocket", "flight_id", "config", "motor", "site", "notes", "log")
"""Fields that are text."""
MAX_KEY_SIZE = 2600
"""Largest size of a tag, and of a rocket's name and a flight_id together, in UTF-8: the keys of a server are no longer,
and a ledger can move between a file and a server. [bytes]"""


def check_keys(flight: Flight) -> None:
    """Raise BadValue for names of a flight that not every kind of ledger can store."""
    check_key("rocket and flight_id", flight.rocket + flight.flight_id)
    for tag in flight.tags:
        check_key("tags", tag)


def check_key(name: str, key: str) -> None:
    """Raise BadValue for a key, or the columns of one together, that not every kind of ledger can store."""
    if (size := len(key.encode(errors="replace"))) > MAX_KEY_SIZE:
        raise BadValue(f"{name}: found {key[:20] + '…'!r} of {size:,} bytes, expected at most {MAX_KEY_SIZE}")


def check_texts(flight: Flight) -> None:
    """Raise BadValue for texts of a flight that no ledger can store: a NUL, or half of a character of two."""
    named: dict[str, tuple[str, ...]] = {name: (getattr(flight, name),) for name in TEXTS}
    named["tags and extra columns"] = (*flight.tags, *flight.extra, *flight.extra.values())
    for name, texts in named.items():
        for text in texts:
            if "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
                raise BadValue(f"{name}: found {text[:40]!r}, expected text without NUL and broken characters")

"""Thresholds of the safety lines: shipped with their source, overridden individually in the user's own file."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.files import read_toml
from fieldkit.planning.toml_values import problem_in

OWN_NAMES = ("wind", "angle")
"""Bounds that only a user's own file sets, in addition to those of the rule sets."""
DATA = Path(__file__).parents[1] / "data" / "limits.toml"
QUANTITIES = {
    "m/s": "speed",
    "mph": "speed",
    "ft/s": "speed",
    "deg": "angle",
    "1": "number",
    "m": "length",
    "ft": "length",
    "C": "temperature",
    "F": "temperature",
    "g": "mass",
    "lb": "mass",
    "N": "force",
    "N s": "impulse",
    "J": "energy",
}


@dataclass(frozen=True, slots=True)
class Limit:
    """A threshold in SI, and its source."""

    value: float
    source: str


Limits = Mapping[str, Limit]
"""Thresholds by name, as in `fieldkit/data/limits.toml`."""


def limits(own: Path | None = None) -> dict[str, Limit]:
    """The shipped thresholds, overridden by those in the user's own file. Raises BadValue."""
    known = _read(DATA)
    if own is None or not own.exists():
        return known
    own_limits = _read(own)
    if unknown := sorted(set(own_limits) - {*known, *OWN_NAMES}):
        raise BadValue(f"{own.name}: found {unknown[0]!r}, expected one of {', '.join([*known, *OWN_NAMES])}")
    return known | own_limits


def _read(file: Path) -> dict[str, Limit]:
    try:
        tables = read_toml(file)
    except (ValueError, OSError) as error:
        raise BadValue(f"{file.name}: found {problem_in(error)}, expected TOML") from error
    return {name: _limit(file, name, table) for name, table in tables.items()}


def _limit(file: Path, name: str, table: Any) -> Limit:
    value = table.get("value") if isinstance(table, dict) else None
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise BadValue(f"{file.name}, {name}: found {value!r}, expected value = a number")
    unit = str(table.get("unit", "1"))
    if unit not in QUANTITIES:
        raise BadValue(f"{file.name}, {name}: found the unit {unit!r}, expected one of {', '.join(QUANTITIES)}")
    scale = units.Unit(1.0) if unit == "1" else units.unit(QUANTITIES[unit], unit.replace(" ", ""))
    return Limit(scale.to_si(float(value)), str(table.get("source", f"your own {file.name}")))

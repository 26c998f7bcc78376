"""The uncertainty and source of a readout: the accompanying columns and their values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import BY_NAME, MEASURED

SOURCES: Mapping[str, str] = MappingProxyType(
    {
        "typed": "Read off the altimeter and typed in.",
        "baro": "Measured in the samples of a barometer.",
        "accel": "Measured in the samples of an accelerometer, with or without a barometer's.",
        "gps": "Measured in the heights of a satellite receiver.",
        "stated": "As the device states it in its file.",
        "simulated": "From a simulation.",
    }
)
"""Allowed sources of a readout."""
MIN_SD, MAX_SD = 1e-9, 1e6
"""Smallest and largest possible standard deviation of a readout in its column's own unit: nanometers and nanoseconds
are below what any altimeter resolves, and squares and reciprocals of numbers between them are finite."""
SENSORS = ("baro", "accel", "gps")
"""Sources that are sensors whose samples gave the readout."""
PEAK_WINDOW = 0.05
"""Averaging window of a peak acceleration measured in samples: an igniter's spike is shorter. [s]"""


@dataclass(frozen=True, slots=True)
class Readout:
    """The value of a readout and its standard deviation, in SI, and its source, one of `SOURCES`.

    None and an empty source mean "not recorded".
    """

    value: float
    sd: float | None = None
    source: str = ""


@dataclass(frozen=True, slots=True)
class ReadoutColumn:
    """The column for a readout's standard deviation, with its unit (empty if cells have their own), or for its
    source."""

    readout: str
    part: Literal["sd", "source"]
    unit: str = ""

    def read(self, text: str) -> float | str | None:
        """Parse a cell of the column; None for an empty cell. Raises BadValue. [SI]"""
        if not text.strip():
            return None
        return read_sd(self.readout, text, self.unit) if self.part == "sd" else read_source(text)


def beside(header: str) -> ReadoutColumn | None:
    """The accompanying column that a lower-case header names (`apogee_sd_ft`, `apogee_source`); None for others.

    Raises BadValue for a standard deviation in a unit that does not fit its readout.
    """
    for column in MEASURED:
        ending = header.removeprefix(f"{column.name}_")
        if header == column.source_header:
            return ReadoutColumn(column.name, "source")
        if ending != header and ending.partition("_")[0] == "sd":
            unit = ending[3:]
            if unit:
                units.unit(column.quantity, unit)
            return ReadoutColumn(column.name, "sd", unit)
    return None


def read_sd(name: str, text: str, unit: str = "") -> float:
    """Parse the standard deviation of a readout; a number without a unit is in `unit`, or in the column's own. [SI]

    Raises BadValue if it is not a positive number between `MIN_SD` and `MAX_SD`.
    """
    column = BY_NAME[name]
    value = units.parse_difference(text, column.quantity, unit or column.unit)
    own = units.unit(column.quantity, column.unit)
    number = own.from_si(value) - own.from_si(0.0)
    if not (math.isfinite(value) and MIN_SD * (1 - 1e-9) <= number <= MAX_SD):
        raise BadValue(
            f"found {text.strip()[:40]!r}, expected a standard deviation above 0 {unit or column.unit} "
            f"(at least {MIN_SD:g} {column.unit}), or nothing"
        )
    return value


def render_sd(name: str, value: float) -> str:
    """Format a standard deviation in the unit of its readout's column."""
    column = BY_NAME[name]
    return units.render_difference(value, column.quantity, column.unit)


def read_source(text: str) -> str:
    """Parse a source, one of `SOURCES`, in any case. Raises BadValue."""
    source = text.strip().lower()
    if source not in SOURCES:
        raise BadValue(f"found {text.strip()[:40]!r}, expected one of {', '.join(SOURCES)}")
    return source

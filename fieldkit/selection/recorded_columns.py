"""The columns that misses may follow, in words: `temperature`, `wind above 4.5 m/s`."""

from collections.abc import Mapping
from types import MappingProxyType

from fieldkit.flight import BY_NAME, COLUMNS
from fieldkit.quantities import ShownUnits, measure, rounded

TITLES: Mapping[str, str] = MappingProxyType(
    {
        "flight_number": "the flight number",
        "hour": "the hour of the day",
        "expected_top_speed_mps": "expected top speed",
    }
)
"""Titles of the columns that are computed."""
BY_HEADER = {column.header: column for column in COLUMNS}


def column_in_words(header: str) -> str:
    """The title of one of `columns_of` or `kinds_of`: `wind`, `the flight number`, `motor`."""
    return TITLES.get(header) or (BY_HEADER[header].title.lower() if header in BY_HEADER else header)


def value_in_words(header: str, value: float, system: str) -> str:
    """A value [SI] of one of `columns_of`, in the unit of a system: `4.5 m/s`, `flight 12`."""
    if header in BY_HEADER:
        return measure(BY_HEADER[header], value, system)
    if header == "expected_top_speed_mps":
        return ShownUnits(system).speed(value, 0)
    return rounded(value)


def misses_of(readout: str) -> str:
    """The misses of a readout as the start of a sentence: `Misses`, `Misses in top speed`."""
    return "Misses" if readout == "apogee" else f"Misses in {BY_NAME[readout].title.lower()}"

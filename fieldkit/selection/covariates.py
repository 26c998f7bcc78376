"""The columns of a flyer's table that a pattern may follow: known before lift-off, not results of the flight.

An outcome, or a forecast of one, correlates with the residual of a flight because it contains it; a pattern in it
explains nothing and is not available for the next flight. The schema states what its columns are. Any other column is
treated as an outcome if its header names a readout or a figure fitted to readouts, or if its values are a readout or a
forecast of one: in a constant ratio to it from flight to flight, or lengths about as large as the apogees.
"""

import re
from collections.abc import Iterator, Sequence

import numpy as np

from fieldkit.flight import MEASURED, READOUTS, Flight
from fieldkit.physics.setups import recorded
from fieldkit.shapes import Array, Float

FITTED_FIGURES = ("cd", "alpha")
"""Names of figures that are fitted to a flight's readouts, as in forecasts and documents."""
LENGTHS = {"m": 1.0, "ft": 0.3048}
"""Last words of headers of lengths, with their units in meters."""
SAME_RATIO = 0.25
"""A column restates a readout if the variance of their log ratio, relative to the readout's variance, is below this:
three quarters of the readout's variance are in the column. [1]"""
SAME_LENGTH = 1 / 3
"""A length counts as an apogee up to this median log ratio to the apogee; forecasts are rarely further off. [1]"""
MIN_FLIGHTS = 4
"""Minimum number of flights with both numbers for a comparison. [1]"""


def known_before(name: str, flights: Sequence[Flight]) -> bool:
    """Whether a column of the user's table was known before lift-off, judging by its header and values."""
    words = _words(name)
    if any(outcome <= words for outcome in _outcomes()):
        return False
    own = own_numbers(name, flights)
    apogee = recorded(flights, "apogee")
    scale = LENGTHS.get(re.split(r"[^a-z]+", name.casefold())[-1])
    if scale and _are_similar(scale * own, apogee):
        return False
    return not any(_restates(own, recorded(flights, column.name)) for column in READOUTS)


def own_numbers(name: str, flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """A column of the user's table in its unit; nan for cells that are not numbers."""
    return np.array([_number(flight.text(name)) for flight in flights])


def _outcomes() -> Iterator[frozenset[str]]:
    """Sets of words that name an outcome together."""
    for column in MEASURED:
        yield _words(column.name)
        yield _words(column.title)
    for name in FITTED_FIGURES:
        yield frozenset({name})


def _words(text: str) -> frozenset[str]:
    return frozenset(re.findall(r"[a-z]+", text.casefold()))


def _restates(numbers: Float[Array, "flight"], readout: Float[Array, "flight"]) -> bool:
    both = np.isfinite(numbers) & np.isfinite(readout) & (numbers > 0) & (readout > 0)
    if both.sum() < MIN_FLIGHTS:
        return False
    ratio, varies = np.log(numbers[both] / readout[both]), np.log(readout[both])
    return bool(np.var(ratio) < SAME_RATIO * np.var(varies))


def _are_similar(lengths: Float[Array, "flight"], apogee: Float[Array, "flight"]) -> bool:
    both = np.isfinite(lengths) & np.isfinite(apogee) & (lengths > 0)
    return bool(both.any() and np.median(np.abs(np.log(lengths[both] / apogee[both]))) < SAME_LENGTH)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")

"""Numbers that loggers write where a sensor gave none: all nines, or the end of a counter's range.

Derivation: heights, pressures and accelerations change by less than their range from one reading to the next, so a
number far from every other one of its column, and of a form that programs use as a mark, is no reading.
"""

from collections.abc import Iterator

import numpy as np

from fieldkit.shapes import Array, Float

_COUNTERS = (15, 16, 31, 32)
"""Bits of counters whose largest or smallest number marks a missing one. [1]"""
_NINES = (999, 9_999, 99_999, 999_999, 9_999_999)
_FAR = 0.25
"""Smallest distance of a mark from the nearest reading, as a fraction of the range of all readings. [1]"""


def without_marks(values: Float[Array, "row"]) -> Float[Array, "row"]:
    """A column of readings in any unit, with nan instead of the marks of missing ones."""
    for mark in _marks_in(values):
        others = values[np.isfinite(values) & (values != mark)]
        if others.size and np.abs(others - mark).min() > _FAR * float(np.ptp(others)):
            values = np.where(values == mark, np.nan, values)
    return values


def _marks_in(values: Float[Array, "row"]) -> Iterator[float]:
    """The numbers of a column that have the form of a mark, those farthest from zero first."""
    ends = [end for bits in _COUNTERS for end in (2.0**bits - 1, 2.0**bits, -(2.0**bits), 1 - 2.0**bits)]
    wholes = np.array([*ends, *_NINES, *(-one for one in _NINES)])
    likely = values[np.isin(np.trunc(values), wholes)]
    for one in sorted(np.unique(likely).tolist(), key=abs, reverse=True):
        if one == int(one) or set(f"{abs(one):.6f}".rstrip("0")) == {"9", "."}:
            yield one

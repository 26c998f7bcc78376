"""Values from the flyer's own TOML files: numbers that calculations can use, and what is wrong with the others."""

from collections.abc import Sequence
from math import inf

from fieldkit.safe_text import printable

LARGEST_NUMBER = 1e9
"""Largest number in these files, beyond every mass, length, impulse and time of a rocket. [any unit]"""


def number(value: object, name: str, *, least: float = 0.0, unlimited: bool = False) -> float:
    """A number from `least` to `LARGEST_NUMBER`, also infinity if it may be `unlimited`. Raises ValueError with its
    name. [as in the file]"""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} = {value!r}")
    if not (least <= value <= LARGEST_NUMBER or (unlimited and value == inf)):
        raise ValueError(f"{name} = {value!r}")
    return float(value)


def whole(value: object, name: str, least: int, most: int) -> int:
    """An integer in a range, both ends included. Raises ValueError with its name."""
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise ValueError(f"{name} = {value!r}")
    return value


def in_order(values: object, name: str) -> tuple[float, float]:
    """Two numbers, the lower one first. Raises ValueError with their name. [as in the file]"""
    if not isinstance(values, Sequence) or isinstance(values, str) or len(values) != 2:
        raise ValueError(f"{name} = {values!r}")
    low, high = (number(one, name) for one in values)
    if low > high:
        raise ValueError(f"{name} = {values!r}")
    return low, high


def texts(values: object, name: str) -> tuple[str, ...]:
    """A list of texts. Raises ValueError with its name."""
    if not isinstance(values, list | tuple) or not all(isinstance(one, str) for one in values):
        raise ValueError(f"{name} = {values!r}")
    return tuple(map(printable, values))


def problem_in(error: Exception) -> str:
    """What an error while reading a file found, for a message: a missing key, the wrong value, or why it cannot be
    read."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return f"no {error.args[0]}" if isinstance(error, KeyError) and error.args else str(error)

"""The names of terms, as values."""

from collections.abc import Hashable
from typing import NamedTuple


class TermName(NamedTuple):
    """What identifies a term: a quantity or an effect, the level of its random effect as in `Hyperprior`, or how the
    effect or pattern acts, and the group of flights on which it acts, such as a motor type, a configuration, a day, a
    year or a place."""

    quantity: str
    level: str = "rocket"
    group: Hashable = ""


SHARED_LEVELS = ("fleet", "drift", "motor", "lot")
"""Levels whose terms the other rockets of a flyer also have."""


def fleet_term(quantity: str) -> TermName:
    """The name of the term for one quantity of a flyer's whole fleet."""
    return TermName(quantity, "fleet")

"""Checks of options that take a number: `nan` passes every bound, and `inf` one side of it."""

from math import isfinite

import typer


def finite(value: float | None) -> float | None:
    """The number itself, in the unit of its option. Raises BadParameter for nan and infinity."""
    if value is not None and not isfinite(value):
        raise typer.BadParameter(f"found {value}, expected a number")
    return value


def not_negative(value: float | None) -> float | None:
    """The number itself, in the unit of its option. Raises BadParameter for one below zero, nan and infinity."""
    if value is not None and value < 0:
        raise typer.BadParameter(f"found {value:g}, expected a number above zero")
    return finite(value)

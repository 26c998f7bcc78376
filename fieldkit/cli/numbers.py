"""Checks of options that take a number: `nan` passes both bounds, and infinity one of them."""

from math import isfinite

import typer

from fieldkit.errors import BadValue
from fieldkit.messages import marked, message
from fieldkit.units import parse


def finite(value: float | None) -> float | None:
    """The number itself, in the unit of its option. Raises BadParameter for nan and infinity."""
    if value is not None and not isfinite(value):
        raise typer.BadParameter(f"found {value}, expected a number")
    return value


def not_negative(value: float | None) -> float | None:
    """The number itself, in the unit of its option. Raises BadParameter for one below zero, nan and infinity."""
    if value is not None and value < 0:
        raise typer.BadParameter(f"found {value:g}, expected zero or more")
    return finite(value)


def typed(option: str, text: str, quantity: str, default: str) -> float:
    """The SI value of a number typed for an option, with or without its unit. Raises BadValue that names the option."""
    try:
        return parse(text, quantity, default)
    except BadValue as error:
        raise BadValue(message(f"{option}: {marked(error)}")) from None


def length(option: str, text: str | None, default: str = "m", *, signed: bool = False) -> float | None:
    """A length typed for an option, with or without its unit; None without one. [m]

    Raises BadValue that names the option, also for a length that is not above zero unless `signed`.
    """
    value = None if text is None else typed(option, text, "length", default)
    if value is not None and value <= 0 and not signed:
        raise BadValue(f"{option}: found {text!r}, expected a length above zero")
    return value

"""Messages that hold their amounts: a text in SI units, and each amount in it, which a medium writes in other units.

A sentence marks its amounts: `message(f"a gap of {amount(30.0, 'm')}")` reads `a gap of 30 m`, and `a gap of 98 ft` as
`fieldkit.quantities.in_system` writes it. Everything else in it, such as the name of a flight, stays as it is.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from fieldkit import units
from fieldkit.spelled_units import rounded, with_sd, with_unit

QUANTITY = {"m": "length", "mm": "length", "m/s": "speed", "c": "temperature", "g": "mass", "N s": "impulse"} | {
    "J": "energy"
}
"""The quantity of a unit that is shown with SI."""
ROUNDED_STYLE, FINE_STYLE, PER_WIND_STYLE = "rounded", "fine", "per wind"
"""Styles of amounts: with significant digits; with one decimal in every unit; a drift for each unit of wind [s]."""
_BEGIN, _NEXT, _END = "\ue000", "\ue001", "\ue002"
_MARKED = re.compile(f"{_BEGIN}([^{_BEGIN}{_END}]*){_END}")


class HasUnit(Protocol):
    """The unit of a column, as in `fieldkit.flight.Column`."""

    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...


@dataclass(frozen=True, slots=True)
class Amount:
    """An amount in a message: one value or two ends of a range [SI], the unit that is shown with SI, and its style.

    `text` is the amount with its unit in SI. The style is a number of decimals, `ROUNDED_STYLE` with a number of
    significant digits, `FINE_STYLE`, `PER_WIND_STYLE`, or the standard deviation after `±`, in SI.
    """

    text: str
    values: tuple[float, ...]
    unit: str
    style: str


class TextWithAmounts(str):
    """A text in SI that holds its amounts: `parts` are its words and its amounts in order."""

    parts: tuple[str | Amount, ...]


def message(marked: str) -> TextWithAmounts:
    """The message of a text with marked amounts."""
    texts = _MARKED.split(marked)
    parts = tuple(_read(text) if place % 2 else text for place, text in enumerate(texts))
    found = TextWithAmounts("".join(part if isinstance(part, str) else part.text for part in parts))
    found.parts = parts
    return found


def marked(text: object) -> str:
    """A text with its amounts marked, to be part of another message; an error by its message."""
    if isinstance(text, Exception) and text.args and isinstance(text.args[0], TextWithAmounts):
        return str(text).removesuffix(text.args[0]) + marked(text.args[0])
    if not isinstance(text, TextWithAmounts):
        return str(text)
    return "".join(part if isinstance(part, str) else _mark(part) for part in text.parts)


def with_words(text: str, change: Callable[[str], str]) -> str:
    """A message with its words changed and its amounts kept, or any other text changed."""
    if not isinstance(text, TextWithAmounts):
        return change(text)
    return message("".join(change(part) if isinstance(part, str) else _mark(part) for part in text.parts))


def amount(value: float, unit: str, digits: int = 0, to: float | None = None) -> str:
    """A marked value [SI], or a range `to` another, with decimals in a unit: `amount(0.322, "g")` is 322 g."""
    scale = units.unit(QUANTITY[unit], unit)
    values = (value,) if to is None else (value, to)
    numbers = [f"{round(scale.from_si(one), digits) + 0.0:.{digits}f}" for one in values]  # zero is never negative
    return _mark(Amount(with_unit(" to ".join(numbers), unit), values, unit, str(digits)))


def of_column(column: HasUnit, value: float, to: float | None = None, digits: int = 4) -> str:
    """A marked value of a column [SI], or a range, with significant digits: `281.3 m`. An acceleration is in g in every
    system, and is not marked."""
    scale = units.unit(column.quantity, column.unit)
    marked_one = of_unit(value, column.unit, to, digits, scale)
    return message(marked_one) if column.quantity == "acceleration" else marked_one


def of_unit(value: float, unit: str, to: float | None = None, digits: int = 4, scale: units.Unit | None = None) -> str:
    """A marked value [SI], or a range, with significant digits in a unit of SI, or one with another scale. A
    unit with an amount of its own is a message."""
    values, scale = (value,) if to is None else (value, to), scale or units.Unit(1.0)
    if isinstance(unit, TextWithAmounts):
        return f"{' to '.join(rounded(scale.from_si(one), digits) for one in values)} {marked(unit)}"
    text = with_unit(" to ".join(rounded(scale.from_si(one), digits) for one in values), unit)
    return _mark(Amount(text, values, unit, f"{ROUNDED_STYLE} {digits}"))


def fine(value: float, unit: str) -> str:
    """A marked length [m] with one decimal in every unit: `1.0 m`."""
    return _mark(Amount(with_unit(f"{value:.1f}", unit), (value,), unit, FINE_STYLE))


def estimate(value: float, sd: float, unit: str) -> str:
    """A marked value and its standard deviation, both in a unit of SI: `13.7 ± 14 m/s^2`. A unit with an amount of its
    own is a message."""
    if isinstance(unit, TextWithAmounts):
        return f"{with_sd(value, sd)} {marked(unit)}"
    return _mark(Amount(f"{with_sd(value, sd)} {unit}", (value,), unit, f"±{sd!r}"))


def per_wind(seconds: float) -> str:
    """A marked drift per unit of wind [s]: `103 m per m/s of wind` or `151 ft per mph of wind`."""
    return _mark(Amount(f"{seconds:.0f} m per m/s of wind", (seconds,), "m", PER_WIND_STYLE))


def _mark(one: Amount) -> str:
    values = " ".join(repr(float(value)) for value in one.values)
    return _BEGIN + _NEXT.join((one.text, values, one.unit, one.style)) + _END


def _read(text: str) -> Amount:
    shown, values, unit, style = text.split(_NEXT)
    return Amount(shown, tuple(float(value) for value in values.split()), unit, style)

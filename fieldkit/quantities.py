"""Formatting of numbers for flyers: in their units, with significant digits only."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from fieldkit import units
from fieldkit.flight import Column
from fieldkit.messages import (
    FINE_STYLE,
    PER_WIND_STYLE,
    QUANTITY,
    ROUNDED_STYLE,
    Amount,
    TextWithAmounts,
    estimate,
    marked,
    message,
)
from fieldkit.spelled_units import rounded as rounded
from fieldkit.spelled_units import spelled as spelled
from fieldkit.spelled_units import with_sd as with_sd
from fieldkit.spelled_units import with_unit as with_unit

_FEET: Mapping[str, str] = {"m": "ft", "m/s": "mph", "c": "f", "J": "ft lbf", "1/km": "1/kft"}
SYSTEMS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {"SI": {}, "US": {**_FEET, "g": "oz", "mm": "in", "hpa": "inhg"}, "mixed": _FEET}
)
"""The unit shown instead of a column's; columns not listed keep theirs. Acceleration stays in g."""

DECIMALS: Mapping[str, int] = MappingProxyType(
    {"m": 1, "ft": 0, "m/s": 1, "mph": 1, "g": 0, "oz": 2, "lb": 2, "mm": 0, "in": 2, "s": 2, "c": 0, "f": 0}
    | {"hpa": 0, "inhg": 2, "%": 0, "deg": 0, "1/km": 2, "1/kft": 2, "J": 0, "ft lbf": 0}
)
"""Decimal digits by unit."""

SHORT_LENGTHS = ("rail_length",)
"""Columns of a few feet, shown in tenths of them: a rail of 1 m is 3.3 ft, not 3 ft."""
MIN_POUNDS = 5 * units.POUND
"""Mass from which text has pounds instead of ounces. [kg]"""
MIN_GROUPED = 1000
"""Counts from here on have commas between thousands. [1]"""


def counted(count: int, noun: str) -> str:
    """A count with its noun: `1 flight`, `2 flights`, `1,200 flights`."""
    return f"{count:{',' if count >= MIN_GROUPED else ''}} {noun}{'' if count == 1 else 's'}"


def unit_of(column: Column, system: str, value: float = 0.0) -> str:
    """The unit in which a column is shown and typed; pounds instead of ounces for a mass [kg] of five or more."""
    if column.quantity == "acceleration":
        return column.unit
    return _as_weighed(SYSTEMS[system].get(column.unit, column.unit), value)


def system_typed(column: Column, unit: str, system: str) -> str:
    """The system that shows a column in the unit in which it was typed; `system` if it does, or if none does."""
    shown = (one for one in (system, *SYSTEMS) if spelled(unit_of(column, one)) == spelled(unit))
    return next(shown, system)


def shown_unit(column: Column, system: str) -> float:
    """The unit in which a length, speed or other ratio is shown, in SI: 0.3048 for feet."""
    return units.unit(column.quantity, unit_of(column, system)).factor


def number(column: Column, value: float, system: str) -> str:
    """A value [SI] without its unit: `923`."""
    unit = unit_of(column, system)
    places = 1 if column.quantity == "acceleration" or column.name in SHORT_LENGTHS else DECIMALS[unit]
    return f"{units.unit(column.quantity, unit).from_si(value):.{places}f}"


_QUANTITY = {**QUANTITY, "hpa": "pressure"}
"""The quantity of a unit that is shown with SI."""


def written(value: float, unit: str, system: str, digits: int | None = None) -> str:
    """A figure [SI] in the unit of a system, given the unit that the system `SI` shows: `written(304.8, "m", "US")` is
    `1000 ft`.

    `digits` is the number of decimals in that unit, by default those of `DECIMALS`. A shown unit with at most as many
    decimals, such as the foot, has at most `digits`; one with more, such as the ounce, keeps its own.
    """
    shown = _as_weighed(SYSTEMS[system].get(unit, unit), value)
    places = DECIMALS.get(shown, 0)
    if digits is not None and (shown == unit or places <= DECIMALS[unit]):
        places = digits if shown == unit else min(digits, places)
    scale = units.unit(_QUANTITY[unit], shown.replace(" ", ""))
    number = round(scale.from_si(value), places) + 0.0  # zero is never negative
    return with_unit(f"{number:.{places}f}", shown)


def _as_weighed(unit: str, *masses: float) -> str:
    """Pounds instead of ounces for the mass of a heavy rocket, as a scale shows it; any other unit unchanged."""
    return "lb" if unit == "oz" and min(masses) >= MIN_POUNDS else unit


_OF_SI = {
    "m": ("ft", 1 / units.FOOT),
    "m/s": ("mph", 1 / units.MILE * 3600),
    "m/s^2": ("ft/s^2", 1 / units.FOOT),
    "K": ("°F", 1.8),
}
"""Feet-based units of estimates with a standard deviation, and how many make one SI unit; kelvins are differences."""


def in_system(text: object, system: str) -> str:
    """A message, or that of an error, with its amounts in the units of a system; any other text unchanged.

    In `a gap of 30 m of Test 30 m`, the gap is `98 ft`, and the flight keeps its name.
    """
    if isinstance(text, Exception):
        text = message(marked(text))
    if not isinstance(text, TextWithAmounts):
        return str(text)
    return "".join(part if isinstance(part, str) else _written(part, system) for part in text.parts)


def _written(one: Amount, system: str) -> str:
    """An amount with its unit in a system."""
    feet, factor = _OF_SI.get(one.unit, ("", 1.0)) if "m" in SYSTEMS[system] else ("", 1.0)
    if one.style.startswith("±"):
        return f"{with_sd(one.values[0] * factor, float(one.style[1:]) * factor)} {feet}" if feet else one.text
    if one.unit == "m²" and "mm" in SYSTEMS[system]:
        ends = [rounded(value / units.INCH**2, 3) for value in one.values]
        return f"{' to '.join(ends)} in²"
    grams = {"kg": "g"}.get(one.unit, one.unit)
    if grams not in SYSTEMS[system]:
        if not feet or not one.style.startswith(ROUNDED_STYLE):
            return one.text
        digits = int(one.style.removeprefix(ROUNDED_STYLE))
        return with_unit(" to ".join(rounded(value * factor, digits) for value in one.values), feet)
    if one.style == PER_WIND_STYLE:
        return ShownUnits(system).per_wind(one.values[0])
    unit = _as_weighed(SYSTEMS[system][grams], *one.values)
    scale = units.unit(_QUANTITY[grams], unit.replace(" ", ""))
    if one.style == FINE_STYLE:
        return with_unit(f"{scale.from_si(one.values[0]):.1f}", unit)
    if one.style.startswith(ROUNDED_STYLE):
        digits = int(one.style.removeprefix(ROUNDED_STYLE))
        return with_unit(" to ".join(rounded(scale.from_si(value), digits) for value in one.values), unit)
    *low, high = (written(value, one.unit, system, int(one.style)) for value in one.values)
    in_one_unit = all(end.split()[1:] == high.split()[1:] for end in low)
    return " to ".join([*(end.split()[0] if in_one_unit else end for end in low), high])


def area_unit(system: str) -> tuple[str, float]:
    """The unit of a drag area in a system, and its factor [m^2]: `cm²` or `in²`."""
    return ("in²", units.INCH**2) if "mm" in SYSTEMS[system] else ("cm²", 1e-4)


def density(value: float, system: str) -> str:
    """A density of the air [kg/m^3] with its unit: `1.225 kg/m³` or `0.0765 lb/ft³`."""
    if "m" not in SYSTEMS[system]:
        return f"{value:.3f} kg/m³"
    return f"{value * units.FOOT**3 / units.POUND:.4f} lb/ft³"


@dataclass(frozen=True, slots=True)
class ShownUnits:
    """Figures [SI] as text in the units of a system."""

    system: str = "SI"

    @property
    def length_unit(self) -> str:
        """`m` or `ft`."""
        return SYSTEMS[self.system].get("m", "m")

    @property
    def speed_unit(self) -> str:
        """`m/s` or `mph`."""
        return SYSTEMS[self.system].get("m/s", "m/s")

    @property
    def length_factor(self) -> float:
        """One unit of length in SI, by which heights are divided for a plot. [m]"""
        return units.unit("length", self.length_unit).factor

    @property
    def speed_factor(self) -> float:
        """One unit of speed in SI. [m/s]"""
        return units.unit("speed", self.speed_unit).factor

    def length(self, value: float, digits: int = 0) -> str:
        """A length [m]: `284 m` or `932 ft`."""
        return written(value, "m", self.system, digits)

    def lengths(self, low: float, high: float) -> str:
        """A range of lengths [m]: `97 to 600 m`."""
        return f"{self.length(low).split()[0]} to {self.length(high)}"

    def difference(self, value: float, digits: int = 1) -> str:
        """A signed difference of two lengths [m]: `+5.6 m` or `-18 ft`."""
        return ("" if value < 0 else "+") + self.length(value, digits)

    def speed(self, value: float, digits: int = 1) -> str:
        """A speed [m/s]: `13.4 m/s` or `30 mph`."""
        return written(value, "m/s", self.system, digits)

    def per_wind(self, seconds: float) -> str:
        """A drift per unit of wind [s]: `94 m per m/s of wind` or `138 ft per mph of wind`."""
        return f"{self.length(seconds * self.speed_factor)} per {self.speed_unit} of wind"

    def mass(self, value: float) -> str:
        """A mass [kg]: `322 g` or `11.36 oz`."""
        return written(value, "g", self.system)

    def temperature(self, value: float) -> str:
        """A temperature [K]: `21 °C` or `70 °F`."""
        return written(value, "c", self.system)


def percent(probability: float) -> str:
    """A probability [1] in percent, never 0% or 100%: `16%`, `> 99%`."""
    return f"{probability:.0%}" if 0.01 <= probability <= 0.99 else "> 99%" if probability > 0.5 else "< 1%"


def strength_in_words(mean: float, sd: float, unit: str, system: str) -> str:
    """The strength of an effect, in the units of a system; a fraction in percent: `1.9 ± 1.3% of the dry mass`."""
    whole = unit.removeprefix("fraction ")
    if whole != unit:
        return f"{with_sd(mean * 100, sd * 100)}% {whole}"
    return in_system(message(estimate(mean, sd, unit)), system)


def significant(column: Column, value: float, system: str) -> str:
    """A value [SI] with its unit and four significant digits: `922.9 ft`."""
    unit = unit_of(column, system)
    return with_unit(rounded(units.unit(column.quantity, unit).from_si(value)), unit)


def measure(column: Column, value: float | None, system: str) -> str:
    """A value [SI] with its unit: `923 ft`; empty if there is none."""
    if value is None:
        return ""
    return with_unit(number(column, value, system), unit_of(column, system))


def weighed(column: Column, value: float | None, system: str) -> str:
    """A value [SI] as by `measure`, a heavy rocket in pounds: not for a form, which keeps hundredths of an ounce."""
    if value is None or unit_of(column, system, value) != "lb":
        return measure(column, value, system)
    return written(value, column.unit, system)


def in_own_unit(column: Column, value: float, unit: str, system: str) -> str:
    """The unit of a typed number, and its value [SI] in the flyer's unit if that is another one: `ft  = 281.3 m`."""
    if spelled(unit) == spelled(unit_of(column, system)):
        return spelled(unit)
    return f"{spelled(unit)}  = {measure(column, value, system)}"

"""Conversions between the units that flyers write and the SI units used inside.

A number is converted on the line where it enters or leaves the program. A column name or a typed value carries its unit
as a suffix (`apogee_ft`, `923ft`); which units are allowed follows from the quantity, so the `g` of `dry_mass_g` is a
gram and the `g` of `peak_accel_g` is the acceleration of free fall. Units may be spelled as flyers do: `29.92 in. Hg`.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from fieldkit.errors import BadValue
from fieldkit.typed_amounts import MAX_TYPED_LENGTH, plain_marks, typed_amount, typed_in_two, value_of

STANDARD_GRAVITY = 9.80665
"""Acceleration of free fall, by definition. [m/s^2]"""
FOOT = 0.3048
"""International foot. [m]"""
INCH = 0.0254
"""International inch. [m]"""
MILE = 1609.344
"""International mile. [m]"""
POUND = 0.45359237
"""Avoirdupois pound. [kg]"""
ZERO_CELSIUS = 273.15
"""0 degrees Celsius. [K]"""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of one quantity: `si = number * factor + offset`."""

    factor: float
    offset: float = 0.0

    def to_si(self, number: float) -> float:
        """The SI value of a number in this unit."""
        return number * self.factor + self.offset

    def from_si(self, value: float) -> float:
        """The number in this unit of an SI value."""
        return (value - self.offset) / self.factor

    def difference_to_si(self, number: float) -> float:
        """The SI value of a difference in this unit, such as a standard deviation."""
        return number * self.factor

    def difference_from_si(self, value: float) -> float:
        """A difference in SI, such as a standard deviation, as a number in this unit."""
        return value / self.factor


DEGREE = 0.017453292519943295
"""One degree. [rad]"""

UNITS: Mapping[str, Mapping[str, Unit]] = {
    "length": {
        "m": Unit(1.0),
        "mm": Unit(1e-3),
        "cm": Unit(1e-2),
        "dm": Unit(1e-1),
        "km": Unit(1e3),
        "in": Unit(INCH),
        "ft": Unit(FOOT),
        "feet": Unit(FOOT),
        "'": Unit(FOOT),
        "yd": Unit(3 * FOOT),
        "mi": Unit(MILE),
    },
    "mass": {"kg": Unit(1.0), "g": Unit(1e-3), "oz": Unit(POUND / 16), "lb": Unit(POUND), "lbs": Unit(POUND)},
    "speed": {
        "mps": Unit(1.0),
        "m/s": Unit(1.0),
        "mph": Unit(MILE / 3600),
        "kph": Unit(1 / 3.6),
        "kmh": Unit(1 / 3.6),
        "km/h": Unit(1 / 3.6),
        "fps": Unit(FOOT),
        "ft/s": Unit(FOOT),
        "cm/s": Unit(0.01),
        "kt": Unit(1852 / 3600),
        "kn": Unit(1852 / 3600),
        "knots": Unit(1852 / 3600),
    },
    "acceleration": {
        "g": Unit(STANDARD_GRAVITY),
        "mps2": Unit(1.0),
        "m/s2": Unit(1.0),
        "m/s²": Unit(1.0),
        "m/s^2": Unit(1.0),
        "cm/s2": Unit(0.01),
        "ft/s2": Unit(FOOT),
        "fps2": Unit(FOOT),
        "mg": Unit(STANDARD_GRAVITY / 1000),
    },
    "time": {
        "s": Unit(1.0),
        "sec": Unit(1.0),
        "ms": Unit(1e-3),
        "ds": Unit(0.1),
        "cs": Unit(0.01),
        "us": Unit(1e-6),
        "µs": Unit(1e-6),
        "ns": Unit(1e-9),
        "min": Unit(60.0),
        "hr": Unit(3600.0),
        "days": Unit(86_400.0),
    },
    "temperature": {
        "c": Unit(1.0, ZERO_CELSIUS),
        "k": Unit(1.0),
        "f": Unit(5 / 9, ZERO_CELSIUS - 32 * 5 / 9),
        "°c": Unit(1.0, ZERO_CELSIUS),
        "°f": Unit(5 / 9, ZERO_CELSIUS - 32 * 5 / 9),
        "degc": Unit(1.0, ZERO_CELSIUS),
        "degf": Unit(5 / 9, ZERO_CELSIUS - 32 * 5 / 9),
    },
    "pressure": {
        "pa": Unit(1.0),
        "hpa": Unit(100.0),
        "mbar": Unit(100.0),
        "mb": Unit(100.0),
        "kpa": Unit(1000.0),
        "inhg": Unit(3386.389),
        "mmhg": Unit(133.322),
        "psi": Unit(6894.757),
        "bar": Unit(1e5),
        "atm": Unit(101325.0),
    },
    "force": {"n": Unit(1.0), "kn": Unit(1e3), "lbf": Unit(POUND * STANDARD_GRAVITY)},
    "voltage": {"v": Unit(1.0), "mv": Unit(1e-3)},
    "angle": {"deg": Unit(DEGREE), "rad": Unit(1.0), "°": Unit(DEGREE)},
    "fraction": {"pct": Unit(0.01), "%": Unit(0.01), "fraction": Unit(1.0)},
    "impulse": {"ns": Unit(1.0)},
    "energy": {"j": Unit(1.0), "ftlbf": Unit(FOOT * POUND * STANDARD_GRAVITY)},
    "number": {"": Unit(1.0)},
    "per length": {"1/km": Unit(1e-3), "pkm": Unit(1e-3), "1/m": Unit(1.0), "1/kft": Unit(1e-3 / FOOT)},
}
"""Units by quantity and lower-case suffix."""

_WORDS = {
    "s": "second seconds sec secs sek sekunde sekunden secondes seg segundos secondi sekundy sekund с сек 秒 초",
    "ms": "millisecond milliseconds millis msec мс 毫秒 ミリ秒",
    "ds": "decisecond deciseconds",
    "cs": "centisecond centiseconds",
    "us": "microsecond microseconds micros usec μs",
    "ns": "nanosecond nanoseconds nanos nsec",
    "min": "minute minutes mins",
    "hr": "hrs hour hours stunden",
    "days": "day",
    "m": "meter meters metre metres mtr metro metros mètre mètres metri м",
    "mm": "millimeter millimeters millimetre millimetres",
    "cm": "centimeter centimeters centimetre centimetres",
    "km": "kilometer kilometers kilometre kilometres",
    "ft": "foot feet fuß fuss voet pied pieds pie pies pé pés piedi stopy stóp фут футы футов フィート 英尺 피트 '",
    "in": 'inch inches "',
    "yd": "yard yards",
    "mi": "mile miles",
    "pa": "pascal pascals па 帕",
    "hpa": "hectopascal hectopascals гпа 百帕",
    "kpa": "kilopascal kilopascals кпа 千帕",
    "mbar": "millibar millibars mbars",
    "inhg": 'inchhg incheshg "hg inchesofmercury inhga',
    "mmhg": "torr",
    "psi": "psia",
    "atm": "atmosphere atmospheres",
    "c": "celsius degreescelsius degreec degreesc centigrade",
    "f": "fahrenheit degreesfahrenheit degreef degreesf",
    "k": "kelvin",
    "g": "gs g's gee gees gee's gram grams gramm gramme grammes gm gms",
    "mg": "mgs millig milligs",
    "v": "volt volts",
    "mv": "millivolt millivolts",
    "n": "newton newtons",
    "lb": "pound pounds",
    "oz": "ounce ounces",
    "kg": "kilogram kilograms kilo kilos",
    "deg": "degree degrees",
    "rad": "radian radians",
    "mph": "mi/h mi/hour mi/hr",
    "km/h": "kmph km/hr km/hour",
    "ft/s": "f/s",
    "knots": "knot kts",
}
_ALIASES = {word: unit for unit, words in _WORDS.items() for word in words.split()} | {
    "ftagl": "ft",
    **dict.fromkeys(["magl", "metern", "metry", "metrów", "米", "メートル", "미터"], "m"),
}
"""Other spellings of units, or of a part of one, such as the `sec` of `ft/sec`."""
CUSTOMARY_UNITS = frozenset({"ft", "in", "yd", "mi", "mph", "fps", "ft/s", "lb", "lbs", "oz", "inhg", "f", "°f", "psi"})
"""Units of flyers who write a decimal point."""
_SMALLER_UNIT = {"ft": "in", "lb": "oz", "kg": "g", "min": "s", "m": "cm"}
"""The unit that may follow a larger one, as in `12 ft 6 in`."""
MIN_TYPED_VALUE, MAX_TYPED_VALUE = 1e-12, 1e30
"""Limits of the magnitude of a typed number other than zero, in SI."""
LOOK_LIKE_DIGITS = re.compile(r"[oOlI\d.,]+")
"""Letters that are typed for digits, as in `2.l4`; no unit consists of them."""


@lru_cache(maxsize=1024)
def plain(unit: str) -> str:
    """A unit in the spelling of `UNITS`: `Feet / Sec` becomes `ft/s`, `m/s²` and `m/s/s` become `m/s2`."""
    text = unicodedata.normalize("NFKC", plain_marks(unit)).lower().replace("per", "/").replace("µ", "μ")
    parts = [re.sub(r"[\s^*·_.]+", "", part) for part in text.split("/")]
    parts = [_ALIASES.get(part, part) for part in parts]
    if len(parts) == 3 and parts[1] == parts[2]:
        parts = [parts[0], f"{parts[1]}2"]
    whole = re.sub(r"/(sec|s)2$|/s\^2$", "/s2", "/".join(parts))
    return _ALIASES.get(whole, whole)


def named(quantity: str, text: str) -> Unit | None:
    """The unit of a quantity that a text names in any spelling, or None."""
    known = UNITS[quantity]
    name = plain(text[:MAX_TYPED_LENGTH])
    if text.strip() and not name:
        return None
    if quantity == "force" and name == "lb":
        return known["lbf"]
    if quantity == "pressure" and name == "in":
        return known["inhg"]
    return known.get(text.strip().lower()) or known.get(name)


def is_unit(text: str) -> bool:
    """Whether a text names a unit of any quantity."""
    return bool(text.strip()) and any(named(quantity, text) for quantity in UNITS)


def unit(quantity: str, suffix: str) -> Unit:
    """The unit of a quantity with this suffix in any spelling.

    Raises BadValue with the allowed units for an unknown suffix.
    """
    if found := named(quantity, suffix):
        return found
    raise BadValue(f"found the unit {suffix!r}, expected one of {', '.join(UNITS[quantity])}")


def parse(text: str, quantity: str, default: str) -> float:
    """The SI value of a number typed with or without its unit: `923ft`, `281,3 m`, `1/2 in`, `1lb 3oz`, `12.5`.

    A number without a unit is in the unit `default`. A comma is a decimal comma, except before three digits: there it
    separates thousands in a customary unit, or if it is repeated, and is ambiguous otherwise. Raises BadValue if the
    text is not an unambiguous number with an allowed unit.
    """
    two = _in_two(text, quantity)
    if two is not None:
        return _bounded(two, text)
    number, scale = _typed(text, quantity, default)
    return _bounded(scale.to_si(number), text)


def typed_unit(text: str, default: str) -> str:
    """The unit of a typed number as `parse` reads it: its own, the first of two, or `default`."""
    two = typed_in_two(text)
    if two and plain(two.unit) in _SMALLER_UNIT:
        return plain(two.unit)
    one = typed_amount(text)
    return one.unit if one and one.unit else default


def parse_difference(text: str, quantity: str, default: str) -> float:
    """As `parse`, for a difference such as a standard deviation: the offset of its unit is ignored. Raises BadValue."""
    number, scale = _typed(text, quantity, default)
    return _bounded(scale.difference_to_si(number), text)


def _typed(text: str, quantity: str, default: str) -> tuple[float, Unit]:
    """A typed number and its unit. Raises BadValue if the text is not one."""
    typed = typed_amount(text)
    if typed is None or (LOOK_LIKE_DIGITS.fullmatch(typed.unit) and not named(quantity, typed.unit)):
        raise BadValue(f"found {text.strip()[:40]!r}, expected a number")
    scale = unit(quantity, typed.unit or default)
    return typed.signed(value_of(typed.digits, customary=plain(typed.unit or default) in CUSTOMARY_UNITS)), scale


def _in_two(text: str, quantity: str) -> float | None:
    """The SI value of a number in two units, such as feet and inches; None if the text is not one. Raises BadValue."""
    typed = typed_in_two(text)
    if typed is None:
        return None
    larger = plain(typed.unit)
    larger = "min" if quantity == "time" and larger == "m" else larger
    smaller = _SMALLER_UNIT.get(larger, "")
    if smaller not in UNITS[quantity] or plain(typed.more_unit or smaller) != smaller:
        return None
    more = UNITS[quantity][smaller].to_si(value_of(typed.more, customary=True))
    return typed.signed(UNITS[quantity][larger].to_si(float(typed.digits)) + more)


def _bounded(value: float, text: str) -> float:
    """The value, zero if no instrument could distinguish it from zero. Raises BadValue if it is too large."""
    if not abs(value) < MAX_TYPED_VALUE:
        raise BadValue(f"found {text.strip()[:20]!r}, expected a plausible number")
    return value if abs(value) >= MIN_TYPED_VALUE else 0.0


def render(value: float, quantity: str, suffix: str) -> str:
    """An SI value as a number in a unit, with enough digits to restore the same SI value. Raises BadValue for an
    unknown unit.
    """
    return f"{unit(quantity, suffix).from_si(value):.12g}"


def render_difference(value: float, quantity: str, suffix: str) -> str:
    """As `render`, for a difference in SI such as a standard deviation. Raises BadValue for an unknown unit."""
    return f"{unit(quantity, suffix).difference_from_si(value):.12g}"

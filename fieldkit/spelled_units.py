"""Numbers and units as they are printed."""

import math

MAX_WRITTEN_OUT = 1e9
"""Numbers from here on have an exponent, in any unit."""


def spelled(unit: str) -> str:
    """A unit as it is printed: `°C` for `c`."""
    return {"c": "°C", "f": "°F", "hpa": "hPa", "inhg": "inHg", "deg": "°", "mps": "m/s", "pct": "%"}.get(
        unit.lower(), unit
    )


def with_unit(number: str, unit: str) -> str:
    """A number and its unit as they are printed: `5 m/s`, without a space `5°` and `5%`; the number without a unit."""
    shown = spelled(unit)
    return f"{number}{shown}" if shown in {"°", "%"} else f"{number} {shown}".rstrip()


def rounded(value: float, digits: int = 4) -> str:
    """A number in any unit with that many significant digits, without an exponent if it is large: `12345`, `281.3`,
    `0.0517`."""
    text = f"{value:.{digits}g}"
    return text if "e+" not in text or abs(value) >= MAX_WRITTEN_OUT else f"{value:.0f}"


def with_sd(value: float, sd: float) -> str:
    """A value and its standard deviation, in the unit of both: at least two significant digits of the deviation, and as
    many decimals of the value: `43.8 ± 6.7`, `1204 ± 153`. Without a deviation above zero and below `MAX_WRITTEN_OUT`,
    the value alone, with four significant digits."""
    if not 0 < sd < MAX_WRITTEN_OUT:
        return rounded(value)
    places = max(1 - math.floor(math.log10(float(f"{sd:.1e}"))), 0)
    return f"{value:.{places}f} ± {sd:.{places}f}"

"""Units as they are printed."""


def spelled(unit: str) -> str:
    """A unit as it is printed: `°C` for `c`."""
    return {"c": "°C", "f": "°F", "hpa": "hPa", "inhg": "inHg", "deg": "°", "mps": "m/s", "pct": "%"}.get(
        unit.lower(), unit
    )


def with_unit(number: str, unit: str) -> str:
    """A number and its unit as they are printed: `5 m/s`, without a space `5°` and `5%`; the number without a unit."""
    shown = spelled(unit)
    return f"{number}{shown}" if shown in {"°", "%"} else f"{number} {shown}".rstrip()

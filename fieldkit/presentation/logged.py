"""Further details from a log as text: uncertainties, and the device's values."""

from collections.abc import Mapping

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import READOUTS, TWO_DEVICES, Column, Flight
from fieldkit.flight.log_origin import OTHER_LOGS
from fieldkit.quantities import ShownUnits, measure, spelled, unit_of, weighed, with_sd

TIME_TO_APOGEE = ("time_to_apogee_s", "time_to_apogee_sd_s")
"""Extra columns: the time to apogee, and its standard deviation. [s]"""
SUFFIXES = {"_s": "s", "_m": "m", "_ft": "ft", "_pa": "Pa", "_mps": "m/s", "_g": "g"}
"""Suffixes of extra columns that are units, in their printed form."""
LENGTHS = {"_m": 1.0, "_ft": units.FOOT}
"""Suffixes of lengths, and their units. [m]"""


def readout(flight: Flight, column: Column, system: str) -> str:
    """A readout, with its standard deviation if it is known: `162.8 ± 1.0 m`; empty without one."""
    return _with_sd(column, flight.number(column.name), flight.sd.get(column.name), system)


def _with_sd(column: Column, value: float | None, sd: float | None, system: str) -> str:
    """A value and its standard deviation [SI] in the user's units."""
    if value is None or sd is None:
        return weighed(column, value, system)
    unit = unit_of(column, system)
    spread = units.unit(column.quantity, unit).difference_from_si(sd)
    return f"{with_sd(units.unit(column.quantity, unit).from_si(value), spread)} {spelled(unit)}"


def beside(extra: Mapping[str, str], system: str) -> list[tuple[str, str]]:
    """The extra columns of a flight, name and value."""
    left = dict(extra)
    lines = [
        (f"{c.title}, stated", _stated(c, left.pop(c.stated_header), system))
        for c in READOUTS
        if c.stated_header in left
    ]
    lines += [
        (c.title, _of_device(c, left.pop(c.header), left.pop(c.sd_header, ""), system))
        for c in TWO_DEVICES
        if c.header in left
    ]
    time, spread = (left.pop(name, "") for name in TIME_TO_APOGEE)
    if time:
        value, sd = _figure(time), _figure(spread)
        lines.append(("Time to apogee", f"{time if value is None or sd is None else with_sd(value, sd)} s"))
    if others := left.pop(OTHER_LOGS, ""):
        lines.append(("Other logs of it", str(len(others.split()))))
    return lines + [_worded(name, text, ShownUnits(system)) for name, text in left.items()]


def _stated(column: Column, text: str, system: str) -> str:
    """The device's own value in the user's units; the text itself if it is not a number."""
    try:
        return measure(column, column.parse(text), system)
    except BadValue:
        return text


def _of_device(column: Column, text: str, spread: str, system: str) -> str:
    """A figure of a drogue or a main with its standard deviation, in the user's units."""
    sd, scale = _figure(spread), units.unit(column.quantity, column.unit)
    try:
        return _with_sd(column, column.parse(text), None if sd is None else scale.difference_to_si(sd), system)
    except BadValue:
        return text


def _worded(name: str, text: str, shown: ShownUnits) -> tuple[str, str]:
    """A column's name as words, and a figure with the unit of its suffix: lengths and speeds in the user's."""
    value = _figure(text)
    suffix = next((one for one in SUFFIXES if name.endswith(one) and value is not None), "")
    words = name.removesuffix(suffix).replace("_", " ").strip()
    title = words[:1].upper() + words[1:]
    if value is None or not suffix:
        return title, text
    if suffix in LENGTHS:
        return title, shown.length(value * LENGTHS[suffix], 1)
    return title, shown.speed(value) if suffix == "_mps" else f"{text} {SUFFIXES[suffix]}"


def _figure(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

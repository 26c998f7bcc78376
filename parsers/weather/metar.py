"""METAR: reports of airports, a line each, times in UTC.

A report states the day of the month; year and month stand before it, as archives write them (`202605161253 METAR`,
`KORD,2026-05-16 12:53,KORD 161253Z ...`) or on a line before it. Source: World Meteorological Organization, No. 306,
FM 15; tenths of a degree in the remarks of American stations: Federal Meteorological Handbook No. 1.
"""

import calendar
import re
from datetime import datetime, timedelta

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.text import lines_of
from fieldkit.importing.weather import OF_A_STATION, Report, SavedWeather, WeatherFormat, checked

REPORT = re.compile(r"\b[A-Z][A-Z0-9]{3} (?P<day>\d\d)(?P<hour>\d\d)(?P<minute>\d\d)Z\b(?P<rest>[^\n]{0,400})")
DATE = re.compile(r"(?<!\d)((?:19|20)\d\d)[-/]?(0[1-9]|1[0-2])[-/]?(0[1-9]|[12]\d|3[01])")
WIND = re.compile(r"\b(\d{3}|VRB)(\d{2,3})(?:G\d{2,3})?(KT|MPS|KMH)\b")
AIR = re.compile(r"(?<=\s)(M?\d\d)/(M?\d\d)?(?=\s|=|$)")
TENTHS = re.compile(r"\bT([01])(\d{3})([01])(\d{3})\b")
SET = re.compile(r"\b([QA])(\d{4})\b")
SPEEDS = {"KT": "kt", "MPS": "mps", "KMH": "kmh"}


def recognizes(text: str) -> bool:
    return REPORT.search(text[:8192]) is not None


def read(text: str) -> SavedWeather:
    reports, rejected, day = [], [], None
    for row, line in enumerate(lines_of(text), start=1):
        found = REPORT.search(line)
        if date := DATE.search(line[: found.start()] if found else line):
            day = datetime(int(date[1]), int(date[2]), min(int(date[3]), _length(int(date[1]), int(date[2]))))
        if found is None:
            continue
        try:
            reports.append(checked(_report(found, day, row), row))
        except DamagedLog as error:
            rejected.append(error)
    return SavedWeather(tuple(reports), tuple(rejected), utc=True, sd=OF_A_STATION)


def _length(year: int, month: int) -> int:
    return calendar.monthrange(year, month)[1]


def _report(found: re.Match[str], day: datetime | None, row: int) -> Report:
    rest = found["rest"]
    wind, air, tenths, pressure = (form.search(rest) for form in (WIND, AIR, TENTHS, SET))
    celsius = _signed(tenths[1], tenths[2]) if tenths else None if air is None else _celsius(air[1])
    dew = _signed(tenths[3], tenths[4]) if tenths else _celsius(air[2]) if air and air[2] else None
    speed = units.UNITS["speed"][SPEEDS[wind[3]]].to_si(float(wind[2])) if wind else None
    blown = float(wind[1]) if wind and wind[1] != "VRB" and int(wind[2]) else None
    unit = units.UNITS["pressure"]["inhg" if pressure and pressure[1] == "A" else "hpa"]
    return Report(
        _time(found, day, row),
        None if celsius is None else celsius + units.ZERO_CELSIUS,
        unit.to_si(int(pressure[2]) / (100 if pressure[1] == "A" else 1)) if pressure else None,
        None if celsius is None or dew is None else min(_saturated(dew) / _saturated(celsius), 1.0),
        speed,
        blown,
    )


def _time(found: re.Match[str], day: datetime | None, row: int) -> datetime:
    """The moment of a report: its day nearest to the date beside it."""
    if day is None:
        shown = found[0][:12]
        raise DamagedLog(
            f"found {shown!r} without year and month, expected them before it: 2026-05-16 {shown}", row=row
        )
    own, hour, minute = (int(found[name]) for name in ("day", "hour", "minute"))
    near = [day + timedelta(days=offset) for offset in range(-20, 21)]
    same = [one for one in near if one.day == own]
    if not same or hour > 23 or minute > 59:
        raise DamagedLog(f"found {found[0][:12]!r}, expected a day, hour and minute", row=row)
    return min(same, key=lambda one: abs(one - day)).replace(hour=hour, minute=minute)


def _signed(sign: str, tenths: str) -> float:
    return (-1 if sign == "1" else 1) * int(tenths) / 10


def _celsius(text: str) -> float:
    return -float(text[1:]) if text.startswith("M") else float(text)


def _saturated(celsius: float) -> float:
    """Saturation pressure of water over that at 0 °C, after Magnus. [1]"""
    return float(10 ** (7.591 * celsius / (240.73 + celsius)))


WEATHER = WeatherFormat("METAR lines", recognizes, read)

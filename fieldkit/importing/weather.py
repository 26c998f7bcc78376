"""Saved weather: what a parser of `parsers/weather` returns, and the weather at one moment with its uncertainty.

Derivation of the standard deviation between two reports: a quantity that changes as a random walk, pinned at both of
them, has the variance d^2 u (1 - u) at the fraction u of the way, d being the root mean square of its changes from one
report to the next (a Brownian bridge). That of the reports themselves is `OF_A_STATION` or `OF_A_MODEL`.
"""

import csv
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from itertools import pairwise

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog, UnknownFormat
from fieldkit.importing.tables.text import check_count, decode_whole, lines_of
from fieldkit.physics.standard_atmosphere import HYDROSTATIC_EXPONENT, LAPSE, STANDARD_TEMPERATURE
from fieldkit.plugins import plugins
from fieldkit.safe_text import whole_number

QUANTITIES = {"temperature": "temperature", "pressure": "pressure", "humidity": "fraction", "wind": "speed"}
"""What a report has of the air near the ground, with the quantity of each."""
OF_A_STATION = {"temperature": 0.7, "pressure": 100.0, "humidity": 0.05, "wind": 1.0}
"""Standard deviation between a weather station and a field some kilometers away: an assumption, larger than the
accuracy of its instruments. [K, Pa, 1, m/s]"""
OF_A_MODEL = {"temperature": 1.5, "pressure": 100.0, "humidity": 0.1, "wind": 1.5}
"""Standard deviation between an hour of a weather model, whose squares are kilometers wide, and a field in one: an
assumption. [K, Pa, 1, m/s]"""
LONGEST_GAP = timedelta(hours=3)
"""Weather services report every three hours or more often; nothing is read into a longer gap."""
MAST = 10.0
"""Height above the ground of the wind in weather reports (World Meteorological Organization, No. 8). [m]"""
ROWS_OF_A_DAY = (9, 18)
"""Hours in which a flight was flown that has a date and no time."""


@dataclass(frozen=True, slots=True)
class WindAloft:
    """The wind at a height above the ground [m]: its speed [m/s] and where it blows from, clockwise from north, None if
    not reported. [deg]"""

    height: float
    speed: float
    direction: float | None = None


@dataclass(frozen=True, slots=True)
class Report:
    """The weather at one time on the clock of its file; None for what was not reported.

    `temperature` [K], `pressure` reduced to sea level by the standard atmosphere (QNH) [Pa], `humidity` [1], `wind` at
    10 m [m/s], and `direction`, where it blows from, clockwise from north. [deg]
    """

    time: datetime
    temperature: float | None = None
    pressure: float | None = None
    humidity: float | None = None
    wind: float | None = None
    direction: float | None = None
    aloft: tuple[WindAloft, ...] = ()


@dataclass(frozen=True, slots=True)
class SavedWeather:
    """The reports of one file, in order of time, and its damaged rows.

    `utc` says that its times are those of Greenwich; otherwise they are local. `sd` is `OF_A_STATION` or `OF_A_MODEL`.
    """

    reports: tuple[Report, ...]
    rejected: tuple[DamagedLog, ...]
    utc: bool
    sd: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class WeatherFormat:
    """A way in which weather is saved: `recognizes` and `read` take the text of a file."""

    title: str
    recognizes: Callable[[str], bool]
    read: Callable[[str], SavedWeather]


@dataclass(frozen=True, slots=True)
class WeatherAtTime:
    """The weather at one moment: value and standard deviation of each of `QUANTITIES` [K, Pa, 1, m/s], where the wind
    near the ground blows from [deg], and the winds aloft of the nearest report."""

    values: Mapping[str, tuple[float, float]]
    direction: float | None = None
    aloft: tuple[WindAloft, ...] = ()


def weather_formats() -> Mapping[str, WeatherFormat]:
    """All formats in the plug-in folder by name."""
    return plugins("parsers.weather", "WEATHER")  # type: ignore[return-value]


def is_weather(head: bytes) -> bool:
    """Whether the beginning of a file is saved weather."""
    with suppress(DamagedLog):
        text = decode_whole(head)
        return any(one.recognizes(text) for one in weather_formats().values())
    return False


def read_weather(content: bytes, source: str) -> tuple[str, SavedWeather]:
    """The name of the format of a saved weather file, and its reports.

    Raises UnknownFormat, or DamagedLog for a file without a usable report; both name the file.
    """
    try:
        text = decode_whole(content)
        check_count(text.count("\n"))
        claimed = [name for name, one in weather_formats().items() if one.recognizes(text)]
        if not claimed:
            titles = ", ".join(one.title for one in weather_formats().values())
            raise UnknownFormat(f"{source}: found no weather, expected one of: {titles}")
        found = weather_formats()[claimed[0]].read(text)
    except DamagedLog as error:
        raise _at(error, source) from error
    if not found.reports:
        raise next((_at(one, source) for one in found.rejected), DamagedLog("found no report", source=source))
    reports = tuple(sorted(found.reports, key=lambda one: one.time))
    return claimed[0], replace(found, reports=reports, rejected=tuple(_at(one, source) for one in found.rejected))


def _at(error: DamagedLog, source: str) -> DamagedLog:
    return DamagedLog(error.found, row=error.row, column=error.column, source=source)


def weather_at(weather: SavedWeather, moment: datetime) -> WeatherAtTime:
    """The weather at a moment on the clock of a file, between the reports before and after it; without those that are
    more than `LONGEST_GAP` apart, as little as is left."""
    values = {name: one for name in QUANTITIES if (one := _value_at(weather, name, moment)) is not None}
    aloft = [one for one in weather.reports if one.aloft]
    near = min(aloft, key=lambda one: abs(one.time - moment), default=None)
    winds = near.aloft if near is not None and abs(near.time - moment) <= LONGEST_GAP else ()
    blown = [one for one in weather.reports if one.direction is not None]
    at = min(blown, key=lambda one: abs(one.time - moment), default=None)
    return WeatherAtTime(
        values, at.direction if at is not None and abs(at.time - moment) <= LONGEST_GAP else None, winds
    )


def weather_of_day(weather: SavedWeather, day: datetime) -> WeatherAtTime:
    """The mean weather between the `ROWS_OF_A_DAY` of a day, with the scatter of these hours in its standard
    deviation: that of a flight without a time."""
    low, high = (day.replace(hour=hour) for hour in ROWS_OF_A_DAY)
    during = [one for one in weather.reports if low <= one.time <= high]
    values = {}
    for name in QUANTITIES:
        found = [value for one in during if (value := getattr(one, name)) is not None]
        if len(found) >= 3:
            mean = sum(found) / len(found)
            scatter = sum((value - mean) ** 2 for value in found) / len(found)
            values[name] = mean, math.sqrt(scatter + weather.sd[name] ** 2)
    return WeatherAtTime(values)


def _value_at(weather: SavedWeather, name: str, moment: datetime) -> tuple[float, float] | None:
    known = [(one.time, value) for one in weather.reports if (value := getattr(one, name)) is not None]
    before = max((one for one in known if one[0] <= moment), default=None)
    after = min((one for one in known if one[0] >= moment), default=None)
    if before is None or after is None or after[0] - before[0] > LONGEST_GAP:
        return None
    changes = [(b - a) ** 2 for (s, a), (t, b) in pairwise(known) if t - s <= LONGEST_GAP]
    step = sum(changes) / len(changes) if changes else 0.0
    u = (moment - before[0]) / (after[0] - before[0]) if after[0] > before[0] else 0.0
    value = before[1] + u * (after[1] - before[1])
    return value, math.sqrt(weather.sd[name] ** 2 + step * u * (1 - u))


def qnh(station_pressure: float, elevation: float) -> float:
    """Pressure at a station [Pa] reduced to sea level by the standard atmosphere, from its elevation. [m] [Pa]"""
    ratio: float = (1 - LAPSE * elevation / STANDARD_TEMPERATURE) ** HYDROSTATIC_EXPONENT
    return station_pressure / ratio


WeatherRow = dict[str, str]
_UNIT = re.compile(r"^(?P<name>.*?)\s*[(\[](?P<unit>[^)\]]*)[)\]]$")


def header_units(header: str, quantity: str) -> units.Unit:
    """The unit in a column's header, `Wind (mph)`, `wind_mph`, `wind [mph]`.

    Raises DamagedLog that names the column.
    """
    found = _UNIT.match(header)
    spelled = found["unit"] if found else header.rpartition("_")[2] if "_" in header else ""
    if (unit := units.UNITS[quantity].get(units.plain(spelled))) is not None and spelled:
        return unit
    known = ", ".join(units.UNITS[quantity])
    raise DamagedLog(f"found no unit, expected one in the header: {known}", column=header)


def table_rows(text: str, first: int = 0) -> tuple[list[str], Iterator[tuple[int, WeatherRow]]]:
    """The header of a table that starts at the index `first` among the lines of a text, and its rows with their
    numbers in the file. The separator is that of the header."""
    lines = lines_of(text)
    separator = max(",;\t", key=lines[first].count)
    headers = _cells(lines[first], separator)

    def rows() -> Iterator[tuple[int, WeatherRow]]:
        for number, line in enumerate(lines[first + 1 :], start=first + 2):
            if line.strip():
                yield number, dict(zip(headers, _cells(line, separator), strict=False))

    return headers, rows()


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line; the whole line if it is damaged."""
    try:
        return [one.strip() for one in next(csv.reader([line], delimiter=separator))]
    except csv.Error:
        return [line]


def cell_number(cells: WeatherRow, header: str, row: int, unit: units.Unit) -> float | None:
    """The SI value of a cell; None if it is empty. Raises DamagedLog for text."""
    text = cells.get(header, "").strip()
    if text.casefold() in ("", "nan", "null", "none", "m", "-"):
        return None
    try:
        value = float(text.replace(",", "."))
    except ValueError as error:
        raise DamagedLog(f"found {text[:40]!r}, expected a number", row=row, column=header) from error
    if not math.isfinite(value):
        raise DamagedLog(f"found {text[:40]!r}, expected a finite number", row=row, column=header)
    return unit.to_si(value)


def read_time(text: str, row: int, column: str = "time") -> datetime:
    """A time as weather services write it: ISO 8601, with a blank or a T, or seconds since 1970. Raises DamagedLog."""
    shown = text.strip()
    try:
        if len(shown) > 8 and (seconds := whole_number(shown)) is not None:
            return datetime(1970, 1, 1) + timedelta(seconds=seconds)
        return datetime.fromisoformat(shown.replace("/", "-").removesuffix("Z").strip()).replace(tzinfo=None)
    except (ValueError, OverflowError) as error:
        raise DamagedLog(f"found {shown[:40]!r}, expected 2026-05-16T14:00", row=row, column=column) from error


WEATHER_LIMITS = {
    "temperature": (190.0, 335.0),
    "pressure": (85e3, 109e3),
    "humidity": (0.0, 1.0),
    "wind": (0.0, 120.0),
}
"""Range of each of `QUANTITIES` on Earth. [K, Pa, 1, m/s]"""


def checked(report: Report, row: int) -> Report:
    """A report whose values are possible. Raises DamagedLog that names the row and the quantity."""
    for name, (low, high) in WEATHER_LIMITS.items():
        value = getattr(report, name)
        if value is not None and not low <= value <= high * 1.001:
            raise DamagedLog(f"found {value:.4g}, expected {low:g} to {high:g}", row=row, column=name)
    return report


def each_row(
    rows: Iterator[tuple[int, WeatherRow]], read: Callable[[int, WeatherRow], Report | None]
) -> tuple[tuple[Report, ...], tuple[DamagedLog, ...]]:
    """The reports of the rows of a table, and the rows that are damaged; a row of None has none."""
    reports, rejected = [], []
    for row, cells in rows:
        try:
            if (report := read(row, cells)) is not None:
                reports.append(checked(report, row))
        except (DamagedLog, BadValue) as error:
            rejected.append(error if isinstance(error, DamagedLog) else DamagedLog(str(error), row=row))
    return tuple(reports), tuple(rejected)


def merged(reports: Sequence[Report]) -> tuple[Report, ...]:
    """Reports of one time as one, with all their winds aloft and the first wind near the ground."""
    found: dict[datetime, Report] = {}
    for one in reports:
        known = found.setdefault(one.time, replace(one, aloft=()))
        ground = one if known.wind is None else known
        found[one.time] = replace(known, aloft=(*known.aloft, *one.aloft), wind=ground.wind, direction=ground.direction)
    return tuple(found.values())

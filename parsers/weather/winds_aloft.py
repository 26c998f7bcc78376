"""Winds aloft: a table with a time, a height above the ground, a speed and a direction in each row, units in the
header: `time,height_ft,wind_mph,wind_from_deg`.

Several rows have the same time. Times are local. Height zero has the wind that is reported near the ground.
"""

from datetime import datetime

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.importing.weather import (
    OF_A_MODEL,
    Report,
    SavedWeather,
    WeatherFormat,
    WeatherRow,
    WindAloft,
    cell_number,
    each_row,
    header_units,
    merged,
    read_time,
    table_rows,
)

MAX_HEIGHT = 40_000.0
"""Height of the highest balloon. [m]"""
MAX_SPEED = 150.0
"""More than the fastest jet streams. [m/s]"""


def recognizes(text: str) -> bool:
    return text.strip() != "" and _named(table_rows(text)[0], "height") is not None and _time(text) is not None


def _named(headers: list[str], *starts: str) -> str | None:
    return next((one for start in starts for one in headers if one.casefold().startswith(start)), None)


def _time(text: str) -> str | None:
    return _named(table_rows(text)[0], "time", "date")


def read(text: str) -> SavedWeather:
    headers, rows = table_rows(text)
    time, height = _named(headers, "time", "date"), _named(headers, "height")
    direction = _named(headers, "wind_from", "wind from", "wind_dir", "wind dir", "direction")
    others = [one for one in headers if one != direction]
    speed = _named(others, "wind", "speed")
    if time is None or height is None or speed is None:
        raise DamagedLog("found no speed of the wind, expected a column such as wind_mph")
    meters, mps = header_units(height, "length"), header_units(speed, "speed")

    def report(row: int, cells: WeatherRow) -> Report | None:
        at: datetime = read_time(cells.get(time, ""), row, time)
        above, blown = cell_number(cells, height, row, meters), cell_number(cells, speed, row, mps)
        turned = cell_number(cells, direction, row, units.Unit(1.0)) if direction else None
        if above is None or blown is None:
            raise DamagedLog("found an empty cell, expected a height and a speed", row=row)
        if not (0 <= above < MAX_HEIGHT and 0 <= blown < MAX_SPEED):
            found = f"found {blown:.4g} m/s at {above:.4g} m"
            raise DamagedLog(f"{found}, expected up to {MAX_SPEED:g} m/s below {MAX_HEIGHT:g} m", row=row)
        if above == 0:
            return Report(at, wind=blown, direction=turned)
        return Report(at, aloft=(WindAloft(above, blown, turned),))

    reports, rejected = each_row(rows, report)
    return SavedWeather(merged(reports), rejected, utc=False, sd=OF_A_MODEL)


WEATHER = WeatherFormat("winds aloft by height (CSV)", recognizes, read)

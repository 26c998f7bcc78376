"""Open-Meteo: hourly weather of a model or its archive, as JSON or CSV, with units stated in the file.

Source: open-meteo.com/en/docs, the names of hourly variables. Pressure at the surface is preferred, since QNH follows
from it exactly; that at mean sea level is reduced with the day's temperature. Winds at heights in meters are above the
ground; those on pressure levels need `geopotential_height` of the same level, which is above sea level.
"""

import json
import re
from itertools import zip_longest

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.text import lines_of
from fieldkit.importing.weather import (
    OF_A_MODEL,
    Report,
    SavedWeather,
    WeatherFormat,
    WeatherRow,
    WindAloft,
    cell_number,
    each_row,
    qnh,
    read_time,
    table_rows,
)

NAMES = {"temperature": "temperature_2m", "humidity": "relative_humidity_2m", "wind": "wind_speed_10m"}
QUANTITY = {"temperature": "temperature", "humidity": "fraction", "wind": "speed"}
LEVEL = re.compile(r"(?:wind_speed|windspeed)_(\d{2,4})(m|hPa)")
ELEVATIONS = (-500.0, 9000.0)
"""Bounds of the heights of land above the sea. [m]"""
HEADINGS = "latitude,longitude,elevation,utc_offset_seconds"


def recognizes(text: str) -> bool:
    start = text[:4096]
    return start.lstrip().startswith(HEADINGS) or ('"hourly"' in text and '"hourly_units"' in text)


def read(text: str) -> SavedWeather:
    return _from_csv(text) if text.lstrip().startswith(HEADINGS) else _from_json(text)


def _from_csv(text: str) -> SavedWeather:
    _, about = table_rows(text)
    _, place = next(about, (2, {}))
    first = next((number for number, line in enumerate(lines_of(text)) if line.startswith("time,")), None)
    if first is None:
        raise DamagedLog("found no row of headers, expected `time,temperature_2m (°C),...`")
    headers, rows = table_rows(text, first)
    stated = {one.partition(" ")[0]: (one, one.partition("(")[2].rstrip(")")) for one in headers}
    reports, rejected = each_row(rows, lambda row, cells: _report(row, cells, stated, place))
    return SavedWeather(reports, rejected, _in_utc(place), OF_A_MODEL)


def _from_json(text: str) -> SavedWeather:
    try:
        document = json.loads(text)
        hourly, spelled = document["hourly"], document["hourly_units"]
        columns = {str(name): [("" if one is None else str(one)) for one in values] for name, values in hourly.items()}
        stated = {name: (name, str(spelled.get(name, ""))) for name in columns}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise DamagedLog("found no hourly weather, expected `hourly` and `hourly_units` of Open-Meteo") from error
    place = {name: str(value) for name, value in document.items() if isinstance(value, int | float | str)}
    each = zip_longest(*columns.values(), fillvalue="")
    rows = ((row, dict(zip(columns, cells, strict=True))) for row, cells in enumerate(each, start=1))
    reports, rejected = each_row(rows, lambda row, cells: _report(row, cells, stated, place))
    return SavedWeather(reports, rejected, _in_utc(place), OF_A_MODEL)


def _in_utc(place: WeatherRow) -> bool:
    return place.get("timezone", "GMT") in ("GMT", "UTC", "")


def _report(row: int, cells: WeatherRow, stated: dict[str, tuple[str, str]], place: WeatherRow) -> Report:
    def value(name: str, quantity: str) -> float | None:
        for spelling in (name, name.replace("wind_", "wind").replace("relative_humidity", "relativehumidity")):
            if spelling in stated:
                header, unit = stated[spelling]
                return cell_number(cells, header, row, _unit(quantity, unit, header))
        return None

    found = {name: value(named, QUANTITY[name]) for name, named in NAMES.items()}
    elevation = cell_number(place, "elevation", 2, units.UNITS["length"]["m"])
    if elevation is not None and not ELEVATIONS[0] < elevation < ELEVATIONS[1]:
        raise DamagedLog(f"found {elevation:.4g}, expected a height of land in meters", row=2, column="elevation")
    ground = elevation or 0.0
    surface = value("surface_pressure", "pressure")
    pressure = None if surface is None or elevation is None else qnh(surface, ground)
    pressure = value("pressure_msl", "pressure") if pressure is None else pressure
    winds = []
    for name in stated:
        if (level := LEVEL.fullmatch(name)) and name not in ("wind_speed_10m", "windspeed_10m"):
            at = f"{level[1]}{level[2]}"
            height = value(f"geopotential_height_{at}", "length") if level[2] == "hPa" else float(level[1])
            speed, turned = value(f"wind_speed_{at}", "speed"), value(f"wind_direction_{at}", "angle")
            above = None if height is None else height - (ground if level[2] == "hPa" else 0.0)
            if speed is not None and above is not None and above > 10:
                winds.append(WindAloft(above, speed, None if turned is None else turned / units.DEGREE))
    direction = value("wind_direction_10m", "angle")
    return Report(
        read_time(cells.get(stated["time"][0], "") if "time" in stated else "", row),
        pressure=pressure,
        direction=None if direction is None else direction / units.DEGREE,
        aloft=tuple(winds),
        **found,
    )


def _unit(quantity: str, spelled: str, header: str) -> units.Unit:
    spelling = {"mp/h": "mph", "kn": "kn"}.get(spelled, spelled)
    if (unit := units.UNITS[quantity].get(units.plain(spelling))) is None:
        raise DamagedLog(
            f"found the unit {spelled!r}, expected one of {', '.join(units.UNITS[quantity])}", column=header
        )
    return unit


WEATHER = WeatherFormat("Open-Meteo (JSON, CSV)", recognizes, read)

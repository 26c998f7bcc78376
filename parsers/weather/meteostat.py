"""Meteostat: hourly weather of a station, CSV, times in UTC.

Source: dev.meteostat.net, hourly data: °C, %, degrees, km/h and hPa, without units in the header. Bulk files have no
header: date, hour, temp, dwpt, rhum, prcp, snow, wdir, wspd, wpgt, pres, tsun, coco.
"""

from collections.abc import Iterator
from datetime import datetime

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.importing.weather import (
    OF_A_STATION,
    Report,
    SavedWeather,
    WeatherFormat,
    WeatherRow,
    cell_number,
    each_row,
    read_time,
    table_rows,
)
from fieldkit.safe_text import whole_number

BULK = "date,hour,temp,dwpt,rhum,prcp,snow,wdir,wspd,wpgt,pres,tsun,coco"
SIGNS = {"temp", "rhum", "wspd", "pres"}


def recognizes(text: str) -> bool:
    return text.strip() != "" and len(SIGNS & set(_headers(text))) >= 3


def _headers(text: str) -> list[str]:
    first = text.lstrip("\ufeff").partition("\n")[0].strip().replace(";", ",").split(",")
    bulk = len(first) == BULK.count(",") + 1 and first[0][:4].isdigit() and first[1].isdigit()
    return BULK.split(",") if bulk else [one.strip() for one in first]


def read(text: str) -> SavedWeather:
    shown = _headers(text)
    bulk = shown == BULK.split(",") and not text.startswith("date")
    _, rows = table_rows(f"{BULK}\n{text}" if bulk else text)
    reports, rejected = each_row(_counted(rows, 1 if bulk else 0), _report)
    return SavedWeather(reports, rejected, utc=True, sd=OF_A_STATION)


def _counted(rows: Iterator[tuple[int, WeatherRow]], added: int) -> Iterator[tuple[int, WeatherRow]]:
    """Rows with their numbers in the file, before which a header was `added`."""
    return ((row - added, cells) for row, cells in rows)


def _report(row: int, cells: WeatherRow) -> Report:
    def value(name: str, quantity: str, unit: str) -> float | None:
        return cell_number(cells, name, row, units.UNITS[quantity][unit])

    direction = value("wdir", "angle", "deg")
    return Report(
        _time(row, cells),
        value("temp", "temperature", "c"),
        value("pres", "pressure", "hpa"),
        value("rhum", "fraction", "pct"),
        value("wspd", "speed", "km/h"),
        None if direction is None else direction / units.DEGREE,
    )


def _time(row: int, cells: WeatherRow) -> datetime:
    if "time" in cells:
        return read_time(cells["time"], row)
    day = cells.get("date") or "-".join(cells.get(name, "").zfill(2) for name in ("year", "month", "day"))
    hour = whole_number(shown := cells.get("hour", ""))
    if hour is None or hour > 23:
        raise DamagedLog(f"found {shown[:40]!r}, expected an hour from 0 to 23", row=row, column="hour")
    return read_time(f"{day}T{hour:02d}:00", row, "date")


WEATHER = WeatherFormat("Meteostat (CSV)", recognizes, read)

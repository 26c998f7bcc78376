"""A table of weather with its units in the header: `time,temperature_c,pressure_hpa,humidity_pct,wind_mph`, or
`Time;Temp (°F);Pressure (inHg);Wind Speed (mph)`. Times are local; the wind is that at 10 m, and the pressure that
reduced to sea level, as weather reports have them."""

from fieldkit import units
from fieldkit.errors import DamagedLog
from fieldkit.importing.weather import (
    OF_A_STATION,
    QUANTITIES,
    Report,
    SavedWeather,
    WeatherFormat,
    WeatherRow,
    cell_number,
    each_row,
    header_units,
    read_time,
    table_rows,
)

STARTS = {
    "temperature": ("temp", "air temp"),
    "pressure": ("pressure", "qnh", "sea level pressure", "sea_level_pressure", "barometer"),
    "humidity": ("humidity", "relative humidity", "relative_humidity", "rh"),
    "wind": ("wind speed", "wind_speed", "windspeed", "wind (", "wind [", "wind_m", "wind_k", "wind_f"),
    "direction": ("wind dir", "wind_dir", "wind from", "wind_from"),
}
FOREIGN_COLUMNS = ("height", "apogee", "rocket", "wspd")
"""Columns of other tables: winds aloft, flights, and Meteostat's."""
TIMES = ("time", "date", "valid", "datetime", "date_time")


def _columns(text: str) -> dict[str, str]:
    headers = table_rows(text)[0] if text.strip() else []
    found = {name: one for name, starts in STARTS.items() for one in headers if one.casefold().startswith(starts)}
    time = next((one for one in headers if one.casefold().partition(" ")[0] in TIMES), None)
    return found | ({"time": time} if time else {})


def recognizes(text: str) -> bool:
    found = _columns(text)
    return (
        "time" in found
        and len(found) > 2
        and not any(one.casefold().startswith(FOREIGN_COLUMNS) for one in table_rows(text)[0])
    )


def read(text: str) -> SavedWeather:
    columns = _columns(text)
    _, rows = table_rows(text)
    scale = {name: header_units(columns[name], kind) for name, kind in QUANTITIES.items() if name in columns}

    def report(row: int, cells: WeatherRow) -> Report:
        values = {name: cell_number(cells, columns[name], row, unit) for name, unit in scale.items()}
        turned = cell_number(cells, columns["direction"], row, units.Unit(1.0)) if "direction" in columns else None
        if all(value is None for value in values.values()):
            raise DamagedLog("found no value, expected a temperature, a pressure or a wind", row=row)
        at = read_time(cells.get(columns["time"], ""), row, columns["time"])
        air, pressure, humidity, wind = (values.get(name) for name in QUANTITIES)
        return Report(at, air, pressure, humidity, wind, turned)

    reports, rejected = each_row(rows, report)
    return SavedWeather(reports, rejected, utc=False, sd=OF_A_STATION)


WEATHER = WeatherFormat("a table with units in its header (CSV)", recognizes, read)

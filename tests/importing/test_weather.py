"""Saved weather files: their units, times and damaged rows, and the weather at a moment between two reports."""

import math
from contextlib import suppress
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.importing.weather import (
    OF_A_MODEL,
    OF_A_STATION,
    QUANTITIES,
    Report,
    SavedWeather,
    qnh,
    read_weather,
    weather_at,
    weather_formats,
    weather_of_day,
)
from fieldkit.physics.atmosphere import station_pressure

pytestmark = pytest.mark.fast
SAVED = Path(__file__).with_name("weather_files")
FILES = sorted(SAVED.iterdir())
TWO = datetime(2026, 5, 16, 14)


def read(name: str) -> tuple[str, SavedWeather]:
    return read_weather((SAVED / name).read_bytes(), name)


@pytest.mark.parametrize("file", FILES, ids=[file.name for file in FILES])
def test_each_file_is_claimed_by_its_own_format_alone(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    assert [name for name, one in weather_formats().items() if one.recognizes(text)] == [file.stem]


def test_every_format_has_a_file() -> None:
    assert set(weather_formats()) == {file.stem for file in FILES}


@pytest.mark.parametrize(
    ("name", "at", "pressure"),
    [
        ("open_meteo.json", TWO, qnh(96150.0, 440.0)),
        ("open_meteo.csv", TWO, qnh(96150.0, 440.0)),
        ("meteostat.csv", TWO - timedelta(hours=2), 101360.0),
        ("hourly_table.csv", TWO, 29.92 * 3386.389),
    ],
)
def test_the_same_hour_in_any_units_is_the_same_weather(name: str, at: datetime, pressure: float) -> None:
    _, weather = read(name)
    (then,) = [one for one in weather.reports if one.time == at]
    assert then.temperature == pytest.approx(293.15)
    assert then.humidity == pytest.approx(0.5)
    assert then.wind == pytest.approx(4.0, abs=0.03)
    assert then.direction == pytest.approx(260)
    assert then.pressure == pytest.approx(pressure)


def test_the_pressure_at_a_station_gives_back_that_pressure_at_its_elevation() -> None:
    assert station_pressure(np.array(qnh(96150.0, 440.0)), np.array(440.0)) == pytest.approx(96150.0)


@pytest.mark.parametrize(
    ("name", "row", "column"),
    [
        ("open_meteo.csv", 7, "temperature_2m (°F)"),
        ("meteostat.csv", 4, "hour"),
        ("metar.txt", 4, "temperature"),
        ("winds_aloft.csv", 4, None),
    ],
)
def test_a_damaged_row_is_named_and_the_others_are_read(name: str, row: int, column: str | None) -> None:
    _, weather = read(name)
    (bad,) = weather.rejected
    assert (bad.source, bad.row, bad.column) == (name, row, column)
    assert weather.reports


def test_a_bulk_file_of_meteostat_without_header_has_the_same_rows() -> None:
    text = (SAVED / "meteostat.csv").read_text(encoding="utf-8").partition("\n")[2]
    name, weather = read_weather(text.encode(), "bulk.csv")
    assert (name, len(weather.reports)) == ("meteostat", 2)
    assert [bad.row for bad in weather.rejected] == [3]


def test_an_airport_report_has_its_date_from_the_line_and_tenths_from_its_remarks() -> None:
    _, weather = read("metar.txt")
    first, zurich, chicago = weather.reports[0], weather.reports[1], weather.reports[2]
    assert weather.utc
    assert [one.time.hour for one in weather.reports] == [12, 12, 12]
    assert (first.pressure, zurich.wind) == (101400.0, pytest.approx(10 * 1852 / 3600))
    assert (chicago.temperature, chicago.direction) == (pytest.approx(273.15 - 1.7), None)
    assert chicago.pressure == pytest.approx(29.92 * 3386.389)
    assert chicago.humidity == pytest.approx(0.525, abs=0.02)  # dew point -10.0 °C at -1.7 °C


def test_a_report_without_year_and_month_says_what_is_missing() -> None:
    with pytest.raises(DamagedLog, match=r"a\.txt, row 1: .* without year and month"):
        read_weather(b"METAR LSZH 161250Z 26010KT 20/09 Q1013=\n", "a.txt")


def test_an_airport_report_after_midnight_belongs_to_the_next_month() -> None:
    _, weather = read_weather(b"2026-05-31 23:55 METAR LSZH 010010Z 26010KT 20/09 Q1013=\n", "a.txt")
    assert weather.reports[0].time == datetime(2026, 6, 1, 0, 10)


def test_a_column_without_a_unit_is_refused_not_guessed() -> None:
    with pytest.raises(DamagedLog, match="Temp: found no unit"):
        read_weather(b"time,Temp,wind_mps\n2026-05-16 14:00,20,4\n", "a.csv")


def test_another_file_is_not_weather() -> None:
    with pytest.raises(UnknownFormat, match=r"a\.csv: found no weather, expected one of: "):
        read_weather(b"time,altitude\n0,1\n", "a.csv")


def test_between_two_reports_the_weather_is_theirs_in_proportion_and_less_certain() -> None:
    """A Brownian bridge: the square mean change of an hour is (2^2 + 1^2) / 2, halfway a quarter of it adds to the
    variance, and at a report nothing does."""
    _, weather = read("open_meteo.json")
    half = weather_at(weather, datetime(2026, 5, 16, 13, 30)).values["temperature"]
    assert half == pytest.approx((292.15, math.hypot(OF_A_MODEL["temperature"], math.sqrt(2.5 / 4))))
    assert weather_at(weather, TWO).values["temperature"] == pytest.approx((293.15, OF_A_MODEL["temperature"]))


def test_nothing_is_read_beyond_the_reports_or_into_a_long_gap() -> None:
    _, weather = read("open_meteo.json")
    assert weather_at(weather, datetime(2026, 5, 16, 18, 30)).values == {}
    assert weather_at(weather, datetime(2026, 5, 16, 12, 59)).values == {}
    four_hours = tuple(Report(TWO + timedelta(hours=hours), temperature=290.0) for hours in (0, 4))
    assert weather_at(SavedWeather(four_hours, (), False, OF_A_STATION), TWO + timedelta(hours=1)).values == {}


def test_a_day_without_a_time_is_the_mean_of_its_hours_with_their_scatter() -> None:
    hours = tuple(Report(datetime(2026, 5, 16, hour), temperature=280.0 + hour) for hour in range(24))
    (value, sd) = weather_of_day(SavedWeather(hours, (), False, OF_A_STATION), datetime(2026, 5, 16)).values[
        "temperature"
    ]
    assert value == pytest.approx(293.5)
    assert sd == pytest.approx(math.hypot(math.sqrt((10**2 - 1) / 12), OF_A_STATION["temperature"]))


def test_winds_on_pressure_levels_are_above_the_ground() -> None:
    _, weather = read("open_meteo.json")
    winds = {round(one.height): one.speed for one in weather.reports[1].aloft}
    assert winds == {120: pytest.approx(7.0), 350: pytest.approx(10.0)}


def test_the_row_of_height_zero_among_winds_aloft_is_the_wind_near_the_ground() -> None:
    rows = "time,height_ft,wind_mps,wind_from_deg\n2026-05-16T14:00,1000,8,250\n2026-05-16T14:00,0,3,240\n"
    _, weather = read_weather(rows.encode(), "winds.csv")
    (report,) = weather.reports
    assert (report.wind, report.direction) == (3.0, 240.0)
    assert [(round(one.height, 1), one.speed) for one in report.aloft] == [(304.8, 8.0)]
    (error,) = read_weather((rows + "2026-05-16T14:00,-5,3,240\n").encode(), "winds.csv")[1].rejected
    assert "found 3 m/s at -1.524 m, expected up to 150 m/s" in str(error)


def test_both_kinds_of_source_have_a_standard_deviation_for_every_quantity() -> None:
    assert OF_A_STATION.keys() == OF_A_MODEL.keys() == QUANTITIES.keys()


@pytest.mark.parametrize(
    "content", [b"", b"{", b'{"hourly": 1, "hourly_units": 2}', b"\0\1\2", b"time,wind_mps,temp_c\n"]
)
def test_a_torn_file_is_an_error_of_one_line(content: bytes) -> None:
    with pytest.raises((DamagedLog, UnknownFormat)):
        read_weather(content, "a")


OPEN_METEO = (SAVED / "open_meteo.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "text",
    [
        OPEN_METEO.replace("utc_offset_seconds", "utc_offset_seconds" + "\x1d" * 100, 1),
        OPEN_METEO.replace("440.0", "high"),
        OPEN_METEO.replace("440.0", "1e9"),
        OPEN_METEO.replace("440.0", "inf"),
        '{"hourly": {"time": ["2026-05-16T11:00"]}, "hourly_units": []}',
        (SAVED / "meteostat.csv").read_text(encoding="utf-8").replace(",11,", ",\u00b2,"),
    ],
    ids=["separators of groups", "an elevation in words", "a high elevation", "no elevation", "units", "superscript"],
)
def test_a_hostile_file_is_read_or_refused_in_a_line(text: str) -> None:
    with suppress(DamagedLog, UnknownFormat):
        assert all(math.isfinite(one.pressure or 0.0) for one in read_weather(text.encode(), "a")[1].reports)

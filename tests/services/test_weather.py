"""The weather of flights filled in from saved files: by date, hour and site, with its uncertainty, and undone."""

import csv
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from fieldkit.errors import BadValue
from fieldkit.services.weather import read_zone
from tests.commands import Run

SAVED = Path(__file__).parents[1] / "importing" / "weather_files"
HEADER = "flight_id,date_time,rocket,motor,dry_mass_g,diameter_mm,site,temperature_c,apogee_m\n"
FLIGHTS = (
    HEADER + "1,2026-05-16T14:00,Astra,F24-4W,400,66,Moor,,200\n2,2026-05-16T14:00,Astra,F24-4W,400,66,Moor,25,201\n"
)


@pytest.fixture
def flights(tmp_path: Path, run: Run) -> Path:
    table = tmp_path / "flights.csv"
    table.write_text(FLIGHTS)
    run("import", table)
    return table


def shown(run: Run) -> dict[str, dict[str, object]]:
    return {one["flight_id"]: one for one in run("flights", "--json").document["flights"]}


def test_flights_get_the_weather_of_their_hour_and_undo_takes_it_away(run: Run, flights: Path) -> None:
    done = run("weather", SAVED / "open_meteo.json", "--json").document
    assert [sorted(one["filled"])[0] for one in done["flights"]] == ["humidity_pct", "humidity_pct"]
    first, second = shown(run)["1"], shown(run)["2"]
    assert (first["temperature_c"], second["temperature_c"]) == (20.0, 25.0)
    assert first["temperature_sd_c"] == "1.5"
    assert "temperature_sd_c" not in second
    assert first["wind_mps"] == pytest.approx(4.0 / 6 ** (1 / 7), abs=0.01)  # 10 m to the pad by the power law
    assert (first["wind_aloft_mps"], first["wind_aloft_height_m"], first["wind_aloft_turn_deg"]) == ("7.0", "120", "10")
    assert first["weather_source"] == "open_meteo.json at 2026-05-16 14:00"
    run("undo")
    assert shown(run)["1"]["temperature_c"] is None
    run("redo")
    assert shown(run)["1"]["temperature_c"] == 20.0


def test_a_second_run_changes_nothing_and_replace_replaces(run: Run, flights: Path) -> None:
    run("weather", SAVED / "open_meteo.json")
    assert "No flight was filled in" in run("weather", SAVED / "open_meteo.json").out
    run("weather", SAVED / "open_meteo.json", "--replace")
    assert shown(run)["2"]["temperature_c"] == 20.0


def test_an_exported_table_imports_with_the_weather_and_its_uncertainty(
    run: Run, flights: Path, tmp_path: Path
) -> None:
    run("weather", SAVED / "open_meteo.json")
    before = shown(run)
    (tmp_path / "out.csv").write_text(run("export").out)
    run("remove", "1", "2")
    run("import", tmp_path / "out.csv")
    assert shown(run)["1"] == before["1"]


def test_a_file_in_utc_asks_for_the_zone_of_the_flights(run: Run, flights: Path) -> None:
    assert "meteostat.csv: found times in UTC, expected" in run("weather", SAVED / "meteostat.csv", status=1).err
    run("weather", SAVED / "meteostat.csv", "--timezone", "Europe/Zurich")
    assert shown(run)["1"]["temperature_c"] == 20.0


def test_flights_at_several_sites_ask_for_the_one_of_the_file(run: Run, flights: Path, tmp_path: Path) -> None:
    more = tmp_path / "more.csv"
    more.write_text(HEADER + "3,2026-05-16T14:00,Astra,F24-4W,400,66,Field,,202\n")
    run("import", more)
    assert "found flights at Moor, Field, expected --site" in run("weather", SAVED / "open_meteo.json", status=1).err
    run("weather", SAVED / "open_meteo.json", "--site", "moor")
    assert [shown(run)[id]["temperature_c"] for id in ("1", "3")] == [20.0, None]


def test_a_damaged_row_is_printed_with_its_line(run: Run, flights: Path) -> None:
    assert "open_meteo.csv, row 7, temperature_2m (°F): found 'warm'" in run("weather", SAVED / "open_meteo.csv").err


def test_a_table_of_plans_is_completed(run: Run, tmp_path: Path) -> None:
    plans, out = tmp_path / "plans.csv", tmp_path / "filled.csv"
    plans.write_text(
        "flight_id,date_time,rocket,motor,dry_mass_g,diameter_mm\n9,2026-05-16T13:30,Astra,F24-4W,400,66\n"
    )
    run("weather", SAVED / "open_meteo.json", SAVED / "winds_aloft.csv", "--plans", plans, "--out", out)
    (row,) = csv.DictReader(out.read_text().splitlines())
    assert float(row["temperature_c"]) == pytest.approx(19.0)
    assert row["wind_aloft_height_m"] == "350"
    (made,) = run("predict", "--flights", out, "--json").document["predictions"]
    assert made["conditions"]["temperature_c"] == pytest.approx(19.0)


def test_the_weather_moves_the_forecast_of_a_flight_as_its_density_does(
    run: Run, flights: Path, tmp_path: Path
) -> None:
    before = run("predict", "--rocket", "Astra", "--motor", "F24-4W", "--json").document["predictions"][0]
    run("weather", SAVED / "open_meteo.json", "--replace")
    after = run("predict", "--rocket", "Astra", "--motor", "F24-4W", "--json").document["predictions"][0]
    assert before["apogee_m"]["p50"] != after["apogee_m"]["p50"]


def test_a_zone_is_a_name_or_hours_ahead_of_utc() -> None:
    when = datetime(2026, 1, 1)
    for text, hours in {"0": 0.0, "UTC": 0.0, "-5": -5.0, "+5:30": 5.5, "America/Chicago": -6.0}.items():
        assert read_zone(text).utcoffset(when) == timedelta(hours=hours)


@pytest.mark.parametrize("text", ["Moon/Base", "+99", "", "../x"])
def test_an_unknown_zone_is_refused(text: str) -> None:
    with pytest.raises(BadValue, match="expected one such as America/Chicago"):
        read_zone(text)


@pytest.mark.parametrize("name", ["metar.txt", "meteostat.csv", "open_meteo.json"])
def test_an_import_of_weather_names_the_command_for_it(name: str, run: Run) -> None:
    assert "it is saved weather, which `fieldkit weather FILE` fills in" in run("import", SAVED / name, status=1).err


def test_a_wind_that_is_known_poorly_widens_the_landing_of_a_plan(run: Run, tmp_path: Path) -> None:
    columns = "flight_id,rocket,motor,dry_mass_g,diameter_mm,wind_mps,wind_sd_mps\n"
    spreads = []
    for sd in ("", "0.1", "3"):
        (tmp_path / "plans.csv").write_text(f"{columns}9,Astra,F24-4W,400,66,3,{sd}\n")
        (made,) = run("predict", "--flights", tmp_path / "plans.csv", "--json").document["predictions"]
        away = made["landing"]["away_m"]
        spreads.append(away["p95"] - away["p05"])
    assert spreads[0] == pytest.approx(spreads[1], rel=0.01)
    assert spreads[1] < 0.7 * spreads[2]

"""Figures in the units that a flyer chose."""

import math
import pickle

import pytest

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME
from fieldkit.messages import amount, estimate, fine, marked, message, of_column, of_unit, per_wind
from fieldkit.quantities import (
    ShownUnits,
    density,
    in_system,
    measure,
    percent,
    rounded,
    significant,
    with_sd,
    with_unit,
)

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("rail_angle", math.radians(5), "5°"),
        ("humidity", 0.8, "80%"),
        ("temperature", 294.15, "21 °C"),
        ("apogee", 281.3, "281.3 m"),
    ],
)
def test_degrees_and_percent_follow_their_number_without_a_space(name: str, value: float, shown: str) -> None:
    assert measure(BY_NAME[name], value, "SI") == significant(BY_NAME[name], value, "SI") == shown
    assert with_unit("7", "") == "7"


@pytest.mark.parametrize(
    ("marks", "si", "us"),
    [
        (f"a gap of {amount(30.0, 'm')} in Test 30 m", "a gap of 30 m in Test 30 m", "a gap of 98 ft in Test 30 m"),
        (f"off the rail at {amount(10.0, 'm/s')}", "off the rail at 10 m/s", "off the rail at 22 mph"),
        (f"friction: {estimate(13.7, 14.0, 'm/s^2')}", "friction: 14 ± 14 m/s^2", "friction: 45 ± 46 ft/s^2"),
        (f"a site: {estimate(-120.0, 60.0, 'm')}", "a site: -120 ± 60 m", "a site: -394 ± 197 ft"),
        (f"days: {estimate(5.0, 2.5, 'K')}", "days: 5.0 ± 2.5 K", "days: 9.0 ± 4.5 °F"),
        (amount(3.0, "m", to=200.0), "3 to 200 m", "10 to 656 ft"),
        (of_column(BY_NAME["dry_mass"], 90.0), "90000 g", "198.4 lb"),
        (of_column(BY_NAME["peak_accel"], 98.0665), "10 g", "10 g"),
        (of_column(BY_NAME["diameter"], 0.254), "254 mm", "10 in"),
        (of_column(BY_NAME["temperature"], 283.15, 293.15), "10 to 20 °C", "50 to 68 °F"),
        (of_unit(2.0, "kg", digits=3), "2 kg", "70.5 oz"),
        (of_unit(0.0001, "m²", 0.004, 3), "0.0001 to 0.004 m²", "0.155 to 6.2 in²"),
        (
            estimate(4.57, 7.4, message(f"deg at {amount(15.0, 'm/s')}")),
            "4.6 ± 7.4 deg at 15 m/s",
            "4.6 ± 7.4 deg at 34 mph",
        ),
        (of_unit(45.0, "m/s^2", digits=2), "45 m/s^2", "148 ft/s^2"),
        (of_unit(15.0, message(f"deg at {amount(15.0, 'm/s')}")), "15 deg at 15 m/s", "15 deg at 34 mph"),
        (fine(1.0, "m"), "1.0 m", "3.3 ft"),
        (per_wind(94.0), "94 m per m/s of wind", "138 ft per mph of wind"),
    ],
)
def test_a_message_holds_its_amounts_and_a_medium_writes_them(marks: str, si: str, us: str) -> None:
    found = message(marks)
    assert found == si
    assert (in_system(found, "SI"), in_system(found, "US")) == (si, us)
    again = pickle.loads(pickle.dumps(found))
    assert in_system(again, "US") == us, "it passes through other processes"
    assert in_system(message(f"x: {marked(found)}"), "US") == f"x: {us}", "and into other messages"


def test_names_and_finished_texts_are_never_converted() -> None:
    assert in_system("no flight 'Test 30 m', 90 g ± 5 m", "US") == "no flight 'Test 30 m', 90 g ± 5 m"


def test_an_error_holds_the_amounts_of_its_message() -> None:
    damage = DamagedLog(message(f"found {amount(30.0, 'm')}"), row=3, source="pad 30 m.eeprom")
    assert str(damage) == "pad 30 m.eeprom, row 3: found 30 m"
    assert in_system(damage, "US") == "pad 30 m.eeprom, row 3: found 98 ft"
    assert in_system(BadValue(message(amount(1.0, "m/s"))), "mixed") == "2 mph"


def test_a_density_is_in_pounds_per_cubic_foot_if_lengths_are_in_feet() -> None:
    assert density(1.225, "SI") == "1.225 kg/m³"
    assert density(1.225, "mixed") == "0.0765 lb/ft³"


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(12345.6, 4, "12346"), (281.31, 4, "281.3"), (0.051719, 3, "0.0517"), (9999.7, 4, "10000"), (1e12, 4, "1e+12")],
)
def test_a_rounded_number_is_written_out(value: float, digits: int, text: str) -> None:
    assert rounded(value, digits) == text


def test_a_high_flight_is_shown_without_an_exponent() -> None:
    assert significant(BY_NAME["apogee"], 4000.0, "US") == "13123 ft"


def test_a_rail_has_tenths_of_feet() -> None:
    rail, site = BY_NAME["rail_length"], BY_NAME["site_elevation"]
    assert [measure(rail, one, "US") for one in (1.0, 0.9144)] == ["3.3 ft", "3.0 ft"]
    assert measure(site, 1.0, "US") == "3 ft"


@pytest.mark.parametrize(
    ("system", "text"),
    [("SI", "94 m per m/s of wind"), ("US", "138 ft per mph of wind"), ("mixed", "138 ft per mph of wind")],
)
def test_a_drift_is_per_one_unit_of_the_users_speed(system: str, text: str) -> None:
    assert ShownUnits(system).per_wind(94.0) == text


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (43.766, 6.691, "43.8 ± 6.7"),
        (1204.3, 153.0, "1204 ± 153"),
        (285.21, 9.96, "285 ± 10"),
        (0.5962, 0.0341, "0.596 ± 0.034"),
        (162.8, 1.0, "162.8 ± 1.0"),
        (281.3, 0.0, "281.3"),
        (281.3, float("nan"), "281.3"),
    ],
)
def test_a_value_has_the_digits_that_its_standard_deviation_supports(value: float, sd: float, text: str) -> None:
    assert with_sd(value, sd) == text


@pytest.mark.parametrize(
    ("probability", "text"),
    [(0.0, "< 1%"), (0.004, "< 1%"), (0.01, "1%"), (0.5, "50%"), (0.99, "99%"), (0.996, "> 99%"), (1.0, "> 99%")],
)
def test_no_chance_is_certain_or_impossible(probability: float, text: str) -> None:
    assert percent(probability) == text


def test_a_heavy_rocket_is_weighed_in_pounds() -> None:
    """As a scale shows it: nobody says that a rocket weighs 144 oz."""
    assert ShownUnits("US").mass(4.0823) == "9.00 lb"
    assert ShownUnits("US").mass(0.322) == "11.36 oz"
    assert ShownUnits("SI").mass(4.0823) == "4082 g"
    assert in_system(message(amount(0.1, "g", 0, 9.07)), "US") == "3.53 oz to 20.00 lb"
    assert in_system(message(amount(4.0823, "g", 0, 9.07)), "US") == "9.00 to 20.00 lb"
    assert in_system(message(of_unit(0.005, "kg", 50.0)), "US") == "0.1764 to 1764 oz"

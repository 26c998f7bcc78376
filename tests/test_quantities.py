"""Figures in the units that a flyer chose."""

import math

import pytest

from fieldkit.flight import BY_NAME
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
    ("note", "shown"),
    [
        ("a gap between 30 m, as recorded, and 61 m", "a gap between 98 ft, as recorded, and 200 ft"),
        ("off the rail at 10 m/s", "off the rail at 22 mph"),
        ("the missing 25 m/s² are filled in", "the missing 25 m/s² are filled in"),
        ("friction: 13.7 ± 14 m/s^2", "friction: 45 ± 46 ft/s^2"),
        ("a site: -120 ± 60 m", "a site: -394 ± 197 ft"),
        ("days: 5 ± 2.5 K", "days: 9.0 ± 4.5 °F"),
        ("4.57 ± 7.4 deg at 15 m/s off the rail", "4.57 ± 7.4 deg at 34 mph off the rail"),
        ("found 0 m, expected 3 to 200 m", "found 0 ft, expected 10 to 656 ft"),
        ("7.5 g is more than 5 g, a dry mass of 280 g on F24", "7.5 g is more than 5 g, a dry mass of 9.88 oz on F24"),
        ("lift-off mass of 0.35 kg", "lift-off mass of 12.35 oz"),
        ("a diameter of 254 mm, in a 29 mm mount", "a diameter of 10.00 in, in a 29 mm mount"),
        ("row 7 m2 has 3 mm and version 1.5 meters", "row 7 m2 has 3 mm and version 1.5 meters"),
    ],
)
def test_a_note_states_lengths_and_speeds_in_the_units_of_the_system(note: str, shown: str) -> None:
    assert in_system(note, "US") == shown
    assert in_system(note, "SI") == note


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


@pytest.mark.parametrize(
    ("note", "shown"),
    [
        (
            "lift-off mass of 2 kg is outside the training range (0.02 to 1.5 kg)",
            "lift-off mass of 70.55 oz is outside the training range (0.71 to 52.91 oz)",
        ),
        (
            "drag area around 0.005 m² is outside the training range (0.0001 to 0.004 m²)",
            "drag area around 7.75 in² is outside the training range (0.155 to 6.2 in²)",
        ),
    ],
)
def test_a_range_of_masses_or_areas_is_in_one_system(note: str, shown: str) -> None:
    assert in_system(note, "US") == shown
    assert in_system(note, "SI") == note


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

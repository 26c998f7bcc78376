"""Text of recovery, wind aloft and rail direction is typed once, where a flight is made."""

import ast
import math
from pathlib import Path

import pytest

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.launch_conditions import AS_USUAL, launch_conditions
from fieldkit.flight.recovery import RECOVERY_NAMES, Recovery
from fieldkit.flight.typed_columns import NO_COLUMNS

pytestmark = pytest.mark.fast

ENGINE = Path(__file__).parents[2] / "fieldkit"
BELOW_THE_EDGES = (
    *("rocket", "motors", "physics", "analysis", "model", "inference", "selection", "forecast", "scoring", "planning"),
)
READERS = {"units.parse", "units.parse_difference", "typed_columns"}
OWN_TEXTS = {"motors/comparison.py", "planning/contest_day.py"}
"""Modules that read files and options of their own."""


def reads(module: ast.Module) -> set[str]:
    """What a module reads from texts of a flight: a parser of numbers, the further columns or one of them by name."""
    found = set()
    for node in ast.walk(module):
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            found |= {called} & READERS
            if called.endswith(".text") and node.args and isinstance(node.args[0], ast.Constant):
                found |= {str(node.args[0].value)} & {*RECOVERY_NAMES}
        elif isinstance(node, ast.Attribute) and node.attr == "extra":
            found.add("extra")
    return found


@pytest.mark.parametrize("folder", BELOW_THE_EDGES)
def test_no_text_of_a_flight_is_parsed_below_the_edges(folder: str) -> None:
    modules = {file.relative_to(ENGINE).as_posix(): file for file in (ENGINE / folder).rglob("*.py")}
    found = {name: reads(ast.parse(file.read_text())) for name, file in modules.items() if name not in OWN_TEXTS}
    assert {name: texts for name, texts in found.items() if texts} == {}


def test_only_a_flight_types_its_further_columns() -> None:
    users = [
        file.relative_to(ENGINE).as_posix()
        for file in ENGINE.rglob("*.py")
        if "typed_columns" in reads(ast.parse(file.read_text()))
    ]
    assert users == ["flight/flight.py"]


def test_a_flight_has_its_columns_typed_however_it_gets_them() -> None:
    texts = {"recovery": "Streamer", "wind_aloft": "36km/h", "rail_direction": "away", "wind_sd_mps": "1.5"}
    made = Flight(extra=texts)
    for flight in (made, Flight().with_columns(**texts), Flight().with_changes(extra=texts)):
        assert flight == made
        assert flight.columns == made.columns
    assert made.columns.recovery == Recovery("streamer")
    assert made.columns.numbers["wind_aloft"] == pytest.approx(10.0)
    assert (made.columns.rail_direction, made.columns.sd) == (math.pi, {"wind": 1.5})
    assert made.with_changes(apogee=100.0).columns is made.columns, "texts that stay are not read again"
    assert made.without_columns(texts).columns == NO_COLUMNS
    assert Flight(extra={"drogue_speed_mps": "20", "main_altitude_ft": "500"}).columns.recovery.dual


@pytest.mark.parametrize(
    ("texts", "problem"),
    [
        ({"recovery": "hope"}, "recovery: found 'hope', expected one of parachute, streamer"),
        ({"drogue_speed_mps": "20"}, "found a drogue speed and no height at which the main opens"),
        ({"main_speed_mps": "-2"}, "main speed: found -2 m/s, expected more than zero"),
        ({"wind_aloft": "twelve"}, "wind aloft: found 'twelve', expected a number"),
        ({"wind_aloft": "500m/s"}, "wind aloft: found 500m/s, expected 0 to 150 m/s"),
        ({"rail_direction": "sideways"}, "rail_direction: found 'sideways', expected into, away, across or degrees"),
        ({"stability_cal": "0"}, "stability cal: found '0', expected body diameters above zero"),
        ({"motor_temperature_c": "warm"}, "motor temperature: found 'warm', expected a number"),
    ],
)
def test_an_impossible_column_counts_as_not_recorded_and_its_check_names_it(
    texts: dict[str, str], problem: str
) -> None:
    flight = Flight(extra={"some column": "of a flyer", **texts})
    assert flight.columns.recovery == Recovery()
    with pytest.raises(BadValue) as raised:
        flight.columns.check()
    assert str(raised.value).startswith(problem)
    (name,) = flight.columns.problems
    assert not flight.columns.readable(name)
    if name == "wind_aloft" and name not in flight.columns.numbers:
        assert launch_conditions(flight) == AS_USUAL


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "about two"])
def test_a_standard_deviation_is_a_finite_number(text: str) -> None:
    assert Flight(extra={"wind_sd_mps": text, "temperature_sd_c": "2"}).columns.sd == {"temperature": 2.0}

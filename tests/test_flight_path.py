"""A reader can follow a rocket's flights through a forecast: few functions in few files pass them on."""

from functools import cache

import pytest

from tools import flight_path
from tools.flight_path import stops

MAX_STOPS = 28
MAX_FILES = 9
MAX_READINGS = 24
passes = cache(flight_path.passes)


@pytest.mark.thorough
def test_the_flights_of_a_forecast_stop_at_few_files() -> None:
    made = passes()
    visited = stops(made)
    assert {"fieldkit/forecast/kinds.py", "fieldkit/model/readout_data.py"} <= set(visited)
    assert len(visited) <= MAX_STOPS, made
    assert len(set(visited)) <= MAX_FILES, visited


@pytest.mark.thorough
def test_objects_that_hold_the_flights_travel_further() -> None:
    found = stops(passes(holders=True))
    assert "fieldkit/inference/laplace/fit.py" in found
    assert len(found) > len(stops(passes()))


def test_the_readings_of_a_log_are_passed_by_few_functions() -> None:
    made = flight_path.passes_of_readings()
    assert ("fieldkit/importing/from_samples.py", "fieldkit/analysis/measure.py") in {
        (one.source, one.target) for one in made
    }
    assert len(made) <= MAX_READINGS, made

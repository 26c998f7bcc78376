"""Flights compared with their forecasts from the others."""

from itertools import pairwise

import pytest

from fieldkit.forecast.evaluation.rivals import rival_scores
from fieldkit.forecast.one_offs import beside_others
from tests.inference.laplace.test_one_offs import season

CHECK_SHAPES = False


def test_the_miss_is_the_flown_apogee_minus_the_forecast_without_the_flight() -> None:
    flown = season({5: {"tilt": 64.0}}, names=("apogee",))
    found = beside_others(flown)
    others = [one for row, one in enumerate(flown) if row != 5]
    left_out = beside_others([*others, (flown[5][0].with_changes(tags=("off_axis",)), flown[5][1])])
    one, again = found[5], left_out[-1]
    assert one.flight.apogee == pytest.approx(one.forecast + one.miss)
    assert one.forecast == pytest.approx(again.forecast, rel=0.01)
    assert one.singled_out
    assert again.singled_out
    assert again.suggested_tags == ()


def test_a_flight_without_readouts_has_no_probability_of_anything() -> None:
    flown = season(names=("apogee",))
    bare = [*flown, (flown[0][0].unflown(flight_id="bare"), flown[0][1])]
    one = beside_others(bare)[-1]
    assert not one.departures
    assert one.probability == 0.0


def test_rivals_are_scored_on_the_same_flights() -> None:
    flown = season(names=("apogee",))
    found = {one.name: one for one in rival_scores(flown)}
    apogees = [float(flight.apogee or 0.0) for flight, _ in flown]
    steps = [abs(one - other) for one, other in pairwise(apogees)]
    assert found["flight before"].mae_m == pytest.approx(sum(steps) / len(steps))
    assert found["flight before"].crps_m == pytest.approx(found["flight before"].mae_m)
    assert found["fleet ratio"].crps_m < found["uncalibrated"].crps_m

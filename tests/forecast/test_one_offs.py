"""Flights compared with their forecasts from the others."""

from itertools import pairwise
from math import log

import pytest

from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.evaluation.rivals import rival_scores
from fieldkit.forecast.one_offs import beside_others
from fieldkit.forecast.predict import Fits, predict
from fieldkit.importing.read import read
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.selection.candidates import Place
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


def test_comparing_flights_and_forecasting_the_next_need_the_same_fits() -> None:
    """Each fit takes as long as a key may take; the wind acts before or after an effect of a set."""
    windy = [(flight.with_changes(wind=2.0 + row % 3), motor) for row, (flight, motor) in enumerate(season())]
    assumed = Assumed(((0.5, ()), (0.5, (Place("wear"),))))
    fits: Fits = {}
    beside_others(windy, assumed, fits=fits)
    known = len(fits)
    flight, motor = windy[-1]
    predict(windy, [(flight.unflown(flight_id="next"), motor)], assumed, fits=fits)
    assert not any(fit.solution for fit in fits.values()), "kept in little memory"
    assert len(fits) == known


def test_a_flight_without_readouts_has_no_probability_of_anything() -> None:
    flown = season(names=("apogee",))
    bare = [*flown, (flown[0][0].unflown(flight_id="bare"), flown[0][1])]
    one = beside_others(bare)[-1]
    assert not one.departures
    assert one.probability == 0.0


def test_reference_flights_without_tags_show_what_their_notes_say() -> None:
    """Notes: 5 weak, 6 very weak, 7 extra drag, 8 off axis; these are tagged, and the other eight are good."""
    table = read(REFERENCE_FLIGHTS.read_bytes(), REFERENCE_FLIGHTS.name, lambda name: None).flights
    flown = [(flight, catalogue().resolve(flight.motor)) for flight in table]
    tagged, untagged = beside_others(flown), beside_others([(one.with_changes(tags=()), motor) for one, motor in flown])
    probable = sorted(untagged, key=lambda one: -one.probability)[:3]
    assert {one.flight.flight_id for one in probable} == {"5", "6", "8"}
    good = [row for row, (flight, _) in enumerate(flown) if flight.clean]
    errors = [sum(abs(found[row].miss) for row in good) / len(good) for found in (tagged, untagged)]
    assert len(good) == 8
    assert errors[1] < 1.05 * errors[0]


def test_rivals_are_scored_on_the_same_flights() -> None:
    flown = season(names=("apogee",))
    found = {one.name: one for one in rival_scores(flown)}
    apogees = [float(flight.apogee or 0.0) for flight, _ in flown]
    steps = [abs(one - other) for one, other in pairwise(apogees)]
    assert found["flight before"].mae_m == pytest.approx(sum(steps) / len(steps))
    assert found["flight before"].crps_m == pytest.approx(found["flight before"].mae_m)
    assert found["fleet ratio"].crps_m < found["uncalibrated"].crps_m


def test_a_readout_that_cannot_be_a_measurement_is_explained_beside_a_usual_flight() -> None:
    flown = season()
    flight, motor = flown[5]
    long = flight.with_changes(burn_time=3.3 * (flight.burn_time or 0.0))
    one = beside_others([*flown[:5], (long, motor), *flown[6:]])[5]
    assert set(one.impossible) == {"burn_time"}
    assert "burn_time" not in one.departures
    assert one.impossible["burn_time"].log_ratio == pytest.approx(log(3.3), abs=0.1)
    assert not one.singled_out
    assert all(not each.impossible for each in beside_others(flown))

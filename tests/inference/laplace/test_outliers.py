"""A readout far from its expectation barely changes a forecast, and has a warning until the flyer confirms it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from fieldkit.flight import CHECKED_TAG
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.outliers import FALSE_ALARMS, smallest_usual_weight
from fieldkit.motors import catalogue
from tests.forecast.test_predict import PLAN, Flown, season

pytestmark = pytest.mark.fast

F39 = [(replace(PLAN, motor="F39"), catalogue().resolve("F39"))]


def with_a_slip(flown: Flown, row: int = 0, factor: float = 2.237) -> Flown:
    """The same with the top speed of one flight in mph read as m/s."""
    flight, motor = flown[row]
    assert flight.top_speed is not None
    slipped = flight.with_changes(top_speed=flight.top_speed * factor)
    return [*flown[:row], (slipped, motor), *flown[row + 1 :]]


def test_good_flights_have_no_outliers() -> None:
    (made,) = predict(season({}), F39)
    assert made.left_out == ()


def test_an_outlier_is_named_with_its_weight() -> None:
    flown = with_a_slip(season({}), 1)
    (made,) = predict(flown, F39)
    (line,) = made.left_out
    name = flown[1][0].flight_id
    assert line.startswith(f"flight {name}: top speed of ")
    assert line.endswith(f"`fieldkit tag {name} {CHECKED_TAG}`")


def test_what_the_flyer_has_checked_is_not_named() -> None:
    flown = with_a_slip(season({}))
    flight, motor = flown[0]
    tagged = [(flight.with_changes(tags=(CHECKED_TAG,)), motor), *flown[1:]]
    assert tagged[0][0].clean
    (made,) = predict(tagged, F39)
    assert made.left_out == ()


@pytest.mark.parametrize("flights", [2, 6])
def test_a_slip_does_not_move_the_next_forecast(flights: int) -> None:
    flown = season({}, 1)[:flights]
    (right,), (slipped,) = predict(flown, F39), predict(with_a_slip(flown), F39)
    assert len(slipped.left_out) == 1
    assert np.median(slipped.apogee) == pytest.approx(np.median(right.apogee), rel=0.05)


def test_one_good_flight_in_a_hundred_is_named() -> None:
    rng = np.random.default_rng(1)
    squares = stats.t(4).rvs((200_000, 5), random_state=rng) ** 2
    usual = smallest_usual_weight(np.full(len(squares), 5), 4.0)
    named = ((5 / (4 + squares)) < usual[:, None]).any(axis=1)
    assert named.mean() == pytest.approx(FALSE_ALARMS, rel=0.05)

"""A readout that does not fit the rest of its flight teaches nothing until the flyer says that it is right."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.errors import DamagedModel
from fieldkit.flight import CHECKED_TAG, Flight
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace import outliers
from fieldkit.inference.laplace.outliers import consistency_check
from fieldkit.motors import Found, catalogue
from tests.forecast.test_predict import PLAN, Flown, season

pytestmark = pytest.mark.fast


def with_a_slip(flown: Flown, row: int = 0) -> Flown:
    """The same with the top speed of one flight typed in mph and taken for m/s."""
    flight, motor = flown[row]
    assert flight.top_speed is not None
    slipped = flight.with_changes(top_speed=flight.top_speed * 2.237)
    return [*flown[:row], (slipped, motor), *flown[row + 1 :]]


def parts(flown: Flown) -> tuple[list[Flight], list[Found]]:
    return [flight for flight, _ in flown], [motor for _, motor in flown]


def test_good_flights_are_left_as_they_are() -> None:
    flights, found = parts(season({}))
    assert consistency_check(flights, found) == (tuple(flights), ())


def test_a_readout_that_does_not_fit_is_left_out_alone_and_named() -> None:
    flights, found = parts(with_a_slip(season({}), 1))
    kept, lines = consistency_check(flights, found)
    assert kept[1] == flights[1].with_changes(top_speed=None, avg_accel=None)
    assert [kept[0], *kept[2:]] == [flights[0], *flights[2:]]
    (line,) = lines
    assert line.startswith(f"flight {flights[1].flight_id}: top speed of ")
    assert line.endswith(f"`fieldkit tag {flights[1].flight_id} {CHECKED_TAG}`")


def test_what_the_flyer_has_checked_teaches() -> None:
    flights, found = parts(with_a_slip(season({})))
    flights[0] = flights[0].with_changes(tags=(CHECKED_TAG,))
    assert flights[0].clean
    assert consistency_check(flights, found) == (tuple(flights), ())


def test_an_apogee_alone_is_believed() -> None:
    flights, found = parts(season({}))
    lonely = [PLAN.with_changes(apogee=flight.apogee) for flight in flights]
    assert consistency_check(lonely, found) == (tuple(lonely), ())


def test_a_slip_of_the_first_flight_does_not_move_the_next_forecast() -> None:
    flown = season({}, 1)[:2]
    plan = [(replace(PLAN, motor="F39"), catalogue().resolve("F39"))]
    (right,), (slipped,) = predict(flown, plan), predict(with_a_slip(flown), plan)
    assert not right.left_out
    assert len(slipped.left_out) == 1
    assert np.median(slipped.apogee) == pytest.approx(np.median(right.apogee), rel=0.05)


def test_without_the_ensemble_forecasts_go_on_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged() -> None:
        raise DamagedModel("field: found another graph, expected its own")

    monkeypatch.setattr(outliers, "_ensemble", damaged)
    flights, found = parts(season({}))
    assert consistency_check(flights, found) == (
        tuple(flights),
        ("whether readouts fit their flights was not looked at: field: found another graph, expected its own",),
    )

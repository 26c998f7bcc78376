"""Patterns that no effect explains: they continue in later flights, and forecasts follow them."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import model_name, predict
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.selection.candidates import Pattern, Place
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.patterns import known_patterns, pattern_terms
from tests.forecast.test_predict import PLAN, Flown, season

pytestmark = pytest.mark.fast

FIRST = datetime(2026, 5, 2, 9, 0)


def flown(count: int = 12) -> list[Flight]:
    """Flights on two days at two sites, with the flyer's column for paint and a temperature."""
    return [
        PLAN.with_changes(
            flight_id=f"F{number}",
            date_time=FIRST + timedelta(days=7 * (number // 6), hours=number % 6),
            site="mead" if number % 2 else "hill",
            temperature=285.0 + number,
            extra={"paint": "rough" if number % 3 else "smooth"},
        )
        for number in range(count)
    ]


def weights(pattern: Pattern, past: list[Flight], ahead: list[Flight]) -> np.ndarray:
    (weigh,) = [kind[pattern] for kind in known_patterns(past) if pattern in kind]
    return weigh([*past, *ahead])[len(past) :]


def test_a_pattern_in_past_flights_does_not_depend_on_plans() -> None:
    past = flown()
    for kind in known_patterns(past):
        for pattern, weigh in kind.items():
            np.testing.assert_array_equal(weigh([*past, PLAN, PLAN])[:12], weigh(past), err_msg=str(pattern))


def test_patterns_continue_in_later_flights() -> None:
    plans = [PLAN.with_changes(site="mead"), PLAN.with_changes(date_time=FIRST), PLAN]
    assert weights(Pattern("lasting", "F5"), flown(), plans).tolist() == [1, 1, 1]
    assert weights(Pattern("repeated", "F1", every=3), flown(), plans).tolist() == [0, 1, 0]
    assert weights(Pattern("site", "mead"), flown(), plans).tolist() == [1, 0, 0]
    assert weights(Pattern("day", "2026-05-02"), flown(), plans).tolist() == [0, 1, 0]
    assert weights(Pattern("text", "paint", "smooth"), flown(), plans).tolist() == [0, 0, 0]


def test_unrecorded_conditions_of_a_plan_are_as_usual() -> None:
    hours = [PLAN, PLAN.with_changes(date_time=FIRST + timedelta(hours=6.5))]
    assert weights(Pattern("hour"), flown(), hours).tolist() == [0, 1]
    warm = [PLAN, PLAN.with_changes(temperature=320.0)]
    assert weights(Pattern("number", "temperature"), flown(), warm)[0] == 0
    assert weights(Pattern("number", "temperature"), flown(), warm)[1] > 3


def test_a_date_without_a_time_has_no_hour() -> None:
    dated = [
        flight.with_changes(date_time=datetime(2026, 5, 2 + row)) if row % 2 else flight
        for row, flight in enumerate(flown())
    ]
    assert not any(Pattern("hour") in kind for kind in known_patterns(dated))
    assert weights(Pattern("hour"), flown(), [PLAN.with_changes(date_time=datetime(2026, 6, 1))]).tolist() == [0]


def test_a_pattern_that_the_flights_do_not_show_is_left_out() -> None:
    flights = flown(4)
    model = rocket_model(history_of(flights, [catalogue().resolve(flight.motor) for flight in flights]))
    assert pattern_terms(Place(pattern=Pattern("lasting", "F9")), model) == ()
    day = Place(pattern=Pattern("day", "2026-05-02"))
    assert len(rocket_model(history_of(flights, model.found), [day]).terms) == len(model.terms)


def test_a_pattern_of_a_rocket_whose_flights_were_removed_is_left_out() -> None:
    plan = (PLAN, catalogue().resolve(PLAN.motor))
    before, after = (
        predict([], [plan], Assumed(((1.0, places),)), draws=20)[0]
        for places in ((), (Place(pattern=Pattern("number", "temperature")),))
    )
    np.testing.assert_array_equal(before.apogee, after.apogee)


def test_a_forecast_follows_a_lasting_change() -> None:
    """From the seventh flight on, apogees are 10% lower than the model's."""
    history: Flown = [
        (one.with_changes(flight_id=f"F{row}", apogee=one.apogee * (0.9 if row > 5 else 1.0)), motor)
        for row, (one, motor) in enumerate(season({}, 4))
        if one.apogee is not None
    ]
    plan = [(PLAN, catalogue().resolve("F24"))]
    lasting = Place(pattern=Pattern("lasting", "F6"))
    (plain,), (followed,) = predict(history, plan), predict(history, plan, Assumed(((1.0, (lasting,)),)))
    (single,) = predict(season({}, 4), plan)
    truth = 0.9 * float(np.median(single.apogee))
    assert abs(np.median(followed.apogee) / truth - 1) < 0.07
    assert abs(np.median(followed.apogee) - truth) < abs(np.median(plain.apogee) - truth)
    assert followed.model == model_name([lasting]) == "field+unexplained"


@pytest.mark.parametrize("count", [3, 8])
def test_single_flights_are_not_a_pattern(count: int) -> None:
    alone = [PLAN.with_changes(flight_id=f"F{row}", site=f"site {row}") for row in range(count)]
    assert not any(pattern.kind == "site" for kind in known_patterns(alone) for pattern in kind)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (Place(pattern=Pattern("count", smooth=True)), "a trend with the number of flights"),
        (Place(pattern=Pattern("lasting", "4")), "a change from flight 4 on"),
        (Place(pattern=Pattern("day", "2026-05-01")), "the day 2026-05-01"),
        (Place("wear", "", "4"), "wear from flight 4 on"),
    ],
)
def test_a_pattern_in_an_average_is_named_in_words(place: Place, words: str) -> None:
    assert place.in_words == words

"""The drift of a fleet: the time it is counted from, and forecasts of rockets that get heavier."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.inference.laplace.learning import learn_hyperprior
from fieldkit.model.fleet_drift import DAYS_PER_YEAR, MAX_YEARS, period_of, years, years_passed
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of

CHECK_SHAPES = False
START = datetime(2015, 6, 1)
RATE = 0.03
"""How much heavier the rockets get. [1/year]"""
MOTOR = catalogue().resolve("F39-6")


def flight(name: str, year: float | None, rocket: str = "Comet") -> Flight:
    day = None if year is None else START + timedelta(days=year * DAYS_PER_YEAR)
    return Flight(name, rocket, "A", MOTOR.motor.designation, day, dry_mass=0.4, diameter=0.066)


def times(flights: list[Flight]) -> list[datetime | None]:
    return [one.date_time for one in flights]


def flown(rocket: str, at: list[float], rate: float) -> list[tuple[Flight, Found]]:
    """Flights of a rocket at some times [year] whose mass grows at a rate [1/year] and is recorded once."""
    plans = [flight(f"{rocket}-{number}", year, rocket) for number, year in enumerate(at)]
    model = base_model(history_of(plans, [MOTOR] * len(plans)), learned(), period=(START.date(), START.date()))
    truth = np.array([[term.mean for term in model.terms]])
    truth[0, [name.level == "drift" for name in model.names]] = rate
    figures = shown(model, truth, {})
    readouts = ("apogee", "top_speed", "coast_to_apogee")
    return [
        (one.with_changes(**{name: float(figures[name][0, row]) for name in readouts}), MOTOR)
        for row, one in enumerate(plans)
    ]


def fleet(rate: float) -> list[list[tuple[Flight, Found]]]:
    return [flown(f"R{number}", [0.5 * number + 0.1, 0.5 * number + 3, 0.5 * number + 6], rate) for number in range(5)]


@given(st.lists(st.none() | st.floats(0, 20), min_size=1, max_size=6), st.integers(0, 6))
def test_years_are_never_negative_and_plans_without_a_date_come_last(at: list[float | None], count: int) -> None:
    flights, past = [flight(str(number), year) for number, year in enumerate(at)], min(count, len(at))
    found = years(times(flights), past, period_of(flights))
    assert (found >= 0).all()
    later = [row for row in range(past, len(at)) if at[row] is None]
    assert all(found[row] == found.max() for row in later)
    assert (found[[row for row, year in enumerate(at) if year is not None]] <= found.max()).all()


def test_a_flight_without_a_date_was_flown_with_the_one_before_it() -> None:
    flights = [flight("1", None), flight("2", 2), flight("3", None), flight("4", 5)]
    np.testing.assert_allclose(years(times(flights), 4, (START.date(), START.date())), [0, 2, 2, 5], atol=0.003)


def test_a_wrong_date_adds_no_thousand_terms() -> None:
    wrong = flight("0", None).with_changes(date_time=datetime(1, 1, 1))
    model = base_model(history_of([wrong, flight("1", 0), flight("2", 1)], [MOTOR] * 3), learned())
    assert sum(name.level == "drift" for name in model.names) == MAX_YEARS


def test_flights_without_dates_have_no_drift() -> None:
    model = base_model(history_of([flight("1", None), flight("2", None)], [MOTOR, MOTOR]), learned())
    assert not any(name.level == "drift" for name in model.names)


@given(st.lists(st.floats(0, 30), max_size=6))
def test_the_parts_of_all_years_add_up_to_the_time(at: list[float]) -> None:
    np.testing.assert_allclose(years_passed(np.array(at)).sum(axis=0), at, atol=1e-9)


def error(hyperprior: Hyperprior) -> float:
    """Relative error of the forecast for a rocket's next flight, in a fleet that gets heavier. [1]"""
    rockets = fleet(RATE)
    period = period_of(one for own in rockets for one, _ in own)
    shared = shared_prior([rocket_fit(own, hyperprior, period) for own in rockets[1:]], period)
    *earlier, (last, _) = flown("R0", [0.1, 1, 2, 8.5], RATE)
    (made,) = predict(earlier, [(last.unflown(), MOTOR)], Assumed(shared=shared, hyperprior=hyperprior), draws=2000)
    assert last.apogee is not None
    return abs(float(np.median(made.apogee)) / last.apogee - 1)


def test_forecasts_follow_a_fleet_that_gets_heavier() -> None:
    without = replace(learned(), sds={key: sd for key, sd in learned().sds.items() if key != "mass.drift"})
    assert error(learned()) < 0.5 * error(without)


@pytest.mark.thorough
def test_the_variation_of_the_drift_among_fleets_is_learned() -> None:
    constant, drifting = (
        learn_hyperprior([fleet(rate), fleet(-rate)], learned(), rounds=1, steps=12).sd("mass", "drift")
        for rate in (0.0, 2 * RATE)
    )
    assert constant < learned().sd("mass", "drift") < drifting

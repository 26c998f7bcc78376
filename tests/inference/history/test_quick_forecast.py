"""Forecasts from one linear pass: laws for any answer, and agreement with the fit."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.forecast.at_once import forecast_at_once, forecasts_at_once
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.moments import ApogeeMixture
from fieldkit.inference.history.quick_forecast import QuickAnswer, answers, prepared
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import History
from fieldkit.scoring.proper_scores import crps
from tests.inference.history.histories import history

CHECK_SHAPES = False


def answer(of: History) -> QuickAnswer:
    ready = prepared(of)
    return answers(ready, ready.flown)[0]


def width(found: QuickAnswer) -> float:
    """The width of the 90% interval relative to the median. [1]"""
    low, middle, high = (found.apogee_at(level) for level in (0.05, 0.5, 0.95))
    return (high - low) / middle


@pytest.mark.usefixtures("shapes_checked")
def test_more_flights_narrow_the_forecast_and_the_posterior_of_drag() -> None:
    few, many = (answer(history(count, seed=3)) for count in (2, 30))
    assert width(many) < width(few)
    assert many.log_cd[1] < few.log_cd[1]
    assert (few.rests_on, many.rests_on) == (2, 30)


def test_a_rocket_that_flew_lower_is_forecast_lower() -> None:
    whole = history(10, recorded=("apogee",))
    lower = [flight.with_changes(apogee=0.8 * flight.apogee if flight.apogee else None) for flight in whole.flights]
    ratio = answer(replace(whole, flights=tuple(lower))).apogee_at(0.5) / answer(whole).apogee_at(0.5)
    assert 0.75 < ratio < 0.9


def test_drag_in_logs_narrows_the_posterior_of_drag_as_it_does_that_of_the_fit() -> None:
    typed = history(6, recorded=("apogee",))
    flown = [flight.with_changes(coast_drag=0.004) for flight in typed.flights[:-1]]
    logged = replace(typed, flights=(*flown, typed.flights[-1]))
    narrower = answer(logged).log_cd[1] / answer(typed).log_cd[1]
    assert narrower < 0.8
    known = [list(zip(one.flights, one.found, strict=True)) for one in (logged, typed)]
    sds = [np.log(predict(some[:-1], some[-1:])[0].cd).std() for some in known]
    assert narrower == pytest.approx(sds[0] / sds[1], rel=0.2)


def test_the_draws_have_the_moments_of_the_mixture() -> None:
    weight, mean = np.array([0.25, 0.75]), np.array([[4.0], [5.0]])
    known, own = np.array([[0.01], [0.04]]), np.array([[0.02], [0.01]])
    mixture = ApogeeMixture(weight, mean, known, own, 8.0)
    draws = mixture.draws(0, 20_000)
    variance = weight @ (known + own * 8 / 6 + (mean - 4.75) ** 2)
    assert draws.mean() == pytest.approx(4.75, abs=0.01)
    assert draws.var() == pytest.approx(float(variance[0]), rel=0.02)
    assert mixture.draws(0, 50).tolist() == mixture.draws(0, 50).tolist()


@pytest.mark.parametrize("count", [4, 12])
def test_the_answer_is_near_that_of_the_fit(count: int) -> None:
    """Medians within a fifth of the fit's 90% interval, and the same score of any apogee within a tenth."""
    flights = history(count)
    found = answer(flights)
    known = list(zip(flights.flights, flights.found, strict=True))
    (fitted,) = predict(known[:-1], known[-1:], draws=2000)
    for name, draws in (("top_speed", fitted.top_speed), ("coast_to_apogee", fitted.coast)):
        low, middle, high = np.percentile(draws, [5, 50, 95])
        assert abs(found.readouts[name][1] - middle) < 0.2 * (high - low)
    low, middle, high = np.percentile(fitted.apogee, [5, 50, 95])
    assert abs(found.apogee_at(0.5) - middle) < 0.2 * (high - low)
    for apogee in (low, middle, high):
        assert crps(found.apogees, float(apogee)) == pytest.approx(crps(fitted.apogee, float(apogee)), rel=0.35)


@pytest.mark.parametrize("count", [1, 3, 5])
def test_an_odd_flight_moves_the_answer_as_it_moves_the_fit(count: int) -> None:
    """The last flight reached three fifths of its apogee."""
    whole = history(count, recorded=("apogee",))
    odd = whole.flights[count - 1]
    flights = [*whole.flights[: count - 1], odd.with_changes(apogee=0.6 * (odd.apogee or 0.0)), whole.flights[-1]]
    (fitted,) = predict(
        list(zip(flights[:-1], whole.found, strict=False)), [(flights[-1], whole.found[-1])], draws=2000
    )
    low, middle, high = np.percentile(fitted.apogee, [5, 50, 95])
    ready = prepared(replace(whole, flights=tuple(flights)))
    found = answers(ready, ready.flown)[0]
    assert abs(found.apogee_at(0.5) - middle) < 0.1 * (high - low)
    assert width(found) == pytest.approx((high - low) / middle, rel=0.25)
    (usual,) = answers(ready, ready.flown, causes=False)
    assert abs(np.log(width(usual) / width(found))) > 0.3


OTHERS_FLEW_ONE = SharedPrior(
    (TermName("drag", "fleet"), TermName("thrust", "motor", "AeroTech F39T")),
    np.array([-0.55, 0.02]),
    np.array([[0.02, 1e-4], [1e-4, 1e-3]]),
)
"""Information from other rockets, which flew one of the motors that are new to this rocket."""


@pytest.mark.parametrize("shared", [None, OTHERS_FLEW_ONE])
def test_many_motors_at_once_are_answered_as_if_each_were_alone(shared: SharedPrior | None) -> None:
    """Motors that the rocket flew, others, and one twice."""
    whole = history(8)
    flown = list(zip(whole.flights[:-1], whole.found[:-1], strict=True))
    motors = [catalogue().resolve(name) for name in ("F24-4W", "F39-6T", "E35-5W", "E15-4W", "F39-6T")]
    plans = [(whole.flights[-1].with_changes(motor=found.motor.name), found) for found in motors]
    together = forecasts_at_once(flown, plans, shared=shared)
    for plan, estimate in zip(plans, together, strict=True):
        alone = forecast_at_once(flown, plan, shared=shared)
        assert estimate.apogees == pytest.approx(alone.apogees, rel=1e-6)
        assert [*estimate.log_cd, *estimate.log_alpha] == pytest.approx([*alone.log_cd, *alone.log_alpha], abs=1e-6)

"""A readout far from its expectation barely changes a forecast, and has a warning until the flyer confirms it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate, stats

from fieldkit.flight import CHECKED_TAG
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.outliers import FALSE_ALARMS, smallest_usual_weight
from fieldkit.model.hyperprior import START
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import base_model
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from tests.forecast.test_predict import PLAN, Flown, season

pytestmark = pytest.mark.fast

F39 = [(replace(PLAN, motor="F39"), catalogue().resolve("F39"))]


def with_a_slip(flown: Flown, row: int = 0, factor: float = 1.6) -> Flown:
    """The same with a top speed that is too high, though not impossible."""
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


def test_a_readout_that_the_flyer_confirmed_is_not_named() -> None:
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


@pytest.mark.parametrize("slip", [1.0, 1.8])
def test_the_evidence_of_a_fit_is_that_of_student_t_residuals(slip: float) -> None:
    motor = catalogue().resolve(PLAN.motor)
    flights = [PLAN.with_changes(apogee=200.0 * factor, sd={"apogee": 10.0}) for factor in (1.0, 1.03, 0.96, slip)]
    same = Scale((1.0,), 1.0, 0.5)
    hyperprior = replace(START, scatter=same, reading=same, sds={"apogee.rocket": 0.4, "drag.flight": 1e-6})
    whole = base_model(history_of(flights, [motor] * 4), hyperprior)
    model = whole.only([whole.names.index(TermName("apogee"))])
    data = observe(history_of(flights, [motor] * 4, used_in_fit=[True] * 4), hyperprior)
    center = np.log(shown(model, np.zeros((1, 1)), {})["apogee"][0])

    def density(bias: float) -> float:
        residual = stats.t.pdf((data.values[:, 0] - center - bias) / data.sd[:, 0], hyperprior.tail) / data.sd[:, 0]
        return float(stats.norm.pdf(bias, 0.0, 0.4) * residual.prod())

    middle = float(np.log(200.0) - center[0])
    exact = np.log(integrate.quad(density, middle - 1.0, middle + 1.0, points=[middle])[0])
    found = fit_robustly(model, data).log_evidence
    assert exact - 0.3 < found < exact

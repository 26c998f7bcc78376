"""A rocket has one diameter, even if it was recorded with only some of its flights."""

from collections.abc import Sequence

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import base_model
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.physics.setups import reference_area

MOTOR = catalogue().resolve("C6-5")
PLAN = Flight("next", "Law", "A", "C6-5", dry_mass=0.08, diameter=0.034)
WIDTHS = (0.034, None, 0.034, None)


def flights(widths: Sequence[float | None]) -> list[Flight]:
    """Flights of a rocket with these recorded diameters [m]."""
    return [PLAN.with_changes(flight_id=f"{i}", apogee=150.0 + 5 * i, diameter=width) for i, width in enumerate(widths)]


def forecast(widths: Sequence[float | None], plan: Flight) -> float:
    """The median forecast of a plan. [m]"""
    (prediction,) = predict([(one, MOTOR) for one in flights(widths)], [(plan, MOTOR)], draws=200)
    return float(np.median(prediction.apogee))


def test_a_diameter_missing_from_some_flights_changes_no_forecast() -> None:
    whole = forecast((0.034,) * 4, PLAN)
    assert forecast(WIDTHS, PLAN) == pytest.approx(whole)
    assert forecast(WIDTHS, PLAN.with_changes(diameter=None)) == pytest.approx(whole)


def test_a_diameter_given_only_in_the_plan_does_not_mean_another_rocket() -> None:
    bare = (None,) * 4
    assert forecast(bare, PLAN) == pytest.approx(forecast(bare, PLAN.with_changes(diameter=None)))


def test_a_missing_diameter_is_that_of_the_configuration() -> None:
    wide = [one.with_changes(config="wide", diameter=0.066) for one in flights((None, None))]
    known = [*flights(WIDTHS), *wide, PLAN.with_changes(config="wide", diameter=None)]
    area = reference_area(known, len(known) - 1)
    assert np.allclose(area, np.pi / 4 * np.array([0.034] * 4 + [0.066] * 3) ** 2)


def test_only_a_rocket_without_any_diameter_has_an_unknown_area() -> None:
    def drag_sd(widths: Sequence[float | None]) -> float:
        terms = base_model(history_of(flights(widths), [MOTOR] * 4), learned()).terms
        (drag,) = (term for term in terms if term.name == TermName("drag"))
        return drag.sd

    assert drag_sd(WIDTHS) == drag_sd((0.034,) * 4) < drag_sd((None,) * 4)


def test_each_plan_of_a_rocket_never_flown_has_its_own_diameter() -> None:
    plans = [PLAN, PLAN.with_changes(diameter=0.066), PLAN.with_changes(diameter=None)]
    area = reference_area(plans, 0)
    assert area[1] / area[0] == pytest.approx((0.066 / 0.034) ** 2)
    assert area[2] == pytest.approx(np.pi / 4 * (0.060 * 0.2**0.2) ** 2)


def test_the_drag_coefficient_of_a_design_does_not_measure_the_body() -> None:
    def width(plan: Flight) -> float:
        (prediction,) = predict([], [(plan, MOTOR)], Assumed(cds={"A": 0.6}), draws=1000)
        return float(np.std(np.log(prediction.cd)))

    assert width(PLAN.with_changes(diameter=None)) > 1.2 * width(PLAN)

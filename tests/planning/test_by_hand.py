"""Plans compared with calculations on paper: each figure behind a decision, computed in another way."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.inference.laplace.linearization import coast_times
from fieldkit.model.simulated_readouts import COARSE_RESOLUTION, shown
from fieldkit.motors import Catalogue, Found, catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.planning.contest import season
from fieldkit.planning.delay import delays
from fieldkit.planning.descent import durations
from fieldkit.planning.descent_rate import usual
from fieldkit.planning.forecasts import Plan, RocketData, fitted_forecast, forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import Wanted, guide, suitable_motors
from fieldkit.planning.quantiles import three
from fieldkit.planning.safety import thrust_to_weight
from fieldkit.units import FOOT, STANDARD_GRAVITY

pytestmark = pytest.mark.fast

NEW = RocketData((), ())
"""A rocket that has not flown."""
PLAN = Flight(rocket="Comet", dry_mass=0.45, diameter=0.066)


@pytest.fixture(scope="module")
def motors() -> Catalogue:
    return catalogue()


@pytest.fixture(scope="module")
def prediction(motors: Catalogue) -> Prediction:
    """A forecast of the plan with a delay."""
    return forecasts(NEW, [(PLAN.with_changes(delay=6.0), motors.resolve("F39T"))], draws=400)[0]


def test_rail_exit_speed_is_the_root_of_twice_length_times_acceleration(motors: Catalogue) -> None:
    even = replace(
        motors.resolve("F39T").motor,
        time=np.array([0.0, 1e-4, 2.0, 2.0001]),
        thrust=np.array([0.0, 30.0, 30.0, 0.0]),
        propellant_mass=1e-4,
        casing_mass=0.05,
    )
    flown = fly(field_setup([PLAN.with_changes(rail_length=1.83)], [Found(even, None)], np.array([1e-9])))
    acceleration = 30.0 / (0.45 + 0.0501) - STANDARD_GRAVITY
    assert flown.rail_speed[0] == pytest.approx(np.sqrt(2 * acceleration * 1.83), rel=1e-3)


def test_thrust_to_weight_is_the_average_thrust_in_the_name_over_the_weight(motors: Catalogue) -> None:
    motor = motors.resolve("F39T").motor
    _, average = thrust_to_weight(motor, 0.45)
    assert average == pytest.approx(39 / ((0.45 + motor.loaded_mass) * 9.81), rel=0.08)  # the name rounds the thrust


def test_the_coast_ends_when_gravity_and_little_drag_have_used_up_the_speed(prediction: Prediction) -> None:
    top, coast = three(prediction.top_speed)[1], three(prediction.coast)[1]
    assert 0.55 * top / STANDARD_GRAVITY < coast < top / STANDARD_GRAVITY


def test_the_charge_fires_at_delay_minus_coast_after_apogee_with_the_scatter_of_both(
    prediction: Prediction, motors: Catalogue
) -> None:
    judged = delays(Plan(NEW, PLAN, motors.resolve("F39T")), limit=15.0, takes_off=(3.0,), draws=400)
    low, middle, high = next(one for one in judged.delays if one.delay == 6.0).after_apogee
    coast = judged.coast
    assert middle == pytest.approx(6.0 - coast[1], abs=0.15)
    delay_sd = np.hypot(
        1.5 / 2, 0.08 * 6.0
    )  # the printed 1.5 s are two standard deviations, and each lot of motors has its own error
    sd = np.hypot((coast[2] - coast[0]) / 3.29, delay_sd)
    assert (high - low) / 3.29 == pytest.approx(sd, rel=0.2)


def test_a_charge_during_the_climb_is_early_by_the_rest_of_the_climb(motors: Catalogue) -> None:
    """Relative to the apogee without it, because the charge ends the climb soon after."""
    judged = delays(Plan(NEW, PLAN, motors.resolve("F39T-6")), limit=15.0, takes_off=(6.0,), draws=400)
    early = min(judged.delays, key=lambda one: one.delay)
    assert early.after_apogee[1] == pytest.approx(early.delay - judged.coast[1], abs=0.2)
    assert early.after_apogee[1] < -2


def test_descent_time_from_the_charge_on_is_height_over_speed(prediction: Prediction) -> None:
    speed = np.full((len(prediction.apogee), 1), 7.0)
    late = prediction.eject > 0
    under = durations([prediction], usual(), speed)[:, 0] - prediction.rise_time - prediction.eject
    assert np.median(7.0 * under[late] / prediction.true_apogee[late]) == pytest.approx(
        1.0, abs=0.06
    )  # it fell until then


def test_a_season_agrees_with_the_organizers_table() -> None:
    rows = {2027: (800, 37, 40), 2026: (750, 36, 39), 2025: (790, 41, 44), 2024: (820, 43, 46)}
    rows |= {2023: (850, 42, 45), 2022: (835, 41, 44), 2021: (800, 40, 43), 2020: (800, 40, 43)}
    for year, (feet, opens, closes) in rows.items():
        rule = season(year)
        assert (rule.target / FOOT, *rule.window) == pytest.approx((feet, opens, closes))
        assert (rule.per_metre * FOOT, rule.per_second, rule.best, rule.declared) == pytest.approx((1.0, 4.0, 2, 3))


# What makes the guide quick


@pytest.mark.parametrize(("wind", "lifted", "times"), [(0.0, 0.45, 1), (6.0, 0.7, 2)], ids=["still", "windy"])
def test_coarse_simulations_agree_with_fine_ones(motors: Catalogue, wind: float, lifted: float, times: float) -> None:
    every = suitable_motors(
        motors, Wanted(mount=0.029, adapter=True, dry_mass=lifted)
    )  # a rocket that barely lifts off is blown over
    planned = [PLAN] * len(every), [Found(motor, None) for motor in every], np.full((1, len(every)), 0.002)
    blown = {"wind": np.array([wind])}
    exact = fly(field_setup(*planned).with_changes(**blown))
    coarse = fly(field_setup(*planned, resolution=COARSE_RESOLUTION).with_changes(**blown))
    for name, off in (("apogee", 0.002), ("top_speed", 0.005), ("rail_speed", 0.02), ("coast_time", 0.002)):
        error = np.abs(getattr(coarse, name) / getattr(exact, name) - 1)[0]
        assert np.quantile(error, 0.95) < times * off
        assert error.max() < 0.05


def test_coast_times_agree_with_simulated_flights(motors: Catalogue) -> None:
    fitted = fitted_forecast(NEW, [(PLAN.with_changes(wind=4.0), motors.resolve(name)) for name in ("F39T", "E16W")], 4)
    model, at = replace(fitted.model, coarse=True), fitted.at
    assert coast_times(model, at) == pytest.approx(shown(model, at[None], {})["coast_time"][0], rel=1e-12)


def test_the_guide_agrees_with_a_forecast(prediction: Prediction, motors: Catalogue) -> None:
    motor = motors.resolve("F39T").motor
    (choice,) = guide(NEW, PLAN, [motor], limits(), Site(), draws=200)
    assert three(choice.prediction.apogee)[1] == pytest.approx(three(prediction.apogee)[1], rel=0.06)
    assert three(choice.prediction.rail_speed)[1] == pytest.approx(three(prediction.rail_speed)[1], rel=0.02)

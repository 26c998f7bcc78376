"""Forecasts trust the simulator and the device only as far as flights confirm them."""

from dataclasses import replace
from datetime import datetime

import numpy as np
import pytest
from scipy.stats import norm
from scipy.stats.qmc import Sobol

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.forecast.prediction import Prediction
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import FROM_LOGS, START, learned
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import base_model
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of
from fieldkit.physics.setups import USUAL_WIND
from fieldkit.selection.candidates import EACH_GROUP, Place
from tests import seasons

CHECK_SHAPES = False

MOTORS = ("F24", "F39", "E35")
PLAN = Flight("plan", "Test", "A", "F24", dry_mass=0.322, diameter=0.066, delay=10.0)
Flown = list[tuple[Flight, Found]]


def season(off: dict[str, float], count: int = 3) -> Flown:
    """Simulated flights at the model's prior mean, with readouts multiplied by `off`: by readout, or for the apogee by
    motor."""
    plans = [replace(PLAN, flight_id=str(i), motor=motor) for i, motor in enumerate(MOTORS * count)]
    found = [catalogue().resolve(plan.motor) for plan in plans]
    model = base_model(history_of(plans, found))
    readings = shown(model, np.array([[term.mean for term in model.terms]]), {})
    rng = np.random.default_rng(4)
    flown = []
    for row, plan in enumerate(plans):
        values = {
            name: float(readings[name][0, row] * off.get(name, 1.0) * np.exp(0.01 * rng.normal()))
            for name in OBSERVED_READOUTS
        }
        values["apogee"] *= off.get(plan.motor, 1.0)
        flown.append((plan.with_changes(**values), found[row]))
    return flown


def next_on(motor: str, flown: Flown) -> Prediction:
    (forecast,) = predict(flown, [(replace(PLAN, motor=motor), catalogue().resolve(motor))])
    return forecast


def mean_apogee(motor: str, flown: Flown) -> float:
    return float(np.mean([flight.apogee for flight, _ in flown if flight.motor == motor and flight.apogee]))


def test_a_motor_on_which_the_simulator_is_wrong_is_forecast_from_its_own_flights() -> None:
    flown = [(PLAN.with_changes(motor=one.motor, apogee=one.apogee), found) for one, found in season({"F24": 1.25})]
    for motor in MOTORS:
        assert np.median(next_on(motor, flown).apogee) == pytest.approx(mean_apogee(motor, flown), rel=0.05)


def test_the_error_is_attributed_to_the_simulator_and_not_to_the_altimeter() -> None:
    """In standard air an altimeter shows the truth, also on the motor with a wrong simulation."""
    forecast = next_on("F24", season({"F24": 1.25}))
    assert np.median(forecast.true_apogee) == pytest.approx(np.median(forecast.apogee), rel=0.01)


def test_a_rocket_that_never_flew_is_forecast_from_its_priors() -> None:
    low, middle, high = next_on("F24", []).apogee_quantiles()
    assert 0 < 1.3 * low < middle < high / 1.3


def test_a_new_motor_is_less_certain_if_motors_disagree() -> None:
    def width(motor: str, flown: Flown) -> float:
        low, _, high = next_on(motor, flown).apogee_quantiles()
        return float(np.log(high / low))

    same_motors, different_motors = season({}), season({"F24": 1.25, "E35": 0.85})
    assert width("F52", different_motors) > 1.05 * width("F39", different_motors)
    assert width("F52", different_motors) > 1.25 * width("F52", same_motors)


def test_a_device_that_misreads_speed_and_coast_does_not_bias_apogees() -> None:
    flown = season({"top_speed": 0.8, "coast_to_apogee": 1.1, "peak_accel": 0.6})
    for motor in MOTORS:
        assert np.median(next_on(motor, flown).apogee) == pytest.approx(mean_apogee(motor, flown), rel=0.04)


def test_the_forecast_spread_scales_with_the_noise_of_rocket_and_device() -> None:
    found = [catalogue().resolve("F24")]
    certain, doubtful = (
        base_model(history_of([PLAN], found), CERTIFIED_PRIOR),
        base_model(history_of([PLAN], found), learned()),
    )
    assert {term.scaled_by for term in certain.terms} == {""}
    assert {str(term.bends) for term in doubtful.terms if term.scaled_by == "reading"} == set(OBSERVED_READOUTS) - {
        "apogee",
        *FROM_LOGS,
    }
    assert [term.name for term in doubtful.terms if term.scaled_by == "scatter"] == [
        TermName("apogee", "rocket_motor", "AeroTech F24W")
    ]


def test_steady_speeds_and_burn_times_do_not_narrow_the_interval_of_apogees_that_scatter() -> None:
    """They do if one scale stands for the scatter of motors and of apogees: most readouts depend on the motor."""
    own, rng = 0.08, np.random.default_rng(8)
    flown = [
        (flight.with_changes(apogee=(flight.apogee or 0) * np.exp(own * rng.normal())), found)
        for flight, found in season({}, 5)
    ]

    def sd(motors: Scale | None) -> float:
        plan = (PLAN, catalogue().resolve("F24"))
        (forecast,) = predict(flown, [plan], Assumed(hyperprior=replace(learned(), motors=motors)))
        low, _, high = forecast.apogee_quantiles()
        return float(np.log(high / low)) / float(norm.ppf(0.95) - norm.ppf(0.05))

    assert sd(None) < 0.9 * own < own < sd(START.motors) < 2 * own


ALTERNATIVES = (
    {"motor": "G40W"},
    {"config": "B", "dry_mass": 0.448},
    {"wind": 5.0},
    {"diameter": None, "dry_mass": 0.9},
    {"motor": "E35", "site": "another field"},
)
"""Differences of the other plans, each of which adds terms to the model."""


@pytest.mark.parametrize(("past", "diameter"), [(0, 0.066), (3, None), (5, 0.066)])
def test_the_forecast_of_a_plan_does_not_depend_on_other_plans(past: int, diameter: float | None) -> None:
    flown = [(one.with_changes(diameter=diameter), motor) for one, motor in season({})]
    flown = flown[:past] if past != 3 else [pair for pair in flown if pair[0].motor == "F24"]  # or a single motor
    plan = PLAN.with_changes(diameter=diameter)
    plans = [plan, *(plan.with_changes(**other) for other in ALTERNATIVES)]
    planned = [(one, catalogue().resolve(one.motor)) for one in plans]
    (alone,), (*_, beside) = predict(flown, planned[:1], draws=30), predict(flown, planned[::-1], draws=30)
    assert beside.apogee == pytest.approx(alone.apogee, rel=1e-9)
    assert beside.cd == pytest.approx(alone.cd, rel=1e-9)


def test_a_new_configuration_without_a_design_is_forecast_as_if_alone() -> None:
    flown, motor = season({}, 2), catalogue().resolve("F24")
    new, designed = ((PLAN.with_changes(config=config), motor) for config in ("B", "C"))
    cds = {"A": 0.5, "C": 0.9}
    (alone,), (beside, _) = (predict(flown, plans, Assumed(cds=cds), draws=30) for plans in ([new], [new, designed]))
    assert beside.cd == pytest.approx(alone.cd, rel=1e-9)


def test_a_plan_without_a_date_is_forecast_as_if_alone() -> None:
    flown = [
        (one.with_changes(date_time=datetime(2026, 5, 1 + row // 2)), motor)
        for row, (one, motor) in enumerate(season({}, 3))
    ]
    averaged = ((0.5, (Place("weather", EACH_GROUP),)), (0.5, ()))
    plan = (PLAN, catalogue().resolve("F24"))
    dated = (PLAN.with_changes(date_time=datetime(2026, 6, 1)), plan[1])
    (alone,), (beside, _) = (predict(flown, plans, Assumed(averaged), draws=30) for plans in ([plan], [plan, dated]))
    assert beside.apogee == pytest.approx(alone.apogee, rel=1e-9)


@pytest.mark.parametrize("place", [Place("mass_offset"), Place("wear"), Place("mass_offset", "", "4")])
def test_a_plan_without_a_name_is_forecast_like_one_with_a_name(place: Place) -> None:
    flown, motor = season({}), catalogue().resolve("F24")
    (named,), (unnamed,) = (
        predict(flown, [(PLAN.with_changes(flight_id=name), motor)], Assumed(((1.0, (place,)),)), draws=100)
        for name in ("plan", "")
    )
    np.testing.assert_array_equal(unnamed.apogee, named.apogee)


def made(known: float, scatter: float, draws: int = 4096) -> Prediction:
    """A forecast with given amounts of reducible and irreducible variance of its logarithm."""
    (forecast,) = predict([], [(PLAN, catalogue().resolve("F24"))], draws=draws)
    normals = norm.ppf(Sobol(2, rng=np.random.default_rng(8)).random(draws))
    common, chance = (
        np.linalg.qr(normals - normals.mean(axis=0))[0] * np.sqrt(draws)
    ).T  # uncorrelated to the last digit
    return replace(forecast, apogee=250 * np.exp(known * common + scatter * chance), random_draws=(chance,))


@pytest.mark.parametrize("more", [0, 1, 4, 20, np.inf])
def test_an_interval_narrows_as_a_normal_mean_becomes_known(more: float) -> None:
    known, scatter = 0.08, 0.05
    left = 1 / (1 / known**2 + more / scatter**2)
    exact = np.sqrt((left + scatter**2) / (known**2 + scatter**2))
    assert made(known, scatter).narrowed(more) == pytest.approx(exact, abs=5e-3)


def test_random_variance_never_narrows_and_without_it_the_interval_vanishes() -> None:
    assert made(0.0, 0.05).narrowed(np.inf) == pytest.approx(1.0, abs=1e-6)
    assert made(0.05, 0.0).narrowed(1) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.thorough
def test_the_interval_narrows_as_announced_once_the_flights_are_flown() -> None:
    """The mean over some seasons, because the scatter is estimated from the flights too."""
    forecast, became = [], []
    for seed in range(16):
        flown = seasons.season(np.random.default_rng(seed), ("apogee",), 9, scatter=learned().sd("apogee", "flight"))
        before, after = next_on("F24", flown[:6]), next_on("F24", flown)
        forecast.append(before.narrowed(1))
        became.append(np.ptp(np.log(after.apogee_quantiles())) / np.ptp(np.log(before.apogee_quantiles())))
    assert np.mean(became) == pytest.approx(np.mean(forecast), abs=0.12)


def test_more_flights_never_widen_an_interval_and_a_new_motor_gains_most() -> None:
    flown = [(flight, found) for flight, found in season({}) if flight.motor != "E35"]
    new, known = next_on("E35", flown), next_on("F24", flown)
    steps = [new.narrowed(more) for more in (0, 1, 2, 5, np.inf)]
    assert steps[0] == pytest.approx(1.0)
    assert steps == sorted(steps, reverse=True)
    assert new.narrowed(1) < known.narrowed(1) - 0.1


def test_flights_without_a_recorded_wind_are_assumed_to_have_the_usual_wind() -> None:
    flown = season({})
    at = {
        wind: float(np.median(predict(flown, [(PLAN.with_changes(wind=wind), flown[0][1])])[0].apogee))
        for wind in (0.0, USUAL_WIND, 8.0)
    }
    assert at[USUAL_WIND] == pytest.approx(mean_apogee("F24", flown), rel=0.015)
    assert at[0.0] > 1.002 * at[USUAL_WIND] > 1.01 * at[8.0]

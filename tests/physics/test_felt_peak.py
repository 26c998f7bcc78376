"""The peak acceleration that an accelerometer shows: a mean over a while, in which an igniter's spike counts little."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.hyperprior import START
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.physics.logged import felt_peak, highest_mean
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array

pytestmark = pytest.mark.fast


@dataclass
class Curve:
    """A thrust curve."""

    time: Array
    thrust: Array
    burnout: float = 1.0
    propellant_mass: float = 0.1
    casing_mass: float = 0.1
    spent: None = field(default=None)


def curve(*knots: tuple[float, float]) -> Curve:
    time, thrust = np.array(knots).T
    return Curve(time, thrust)


def test_the_highest_mean_of_thrust_is_exact() -> None:
    assert highest_mean(curve((0.0, 50.0), (1.0, 50.0))) == pytest.approx(1.0)
    triangle = curve((0.0, 0.0), (0.02, 100.0), (0.04, 0.0), (1.0, 0.0))
    assert highest_mean(triangle, 0.08) == pytest.approx(0.5 * 100 * 0.04 / 0.08 / 100)
    assert highest_mean(triangle, 0.02) == pytest.approx(0.75, rel=1e-3)  # half of the window on either side
    step = curve((0.0, 100.0), (0.01, 100.0), (0.01, 40.0), (1.0, 40.0))
    assert highest_mean(step, 0.05) == pytest.approx((0.01 * 100 + 0.04 * 40) / 0.05 / 100, rel=1e-3)
    assert highest_mean(step, 5.0) == pytest.approx((0.01 * 100 + 0.99 * 40) / 100, rel=1e-3)


@pytest.mark.parametrize("name", ["C6", "F24-4W", "G40-7W", "I200W"])
def test_the_highest_mean_is_that_of_a_finely_sampled_curve(name: str) -> None:
    motor = catalogue().resolve(name).motor
    time = np.arange(0.0, motor.time[-1], 1e-4)
    thrust = np.interp(time, motor.time, motor.thrust)
    best = np.convolve(thrust, np.full(500, 1 / 500), "valid").max()
    assert highest_mean(motor) == pytest.approx(best / np.max(motor.thrust), rel=0.01)


def test_gravity_is_subtracted_after_the_mean() -> None:
    mass, motor = 2.0, curve((0.0, 0.0), (0.02, 100.0), (0.04, 0.0), (1.0, 0.0))
    peak = 100.0 / mass - GRAVITY
    assert felt_peak(np.array([[peak]]), np.array([0.25]))[0, 0] == pytest.approx(25.0 / mass - GRAVITY)
    assert highest_mean(motor, 0.08) == pytest.approx(0.25)


def test_a_model_expects_of_an_accelerometer_the_mean_and_of_a_display_the_curve() -> None:
    typed = Flight("1", "Law", "A", "G40-7W", dry_mass=0.6, diameter=0.066, peak_accel=100.0)
    logged = typed.with_changes(flight_id="2", source={"peak_accel": "accel"})
    found = catalogue().resolve("G40-7W")
    model = base_model(history_of([typed, logged], [found, found]), START)
    at = np.array([[term.mean for term in model.terms]])
    typed_peak, logged_peak = shown(model, at, {})["peak_accel"][0]
    part = highest_mean(found.motor)
    assert 0.7 < part < 0.9
    assert logged_peak == pytest.approx((typed_peak + GRAVITY) * part - GRAVITY, rel=1e-6)

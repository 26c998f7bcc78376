"""What heights show of a slanted path: its upward part, and drag and impulse that look like others."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.hyperprior import START
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup, history_of
from fieldkit.physics.logged import climbed_drag, climbed_impulse, climbed_peak
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.physics.state import FlightResult

pytestmark = pytest.mark.fast

PLAN = Flight("1", "Law", "A", "F24-4W", dry_mass=0.322, diameter=0.066, delay=8.0)
LOGGED = ("top_speed", "peak_accel", "coast_drag", "burn_impulse")


def flown(degrees: float) -> FlightResult:
    setup = field_setup([PLAN], [catalogue().resolve(PLAN.motor)], np.array([0.002]))
    return fly(setup.with_changes(rail_angle=np.radians([degrees])))


def test_heights_show_all_of_a_vertical_path() -> None:
    straight = flown(0.0)
    assert straight.top_climb == pytest.approx(straight.top_speed)
    assert climbed_drag(straight, np.array([2e-3])) == pytest.approx(2e-3)
    assert climbed_impulse(straight, np.array([80.0])) == pytest.approx(80.0)
    assert climbed_peak(straight) == pytest.approx(straight.peak_accel)


def test_a_slanted_path_climbs_by_the_cosine_of_its_angle_or_less() -> None:
    slanted = flown(30.0)
    assert 0.75 < slanted.top_climb[0] / slanted.top_speed[0] < np.cos(np.radians(30.0))


@pytest.mark.parametrize("drag", [5e-4, 2e-3])
def test_drag_by_heights_is_that_of_the_upward_motion_of_a_slanted_coast(drag: float) -> None:
    speed, angle, step = 60.0, np.radians(30.0), 1e-3
    up, across, fell, squares = speed * np.cos(angle), speed * np.sin(angle), 0.0, 0.0
    start = up
    while up > 0.15 * start:
        rate = -GRAVITY - drag * np.hypot(up, across) * up
        fell, squares = fell + up**2 * (-GRAVITY - rate), squares + up**4  # least squares of b up²
        up, across = up + rate * step, across - drag * np.hypot(up, across) * across * step
    path = replace(flown(0.0), top_speed=np.array([speed]), top_climb=np.array([start]))
    assert climbed_drag(path, np.array([drag]))[0] == pytest.approx(fell / squares, rel=0.05)


def test_a_model_expects_of_heights_what_they_show_of_an_arc() -> None:
    from_heights = PLAN.with_changes(
        **dict.fromkeys(LOGGED, 1.0), apogee=200.0, source=dict.fromkeys((*LOGGED, "apogee"), "baro")
    )
    typed = from_heights.with_changes(source=dict.fromkeys((*LOGGED, "apogee"), "accel"))
    motor = catalogue().resolve(PLAN.motor)
    model = base_model(history_of([from_heights, typed], [motor] * 2), START)
    at = np.tile([term.mean for term in model.terms], (2, 1))
    arc = {"tilt": np.array([[0.0, 0.0], [49.0, 49.0]])}  # 35 degrees
    found = shown(model, at, arc)
    change = {name: np.log(found[name][1] / found[name][0]) for name in LOGGED}
    assert {name: abs(float(change[name][1])) < 0.04 for name in LOGGED} == dict.fromkeys(LOGGED, True)
    assert change["top_speed"][0] < np.log(np.cos(np.radians(35.0))) + 0.02
    assert change["burn_impulse"][0] < -0.1
    assert change["peak_accel"][0] < -0.2
    assert change["coast_drag"][0] > 0.2

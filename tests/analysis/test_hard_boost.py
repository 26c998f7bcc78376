"""Lift-off of hard boosts with biased static ports."""

import numpy as np
import pytest

from bench.recorders.flights import draw, sampled
from fieldkit.analysis import measure
from fieldkit.analysis.ballistic import coast
from fieldkit.analysis.hard_boost import BOOST_SHAPE, BOOST_SHAPE_SD, BURN_SPREAD, BURN_TIME, hidden_lead
from fieldkit.analysis.notes import ENDS_IN_BOOST
from fieldkit.flight import Series
from fieldkit.motors import catalogue
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array

LIFT, BURN = 5.0, 1.6


def heights(static: float, burn: float = BURN, apogee: float = 22.0, top: float = 2700.0) -> tuple[Array, Array]:
    """Times [s] and heights [m] of a boost at constant thrust and its coast, measured through biased ports."""
    drag = 6e-4
    free = coast(apogee, top, drag, 0.0, apogee)
    time = np.arange(0, 60, 0.05)
    burnout = float(free.time[np.argmin(np.abs(free.height - free.speed * burn / 2))])
    height, speed = (float(np.interp(burnout, free.time, one)) for one in (free.height, free.speed))
    shift = LIFT + burn - burnout
    since = np.clip(time - LIFT, 0, burn)
    boost = time < LIFT + burn
    way = np.where(boost, height * (since / burn) ** 2, np.interp(time, free.time + shift, free.height))
    fast = np.where(boost, speed * since / burn, np.interp(time, free.time + shift, free.speed))
    late = time > apogee + shift
    way = np.where(late, np.maximum(top - 20 * (time - apogee - shift), 0), way)
    fast = np.where(late, 0.0, fast)
    noise = np.random.default_rng(1).normal(0, 0.4, time.size)
    return time, way - static * fast**2 / (2 * GRAVITY) + noise


@pytest.mark.sampled
@pytest.mark.parametrize("static", [-0.03, 0.0, 0.02, 0.036])
def test_the_true_lift_off_is_within_two_stated_standard_deviations(static: float) -> None:
    time, height = heights(static)
    lift = measure([Series(time, altitude=height)]).events["liftoff"]
    assert abs(lift.time - LIFT) < 2 * lift.sd


def test_a_lift_off_hidden_by_port_errors_has_a_large_standard_deviation() -> None:
    clear, hidden = (measure([Series(time, altitude=height)]) for time, height in map(heights, (0.0, 0.033)))
    assert clear.events["liftoff"].sd < 0.15
    assert hidden.events["liftoff"].time > LIFT + 0.3
    assert hidden.events["liftoff"].sd > 0.3


@pytest.mark.parametrize("static", [0.055, 0.065])
def test_a_lift_off_hidden_in_a_subsonic_boost_is_found_by_the_whole_climb(static: float) -> None:
    """At 14 g such ports keep the heights on the pad's level for most of the boost: the first rise is 0.4 s late."""
    time, height = heights(static, 0.7, 7.5, 300.0)
    lift = measure([Series(time, altitude=height)]).events["liftoff"]
    assert abs(lift.time - LIFT) < 2 * lift.sd < 0.3


def test_a_boost_that_ports_show_as_a_dive_begins_with_the_dive() -> None:
    """At 28 g heights fall below the pad until burnout and then jump."""
    time, height = heights(0.06)
    assert height.min() < -5
    assert measure([Series(time, altitude=height)]).events["liftoff"].time == pytest.approx(LIFT, abs=0.3)


def test_the_shape_of_a_boost_agrees_with_the_catalog() -> None:
    """Height at burnout, relative to speed times burn time, is the mean time from impulse to burnout."""
    part, motors = np.linspace(0, 1, 401), catalogue().motors
    classes = [motor.impulse_class for motor in motors]
    weight = np.array([1 / classes.count(one) for one in classes])
    shapes = []
    for motor in motors:
        thrust = np.interp(part * motor.burnout, motor.time, motor.thrust, left=0.0, right=0.0)
        shapes.append(np.trapezoid(thrust * (1 - part), part) / np.trapezoid(thrust, part))
    mean = np.average(shapes, weights=weight)
    assert mean == pytest.approx(BOOST_SHAPE, abs=0.01)
    assert np.sqrt(np.average((np.array(shapes) - mean) ** 2, weights=weight)) == pytest.approx(
        BOOST_SHAPE_SD, abs=0.01
    )


def test_measured_burn_times_agree_with_the_catalog() -> None:
    motors = catalogue().motors
    classes = [motor.impulse_class for motor in motors]
    weight = np.array([1 / classes.count(one) for one in classes])
    logs = np.log([float(motor.burnout) for motor in motors])
    mean = np.average(logs, weights=weight)
    assert mean == pytest.approx(np.log(BURN_TIME), abs=0.03)
    assert np.sqrt(np.average((logs - mean) ** 2, weights=weight)) == pytest.approx(BURN_SPREAD, abs=0.03)


def test_port_errors_do_not_hide_an_ordinary_boost() -> None:
    usual = [hidden_lead(100.0, burn, 0.4, 0.04) / burn for burn in (3.0, 1.5, 1.0)]
    hard = [hidden_lead(300.0, burn, 0.4, 0.04) / burn for burn in (1.0, 0.6, 0.3)]
    assert max(usual) < 0.02
    assert [*usual, *hard] == sorted([*usual, *hard])
    assert hard[-1] > 0.5


def test_an_accelerometer_log_that_ends_during_the_boost_gives_no_burnout() -> None:
    time, height = heights(0.0)
    clock = np.arange(0, LIFT + BURN / 2, 0.01)
    felt = np.where(clock < LIFT, GRAVITY, 26 * GRAVITY) + np.random.default_rng(2).normal(0, 0.5, clock.size)
    recorded = measure([Series(time, altitude=height), Series(clock, felt=felt)])
    assert ENDS_IN_BOOST in recorded.notes
    assert abs(recorded.events["burnout"].time - LIFT - BURN) < 2 * recorded.events["burnout"].sd


@pytest.mark.sampled
@pytest.mark.parametrize("end", [7.4, 8.0, 9.0, 12.0])
def test_a_log_that_ends_during_the_coast_gives_no_speed_that_contradicts_its_heights(end: float) -> None:
    time, height = heights(0.0)
    whole = measure([Series(time, altitude=height)]).figures["top_speed"]
    cut = measure([Series(time[time < end], altitude=height[time < end])]).figures.get("top_speed")
    assert cut is None or abs(cut.value - whole.value) < 2 * np.hypot(cut.sd, whole.sd)


@pytest.mark.sampled
@pytest.mark.parametrize("static", [-0.06, 0.06])
def test_the_top_speed_of_a_hard_boost_has_the_error_of_the_ports(static: float) -> None:
    """By the curve through the heights alone it was four standard deviations off at 17 g."""
    path = draw(np.random.default_rng(9301), 7)[6]
    time = np.arange(-3.0, path.landing + 5.0, 0.05)
    height, speed = (sampled(path, time, values, 0.0) for values in (path.height, path.speed))
    noise = np.random.default_rng(6).normal(0, 0.4, time.size)
    shown = height - static * speed * np.abs(speed) / (2 * GRAVITY) + noise
    found, true = measure([Series(time, altitude=shown)]).figures["top_speed"], path.readouts()["top_speed"]
    assert abs(found.value - true) < 2 * found.sd < 0.6 * true

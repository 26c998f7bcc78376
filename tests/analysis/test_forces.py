"""Thrust and drag from an accelerometer: at the ends of its log, and with an offset."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.burnout import Burnout
from fieldkit.analysis.channels import Push
from fieldkit.analysis.flight_parts import _doubted
from fieldkit.analysis.forces import FADE, FADE_SD, boost_event, forces
from fieldkit.analysis.records import Figure, MeasuredClimb
from fieldkit.analysis.samples import Marks
from fieldkit.motors import catalogue
from fieldkit.physics.standard_atmosphere import GRAVITY, standard_density

pytestmark = pytest.mark.fast


def test_drag_is_complete_up_to_the_last_accelerometer_sample() -> None:
    time = np.arange(0, 5, 0.02)
    one = np.ones(time.size)
    climb = MeasuredClimb(time, 500 * one, 100 * one, one, -30 * one, one, time < 0, "acceleration")
    ticks = np.arange(0, 4.8, 0.01)
    found = forces(climb, Push(ticks, np.full(ticks.size, -20.0), False, "acceleration"), 200.0, np.inf)
    assert found is not None
    assert found.window
    assert found.push == pytest.approx(-20.0)
    density = standard_density(np.array([700.0]))[0]
    assert found.drag_area == pytest.approx(20 / (density * 100**2 / 2))


@pytest.mark.parametrize("zero", [-1.0, 0.0, 1.0])
def test_an_offset_seen_on_the_pad_is_not_drag(zero: float) -> None:
    time = np.arange(0, 5, 0.02)
    one = np.ones(time.size)
    climb = MeasuredClimb(time, 500 * one, 100 * one, one, -30 * one, one, time < 0, "acceleration")
    ticks = np.arange(-5, 6, 0.01)
    felt = np.where(ticks < -0.06, GRAVITY, -20.0) + zero
    found = forces(climb, Push(ticks, felt, False, "acceleration", weighs=True), 200.0, np.inf)
    assert found is not None
    assert found.push == pytest.approx(-20.0)


def test_burnout_from_pressure_is_less_certain_if_thrust_fades() -> None:
    """Heights that are low by k v²/2g show v (1 - k a/g), so the crossing of a slow fade moves by up to k v/g."""
    time = np.arange(0, 6, 0.02)
    sudden = np.where(time < 1, 150.0, -40.0)
    fading = np.clip(300 - 300 * time, -40.0, None)
    sds = []
    for net in (sudden, fading):
        speed = np.cumsum(net) * 0.02
        height = np.cumsum(speed) * 0.02
        draws = (np.tile(one, (2, 1)) for one in (height, speed, net))
        ascent = Ascent(time, height, speed, net, *draws, noise=0.4, burnout_sd=0.05, fused=False)
        found = boost_event(ascent, None, 0.0, 5.9, "barometric altitude")
        assert found is not None
        sds.append(found[0].sd)
    level = 40 / (150 + GRAVITY + (40 - GRAVITY) / 3)  # of the thrust at which the speed is highest
    fades = 2 * np.array([FADE_SD * (level - 0.25), np.hypot(FADE, FADE_SD) / np.sqrt(48)])
    assert sds[0] == pytest.approx(np.linalg.norm([0.05, 0.05, *fades]), rel=0.1)
    assert sds[1] > 2 * sds[0]


def test_burnout_by_an_accelerometer_is_as_certain_as_its_noise_allows_for_thrust_that_fades() -> None:
    """Integrated noise moves the maximum of a speed by about its own scatter over many flights."""
    ticks, random = np.arange(-2, 6, 0.01), np.random.default_rng(4)
    net = np.where(ticks < 0, 0.0, np.clip(60 - 40 * ticks, -20.0, None))
    felt = net + GRAVITY + random.normal(0, 4.0, (300, ticks.size))
    near = (ticks > 1.0) & (ticks < 2.0)
    tops = ticks[near][np.argmax(np.cumsum(felt[:, near] - GRAVITY, axis=1), axis=1)]
    time = np.arange(0, 6, 0.02)
    smooth = np.clip(60 - 40 * time, -20.0, None)
    speed = np.cumsum(smooth) * 0.02
    draws = (np.tile(one, (2, 1)) for one in (np.cumsum(speed) * 0.02, speed, smooth))
    ascent = Ascent(time, np.cumsum(speed) * 0.02, speed, smooth, *draws, noise=0.4, burnout_sd=0.0, fused=True)
    found = boost_event(ascent, Push(ticks, felt[0], False, "acceleration", weighs=True), 0.0, 5.9, "acceleration")
    assert found is not None
    assert 0.7 * tops.std() < found[0].sd < 1.5 * tops.std()
    quiet = Push(ticks, net + GRAVITY, False, "acceleration", weighs=True)
    exact = boost_event(ascent, quiet, 0.0, 5.9, "acceleration")
    assert exact is not None
    assert exact[0].sd < 0.03


def test_a_speed_by_widely_spaced_accelerations_allows_for_what_happened_between_them() -> None:
    """The trapezoidal rule on samples of a sudden thrust, at any offset of the samples from ignition."""
    time = np.arange(0, 6, 0.02)
    net = np.where(time < 1, 100.0, -20.0)
    speed = np.cumsum(net) * 0.02
    draws = (np.tile(one, (2, 1)) for one in (np.cumsum(speed) * 0.02, speed, net))
    ascent = Ascent(time, np.cumsum(speed) * 0.02, speed, net, *draws, noise=0.4, burnout_sd=0.0, fused=True)
    sums, sds = [], []
    for offset in np.arange(0, 0.16, 0.01):
        ticks = np.arange(-1 + offset, 5, 0.16)
        felt = np.where(ticks < 0, 0.0, np.where(ticks < 1, 100.0, -20.0)) + GRAVITY
        boost = ticks < 1.2
        sums.append(float(np.trapezoid(np.maximum(felt[boost] - GRAVITY, 0), ticks[boost])))
        found = boost_event(ascent, Push(ticks, felt, False, "acceleration", weighs=True), 0.0, 5.9, "acceleration")
        assert found is not None
        sds.append(found[1].sd)
    assert min(sds) > 0.7 * np.std(sums)
    assert max(sds) < 3 * np.std(sums)


@pytest.mark.parametrize(("true", "least"), [(60.0, 0.0), (75.0, 50.0)])
def test_a_top_speed_far_from_that_of_an_uncompared_accelerometer_is_uncertain(true: float, least: float) -> None:
    """Of 282 +- 6 m/s in a log of a TeleMetrum near Mach 1, its accelerometer alone gave 318."""
    time = np.arange(-3.0, 10.0, 0.01)
    felt = GRAVITY + np.where((time > 0) & (time < 5), true, 0.0)
    speed = _doubted(Figure(300.0, 6.0, ""), Push(time, felt, False, ""), 0.0, 5.0)
    assert speed.value == 300.0
    assert max(least, 6.0) <= speed.sd < max(1.6 * least, 7.0)


def test_the_fading_of_thrust_agrees_with_the_catalog() -> None:
    levels, step = np.array([0.3, 0.4, 0.5, 0.6]), 0.005
    rows, classes = [], []
    for motor in catalogue().motors:
        thrust = np.interp(np.arange(0.0, motor.burnout, step), motor.time, motor.thrust)
        left = np.cumsum(thrust[::-1])[::-1] / thrust.sum()
        last = [np.flatnonzero(thrust >= level * thrust.mean())[-1] for level in levels]
        rows.append((np.append(left, 0.0)[np.array(last) + 1] / levels**2).mean())
        classes.append(motor.impulse_class)
    weight = 1 / np.array([classes.count(one) for one in classes])
    mean = np.average(rows, weights=weight)
    assert mean == pytest.approx(FADE, abs=0.01)
    assert np.sqrt(np.average((rows - mean) ** 2, weights=weight)) == pytest.approx(FADE_SD, abs=0.02)


@pytest.mark.parametrize("drag", [0.002, 0.004, 0.006])
def test_a_coast_extrapolated_to_burnout_is_corrected_for_thrust_that_fades(drag: float) -> None:
    """The curve ends with the motor, or in the middle of its fade; top speed is evenly between what both show."""
    step, fades, ends = 0.002, 2 * FADE, 1.0
    time = np.arange(0, 4, step)
    speed = np.zeros(time.size)
    for place, thrust in enumerate(200.0 * np.clip((ends + fades / 2 - time[:-1]) / fades, 0, 1)):
        speed[place + 1] = speed[place] + step * (thrust - GRAVITY - drag * speed[place] ** 2)
    right, top = float(speed.max()), int(np.argmax(speed))
    curve = speed.copy()
    for place in range(round((ends + fades) / step), 0, -1):
        curve[place - 1] = curve[place] + step * (GRAVITY + drag * curve[place] ** 2)
    found = []
    for end in (top, round((ends + fades / 2) / step), round(ends / step)):
        shown = np.where(time < time[end], curve[end] * time / time[end], curve)
        net, height = np.gradient(shown, step), np.cumsum(shown) * step
        draws = (np.tile(one, (2, 1)) for one in (height, shown, net))
        ascent = Ascent(time, height, shown, net, *draws, noise=0.4, burnout_sd=0.0, fused=False)
        one = boost_event(ascent, None, 0.0, 3.0, "barometric altitude")
        assert one is not None
        found.append(one)
    assert found[0][1].value == pytest.approx(right, abs=0.25 * (curve[top] - right))
    late, early = (one[0] for one in found[1:])
    assert early.time < time[top] < late.time
    assert (early.time + late.time) / 2 == pytest.approx(time[top], abs=0.02)
    assert late.time - time[top] < 2 * late.sd


def test_the_end_of_thrust_between_two_samples_of_an_accelerometer_is_known_better_than_the_curve() -> None:
    """The knots of a curve through few heights are far apart, the samples of the accelerometer are not."""
    time, ticks = np.arange(0, 6, 0.1), np.arange(-2, 6, 0.01)
    net, felt = (np.where(one < 1.004, 100.0, -20.0) for one in (time, ticks))
    felt = np.where(ticks < 0, 0.0, felt) + GRAVITY
    speed = np.cumsum(net) * 0.1
    draws = (np.tile(one, (2, 1)) for one in (np.cumsum(speed) * 0.1, speed, net))
    ascent = Ascent(time, np.cumsum(speed) * 0.1, speed, net, *draws, noise=0.4, burnout_sd=0.0, fused=True)
    found = boost_event(ascent, Push(ticks, felt, False, "acceleration", weighs=True), 0.0, 5.9, "acceleration")
    assert found is not None
    assert found[0].time == pytest.approx(1.004, abs=0.005)
    assert found[0].sd == pytest.approx(0.01 / np.sqrt(12), rel=0.01)


@pytest.mark.parametrize(
    ("moment", "speed_then", "ports", "counts"),
    [(1.1, 90.0, 0.5, True), (2.4, 90.0, 0.5, False), (1.1, 90.0, 3.5, False), (1.1, 60.0, 0.5, False)],
)
def test_the_speed_at_a_burnout_counts_only_if_the_curve_is_fastest_there_and_the_climb_is_possible_with_it(
    moment: float, speed_then: float, ports: float, counts: bool
) -> None:
    """Where samples near the speed of sound are missing, the likeliest burnout may lie in the coast. The curve climbs
    250 m after it, for which 70 m/s is the least."""
    time = np.arange(0, 6, 0.02)
    net = np.where(time < 1, 100.0, -20.0)
    speed = np.cumsum(net) * 0.02
    draws = (np.tile(one, (2, 1)) for one in (np.cumsum(speed) * 0.02, speed, net))
    ended = Burnout(Marks(0.0, moment, 5.0, np.inf), 0.1, 0.0, 0.0, speed_then, 2.0, ports)
    curve = Ascent(time, np.cumsum(speed) * 0.02, speed, net, *draws, noise=0.4, burnout_sd=0.1, fused=False)
    alone, both = (
        boost_event(one, None, 0.0, 5.9, "barometric altitude") for one in (curve, replace(curve, burnout=ended))
    )
    assert alone is not None
    assert both is not None
    assert (both[1].value < alone[1].value - 5) is counts
    assert (both[1].sd < alone[1].sd) is counts

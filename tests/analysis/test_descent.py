"""Landing after a fall, and the descent speed if no sensor shows when the parachute was ejected."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.channels import Heights, Push
from fieldkit.analysis.descent import (
    _GUST_WALK,
    _final_line,
    _from_unseen_ejection,
    _line_error,
    landing,
)
from fieldkit.analysis.ejection import _braked, _shift, shock
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event
from fieldkit.analysis.robust_statistics import running_median
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import SMALL, Logger, fly, log

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("after", [-1.0, -0.5, 0.0, 0.8])
def test_an_unseen_ejection_as_early_as_a_parachute_allows_is_within_the_uncertainty(after: float) -> None:
    height, lasts = 177.0, 25.0
    true = (height - GRAVITY * after**2 / 2) / (lasts - after)
    mean, sd = _from_unseen_ejection(height / lasts, height, lasts, 0.05)
    assert abs(mean - true) < 2.5 * sd
    assert sd < 0.08 * mean


@pytest.mark.sampled
@pytest.mark.parametrize("rate", [5.0, 20.0])
@pytest.mark.parametrize("part", [0.4, 0.6])
def test_a_fall_without_a_parachute_lands_when_it_hits_the_ground(part: float, rate: float) -> None:
    """It still accelerates in its last seconds, so a line through them reaches the ground too late."""
    truth = fly(replace(SMALL, burn=part * SMALL.burn, delay=1000.0))
    recorded = measure(log(truth, Logger(start=0.0, wait=3.0, rate=rate), np.random.default_rng(6)))
    duration = recorded.figures["duration"]
    assert abs(duration.value - truth.readouts()["duration"]) < 2 * duration.sd


@pytest.mark.sampled
@pytest.mark.parametrize("fraction", [0.5, 1.3])
@pytest.mark.parametrize("wait", [20.0, 120.0, 900.0])
def test_only_the_higher_of_two_flights_on_one_clock_is_measured(fraction: float, wait: float) -> None:
    truth = fly(SMALL)
    (series,) = log(truth, Logger(start=0.0, wait=wait, rate=10.0), np.random.default_rng(6))
    height = np.asarray(series.altitude)
    both = np.concatenate([height, fraction * height])
    recorded = measure((Series(time=np.asarray(0.1 * np.arange(both.size), np.float64), altitude=both),))
    duration = recorded.figures["duration"]
    assert abs(duration.value - truth.readouts()["duration"]) < 3 * duration.sd
    apogee, top = recorded.figures["apogee"], max(fraction, 1.0) * truth.readouts()["apogee"]
    assert apogee.value == pytest.approx(top, abs=max(0.01 * top, 2 * apogee.sd))  # a stretched flight is none: wide
    assert any("another flight follows" in note for note in recorded.notes) == (fraction < 1)
    assert any("another flight ends" in note for note in recorded.notes) == (fraction > 1 and wait < 60)


def test_carrying_a_rocket_uphill_after_landing_is_not_a_second_flight() -> None:
    truth = fly(SMALL)
    (series,) = log(truth, Logger(start=0.0, wait=5.0, rate=10.0), np.random.default_rng(6))
    height = np.asarray(series.altitude)
    walk = height[-1] + np.clip(np.arange(3000) * 0.1, 0, 0.4 * height.max())
    both = np.concatenate([height, walk])
    recorded = measure((Series(time=np.asarray(0.1 * np.arange(both.size), np.float64), altitude=both),))
    assert not any("another flight" in note for note in recorded.notes)


def test_a_rocket_that_swings_under_a_parachute_is_not_braked_again() -> None:
    """Its apparent speed is once that of a free fall, but was far from it before: a charge was seen 6.5 s too late."""
    time = np.arange(0.0, 20.0, 0.2)
    shown = {0.0: 0.0, 1.0: 15.0, 1.7: 8.0, 2.8: 28.0, 4.3: 6.0, 4.7: 30.0, 5.5: 20.0, 6.3: 45.0, 7.3: 16.0, 20.0: 23.0}
    height = 640.0 - np.cumsum(0.2 * np.interp(time, list(shown), list(shown.values())))
    free = 640.0 - np.cumsum(0.2 * np.where(time < 4.0, 0.8 * GRAVITY * time, 8.0))
    apogee = Event(0.0, 0.1, "")
    swings, falls = (Heights(time, one, True, 0.3, "") for one in (height, free))
    assert _braked(swings, apogee, np.inf) is None
    braked = _braked(falls, apogee, np.inf)
    assert braked is not None
    assert abs(braked.time - 4.0) < 3 * braked.sd  # no parachute opens as suddenly


@pytest.mark.parametrize(("noise", "after"), [(0.05, 0.0), (0.4, 0.4), (2.0, 0.4)])
def test_the_error_of_the_last_line_of_a_descent_is_that_of_noise_and_gusts(noise: float, after: float) -> None:
    """The end of lines through many descents, and that no other length is much better."""
    step, rng = 0.05, np.random.default_rng(4)
    time = np.arange(0.0, 10.0, step)
    gusts = rng.normal(0, np.sqrt(_GUST_WALK * step), (2000, time.size + round(after / step))).cumsum(axis=1)
    path = gusts.cumsum(axis=1) * step
    shown = path[:, : time.size] + rng.normal(0, noise, (2000, time.size))

    def error(first: int) -> float:
        values = np.polyfit(time[first:], shown[:, first:].T, 1)
        return float(np.std(values[0] * (time[-1] + after) + values[1] - path[:, -1]))

    line = _final_line(time, noise)
    found = error(line.start)
    assert _line_error(time[line], noise, time[-1] + after) == pytest.approx(found, rel=0.15)
    for length in (0.5, 2.0):
        assert found < 1.1 * error(time.size - round(length * (time.size - line.start)))


def test_landings_are_off_by_as_much_as_their_standard_deviations_say() -> None:
    """In gusts, with a barometer of 20 samples a second."""
    rng, step, off = np.random.default_rng(5), 0.05, []
    for _ in range(60):
        time = np.arange(0.0, 60.0, step)
        gusts = np.zeros(time.size)
        for place, kick in enumerate(rng.normal(0, 0.5 * np.sqrt(2 * step / 3.0), time.size - 1)):
            gusts[place + 1] = gusts[place] * (1 - step / 3.0) + kick
        fall = 200.0 - np.cumsum((5.0 + gusts) * step)
        truth = float(time[int(np.argmax(fall < 0))])
        height = np.where(time < truth, fall, 0.0) + rng.normal(0, 0.4, time.size)
        track = Heights(time, height, True, 0.4, "barometric altitude")
        seen = Outline(0.0, 0.0, 0.0, True, 0.0, 0.1, 200.0, running_median(height, 11), False, 50.0)
        landed, _ = landing(track, seen, 0.0)
        assert landed is not None
        off.append((landed.time - truth) / landed.sd)
    assert abs(np.mean(off)) < 0.5
    assert 0.6 < np.std(off) < 1.3


def test_a_shock_between_two_samples_was_in_their_middle() -> None:
    """The first sample that shows it is late by half a step on average."""
    step, rng, off = 0.04, np.random.default_rng(6), []
    for fired in rng.uniform(10.0, 11.0, 200):
        time = np.arange(0.0, 20.0, step)
        felt = np.where((time > fired) & (time < fired + 0.1), 20 * GRAVITY, 0.0) + rng.normal(0, 0.5, time.size)
        found = shock(Push(time, felt, False, "acceleration"), 2.0, 10.0)
        assert found is not None
        off.append(found.time - fired)
    assert np.mean(off) == pytest.approx(0.0, abs=0.003)
    assert np.std(off) < found.sd < 2.5 * np.std(off)


@pytest.mark.parametrize("faster", [2.5, 4.0])
def test_a_mean_of_speeds_is_highest_before_a_parachute_brakes_hard(faster: float) -> None:
    """The slope of heights over a window is a mean of the speeds with the weights of a parabola."""
    time = np.arange(-2.0, 2.0, 0.002)
    speed = GRAVITY * np.where(time < 0, time, -(faster**2 - 1) * time)
    weights = 1 - np.linspace(-1.0, 1.0, 401) ** 2
    highest = time[np.argmax(np.convolve(speed, weights, "same")[500:-500]) + 500]
    assert highest == pytest.approx(-0.4 * _shift(faster**2 - 1), abs=0.005)


@pytest.mark.parametrize("lag", [0.3, 1.0])
def test_a_charge_behind_a_filter_is_dated_by_what_the_filter_makes_of_its_braking(lag: float) -> None:
    """The top of a coast is late by the lag, from which the times are freed; a sudden braking is hardly late."""
    step, fired, final = 0.04, 2.0, 5.0
    time = np.arange(-4.0, 20.0, step)
    fall = np.where(time < fired, GRAVITY * time, final + (GRAVITY * fired - final) * np.exp(-(time - fired) / 0.3))
    height = 200 - np.cumsum(fall) * step
    shown = height.copy()
    for place in range(1, shown.size):
        shown[place] = shown[place - 1] + (1 - np.exp(-step / lag)) * (height[place] - shown[place - 1])
    noise = np.random.default_rng(3).normal(0, 0.05, time.size)
    track = Heights(time - lag, shown + noise, True, 0.05, "barometric altitude", bend=lag, shift=lag)
    found = _braked(track, Event(0.0, 0.1, "barometric altitude"), 15.0)
    assert found is not None
    assert found.time == pytest.approx(fired, abs=0.15 * lag + 0.1)
    assert abs(found.time - fired) < 2 * found.sd


def test_a_parachute_that_opens_just_above_the_ground_moves_the_landing() -> None:
    """The line through the fall before it reaches the ground half a second too early."""
    time = np.arange(0.0, 20.0, 0.05)
    fall = np.where(time < 7.0, 20 * time, 140 + 4 * (time - 7.0))
    landed = 7.0 + 4.0 / 4
    height = np.maximum(144 - fall, 0.0)
    shown = np.concatenate([np.full(100, 144.0), height]) + np.random.default_rng(3).normal(0, 0.2, time.size + 100)
    clock = np.arange(shown.size) * 0.05 - 5.0
    track = Heights(clock, shown, True, 0.2, "barometric altitude")
    seen = Outline(-9.0, -8.0, 0.0, True, 0.0, 0.1, 144.0, running_median(shown, 21), False, 50.0)
    found, _ = landing(track, seen, 0.0)
    assert found is not None
    assert abs(found.time - landed) < 2 * found.sd < 1.0


def test_heights_in_steps_that_hide_the_fall_show_no_ejection() -> None:
    """Pressures in steps of 0.1 kPa are 8 m apart, through two of which the rocket falls."""
    time = np.arange(-4.0, 20.0, 0.05)
    fall = np.where(time < 1.5, GRAVITY * np.maximum(time, 0.0), 5.0)
    height = 200 - np.cumsum(np.where(time < 0, GRAVITY * time, fall)) * 0.05
    for step, seen in ((8.0, False), (0.5, True)):
        track = Heights(time, np.round(height / step) * step, True, 0.3 * step, "pressure", held=step)
        assert (_braked(track, Event(0.0, 0.1, "pressure"), 15.0) is not None) == seen

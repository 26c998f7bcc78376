"""Measurements from samples of flights that are known exactly."""

import tracemalloc
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.analysis import Recorded, by_device, columns, measure
from fieldkit.analysis.channels import Push
from fieldkit.analysis.compare import compare
from fieldkit.analysis.ejection import shock
from fieldkit.analysis.forces import forces
from fieldkit.analysis.notes import (
    CLIPPED_NOTE,
    FILLED_NOTE,
    NO_APOGEE,
    NO_BOOST,
    NO_FLIGHT,
    NO_HEIGHT,
    NO_LANDING,
    NO_LIFTOFF,
    NO_PAD,
)
from fieldkit.analysis.records import MeasuredClimb
from fieldkit.analysis.robust_statistics import local_slopes
from fieldkit.flight import READOUTS, Series
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure, pressure_height
from tests.analysis.recordings import FAST, LARGE, SMALL, TINY, Logger, Rocket, Truth, changed, fly, log
from tests.effort import examples

flown = cache(fly)


def measured(rocket: Rocket, logger: Logger, seed: int = 1) -> tuple[Recorded, Truth]:
    truth = flown(rocket)
    return measure(log(truth, logger, np.random.default_rng(seed))), truth


def off(recorded: Recorded, truth: Truth, name: str) -> float:
    """The error of a measured figure."""
    return recorded.figures[name].value - truth.readouts()[name]


@pytest.mark.sampled
@pytest.mark.parametrize(
    "logger",
    [
        Logger(),
        Logger(resolution=0.3048),
        Logger(rate=100, noise=1.0),
        Logger(rate=5),
        Logger(rate=1),
        Logger(spikes=0.03),
        Logger(shock=60),
        Logger(channel="pressure", wait=300),
        Logger(drift=12),
        Logger(jitter=0.3),
        Logger(accelerometer=50, spikes=0.01, shock=30),
    ],
    ids=["plain", "feet", "fast", "thin", "1 Hz", "spikes", "shock", "pressure", "drifted zero", "jitter", "fused"],
)
@pytest.mark.parametrize("rocket", [TINY, SMALL, LARGE], ids=["tiny", "small", "large"])
def test_apogee_and_its_time_are_right_despite_logger_faults(rocket: Rocket, logger: Logger) -> None:
    recorded, truth = measured(rocket, logger)
    apogee = truth.readouts()["apogee"]
    assert abs(off(recorded, truth, "apogee")) < max(1.0, 0.005 * apogee)
    event = recorded.events["apogee"]
    late = event.time - logger.start - truth.apogee_time
    limit = 0.2 if logger.rate > 1 else 0.5
    assert abs(late) < max(limit, 3 * event.sd), "the sd covers an unknown lag"
    assert event.sd < limit


def test_shocks_near_the_speed_of_sound_bias_no_figure() -> None:
    recorded, truth = measured(FAST, Logger(dip=True))
    assert abs(off(recorded, truth, "apogee")) < 0.005 * truth.readouts()["apogee"]
    assert abs(off(recorded, truth, "top_speed")) < 0.06 * truth.readouts()["top_speed"]
    assert abs(off(recorded, truth, "burn_time")) < 0.4


@pytest.mark.parametrize("early", [1.5, 2.0])
def test_gas_of_a_charge_before_apogee_is_not_taken_for_the_apogee(early: float) -> None:
    """Pressure in the bay rises, stays, and falls: heights fall by 90 m, stay, and are then 50 m too high."""
    truth = flown(LARGE)
    (series,) = log(truth, Logger(rate=20, noise=0.2), np.random.default_rng(5))
    assert series.altitude is not None
    since = series.time - Logger().start - truth.apogee_time + early
    plateau = series.altitude[np.searchsorted(since, 0)]
    blown = [plateau - 90 * (1 - since / 0.3), plateau, series.altitude + 50 * np.sin(np.pi * (since - 1.4) / 0.9)]
    height = np.select([(since > 0) & (since < 0.3), (since > 0) & (since < 1.4), (since > 0) & (since < 2.3)], blown,
        series.altitude)  # fmt: skip
    recorded = measure((Series(time=series.time, altitude=height),))
    right = truth.readouts()
    assert recorded.figures["apogee"].value == pytest.approx(right["apogee"], rel=0.003)
    assert recorded.events["apogee"].time == pytest.approx(Logger().start + truth.apogee_time, abs=0.25)


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [TINY, SMALL, LARGE], ids=["tiny", "small", "large"])
def test_heights_alone_give_speed_and_burn_time(rocket: Rocket) -> None:
    recorded, truth = measured(rocket, Logger(resolution=0.3048))
    assert abs(off(recorded, truth, "top_speed")) < 0.05 * truth.readouts()["top_speed"]
    assert abs(off(recorded, truth, "burn_time")) < 0.2
    assert abs(off(recorded, truth, "coast_to_apogee")) < 0.3
    assert abs(off(recorded, truth, "duration")) < 0.5
    assert recorded.figures["avg_accel"].value == pytest.approx(
        recorded.figures["top_speed"].value / recorded.figures["burn_time"].value
    )


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [TINY, SMALL, LARGE, FAST], ids=["tiny", "small", "large", "fast"])
def test_an_accelerometer_reduces_the_uncertainty_of_the_boost(rocket: Rocket) -> None:
    recorded, truth = measured(rocket, Logger(accelerometer=100))
    assert abs(off(recorded, truth, "burn_time")) < 0.06
    assert abs(off(recorded, truth, "top_speed")) < 0.03 * truth.readouts()["top_speed"]
    assert abs(off(recorded, truth, "peak_accel")) < 0.04 * truth.readouts()["peak_accel"]
    assert abs(off(recorded, truth, "apogee_to_eject")) < 0.25
    assert abs(off(recorded, truth, "eject_altitude")) < max(4.0, 0.01 * truth.readouts()["apogee"])
    blind, _ = measured(rocket, Logger())
    assert recorded.figures["burn_time"].sd < blind.figures["burn_time"].sd


def test_a_rocket_that_comes_in_ballistic_has_no_ejection() -> None:
    """The ground ends its fall, not a parachute."""
    recorded, truth = measured(replace(SMALL, delay=1e6), Logger(accelerometer=50))
    assert not {"apogee_to_eject", "eject_altitude"} & set(recorded.figures)
    assert "ejection" not in recorded.events
    assert abs(off(recorded, truth, "duration")) < 0.5
    assert recorded.figures["descent_speed"].value > 35


def test_a_charge_that_a_logger_fires_after_landing_is_not_the_ejection() -> None:
    truth = fly(SMALL)
    recorded = measure(log(truth, Logger(), np.random.default_rng(2)), {"drogue": 100.0 + float(truth.time[-1]) + 4})
    ejected = recorded.events.get("ejection")
    assert ejected is None or ejected.time < recorded.events["landing"].time


def test_the_speed_of_a_device_is_that_of_its_accelerometer() -> None:
    """A charge raises a speed derived from heights."""
    (heights,) = log(flown(SMALL), Logger(), np.random.default_rng(1))
    spoiled = replace(heights, speed=np.full(heights.time.size, 600.0), inertial_speed=np.full(heights.time.size, 60.0))
    recorded = measure((heights,))
    assert by_device((spoiled,), recorded, {})["top_speed"] == 60
    assert by_device((replace(spoiled, inertial_speed=None),), recorded, {})["top_speed"] == 600


def test_a_charge_that_raises_the_heights_is_found_though_they_are_removed() -> None:
    """Its gas adds 30 m for a fifth of a second: samples are missing before the fall is braked."""
    recorded, truth = measured(replace(SMALL, delay=9.2), Logger(shock=30))
    assert truth.readouts()["apogee_to_eject"] > 1
    assert abs(off(recorded, truth, "apogee_to_eject")) < 2 * recorded.figures["apogee_to_eject"].sd


@pytest.mark.parametrize("rate", [10, 100])
def test_an_ejection_at_high_speed_changes_only_the_curve_after_it(rate: int) -> None:
    """A short delay deploys the parachute at 50 m/s: the rocket stops within half a second."""
    recorded, truth = measured(replace(SMALL, delay=3.3), Logger(accelerometer=rate))
    assert abs(off(recorded, truth, "eject_altitude")) < 3 * recorded.figures["eject_altitude"].sd < 20
    assert abs(off(recorded, truth, "apogee")) < 1
    assert abs(off(recorded, truth, "apogee_to_eject")) < 0.25


@pytest.mark.sampled
@pytest.mark.parametrize("range_end", [6.0, 8.0])
def test_a_clipped_accelerometer_still_measures_the_rest(range_end: float) -> None:
    truth = flown(LARGE)
    heights, felt = log(truth, Logger(accelerometer=100), np.random.default_rng(1))
    assert felt.felt is not None
    recorded = measure((heights, replace(felt, felt=np.minimum(felt.felt, range_end * GRAVITY))))
    alone = measure((heights,))
    assert any(note.startswith(FILLED_NOTE.split("{")[0]) for note in recorded.notes)
    for name in ("peak_accel", "top_speed", "avg_accel", "burn_time"):
        assert abs(off(recorded, truth, name)) < 2 * recorded.figures[name].sd
        assert name == "peak_accel" or recorded.figures[name].sd < alone.figures[name].sd
        assert "acceleration" in recorded.figures[name].source
    assert recorded.figures["peak_accel"].value > (range_end - 1) * GRAVITY
    assert recorded.events["ejection"].source == "acceleration"  # a pressure pulse of any size counts


def test_a_clipped_accelerometer_that_contradicts_the_heights_is_not_used_for_the_boost() -> None:
    truth = flown(LARGE)
    heights, felt = log(truth, Logger(accelerometer=100), np.random.default_rng(1))
    assert felt.felt is not None
    late = replace(felt, time=felt.time + 0.8, felt=np.minimum(felt.felt, 8 * GRAVITY))
    recorded = measure((heights, late))
    assert CLIPPED_NOTE in recorded.notes
    for name in ("peak_accel", "top_speed", "avg_accel"):
        assert abs(off(recorded, truth, name)) < 2 * recorded.figures[name].sd
        assert "acceleration" not in recorded.figures[name].source
    assert recorded.forces is not None
    assert "acceleration" not in recorded.forces.source


def test_an_accelerometer_offset_is_corrected_from_the_pad() -> None:
    recorded, truth = measured(SMALL, Logger(accelerometer=100, scale=1.0, bias=1.4))
    assert abs(off(recorded, truth, "peak_accel")) < 1.5


@pytest.mark.parametrize("part", [-0.04, 0.04])
def test_a_pressure_error_that_grows_with_speed_is_within_the_uncertainty_from_heights_alone(part: float) -> None:
    truth = flown(LARGE)
    (series,) = log(truth, Logger(), np.random.default_rng(1))
    speed = np.interp(series.time - 100, truth.time, truth.speed, left=0, right=0)
    assert series.altitude is not None
    recorded = measure((replace(series, altitude=series.altitude + part * speed**2 / (2 * GRAVITY)),))
    for name in ("top_speed", "burn_time", "avg_accel", "peak_accel"):
        assert abs(off(recorded, truth, name)) < 2.5 * recorded.figures[name].sd
    assert abs(off(recorded, truth, "apogee")) < 1


def test_a_zero_that_drifts_on_the_pad_widens_the_apogee() -> None:
    (series,) = log(flown(SMALL), Logger(wait=60), np.random.default_rng(1))
    assert series.altitude is not None
    drifting = measure((replace(series, altitude=series.altitude + 0.05 * (series.time - series.time[0])),))
    assert abs(off(drifting, flown(SMALL), "apogee")) < 2 * drifting.figures["apogee"].sd
    assert measure((series,)).figures["apogee"].sd < 0.3


def test_gusts_on_the_ground_do_not_hide_the_landing() -> None:
    random, truth = np.random.default_rng(1), flown(SMALL)
    (series,) = log(truth, Logger(wait=60, rest=60), random)
    stands = (series.time < 100) | (series.time > 100 + truth.time[-1])
    assert series.altitude is not None
    gust = np.convolve(random.standard_normal(stands.size), np.exp(-np.arange(200) / 30), "same") * 0.37
    recorded = measure((replace(series, altitude=series.altitude + stands * gust),))
    assert abs(off(recorded, truth, "duration")) < 1.0
    assert abs(off(recorded, truth, "apogee")) < 2 * recorded.figures["apogee"].sd


def test_a_log_that_begins_late_has_an_apogee_and_no_burn_time() -> None:
    recorded, truth = measured(LARGE, Logger(late=3.0))
    assert abs(off(recorded, truth, "apogee")) < 0.005 * truth.readouts()["apogee"]
    assert not {"burn_time", "duration", "avg_accel", "coast_to_apogee", "time_to_apogee"} & set(recorded.figures)
    assert "liftoff" not in recorded.events
    assert NO_LIFTOFF in recorded.notes


@pytest.mark.parametrize("gap", [(-1.0, 6.4), (0.7, 3.9)], ids=["lift-off and burnout", "burnout"])
def test_a_boost_without_samples_has_no_figures(gap: tuple[float, float]) -> None:
    truth = flown(LARGE)
    (series,) = log(truth, Logger(rate=5, noise=1.0), np.random.default_rng(1))
    there = (series.time - 100 < gap[0]) | (series.time - 100 > gap[1])
    assert series.altitude is not None
    recorded = measure((Series(time=series.time[there], gps_altitude_msl=series.altitude[there] + 200),))
    assert not {"top_speed", "burn_time", "avg_accel", "peak_accel", "coast_to_apogee"} & set(recorded.figures)
    assert NO_BOOST in recorded.notes
    assert recorded.forces is None
    assert abs(off(recorded, truth, "apogee")) < 2
    assert abs(off(recorded, truth, "time_to_apogee")) < 2 * recorded.figures["time_to_apogee"].sd


def test_a_boost_between_two_samples_has_no_figures() -> None:
    recorded, truth = measured(TINY, Logger(rate=1))
    assert not {"top_speed", "burn_time", "avg_accel", "peak_accel", "coast_to_apogee"} & set(recorded.figures)
    assert NO_BOOST in recorded.notes
    assert abs(off(recorded, truth, "apogee")) < 1


def test_a_receiver_that_loses_track_under_thrust_gives_no_boost_figures() -> None:
    """Its height first extrapolates, then falls by thirty meters, and returns to the rocket's within a second."""
    truth = flown(LARGE)
    (series,) = log(truth, Logger(rate=10, noise=0.2), np.random.default_rng(2))
    since = series.time - 100
    assert series.altitude is not None
    lost = np.select([(since > 0.3) & (since < 1.5), (since >= 1.5) & (since < 2.5)],
        [4 - 30 * (since - 0.3) / 1.2, np.interp(since, [1.5, 2.5], [-26, np.interp(2.5, truth.time, truth.height)])],
        series.altitude)  # fmt: skip
    recorded = measure((Series(time=series.time, gps_altitude_msl=lost + 900),))
    assert NO_BOOST in recorded.notes
    assert "top_speed" not in recorded.figures
    assert abs(off(recorded, truth, "apogee")) < 3
    barometer = measure((Series(time=series.time, altitude=lost),))
    assert "top_speed" in barometer.figures  # the barometer may react to the air there; the rest determines the speed


@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_repeated_fixes_of_a_receiver_are_not_measurements(rate: float) -> None:
    truth = flown(LARGE)
    (series,) = log(truth, Logger(rate=rate, noise=0.5, wait=30.0), np.random.default_rng(2))
    assert series.altitude is not None
    since = series.time - 100
    lost = np.where((since > -2) & (since < 9), series.altitude[np.searchsorted(since, -2)], series.altitude)
    recorded = measure((Series(time=series.time, gps_altitude_msl=lost + 900),))
    assert "top_speed" not in recorded.figures
    assert abs(off(recorded, truth, "apogee")) < 3
    duration = recorded.figures.get("duration")
    assert duration is None or abs(off(recorded, truth, "duration")) < 2 * duration.sd


@pytest.mark.sampled
@pytest.mark.parametrize("rest", [2.5, 3.0, 4.0])
def test_a_log_that_ends_a_few_seconds_after_landing_has_a_landing(rest: float) -> None:
    truth = flown(SMALL)
    recorded = measure(log(truth, Logger(rest=rest), np.random.default_rng(3)))
    assert abs(off(recorded, truth, "duration")) < 2 * recorded.figures["duration"].sd
    assert abs(off(recorded, truth, "descent_speed")) < 2 * recorded.figures["descent_speed"].sd


@pytest.mark.parametrize(
    ("rate", "noise", "rest", "shows"),
    [
        (2.0, 0.1, 2.2, True),
        (20.0, 0.05, 0.8, True),
        (2.0, 0.4, 0.8, False),
        (20.0, 2.0, 1.0, False),
    ],
)
def test_a_rest_shows_once_it_excludes_the_slowest_descent(rate: float, noise: float, rest: float, shows: bool) -> None:
    truth = flown(SMALL)
    recorded = measure(log(truth, Logger(rate=rate, noise=noise, rest=rest), np.random.default_rng(3)))
    assert ("duration" in recorded.figures) is shows
    if shows:
        assert abs(off(recorded, truth, "duration")) < 2 * recorded.figures["duration"].sd


@pytest.mark.sampled
@pytest.mark.parametrize("early", [0.5, 1.0, 2.0])
def test_a_log_that_ends_before_landing_has_no_landing(early: float) -> None:
    for rate, noise in ((2.0, 0.1), (20.0, 0.05), (20.0, 1.5)):
        (series,) = log(flown(SMALL), Logger(rate=rate, noise=noise, rest=-early), np.random.default_rng(4))
        assert "duration" not in measure((series,)).figures


@pytest.mark.parametrize("channel", ["altitude_msl", "altitude"])
def test_heights_above_sea_level_that_begin_in_flight_have_no_pad_to_refer_to(channel: str) -> None:
    """Also if nothing but the height of the landing says that they are above sea level."""
    (series,) = log(flown(LARGE), Logger(late=3.0), np.random.default_rng(1))
    assert series.altitude is not None
    recorded = measure((Series(time=series.time, **{channel: series.altitude + 900}),))
    assert "apogee" not in recorded.figures
    assert "apogee" in recorded.events
    assert NO_PAD in recorded.notes


@pytest.mark.parametrize("notices", [-2.0, 0.3])
def test_a_logger_may_set_its_zero_when_it_notices_the_flight(notices: float) -> None:
    truth = flown(LARGE)
    (series,) = log(truth, Logger(), np.random.default_rng(1))
    assert series.altitude is not None
    before = series.time < series.time[0] + Logger().wait + notices
    recorded = measure((replace(series, altitude=series.altitude + np.where(before, 412.0, 0.0)),))
    assert abs(off(recorded, truth, "apogee")) < 1
    assert abs(off(recorded, truth, "time_to_apogee")) < 0.2


@pytest.mark.parametrize("rocket", [SMALL, LARGE, TINY], ids=["small", "large", "tiny"])
@pytest.mark.parametrize("late", [0.1, 0.2])
def test_a_zero_set_just_after_lift_off_does_not_shorten_the_burn(rocket: Rocket, late: float) -> None:
    """The first heights hide how high it was by then, but not how fast."""
    truth = flown(rocket)
    heights, felt = log(truth, Logger(accelerometer=100, late=late), np.random.default_rng(2))
    zeroed = replace(heights, altitude=heights.altitude - np.median(heights.altitude[:2]))
    figure = measure((zeroed, felt)).figures.get("burn_time")
    assert figure is None or abs(figure.value - truth.readouts()["burn_time"]) < 1.9 * figure.sd


def test_without_samples_on_the_pad_the_zero_is_as_certain_as_the_landing_height() -> None:
    near, truth = measured(SMALL, Logger(late=0.3))
    far, _ = measured(SMALL, Logger(late=0.3, drift=8))
    assert near.figures["apogee"].sd < 1.3
    assert 4 < far.figures["apogee"].sd < 6
    assert abs(off(far, truth, "apogee")) < 2.5 * far.figures["apogee"].sd
    assert abs(off(near, truth, "apogee")) < 1.5


def test_an_accelerometer_that_begins_late_has_no_peak() -> None:
    """The thrust of this rocket falls from the first moment, so the peak was before the log."""
    clocks = log(flown(LARGE), Logger(accelerometer=100), np.random.default_rng(1))
    late = tuple(
        Series(s.time[s.time > 100.5], **{c: getattr(s, c)[s.time > 100.5]})
        for s, c in zip(clocks, ("altitude", "felt"), strict=True)
    )
    assert "peak_accel" in measure(clocks).figures
    assert "peak_accel" not in measure(late).figures


def test_a_log_that_ends_soon_after_its_top_has_an_apogee() -> None:
    truth = flown(LARGE)
    (series,) = log(truth, Logger(noise=1.3), np.random.default_rng(1))
    assert series.altitude is not None
    there = series.time < 100 + truth.apogee_time + 2
    recorded = measure((Series(time=series.time[there], altitude=series.altitude[there]),))
    assert abs(off(recorded, truth, "apogee")) < 3 * recorded.figures["apogee"].sd
    assert "descent_speed" not in recorded.figures


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE], ids=["small", "large"])
@pytest.mark.parametrize("early", [0.97, 1.0, 1.03])
def test_an_apogee_close_to_the_end_of_a_log_has_an_interval(rocket: Rocket, early: float) -> None:
    recorded, truth = measured(rocket, Logger(early=early))
    for name in ("apogee", "coast_to_apogee", "time_to_apogee"):
        assert abs(off(recorded, truth, name)) < 2.5 * recorded.figures[name].sd
    assert recorded.figures["apogee"].sd < 0.01 * truth.readouts()["apogee"]
    assert not {"descent_speed", "duration", "apogee_to_eject"} & set(recorded.figures)


def test_a_log_that_ends_before_apogee_reports_it() -> None:
    recorded, truth = measured(LARGE, Logger(early=0.8))
    assert not {"apogee", "coast_to_apogee", "descent_speed", "duration", "time_to_apogee"} & set(recorded.figures)
    assert NO_APOGEE in recorded.notes
    assert abs(off(recorded, truth, "top_speed")) < 0.06 * truth.readouts()["top_speed"]


def test_a_log_that_ends_in_the_air_has_no_duration() -> None:
    recorded, _ = measured(SMALL, Logger(early=4.0))
    assert "duration" not in recorded.figures
    assert recorded.figures["descent_speed"].value == pytest.approx(SMALL.sink, rel=0.15)
    assert NO_LANDING in recorded.notes


@pytest.mark.parametrize(
    "shape",
    [
        lambda t: 0 * t,
        lambda t: np.where(np.abs(t - 20) < 0.02, 738.0, 0.0) - 75.0 * (t > 21),
        lambda t: 0.4 * t,
        lambda t: -3.0 * t,
        lambda t: 4 * np.sin(t / 9),
    ],
    ids=["still", "one spike and a fall", "a walk uphill", "a descent", "drift"],
)
def test_samples_without_a_flight_give_no_figures(shape: object) -> None:
    time = np.arange(0, 60, 0.05)
    noise = 0.5 * np.random.default_rng(2).standard_normal(time.size)
    recorded = measure((Series(time=time, altitude=shape(time) + noise),))  # type: ignore[operator]
    assert recorded == Recorded(notes=(NO_FLIGHT,))


def test_a_log_without_heights_reports_it() -> None:
    time = np.arange(0, 10, 0.1)
    assert measure((Series(time=time, felt=np.full(time.size, 9.8)),)).notes == (NO_HEIGHT,)
    assert measure(()).notes == (NO_HEIGHT,)


@pytest.mark.parametrize("count", [0, 1, 3, 12, 13, 40])
def test_a_few_samples_cause_no_crash(count: int) -> None:
    time = np.arange(count) * 0.5
    measure((Series(time=time, altitude=400 - (time - 9) ** 2 * 4.9, felt=np.full(count, np.nan)),))


def test_a_climb_after_hours_of_other_samples_needs_little_memory() -> None:
    """Ten meters per second for five minutes, like a balloon: nothing in the last two minutes shows when it began."""
    time = np.arange(0, 40_000, 5.0)
    height = np.minimum(np.clip(10 * (time - 30_000), 0, 3000), np.clip(40_000 - time, 0, None))
    tracemalloc.start()
    measure((Series(time=time, altitude=height + np.random.default_rng(1).normal(0, 0.3, time.size)),))
    assert tracemalloc.get_traced_memory()[1] < 100e6
    tracemalloc.stop()


@examples(15)
@given(seed=st.integers(0, 2**32), hurt=st.sampled_from(["cut", "noise", "jumps", "huge", "missing", "constant"]))
def test_any_samples_give_finite_figures(seed: int, hurt: str) -> None:
    random = np.random.default_rng(seed)
    (series,) = log(flown(SMALL), Logger(rate=10), random)
    height = series.altitude.copy()
    some = random.random(height.size) < 0.4
    if hurt == "cut":
        first, last = np.sort(random.integers(0, height.size, 2))
        series, height = Series(time=series.time[first:last]), height[first:last]
    elif hurt == "noise":
        height += 300 * random.standard_normal(height.size)
    elif hurt == "jumps":
        height += np.cumsum(some * random.normal(0, 200, height.size))
    else:
        height[some] = {"huge": 1e30, "missing": np.nan, "constant": 7.0}[hurt]
    recorded = measure((Series(time=series.time, altitude=height, felt=height),))
    for figure in recorded.figures.values():
        assert np.isfinite([figure.value, figure.sd]).all()
        assert figure.sd > 0


def test_no_figure_rests_on_a_single_sample() -> None:
    truth = flown(SMALL)
    (series,) = log(truth, Logger(), np.random.default_rng(3))
    spiked = series.altitude.copy()
    spiked[[40, 100, 400]] += [900.0, 2000.0, -3000.0]
    calm, wild = measure((series,)), measure((replace(series, altitude=spiked),))
    for name, figure in calm.figures.items():
        assert wild.figures[name].value == pytest.approx(figure.value, abs=2 * figure.sd + 0.05)


def test_gaps_and_duplicate_rows_do_not_stop_the_measurement() -> None:
    truth = flown(SMALL)
    (series,) = log(truth, Logger(), np.random.default_rng(4))
    kept = np.r_[0:85, 93:140, 140:142, 140:142, 150 : series.time.size]
    holes = series.altitude[kept].copy()
    holes[10:20] = np.nan
    recorded = measure((Series(time=np.sort(series.time[kept]), altitude=holes),))
    assert abs(off(recorded, truth, "apogee")) < 1.5


def test_drag_area_is_measured_in_the_coast() -> None:
    for logger in (Logger(accelerometer=100, scale=1.0, bias=0.0), Logger(noise=0.2, rate=50)):
        recorded, truth = measured(LARGE, logger)
        forces = recorded.forces
        assert forces is not None
        slow = np.isfinite(forces.drag_area) & (forces.speed < 200) & (forces.speed > 60)
        assert np.median(forces.drag_area[slow]) == pytest.approx(LARGE.area / LARGE.mass, rel=0.06)
        thrust = np.interp(forces.time_from_liftoff, truth.time, truth.felt)
        middle = forces.burning & (forces.time_from_liftoff > 0.5) & (forces.time_from_liftoff < 1.9)
        assert np.abs(forces.push[middle] - thrust[middle]).max() < 0.15 * thrust.max()


def test_above_the_atmosphere_no_drag_area_is_measured() -> None:
    time, one = np.arange(0.0, 10.0), np.ones(10)
    for height, shown in ((1e3, True), (1e6, False)):
        climb = MeasuredClimb(time, height * one, 100 * one, one, -20 * one, one, time < 0, "pressure")
        found = forces(climb, None, 0.0, np.inf)
        assert found is not None
        assert np.all(np.isfinite(found.drag_area) == shown)


@pytest.mark.slow
def test_stated_uncertainties_hold_over_many_flights() -> None:
    random = np.random.default_rng(11)
    far: dict[str, list[float]] = {}
    loggers = [Logger(), Logger(resolution=0.3048), Logger(rate=10), Logger(spikes=0.02), Logger(accelerometer=100)]
    for number in range(150):
        truth = fly(changed([TINY, SMALL, LARGE][number % 3], random))
        recorded = measure(log(truth, loggers[number % 5], random))
        for name, right in truth.readouts().items():
            if name in recorded.figures:
                figure = recorded.figures[name]
                far.setdefault(name, []).append(abs(figure.value - right) / figure.sd)
    for name, distances in far.items():
        assert np.mean(np.array(distances) < 2) > 0.8, (name, np.quantile(distances, [0.5, 0.8, 0.95]))


@pytest.mark.thorough
def test_stated_uncertainties_hold_over_a_few_flights() -> None:
    random = np.random.default_rng(5)
    truths = [flown(SMALL), flown(LARGE)]
    far = []
    for number in range(8):
        truth = truths[number % 2]
        recorded = measure(log(truth, Logger(resolution=0.3048 * (number % 2)), random))
        names = ("apogee", "top_speed", "burn_time", "duration")
        far += [abs(off(recorded, truth, name)) / recorded.figures[name].sd for name in names]
    assert np.mean(np.array(far) < 2) > 0.75
    assert np.median(far) > 0.1  # nor are they so wide that they are useless


def test_measuring_twice_gives_identical_results() -> None:
    once, again = (measured(SMALL, Logger())[0] for _ in range(2))
    assert once.figures == again.figures


def test_a_long_wait_on_the_pad_changes_no_figure() -> None:
    recorded, truth = measured(TINY, Logger(rate=100, wait=1500, noise=0.5))
    assert abs(off(recorded, truth, "apogee")) < 1.0
    assert abs(off(recorded, truth, "time_to_apogee")) < 0.2


def test_two_loggers_on_one_flight_agree_once_their_clocks_are_aligned() -> None:
    first, _ = measured(SMALL, Logger())
    second, _ = measured(SMALL, Logger(start=3.0, rate=50, noise=1.0, accelerometer=50), seed=8)
    found = compare(first, second)
    assert found.shift == pytest.approx(97.0, abs=0.1)
    assert found.rms is not None
    assert found.rms < 1.5
    assert abs(found.differences["apogee"].value) < 1.0
    other, _ = measured(TINY, Logger())
    assert (compare(first, other).differences["apogee"].in_sd or 0) < -50


def test_a_measured_figure_becomes_the_readout_and_the_stated_one_is_kept_with_it() -> None:
    recorded, _ = measured(SMALL, Logger())
    fields, extra = columns(recorded, {"rocket": "Swift", "apogee": 500.0})
    assert fields["rocket"] == "Swift"
    assert fields["apogee"] == pytest.approx(recorded.figures["apogee"].value, abs=1e-3)
    assert extra["stated_apogee_m"] == "500"
    assert fields["sd"]["apogee"] == pytest.approx(recorded.figures["apogee"].sd, rel=0.05)
    assert fields["source"]["apogee"] == "baro"
    assert "eject_altitude" not in fields["sd"]
    assert not any("_sd_" in name for name in extra if name != "time_to_apogee_sd_s")
    short, _ = measured(LARGE, Logger(early=0.8))
    assert columns(short, {"apogee": 500.0})[0]["apogee"] == 500.0
    failed = Recorded(notes=(NO_FLIGHT,))
    assert columns(failed, {"apogee": 738.0}) == ({}, {"stated_apogee_m": "738"})


def test_a_missing_readout_is_never_zero() -> None:
    for logger in (Logger(), Logger(late=3.0), Logger(early=0.8)):
        fields, _ = columns(measured(LARGE, logger)[0], {})
        assert all(fields[column.name] for column in READOUTS if column.name in fields)


def test_standard_height_and_pressure_are_inverse_functions() -> None:
    height = np.array([-300.0, 0.0, 1500.0, 10999.0, 11001.0, 18000.0])
    assert pressure_height(height_pressure(height)) == pytest.approx(height, abs=1e-6)
    assert height_pressure(np.array([11000.0, 20000.0])) == pytest.approx([22632.1, 5474.9], rel=1e-4)
    assert np.isnan(pressure_height(np.array([0.0, -5.0]))).all()


@pytest.mark.parametrize("place", [0, -1])
def test_a_spike_at_either_end_of_a_log_is_a_spike(place: int) -> None:
    truth = flown(SMALL)
    (series,) = log(truth, Logger(), np.random.default_rng(6))
    height = series.altitude.copy()
    height[place] = 5000.0
    assert abs(off(measure((replace(series, altitude=height),)), truth, "apogee")) < 1.0


@pytest.mark.parametrize("size", [9, 40])
def test_slopes_agree_with_scipy(size: int) -> None:
    from scipy.signal import savgol_filter

    y = np.random.default_rng(size).normal(size=size).cumsum()
    whole = savgol_filter(y, 5, 2, deriv=1, delta=0.2)
    np.testing.assert_allclose(local_slopes(y, 5, 0.2), whole[2:-2], atol=1e-12)


def test_the_drag_of_a_fast_coast_is_not_taken_for_a_charge() -> None:
    random, time = np.random.default_rng(3), np.arange(0, 20, 0.05)
    drag = -90 * np.exp(-(time - 4) / 1.5)
    felt = np.where(time < 3, 9.8, np.where(time < 4, 260.0, np.where(time < 11.8, drag, 6.0)))
    felt = felt + random.normal(0, 0.5, time.size)
    felt[np.searchsorted(time, 11.8)] += 150.0
    push = Push(time, felt, False, "acceleration")
    found = shock(push, 4.0, 11.0)
    assert found is not None
    assert found.time == pytest.approx(11.8, abs=0.06)


@pytest.mark.parametrize("rate", [10, 50])
@pytest.mark.parametrize(
    "moved",
    [
        lambda time, rng: np.repeat(rng.normal(0, 2.0, 50), time.size // 50)[: time.size],
        lambda time, rng: 8 * np.sin(time / 3),
        lambda time, rng: np.cumsum(rng.normal(0, 0.4, time.size)),
    ],
    ids=["doors", "gusts", "weather"],
)
def test_heights_that_move_on_the_pad_are_not_a_flight(rate: int, moved: Any) -> None:
    """Pressures that differ by 48 counts, among others, are 6 m."""
    rng = np.random.default_rng(5)
    time = np.arange(0, 100, 1 / rate)
    height = moved(time, rng) + rng.normal(0, 0.3, time.size)
    assert measure((Series(time=time, altitude=height),)).notes == (NO_FLIGHT,)


def test_a_low_flight_on_a_windy_day_is_a_flight() -> None:
    rng = np.random.default_rng(6)
    time = np.arange(0, 60, 0.05)
    flown = np.clip(np.where(time < 33.4, 16 - 4.9 * (time - 31.8) ** 2, 3.5 - 2 * (time - 33.4)), 0, None)
    recorded = measure((Series(time=time, altitude=flown + 0.7 * np.sin(time / 4) + rng.normal(0, 0.2, time.size)),))
    assert recorded.figures["apogee"].value == pytest.approx(16.0, abs=3 * recorded.figures["apogee"].sd)

"""Pressure that is off for seconds: ports behind a shock in a fast climb, and a sensor or radio that holds a value."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.apogee import apogee_of
from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.burnout import Burnout
from fieldkit.analysis.channels import Heights, heights
from fieldkit.analysis.disturbed_heights import undisturbed
from fieldkit.analysis.forces import boost_event
from fieldkit.analysis.initial_guess import lagged
from fieldkit.analysis.notes import CLIPPED_NOTE, DIVES_NOTE
from fieldkit.analysis.phases import Outline, outline
from fieldkit.analysis.samples import Marks
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure, standard_density
from tests.analysis.recordings import SMALL, STEP, Logger, fly, log

PAD, SOUND = 300.0, 335.0


@cache
def fast_flight(
    thrust: float, burn: float, drag: float, fades: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], height [m], speed [m/s] and specific force [m/s^2] of a vertical flight with a parachute at apogee;
    thrust [m/s^2] and the fraction of it by which it fades, burn [s], and drag area per mass [m^2/kg], which rises
    around Mach 1."""
    step, rows = 0.005, []
    time, height, speed = -3.0, 0.0, 0.0
    while height >= 0 or time < burn:
        air = float(standard_density(np.array([height + PAD]))[0])
        sonic = 1 + 0.8 * np.exp(-(((speed / SOUND - 1.05) / 0.15) ** 2))
        pushed = thrust * (1 + fades * (0.5 - time / burn)) if time < burn else 0.0
        felt = pushed - air / 2 * drag * sonic * speed * abs(speed) if time >= 0 else GRAVITY
        net = felt - GRAVITY if speed > 0 or time < burn else (-20 * np.sqrt(1.225 / air) - speed) / 0.5
        rows.append((time, height, speed, felt))
        time, speed, height = time + step, speed + net * step, height + speed * step
    return tuple(np.array(rows).T)  # type: ignore[return-value]


def recorded(
    *flight: np.ndarray, static: float, rate: float, shock: float = 0.0, held: tuple[float, float] = (0, 0), end: float
) -> tuple[Series, Series]:
    """What a barometer and an accelerometer record: the ports are off by a fraction of the dynamic pressure, and by
    `shock` meters near Mach 1; from `held[0]` seconds after apogee on the pressure is held for `held[1]` seconds; the
    log ends `end` seconds after apogee."""
    time, height, speed, felt = flight
    rng, top = np.random.default_rng(5), time[np.argmax(height)]
    mach = speed / SOUND
    shown = height - static * speed * np.abs(speed) / (2 * GRAVITY)
    shown -= shock * np.clip(np.minimum((mach - 0.92) / 0.05, (1.12 - mach) / 0.05), 0, 1)
    when = np.arange(time[0], min(top + end, time[-1]), 1 / rate)
    seen = np.interp(when, time, shown) + rng.normal(0, 1, when.size)
    holds = (when > top + held[0]) & (when < top + sum(held))
    seen[holds] = seen[holds][:1]
    clock = np.arange(time[0], when[-1], 0.01)
    swings = np.where(clock > top + 1, rng.normal(4, 5, clock.size), np.interp(clock, time, felt))
    return Series(when, pressure=height_pressure(seen + PAD)), Series(
        clock, felt=swings + rng.normal(0, 0.5, clock.size)
    )


def test_a_step_in_the_climb_and_the_swings_of_a_parachute_are_not_one_fault() -> None:
    """Air brakes that open raise the pressure in the bay at once; a parachute that opens shakes it for seconds."""
    time, rng = np.arange(0, 30, 0.02), np.random.default_rng(8)
    climbs = time < 15
    height = np.where(climbs, 500 - GRAVITY / 2 * (time - 10.5) ** 2, 401 - 12 * (time - 15))
    height += np.where(time > 4, -20 * np.exp(-(time - 4) / 3), 0) + rng.normal(0, np.where(climbs, 0.2, 8))
    track = Heights(time, height, True, 0.2, "barometric altitude")
    kept = undisturbed(track)
    assert np.diff(kept.time).max() < 0.5
    assert kept.time.size > 0.99 * time.size


def test_the_apogee_is_that_of_the_heights_if_a_curve_through_the_climb_misses_them() -> None:
    """Air brakes disturb the pressure in the climb but not at the top, where a parabola fits better than the curve."""
    time, rng = np.arange(0, 20, 0.02), np.random.default_rng(8)
    height = 760 - GRAVITY / 2 * (time - 15) ** 2
    track = Heights(time, height + rng.normal(0, 0.2, time.size), True, 0.2, "barometric altitude")
    seen = Outline(2.0, 4.0, 15.0, True, 0.0, 0.1, 760.0, height, False, 120.0)

    def curve(top: float, moment: float) -> Ascent:
        high, fast = top - GRAVITY / 2 * (time - moment) ** 2, -GRAVITY * (time - moment)
        drawn = [one + rng.normal(0, 0.1, (50, 1)) for one in (high, fast, 0 * time - GRAVITY)]
        return Ascent(time, high, fast, 0 * time - GRAVITY, *drawn, 0.2, 0.0, True)

    for ascent in (curve(790.0, 13.5), curve(760.1, 15.0)):
        found = apogee_of(ascent, seen, track)
        assert found is not None
        assert found[1].value == pytest.approx(760.0, abs=0.3)
        assert found[0].time == pytest.approx(15.0, abs=0.1)


@pytest.mark.parametrize("shock", [0.0, 800.0])
def test_an_accelerometer_shows_a_boost_that_static_ports_hide(shock: float) -> None:
    """Ports that show a tenth of the dynamic pressure hide 1300 m at 500 m/s: the heights rise only in the coast."""
    flight = fast_flight(170.0, 4.0, 0.0005)
    found = measure(recorded(*flight, static=0.1, rate=20, shock=shock, end=30)).figures
    assert found["apogee"].value == pytest.approx(flight[1].max(), rel=0.002)
    assert found["top_speed"].value == pytest.approx(flight[2].max(), abs=3 * found["top_speed"].sd)
    assert found["top_speed"].sd < 0.05 * found["top_speed"].value
    assert found["burn_time"].value == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("accelerometer", [True, False])
@pytest.mark.parametrize("held", [(-4.0, 1.0), (-1.5, 1.0), (-8.0, 3.0), (-5.0, 6.0)])
@pytest.mark.parametrize("end", [2.5, 8.0])
def test_a_held_pressure_hides_no_apogee(held: tuple[float, float], end: float, *, accelerometer: bool) -> None:
    """It resumes with a jump that is not a fault of its own, also where the log ends soon after it."""
    flight = fast_flight(200.0, 5.0, 0.0005)
    clocks = recorded(*flight, static=0.05, rate=20, held=held, end=end)
    apogee = measure(clocks if accelerometer else clocks[:1]).figures["apogee"]
    assert apogee.value == pytest.approx(flight[1].max(), abs=max(3 * apogee.sd, 0.002 * flight[1].max()))


def test_coarse_heights_are_not_taken_for_held_ones() -> None:
    """A barometer with steps of 1 hPa repeats most values in a slow climb, and each change is a step of 8 m."""
    time = np.arange(0, 60, 0.05)
    height = np.where(time > 5, 400 * np.sin(np.clip((time - 5) / 20, 0, np.pi)), 0.0)
    pressure = np.round(height_pressure(height + PAD) / 100) * 100
    track = heights((Series(time, pressure=pressure),))
    assert track is not None
    assert track.time.size > 0.95 * time.size


def test_a_pad_is_as_uncertain_as_the_digits_of_its_pressure() -> None:
    """With three digits a pad of 100,600 Pa is 1.01E5, and above it the steps are of 100 Pa."""
    time = np.arange(0, 60, 0.05)
    height = np.where(time > 5, 400 * np.sin(np.clip((time - 5) / 20, 0, np.pi)), 0.0)
    pressure = np.array([float(f"{one:.2e}") for one in height_pressure(height + 60.0)])
    track = heights((Series(time, pressure=pressure),))
    assert track is not None
    assert track.time.size > 0.95 * time.size
    seen = outline(track)
    assert seen is not None
    off = track.height.max() - seen.pad - 400
    assert abs(off) > 20
    assert abs(off) < 2 * seen.pad_sd < 60


@pytest.mark.parametrize(("moment", "sd"), [(3.0, 0.2), (4.4, 1.4)])
def test_a_burnout_that_contradicts_the_curve_is_uncertain_by_the_difference(moment: float, sd: float) -> None:
    """Air brakes that open at burnout change the pressure in the bay, which looks like more thrust."""
    time, rng = np.arange(0, 12, 0.02), np.random.default_rng(8)
    speed = np.where(time < 3, 35 * time, 105 - 15 * (time - 3))
    height = np.cumsum(speed) * 0.02
    drawn = [one + rng.normal(0, 0.1, (50, 1)) for one in (height, speed, np.gradient(speed, time))]
    burnout = Burnout(Marks(0.0, moment, 10.0, np.inf), 0.1, 0.0, 0.0, 105.0, 2.0, 0.0)
    ascent = Ascent(time, height, speed, np.gradient(speed, time), *drawn, 0.2, 0.1, False, 0.2, burnout=burnout)
    found = boost_event(ascent, None, 0.0, 10.0, "barometric altitude")
    assert found is not None
    assert found[0].time == pytest.approx(3.0, abs=0.1)  # thrust fades before it
    assert sd - 0.1 < found[0].sd < sd + 0.2


@pytest.mark.parametrize(("static", "fades"), [(0.03, 0.0), (-0.03, 0.0), (0.05, 1.2)])
def test_ports_that_are_off_do_not_hide_what_a_saturated_accelerometer_missed(static: float, fades: float) -> None:
    """Their error is of the dynamic pressure of the whole speed, of which the accelerometer shows a third. A climb that
    is half a second early may fit better, but both sensors have one clock."""
    flight = fast_flight(120.0, 1.6, 0.004, fades)
    barometer, accelerometer = recorded(*flight, static=static, rate=20.0, end=20.0)
    assert accelerometer.felt is not None
    clipped = replace(accelerometer, felt=np.clip(accelerometer.felt, -4 * GRAVITY, 4 * GRAVITY))
    speed = measure([barometer, clipped]).figures["top_speed"]
    assert "acceleration" in speed.source
    assert speed.sd < 5.0
    assert abs(speed.value - flight[2].max()) < 2.5 * speed.sd


@pytest.mark.parametrize("lag", [0.0, 0.25])
def test_an_accelerometer_shows_how_far_heights_behind_a_filter_are_late(lag: float) -> None:
    truth = fly(replace(SMALL, delay=9.0))
    shown = replace(truth, height=lagged(truth.height, 0.0, STEP, lag)) if lag else truth
    heights, _ = log(shown, Logger(accelerometer=100.0), np.random.default_rng(3))
    _, felt = log(truth, Logger(accelerometer=100.0), np.random.default_rng(3))
    found = measure((heights, felt)).figures
    for name in ("time_to_apogee", "coast_to_apogee", "duration"):
        assert abs(found[name].value - truth.readouts()[name]) < 3.5 * found[name].sd, name
        assert found[name].sd < 0.15, name


def test_a_boost_that_the_pressure_hides_has_no_burn_time() -> None:
    truth = fly(replace(SMALL, thrust=260.0, burn=0.5))
    off = replace(truth, height=truth.height - 0.1 * truth.speed * np.abs(truth.speed) / (2 * GRAVITY))
    assert "burn_time" in measure(log(truth, Logger(), np.random.default_rng(3))).figures
    hidden = measure(log(off, Logger(), np.random.default_rng(3)))
    assert not hidden.figures.keys() & {"burn_time", "avg_accel", "peak_accel"}
    assert DIVES_NOTE in hidden.notes
    assert hidden.figures["apogee"].value == pytest.approx(truth.height.max(), abs=3.0)


def test_an_accelerometer_that_saturates_at_both_ends_shows_no_speed() -> None:
    truth = fly(replace(SMALL, thrust=260.0, area=0.003))
    heights, felt = log(truth, Logger(accelerometer=100.0), np.random.default_rng(3))
    clipped = replace(felt, felt=np.clip(felt.felt, -3 * GRAVITY, 3 * GRAVITY))
    found = measure((heights, clipped))
    assert CLIPPED_NOTE in found.notes
    assert abs(found.figures["top_speed"].value - truth.speed.max()) < 3 * found.figures["top_speed"].sd


def test_times_by_steps_of_pressure_are_as_uncertain_as_the_steps_are_long() -> None:
    truth = fly(SMALL)
    fine, coarse = (
        measure(log(truth, Logger(noise=0.2, resolution=step), np.random.default_rng(3))).figures for step in (0.1, 8.0)
    )
    assert coarse["time_to_apogee"].sd > 0.37
    assert coarse["duration"].sd > fine["duration"].sd + 0.3
    assert abs(coarse["time_to_apogee"].value - truth.apogee_time) < 3 * coarse["time_to_apogee"].sd

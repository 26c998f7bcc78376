"""Recordings in which a sensor reports an impossible flight: it is left out with a note, and the figures remain
right."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.recorders.flights import draw
from bench.recorders.judge import read
from bench.recorders.models import Recorder
from bench.recorders.record import written
from fieldkit.analysis import NO_FLIGHT, Recorded, measure
from fieldkit.analysis.channels import Heights, Push, heights
from fieldkit.analysis.disturbed_heights import undisturbed
from fieldkit.analysis.liftoff import liftoff
from fieldkit.analysis.moved_zero import on_one_zero, without_start_up
from fieldkit.analysis.phases import Outline, outline
from fieldkit.analysis.possible import known_well, possible, widened_by_contradictions
from fieldkit.analysis.records import Figure
from fieldkit.analysis.whole_flight import flight_curve
from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure
from tests.analysis.recordings import FAST, LARGE, SMALL, Logger, Rocket, Truth, fly, log

SOUND = 335.0
HARD = Rocket(thrust=1900.0, burn=2.0, mass=4.0, area=0.0025, delay=20.0, sink=12.0)
"""Passes the speed of sound in the first second."""
flown = cache(fly)


def recording(truth: Truth, seed: int = 2, **settings: float) -> tuple[Series, ...]:
    return log(truth, Logger(start=0.0, **settings), np.random.default_rng(seed))


def misses(recorded: Recorded, truth: Truth, *names: str, sds: float = 3.0) -> list[str]:
    """The figures with an error of more than this number of standard deviations, or that are missing."""
    right = truth.readouts()
    figures = recorded.figures
    return [n for n in names if n not in figures or abs(figures[n].value - right[n]) > sds * figures[n].sd]


def shocked(truth: Truth, lowest: float, depth: float, **settings: float) -> tuple[Series, ...]:
    """A log whose pressure is too high in a range of speeds, as behind shocks. [Mach], [m]"""
    series, *others = recording(truth, **settings)
    mach = np.interp(series.time, truth.time, truth.speed, left=0, right=0) / SOUND
    fakes = depth * np.clip(np.minimum((mach - lowest) / 0.05, (1.2 - mach) / 0.05), 0, 1)
    return replace(series, altitude=series.altitude - fakes), *others


def of_bench(recorder: Recorder, seed: int, early: float = -np.inf) -> tuple[Recorded, dict[str, float]]:
    """What is measured of a flight of the recorder bench whose charge fires this long before apogee or sooner [s], and
    its truth."""
    random = np.random.default_rng(seed)
    path = next(one for one in draw(random, 30) if one.readouts().get("apogee_to_eject", np.inf) < -early)
    return read(written(path, recorder, random)), path.readouts(barometric=recorder.baro > 0)


@pytest.mark.sampled
@pytest.mark.parametrize("seed", [2, 3, 5, 6])
def test_a_parachute_that_opens_before_the_top_does_not_raise_the_apogee(seed: int) -> None:
    """Without an accelerometer only the heights show it, which leave their coast downward."""
    recorded, right = of_bench(Recorder(resolution=1.0), seed, early=0.8)
    for name in ("apogee", "time_to_apogee", "coast_to_apogee", "top_speed", "burn_time"):
        assert abs(recorded.figures[name].value - right[name]) < 3 * recorded.figures[name].sd, name


def test_thrust_that_grows_from_the_first_sample_on_is_no_pad() -> None:
    truth = flown(replace(SMALL, burn=1.6))
    series, push = recording(truth, 5, late=0.3, accelerometer=100.0)
    grows = np.where(push.time < truth.burnout, 1 + 0.5 * (push.time - 0.3), 1.0)
    lift = measure((series, replace(push, felt=push.felt * grows))).events.get("liftoff")
    assert lift is None or abs(lift.time) < 3 * lift.sd


@pytest.mark.sampled
@pytest.mark.parametrize("seed", [1, 2])
def test_a_rest_that_drift_hides_is_no_part_of_the_descent(seed: int) -> None:
    """A receiver's heights drift after landing, so the log may show none; its last part may be a rest."""
    recorded, right = of_bench(Recorder(baro=0, gps=1), seed)
    figure = recorded.figures["descent_speed"]
    assert abs(figure.value - right["descent_speed"]) < 3 * figure.sd


@pytest.mark.parametrize(("rate", "noise"), [(100.0, 1.3), (20.0, 0.5)])
@pytest.mark.parametrize("delay", [0.1, 0.4])
def test_a_charge_soon_after_burnout_leaves_the_top_speed(delay: float, rate: float, noise: float) -> None:
    """The coast before the charge is too short for its deceleration, which the parachute makes large."""
    truth = flown(Rocket(thrust=27.0, burn=1.8, mass=0.5, area=0.001, delay=delay, sink=8.0))
    recorded = measure(recording(truth, 0, rate=rate, noise=noise))
    assert not misses(recorded, truth, "top_speed", sds=2.0)
    assert recorded.figures["top_speed"].sd < 0.3 * truth.readouts()["top_speed"]


@pytest.mark.sampled
@pytest.mark.parametrize("wait", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("lowest", [0.3, 0.8])
@pytest.mark.parametrize("depth", [268.0, 600.0])
def test_shocks_near_the_speed_of_sound_are_not_taken_for_the_pad(wait: float, lowest: float, depth: float) -> None:
    truth = flown(HARD)
    recorded = measure(shocked(truth, lowest, depth, wait=wait))
    assert recorded.figures["apogee"].value == pytest.approx(truth.readouts()["apogee"], rel=0.002)
    there = [name for name in ("apogee", "top_speed", "burn_time", "coast_to_apogee") if name in recorded.figures]
    assert not misses(recorded, truth, *there)


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [HARD, FAST], ids=["hard", "fast"])
@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_shocks_do_not_move_burnout(rocket: Rocket, rate: float) -> None:
    truth = flown(rocket)
    recorded = measure(shocked(truth, 0.8, 268.0, wait=2.0, rate=rate))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "coast_to_apogee")
    assert recorded.figures["burn_time"].value == pytest.approx(truth.burnout, rel=0.15)


def test_burnout_is_that_of_a_saturated_accelerometer_if_shocks_hide_it_from_the_heights() -> None:
    truth = flown(HARD)
    heights, accelerometer = shocked(truth, 0.8, 600.0, wait=2.0, accelerometer=100.0)
    assert accelerometer.felt is not None
    recorded = measure((heights, replace(accelerometer, felt=np.minimum(accelerometer.felt, 8 * GRAVITY))))
    assert any("saturated" in note for note in recorded.notes)
    assert recorded.events["burnout"].source == "acceleration"
    assert recorded.figures["burn_time"].value == pytest.approx(truth.readouts()["burn_time"], abs=0.06)


def test_satellite_heights_are_used_through_the_speed_of_sound() -> None:
    """Shocks sit on static ports; a receiver has none."""
    truth = flown(HARD)
    (series,) = recording(truth, rate=5.0, wait=3.0)
    satellites = Series(series.time, gps_altitude_msl=series.altitude)
    speed = measure((satellites,)).figures["top_speed"]
    assert speed.value == pytest.approx(truth.readouts()["top_speed"], rel=0.04)
    assert speed.sd < 0.05 * speed.value


def test_a_log_sampled_faster_in_the_climb_than_after_it_is_measured_as_well() -> None:
    """The typical time step of such a log is that of its long descent."""
    truth = flown(LARGE)
    fast = recording(truth, rate=100.0, noise=1.0)[0]
    climbs = fast.time < truth.apogee_time + 0.2
    every = climbs | (np.arange(fast.time.size) % 20 == 0)
    assert fast.altitude is not None
    seen = outline(undisturbed(heights([Series(fast.time[every], altitude=fast.altitude[every])])))
    assert seen is not None
    assert seen.climbs == pytest.approx(truth.readouts()["top_speed"], rel=0.08)
    assert seen.fastest == pytest.approx(truth.burnout, abs=0.4)


@pytest.mark.sampled
@pytest.mark.parametrize(("begin", "lasts", "step"), [(100.0, 3.0, 3000.0), (20.0, 2.0, 3000.0), (60.0, 8.0, -400.0)])
def test_a_step_of_a_few_seconds_is_not_the_apogee(begin: float, lasts: float, step: float) -> None:
    truth = flown(LARGE)
    (series,) = recording(truth)
    wrong = (series.time > begin) & (series.time < begin + lasts)
    recorded = measure((replace(series, altitude=series.altitude + step * wrong),))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "duration")


def test_a_step_near_the_end_of_a_log_leaves_the_flight_complete() -> None:
    truth = flown(LARGE)
    (series,) = recording(truth)
    wrong = series.time > series.time[-1] - 6
    recorded = measure((replace(series, altitude=series.altitude + 3000.0 * wrong),))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")
    assert "apogee" in recorded.events


@pytest.mark.sampled
@pytest.mark.parametrize("moved", [-70.0, 40.0])
def test_a_zero_that_a_logger_moves_in_flight_changes_no_figure(moved: float) -> None:
    """Its pressures show the same flight."""
    truth = flown(SMALL)
    (series,) = recording(truth, wait=0.8)
    later = series.time > 0.3
    log_of_both = replace(series, altitude=series.altitude + moved * later, pressure=height_pressure(series.altitude))
    recorded = measure((log_of_both,))
    assert recorded.figures["apogee"].source == "pressure"
    assert not misses(recorded, truth, "apogee", "top_speed", "time_to_apogee", "duration")


def test_altitudes_corrected_for_temperature_are_not_a_moved_zero() -> None:
    (series,) = recording(flown(LARGE))
    warm = replace(series, altitude=1.08 * series.altitude, pressure=height_pressure(series.altitude))
    track = heights((warm,))
    assert track is not None
    assert track.source == "barometric altitude"


@pytest.mark.parametrize("part", [0.2, 0.3])
def test_a_bay_that_opens_in_the_boost_gives_no_boost_figures(part: float) -> None:
    """Its pressure then falls by a fraction of the dynamic pressure, and a sensor shows that as a jump of tens of
    meters."""
    truth = flown(SMALL)
    (series,) = recording(truth)
    speed = np.interp(series.time, truth.time, truth.speed, left=0, right=0)
    opened = (series.time > 0.9 * truth.burnout) & (series.time < truth.apogee_time)
    recorded = measure((replace(series, altitude=series.altitude + opened * part * speed**2 / (2 * GRAVITY)),))
    assert not {"top_speed", "burn_time", "avg_accel", "peak_accel"} & recorded.figures.keys()
    assert any("jump" in note for note in recorded.notes)
    assert not misses(recorded, truth, "apogee", "duration")


def test_the_boost_of_a_receiver_with_a_fix_per_second_is_as_uncertain_as_its_samples() -> None:
    """They show the fastest climb only to a second, so burnout may be that far from it."""
    truth = fly(replace(SMALL, burn=1.5, thrust=40.0))
    random = np.random.default_rng(4)
    burns = []
    for phase in np.linspace(0, 0.8, 5):
        time = np.arange(-3.0 + phase, truth.time[-1] + 8)
        height = np.interp(time, truth.time, truth.height, left=0.0, right=0.0) + truth.elevation
        recorded = measure((Series(time, gps_altitude_msl=height + random.normal(0, 0.3, time.size)),))
        if "burn_time" in recorded.figures:
            assert not misses(recorded, truth, "burn_time", "coast_to_apogee", "top_speed", sds=1.0)
            burns.append(recorded.figures["burn_time"].value)
    assert len(burns) >= 3


def test_motion_of_a_rocket_is_not_taken_for_a_step() -> None:
    for rocket in (SMALL, LARGE, FAST, HARD):
        (series,) = recording(flown(rocket), rate=50.0)
        track = Heights(series.time, series.altitude, True, 0.4, "barometric altitude")
        assert undisturbed(track) == track


@pytest.mark.sampled
@pytest.mark.parametrize("begins", [-8.0, -6.0, -4.0, -2.0, -1.0])
@pytest.mark.parametrize("seed", [2, 3])
def test_an_apogee_in_a_radio_gap_has_an_interval(begins: float, seed: int) -> None:
    truth = flown(LARGE)
    (series,) = recording(truth, rate=10.0, seed=seed)
    heard = ~((series.time > truth.apogee_time + begins) & (series.time < truth.apogee_time + begins + 12))
    recorded = measure((Series(time=series.time[heard], altitude=series.altitude[heard]),))
    assert not misses(recorded, truth, "apogee", "time_to_apogee", "descent_speed", sds=2.5)
    (note,) = [note for note in recorded.notes if "apogee is in a gap" in note]
    low, high = (float(word) for word in note.replace(",", "").split() if word.isdigit() and int(word) > 100)
    assert low - 5 < truth.readouts()["apogee"] < high + 5


@pytest.mark.sampled
@pytest.mark.parametrize("accelerometer", [0.0, 10.0])
@pytest.mark.parametrize("begins", [0.3, 0.6, 0.9])
def test_a_radio_gap_from_boost_to_descent_does_not_bound_the_apogee(begins: float, accelerometer: float) -> None:
    truth = flown(LARGE)
    clocks = recording(truth, rate=10.0, accelerometer=accelerometer)
    gap = (begins * truth.burnout, truth.apogee_time + 2)
    recorded = measure([series_without(series, *gap) for series in clocks])
    assert not {"apogee", "top_speed", "burn_time", "avg_accel", "coast_to_apogee"} & recorded.figures.keys()
    assert not misses(recorded, truth, "duration")
    assert any("begins in the boost and ends after apogee" in note for note in recorded.notes)


@pytest.mark.parametrize("accelerometer", [0.0, 10.0])
def test_a_radio_gap_from_the_boost_on_gives_no_boost_figures(accelerometer: float) -> None:
    truth = flown(LARGE)
    clocks = recording(truth, rate=10.0, accelerometer=accelerometer)
    gap = (0.6 * truth.burnout, 0.6 * truth.burnout + 3.5)
    recorded = measure([series_without(series, *gap) for series in clocks])
    assert not misses(recorded, truth, "apogee", "duration")
    assert not {"top_speed", "burn_time", "avg_accel", "peak_accel"} & recorded.figures.keys()


@pytest.mark.parametrize("seed", [2, 3])
def test_a_radio_gap_from_boost_to_near_the_top_leaves_the_apogee(seed: int) -> None:
    """Two seconds of coast near the top do not show how fast it began, nor does a boost cut short show a lag."""
    truth = flown(SMALL)
    clocks = recording(truth, rate=10.0, seed=seed)
    recorded = measure([series_without(series, 0.5 * truth.burnout, truth.apogee_time - 2) for series in clocks])
    assert not misses(recorded, truth, "apogee", "time_to_apogee", "descent_speed", "duration")


@pytest.mark.parametrize("static", [-0.04, 0.04])
def test_the_interval_of_an_apogee_in_a_gap_allows_for_static_ports(static: float) -> None:
    truth = flown(LARGE)
    (series,) = recording(truth, rate=10.0)
    speed = np.interp(series.time, truth.time, truth.speed, left=0, right=0)
    heard = (series.time < truth.apogee_time - 7) | (series.time > truth.apogee_time + 8)
    assert series.altitude is not None
    altitude = series.altitude - static * speed * np.abs(speed) / (2 * GRAVITY)
    notes = measure((Series(time=series.time[heard], altitude=altitude[heard]),)).notes
    (note,) = [note for note in notes if "apogee is in a gap" in note]
    low, high = (float(word) for word in note.replace(",", "").split() if word.isdigit() and int(word) > 100)
    free = float(np.interp(truth.apogee_time - 7, truth.time, truth.speed)) ** 2 / (2 * GRAVITY)
    assert low < truth.height.max() < high
    assert high > float(np.interp(truth.apogee_time - 7, truth.time, truth.height)) + free


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE, HARD], ids=["small", "large", "hard"])
@pytest.mark.parametrize("before", [0.6, 1.2])
def test_a_radio_gap_that_ends_while_the_rocket_still_rises_leaves_the_apogee(rocket: Rocket, before: float) -> None:
    truth = flown(rocket)
    (series,) = recording(truth, rate=10.0)
    heard = (series.time < 0.9 * truth.burnout) | (series.time > truth.apogee_time - before)
    assert series.altitude is not None
    recorded = measure((Series(time=series.time[heard], altitude=series.altitude[heard]),))
    assert not misses(recorded, truth, "apogee", "time_to_apogee")
    assert recorded.figures["apogee"].sd < 1.0


def test_thrust_from_the_first_sample_on_gives_no_later_lift_off() -> None:
    """A pressure error in proportion to the dynamic pressure keeps the first heights of the boost near the pad."""
    truth = flown(HARD)
    barometer, felt = (series_without(one, -np.inf, 0.15) for one in recording(truth, accelerometer=100.0, wait=0.0))
    speed = np.interp(barometer.time, truth.time, truth.speed) * (barometer.time < truth.burnout)
    recorded = measure((replace(barometer, altitude=barometer.altitude - 0.03 * speed**2 / (2 * GRAVITY)), felt))
    assert "liftoff" not in recorded.events or recorded.events["liftoff"].time <= 0.15


def lowered(truth: Truth, static: float, **settings: float) -> tuple[Series, ...]:
    """A log whose static ports lower the heights by a fraction of the dynamic pressure. [1]"""
    series, *others = recording(truth, **settings)
    speed = np.interp(series.time, truth.time, truth.speed, left=0, right=0)
    return replace(series, altitude=series.altitude - static * speed * np.abs(speed) / (2 * GRAVITY)), *others


@pytest.mark.parametrize("static", [-0.08, 0.08])
def test_biased_ports_move_neither_speed_nor_burnout_of_an_accelerometer(static: float) -> None:
    truth = flown(SMALL)
    recorded = measure(lowered(truth, static, accelerometer=100.0, rate=50.0))
    assert not misses(recorded, truth, "top_speed", "burn_time", "avg_accel", sds=2.5)
    assert recorded.figures["top_speed"].value == pytest.approx(truth.readouts()["top_speed"], rel=0.03)


@pytest.mark.parametrize(("lift", "fastest"), [(3.7, 4.9), (2.2, 5.9)], ids=["hidden by ports", "a height a second"])
def test_lift_off_is_by_the_accelerometer_if_heights_show_the_boost_at_another_time(
    lift: float, fastest: float
) -> None:
    time = np.arange(0, 8, 0.01)
    felt = np.where((time > 3) & (time < 4), 100.0, np.where(time > 4, -20.0, GRAVITY))
    push = Push(time, felt + np.random.default_rng(1).normal(0, 2, time.size), False, "acceleration", True)
    clock = np.arange(0, 12, 0.05)
    track = Heights(clock, np.where(clock > lift, 100 * (clock - lift), 0.0), True, 0.4, "barometric altitude")
    seen = Outline(lift, fastest, 12.0, True, 0.0, 0.1, 500.0, track.height, False, 100.0)
    found = liftoff(track, push, seen)
    assert found is not None
    assert found.time == pytest.approx(3.0, abs=0.02)


def test_burnout_by_an_accelerometer_with_few_samples_is_not_late() -> None:
    """A curve through samples a tenth of a second apart spreads the end of a strong thrust over two of them."""
    truth = flown(Rocket(thrust=120.0, burn=0.9))
    recorded = measure(recording(truth, accelerometer=10.0, rate=10.0))
    assert recorded.figures["burn_time"].value == pytest.approx(truth.readouts()["burn_time"], abs=0.06)


@pytest.mark.parametrize(("rate", "most"), [(20.0, 0.01), (50.0, 0.003)])
def test_top_speed_by_an_accelerometer_with_few_samples_is_not_low(rate: float, most: float) -> None:
    """A curve through them rounds the corner of the speed at a sudden burnout."""
    truths = [
        flown(Rocket(thrust=thrust, burn=burn)) for thrust, burn in ((90, 0.9), (110, 1.13), (130, 0.77), (120, 1))
    ]
    exact = {"accelerometer": rate, "rate": rate, "scale": 1.0, "bias": 0.0}
    top = [measure(recording(one, **exact)).figures["top_speed"] for one in truths]
    off = [found.value / one.readouts()["top_speed"] - 1 for found, one in zip(top, truths, strict=True)]
    assert abs(float(np.mean(off))) < most


def test_a_peak_before_the_first_sample_of_an_accelerometer_is_not_measured() -> None:
    truth = flown(LARGE)
    barometer, felt = (series_without(one, -np.inf, 0.2) for one in recording(truth, accelerometer=100.0, wait=0.0))
    recorded = measure((barometer, replace(felt, felt=felt.felt * np.where(felt.time < 0.4, 0.95, 1.0))))
    assert recorded.events["liftoff"].time < 0.2
    assert "peak_accel" not in recorded.figures


@pytest.mark.parametrize("turn", [-1.0, 1.0])
def test_drift_of_a_receiver_after_landing_is_not_a_descent(turn: float) -> None:
    truth = flown(LARGE)
    (series,) = recording(truth, rate=5.0, noise=0.5)
    landed = float(truth.time[-1])
    time = np.append(series.time[series.time < landed], landed + 0.2 * np.arange(60))
    assert series.altitude is not None
    rest = np.interp(time, [landed + 2, landed + 6, landed + 7, landed + 11], [0.0, 5.0 * turn, 5.0 * turn, 0.0])
    height = np.interp(time, series.time, series.altitude) + rest
    recorded = measure((Series(time=time, gps_altitude_msl=height + 200),))
    assert not misses(recorded, truth, "duration", "descent_speed")


def series_without(series: Series, begin: float, end: float) -> Series:
    """A series without the samples between two times. [s]"""
    there = (series.time <= begin) | (series.time >= end)
    channels = {name: getattr(series, name) for name in series.__slots__}
    return Series(**{name: None if values is None else values[there] for name, values in channels.items()})


@pytest.mark.sampled
@pytest.mark.parametrize("factor", [0.3, 0.5, 1.5, 3.0])
def test_of_an_accelerometer_with_a_wrong_scale_only_the_clock_is_used(factor: float) -> None:
    truth = flown(LARGE)
    barometer, felt = recording(truth, accelerometer=100.0)
    recorded = measure((barometer, replace(felt, felt=GRAVITY + factor * (felt.felt - GRAVITY))))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "peak_accel")
    assert any("of the climb that the heights show" in note for note in recorded.notes)
    assert "acceleration" not in recorded.figures["top_speed"].source
    if factor == 0.3:  # too far off to be sure that it is the axis of the rocket
        return
    assert recorded.events["liftoff"].source == "acceleration"
    assert recorded.figures["burn_time"].value == pytest.approx(truth.readouts()["burn_time"], abs=0.05)


def test_an_acceleration_across_the_axis_shows_no_lift_off() -> None:
    truth = flown(LARGE)
    barometer, felt = recording(truth, accelerometer=100.0)
    recorded = measure((barometer, replace(felt, felt=np.random.default_rng(3).normal(0, 4, felt.time.size))))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")
    assert recorded.events["liftoff"].source == "barometric altitude"


@pytest.mark.parametrize("wait", [0.2, 0.3, 0.6])
@pytest.mark.parametrize("static", [0.1, -0.1])
@pytest.mark.parametrize("burn", [1.2, 4.0])
def test_lift_off_is_by_the_accelerometer_however_little_of_the_pad_a_log_has(
    wait: float, static: float, burn: float
) -> None:
    """Ports hide the boost from the heights, which then rise late or from the first sample on."""
    truth = flown(replace(LARGE, thrust=1400.0, burn=burn))
    wrong = replace(truth, height=truth.height - static * truth.speed * abs(truth.speed) / (2 * GRAVITY))
    clocks = log(wrong, Logger(start=0.0, accelerometer=100.0, rate=100.0, wait=wait), np.random.default_rng(2))
    recorded = measure(clocks)
    assert recorded.events["liftoff"].source == "acceleration"
    assert recorded.events["liftoff"].time == pytest.approx(0.0, abs=0.03)


def test_an_accelerometer_with_a_late_clock_is_not_used() -> None:
    truth = flown(LARGE)
    barometer, felt = recording(truth, accelerometer=100.0)
    recorded = measure((barometer, replace(felt, time=felt.time + 1.6)))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "time_to_apogee")
    assert any(" s late" in note for note in recorded.notes)


@pytest.mark.thorough
def test_an_accelerometer_is_used_in_a_tilted_flight_but_not_with_air_brakes() -> None:
    """The flight is 22 degrees off vertical; for two seconds of the coast the pressures are those of 150 m lower."""
    random = np.random.default_rng(11)
    for path in draw(random, 3, launch_angle=float(np.radians(22))):
        right = path.readouts()
        found = open_log(written(path, Recorder(baro=50, accel=100, static=0.02), random), "log", None).found
        (series,) = next(item for item in found if isinstance(item, Reading)).clocks
        start = series.time[0] + 3.0  # of the pad
        low = (series.time > start + right["burn_time"] + 0.3) & (series.time < start + right["burn_time"] + 2.3)
        recorded = measure((replace(series, altitude=series.altitude - 150.0 * low),))
        burn = recorded.figures["burn_time"]
        assert burn.value == pytest.approx(right["burn_time"], abs=max(0.15, 2 * burn.sd))
        assert recorded.figures["top_speed"].value == pytest.approx(right["top_speed"], rel=0.08)
        assert recorded.figures["apogee"].value == pytest.approx(right["apogee"], rel=0.01)


@pytest.mark.parametrize("lag", [0.15, 0.3])
def test_heights_after_a_filter_are_treated_as_late(lag: float) -> None:
    truth = flown(LARGE)
    barometer, felt = recording(truth, accelerometer=100.0)
    recorded = measure((replace(barometer, time=barometer.time + lag), felt))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "time_to_apogee", "coast_to_apogee")


def delayed(values: np.ndarray, step: float, over: float) -> np.ndarray:
    """Values through a filter that delays them."""
    out = np.zeros_like(values)
    for place in range(1, values.size):
        out[place] = out[place - 1] + step / over * (values[place] - out[place - 1])
    return out


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE], ids=["small", "large"])
def test_accelerations_derived_from_pressure_are_not_an_accelerometer(rocket: Rocket) -> None:
    truth = flown(rocket)
    (series,) = recording(truth)
    speed = delayed(np.gradient(series.altitude, series.time), 0.05, 0.3)
    derived = delayed(np.gradient(speed, series.time), 0.05, 0.3)
    recorded = measure((replace(series, speed=speed, acceleration=derived),))
    assert not misses(recorded, truth, "burn_time", "top_speed", "peak_accel")
    assert abs(recorded.events["liftoff"].time) < 3 * recorded.events["liftoff"].sd


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE, FAST], ids=["small", "large", "fast"])
@pytest.mark.parametrize("scale", [0.95, 1.05])
def test_an_accelerometer_with_a_small_error_is_used(rocket: Rocket, scale: float) -> None:
    recorded = measure(recording(flown(rocket), accelerometer=100.0, scale=scale))
    assert "acceleration" in recorded.figures["top_speed"].source
    assert not any("not used" in note for note in recorded.notes)


@pytest.mark.parametrize("shape", [lambda t: np.clip(6 * (t - 30), 0, 60), lambda t: np.clip(6 * (t - 30), 0, 400)])
def test_an_elevator_ride_is_not_a_flight(shape: object) -> None:
    time = np.arange(0, 120, 0.1)
    height = shape(time) + np.random.default_rng(3).normal(0, 0.3, time.size)  # type: ignore[operator]
    assert measure((Series(time=time, altitude=height),)) == Recorded(notes=(NO_FLIGHT,))


def figures(**values: tuple[float, float]) -> dict[str, Figure]:
    return {name: Figure(value, sd, "acceleration") for name, (value, sd) in values.items()}


@pytest.mark.parametrize(
    "impossible",
    [
        figures(burn_time=(0.5, 0.03), avg_accel=(200.0, 3.0), peak_accel=(150.0, 3.0), apogee=(300.0, 1.0)),
        figures(burn_time=(0.17, 0.03), avg_accel=(1500.0, 90.0), peak_accel=(3364.0, 60.0), apogee=(300.0, 1.0)),
    ],
    ids=["average above peak", "343 g"],
)
def test_impossible_readouts_are_named_and_not_stored(impossible: dict[str, Figure]) -> None:
    kept, notes = possible(impossible)
    assert kept.keys() == {"apogee"}
    (note,) = notes
    assert note.startswith("not measured: burn time, average acceleration, peak acceleration; ")


def test_an_average_above_the_peak_by_no_more_than_their_errors_is_below_it() -> None:
    """The moments of a million draws, of which those with the average above the peak are dropped."""
    close = figures(burn_time=(0.5, 0.03), avg_accel=(155.0, 9.0), peak_accel=(150.0, 3.0))
    kept, notes = possible(close)
    draws = np.random.default_rng(1).normal([155.0, 150.0], [9.0, 3.0], (1_000_000, 2))
    right = draws[draws[:, 0] < draws[:, 1]]
    assert not notes
    assert kept["burn_time"] == close["burn_time"]
    for name, mean, sd in zip(("avg_accel", "peak_accel"), right.mean(axis=0), right.std(axis=0), strict=True):
        assert kept[name].value == pytest.approx(mean, abs=0.05)
        assert kept[name].sd == pytest.approx(sd, abs=0.05)


@pytest.mark.parametrize(("stated", "doubt"), [(300.5, False), (306.0, False), (240.0, True), (600.0, True)])
def test_a_different_stated_apogee_increases_the_uncertainty(stated: float, doubt: bool) -> None:
    recorded = Recorded(figures=figures(apogee=(300.0, 1.0), duration=(50.0, 1.0)))
    found = widened_by_contradictions(recorded, {"apogee": stated, "notes": "windy"})
    assert found.figures["apogee"].value == 300.0
    assert found.figures["apogee"].sd >= (abs(stated - 300) / 2 if doubt else 1.0)
    assert (found.figures["apogee"].sd > 1.0) is doubt
    assert any("the device states" in note for note in found.notes) is doubt
    assert found.figures["duration"] == recorded.figures["duration"]


def beside_satellites(truth: Truth, static: float, *, warm: float = 1.0) -> tuple[Series, ...]:
    """A log with a pressure error that is a fraction of the dynamic pressure, and a receiver's heights, 0.2 s late."""
    series, *_ = recording(truth)
    speed = np.interp(series.time, truth.time, truth.speed, left=0, right=0)
    assert series.altitude is not None
    wrong = replace(series, altitude=series.altitude - static * speed * np.abs(speed) / (2 * GRAVITY))
    rng = np.random.default_rng(9)
    when = np.arange(series.time[0], series.time[-1], 0.2)
    seen = warm * np.interp(when - 0.2, truth.time, truth.height, left=0, right=0)
    seen += 1400 + rng.normal(0, 0.5, when.size) + np.cumsum(rng.normal(0, 0.1, when.size))
    return wrong, Series(time=when, gps_altitude_msl=seen)


@pytest.mark.parametrize(("static", "most"), [(-0.04, 0.2), (0.0, 0.07), (0.04, 0.07)])
def test_errors_of_ports_at_burnout_and_in_the_coast_nearly_cancel_in_a_top_speed(static: float, most: float) -> None:
    """Ports that lower heights make the coast faster, but burnout later, where the coast has lost as much."""
    truth = flown(SMALL)
    found = measure(beside_satellites(truth, static)[:1]).figures["top_speed"]
    assert abs(found.value - truth.readouts()["top_speed"]) < 2 * found.sd
    assert found.sd < most * found.value


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [LARGE, FAST], ids=["large", "fast"])
@pytest.mark.parametrize("static", [-0.04, 0.0, 0.04])
def test_satellite_heights_reduce_the_uncertainty_of_a_fast_flights_speed(rocket: Rocket, static: float) -> None:
    """Unless pressure alone shows the speed within four percent."""
    truth = flown(rocket)
    alone, both = beside_satellites(truth, static)[:1], beside_satellites(truth, static)
    before, after = measure(alone).figures["top_speed"], measure(both).figures["top_speed"]
    right = truth.readouts()["top_speed"]
    assert after.sd < max(0.6 * before.sd, 0.04 * right)
    assert abs(after.value - right) < 2 * after.sd
    assert rocket is LARGE or after.source == "barometric altitude and GPS altitude"
    assert not misses(measure(both), truth, "apogee", "time_to_apogee")


def test_satellite_heights_of_another_flight_change_no_figure() -> None:
    series, receiver = beside_satellites(flown(LARGE), 0.0)
    assert receiver.gps_altitude_msl is not None
    other = replace(receiver, gps_altitude_msl=1400 + 3 * (receiver.gps_altitude_msl - 1400))
    still = replace(receiver, gps_altitude_msl=np.full(receiver.time.size, 1400.0))
    expected = measure((series,)).figures
    for wrong in (other, still):
        assert measure((series, wrong)).figures == expected


def test_on_a_warm_day_heights_refer_to_the_standard_atmosphere_despite_satellites() -> None:
    truth = flown(LARGE)
    recorded = measure(beside_satellites(truth, 0.0, warm=1.06))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")


def test_zeros_between_samples_of_a_slow_sensor_are_not_heights() -> None:
    truth = flown(SMALL)
    series, *_ = recording(truth, wait=2.0)
    time = np.arange(series.time[0], series.time[-1], 0.01)
    slow = np.arange(time.size) % 10 == 0
    height = np.where(slow, np.interp(time, series.time, series.altitude), 0.0)
    recorded = measure((Series(time=time, altitude=height),))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")


@pytest.mark.sampled
@pytest.mark.parametrize("late", [0.15, 0.25])
def test_a_computed_acceleration_with_a_delay_is_left_out(late: float) -> None:
    truth = flown(SMALL)
    series, *_ = recording(truth, wait=2.0)
    slowed = np.interp(series.time - late, truth.time, truth.acceleration, left=0.0, right=0.0)
    width = np.ones(9) / 9
    derived = np.convolve(np.where(series.time > truth.ejection, 0.0, slowed), width, "same")
    recorded = measure((replace(series, acceleration=derived),))
    assert any(" s late" in note for note in recorded.notes)
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "avg_accel")


@pytest.mark.sampled
@pytest.mark.parametrize("wait", [0.1, 0.3, 2.0])
def test_a_computed_acceleration_that_is_smoothed_without_delay_is_left_out(wait: float) -> None:
    truth = flown(SMALL)
    series, *_ = recording(truth, seed=3, wait=wait, rate=10.0)
    falls = np.where(truth.time > truth.ejection, 0.0, truth.acceleration)
    smooth = np.convolve(np.interp(series.time, truth.time, falls, left=0.0, right=0.0), np.ones(9) / 9, "same")
    recorded = measure((replace(series, acceleration=smooth),))
    assert any("was computed" in note for note in recorded.notes)
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")
    assert recorded.figures["top_speed"].source == "barometric altitude"


@pytest.mark.parametrize("coast", [0.8, 1.8])
def test_lift_off_of_two_stages_is_by_the_first(coast: float) -> None:
    burns, step, lift = (1.2, 2.0), 0.01, 3.0
    time = np.arange(0.0, 90.0, step)
    flies = time - lift
    second = burns[0] + coast
    thrust = (flies >= 0) & (flies < burns[0]) | (flies >= second) & (flies < second + burns[1])
    net = np.where(flies < 0, 0.0, np.where(thrust, 70.0, -12.0))
    speed = np.maximum(np.cumsum(net) * step, np.where(flies < 0, 0.0, -12.0))
    height = np.maximum(np.cumsum(speed) * step, 0.0) + np.random.default_rng(1).normal(0, 0.4, time.size)
    recorded = measure((Series(time=time, altitude=height, felt=net + GRAVITY),))
    assert recorded.events["liftoff"].time == pytest.approx(lift, abs=0.1)
    assert recorded.figures["burn_time"].value == pytest.approx(second + burns[1], abs=0.1)


def test_an_accelerometer_whose_integral_passes_apogee_is_not_used() -> None:
    truth = flown(LARGE)
    series, *_ = recording(truth, wait=2.0)
    there = series.time > 0.4
    time = series.time[there]
    felt = np.interp(time, truth.time, truth.felt, left=GRAVITY, right=GRAVITY) + 2.0 * GRAVITY
    assert series.altitude is not None
    recorded = measure((Series(time=time, altitude=series.altitude[there], felt=felt),))
    assert recorded.figures["apogee"].value == pytest.approx(truth.readouts()["apogee"], rel=0.01)


@pytest.mark.thorough
def test_a_drone_flight_is_not_a_rocket_flight() -> None:
    time = np.arange(0.0, 200.0, 0.1)
    climb = np.interp(time, [0, 10, 25, 100, 130, 200], [0, 0, 110, 112, 0, 0])
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(0, 0.4, time.size)
        assert measure((Series(time=time, altitude=climb + noise),)).notes == (NO_FLIGHT,)


def test_a_readout_with_a_standard_deviation_above_half_its_value_is_not_stored() -> None:
    figures = {"peak_accel": Figure(300.0, 160.0, "pressure"), "burn_time": Figure(1.0, 0.2, "pressure")}
    known, notes = known_well(figures)
    assert known.keys() == {"burn_time"}
    assert "peak acceleration" in notes[0]


def test_a_complete_flight_is_plotted_from_lift_off_to_landing() -> None:
    truth = flown(SMALL)
    recorded = measure(recording(truth, wait=2.0))
    curve = flight_curve(recorded)
    assert curve is not None
    assert curve.from_liftoff
    assert curve.time[0] == pytest.approx(-1.0, abs=0.2)
    assert curve.time[-1] == pytest.approx(curve.events["landing"] + 1, abs=0.5)
    height, speed, acceleration = curve.at(curve.events["apogee"])
    assert height == pytest.approx(truth.readouts()["apogee"], rel=0.01)
    assert abs(speed) < 2
    assert acceleration == pytest.approx(-GRAVITY, abs=5)  # a parachute is open since 0.9 s
    sinks = curve.speed[(curve.time > curve.events["landing"] - 10) & (curve.time < curve.events["landing"] - 3)]
    assert sinks.mean() == pytest.approx(-recorded.figures["descent_speed"].value, rel=0.2)


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [HARD, FAST], ids=["hard", "fast"])
@pytest.mark.parametrize("late", [0.02, 0.05, 0.1])
def test_a_filtered_vertical_acceleration_is_used_if_the_boost_is_much_longer_than_its_delay(
    rocket: Rocket, late: float
) -> None:
    """A device's own filter delays its acceleration and deforms its heights near the speed of sound."""
    truth = flown(rocket)
    series, *_ = recording(truth, wait=2.0, rate=100.0)
    mach = np.interp(series.time, truth.time, truth.speed, left=0, right=0) / SOUND
    fakes = 120.0 * np.clip(np.minimum((mach - 0.8) / 0.05, (1.2 - mach) / 0.05), 0, 1)
    vertical = np.interp(series.time, truth.time, truth.acceleration, left=0.0, right=0.0)
    vertical[series.time > truth.ejection] = 0.0
    heights = series.altitude - delayed(fakes, 0.01, 2.0)
    recorded = measure((replace(series, altitude=heights, acceleration=delayed(vertical, 0.01, late)),))
    assert not any("not used" in note for note in recorded.notes)
    assert not misses(recorded, truth, "burn_time", "top_speed", "peak_accel", "coast_to_apogee", sds=2.5)
    assert recorded.figures["top_speed"].sd < 0.04 * truth.readouts()["top_speed"]


def test_a_second_accelerometer_is_used_if_the_first_one_contradicts_the_heights() -> None:
    """The samples of a high rate whose rows were mixed up, beside the good speed of a low rate."""
    truth = flown(LARGE)
    barometer, felt = recording(truth, accelerometer=100.0)
    assert felt.felt is not None
    mixed = replace(felt, felt=np.roll(felt.felt, felt.felt.size // 3))
    speed = np.interp(barometer.time, truth.time, truth.speed, left=0.0, right=0.0)
    recorded = measure((replace(barometer, inertial_speed=speed), mixed))
    assert recorded.figures["top_speed"].source == "barometric altitude and inertial speed"
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time")
    assert any("the inertial speed is used instead" in note for note in recorded.notes)


def test_a_log_that_begins_in_the_coast_has_no_liftoff() -> None:
    """An accelerometer rises there too, as the drag falls."""
    truth = flown(LARGE)
    recorded = measure(recording(truth, wait=-truth.burnout - 0.3, accelerometer=25.0))
    assert "liftoff" not in recorded.events
    assert not recorded.figures.keys() & {"time_to_apogee", "burn_time", "peak_accel", "duration"}
    assert not misses(recorded, truth, "apogee")


def test_a_step_that_leaves_the_levels_at_rest_as_they_were_sets_no_zero() -> None:
    time = np.arange(0.0, 30.0, 0.005)
    height = np.interp(time, [5.0, 8.0, 25.0], [0.0, 150.0, 0.0]) + np.where((time > 7.5) & (time < 8.5), 6.0, 0.0)
    np.testing.assert_array_equal(on_one_zero(time, height), height)
    zeroed = np.where(time < 5.5, height + 40.0, height)
    assert np.ptp(on_one_zero(time, zeroed)[time < 5.0]) < 1e-6
    assert on_one_zero(time, zeroed)[0] == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("offset", [-38.0, -20.0, 25.0])
def test_a_zero_that_is_set_at_lift_off_is_found_by_the_levels_at_rest(offset: float) -> None:
    """A step that is no faster than a rocket, but beside the curve through the heights around it."""
    truth = flown(SMALL)
    (series,) = recording(truth)
    assert series.altitude is not None
    moved = np.where(series.time > 0.3, series.altitude, series.altitude - offset)
    recorded = measure((replace(series, altitude=moved),))
    assert recorded.figures["apogee"].value == pytest.approx(truth.readouts()["apogee"], abs=1.5)
    assert not misses(recorded, truth, "time_to_apogee", "burn_time")


@pytest.mark.parametrize("name", ["altitude_msl", "gps_altitude_msl"])
@pytest.mark.parametrize("count", [1, 5, 30])
@pytest.mark.parametrize("value", [0.0, 44_000.0])
def test_what_a_sensor_returns_before_it_works_is_no_pad(name: str, count: int, value: float) -> None:
    """A receiver without a fix writes zero, then heights above the sea."""
    truth = flown(SMALL)
    series, *_ = recording(truth)
    assert series.altitude is not None
    heights_above_sea = np.where(np.arange(series.time.size) < count, value, series.altitude + 310.0)
    recorded = measure((replace(series, altitude=None, **{name: heights_above_sea}),))
    assert not misses(recorded, truth, "apogee", "time_to_apogee", sds=4.0)


@pytest.mark.parametrize("lag", [0.05, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("rate", [25.0, 100.0])
def test_an_accelerometer_behind_a_filter_moves_no_burnout(lag: float, rate: float) -> None:
    """Its figures are uncertain by the filter, or from the heights alone with a note."""
    truth = flown(SMALL)
    series, push = recording(truth, accelerometer=rate)
    assert push.felt is not None
    recorded = measure((series, replace(push, felt=GRAVITY + delayed(push.felt - GRAVITY, 1 / rate, lag))))
    assert not misses(recorded, truth, "apogee", "top_speed", "burn_time", "avg_accel", "peak_accel")
    assert lag < 0.2 or any("it is not used" in note for note in recorded.notes)


@pytest.mark.parametrize("rate", [25.0, 100.0])
@pytest.mark.parametrize("vibration", [10.0, 20.0])
def test_the_vibration_of_a_motor_does_not_raise_the_peak(rate: float, vibration: float) -> None:
    truth = flown(LARGE)
    series, push = recording(truth, accelerometer=rate)
    assert push.felt is not None
    burns = (push.time > 0) & (push.time < truth.burnout)
    shaken = push.felt + burns * np.random.default_rng(4).normal(0, vibration, push.time.size)
    assert not misses(measure((series, replace(push, felt=shaken))), truth, "peak_accel", "top_speed", "burn_time")


def test_a_shock_under_a_parachute_is_no_ejection() -> None:
    """The charge was over between two samples, and a line went taut seconds later."""
    truth = flown(replace(SMALL, delay=8.3))
    series, push = recording(truth, accelerometer=25.0)
    assert push.felt is not None
    late = truth.readouts()["time_to_apogee"] + 3.5
    quiet = np.where((push.time > truth.burnout + 0.7) & (push.time < late), np.minimum(push.felt, GRAVITY), push.felt)
    felt = np.where(np.abs(push.time - late) < 0.021, 150.0, quiet)
    recorded = measure((series, replace(push, felt=felt)))
    assert "apogee_to_eject" not in recorded.figures or not misses(recorded, truth, "apogee_to_eject")


def test_heights_that_a_coarse_sensor_holds_are_not_what_it_returns_before_it_works() -> None:
    time = np.arange(0.0, 20.0, 0.05)
    drifts = np.where(time < 3.0, 0.0, 40.0) + 40.0 * np.floor(np.interp(time, [8.0, 12.0, 18.0], [0.0, 5.0, 0.0]))
    np.testing.assert_array_equal(without_start_up(time, drifts, 40.0), drifts)

"""The speeds under a drogue and a main, and where the main opened: both measured, and neither invented."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.records import Recorded
from fieldkit.flight import Series
from fieldkit.importing.read import read
from fieldkit.shapes import Array
from tests.analysis.recordings import LARGE, SMALL, Logger, Rocket, fly, log
from tests.analysis.test_real_logs import LOGS, flown

pytestmark = pytest.mark.fast
SAMPLES = Path(__file__).parents[2] / "sample_logs"
DUAL = replace(LARGE, delay=16.0, sink=22.0, main_sink=5.0, main_height=200.0)
TRUTH = fly(DUAL)
BARO = Logger(start=0.0, rate=10.0)


def of(truth: object, logger: Logger = BARO, seed: int = 6) -> Recorded:
    return measure(log(truth, logger, np.random.default_rng(seed)))  # type: ignore[arg-type]


def assert_two(recorded: Recorded, drogue: float, main: float, height: float) -> None:
    """`drogue` and `main` are the speeds of each device alone; below its release the main is helped by the drogue."""
    together = 1 / np.hypot(1 / drogue, 1 / main)
    for name, right in {"drogue_speed": drogue, "descent_speed": together, "main_altitude": height}.items():
        figure = recorded.figures[name]
        assert abs(figure.value - right) < max(3 * figure.sd, 0.03 * right), name
        assert figure.sd < 0.15 * right, name


@pytest.mark.sampled
@pytest.mark.parametrize(
    "logger",
    [
        BARO,
        replace(BARO, rate=1.0),
        replace(BARO, noise=1.5),
        replace(BARO, channel="pressure", rate=50.0),
        replace(BARO, spikes=0.01),
        replace(BARO, accelerometer=100.0),
    ],
    ids=["10 Hz", "1 Hz", "noisy", "pressure 50 Hz", "spikes", "with accelerometer"],
)
def test_drogue_speed_main_speed_and_release_of_the_main_are_measured(logger: Logger) -> None:
    assert_two(of(TRUTH, logger), 22.0, 5.0, 200.0)


def test_a_streamer_and_then_a_parachute_are_two_speeds() -> None:
    truth = fly(replace(SMALL, thrust=90.0, sink=11.0, main_sink=4.5, main_height=90.0))
    assert_two(of(truth), 11.0, 4.5, 90.0)


def test_a_log_that_ends_under_the_main_shows_both_speeds() -> None:
    """It lacks the last quarter of the time under the main."""
    (series,) = log(TRUTH, BARO, np.random.default_rng(6))
    end = TRUTH.time[-1] - 10
    cut = measure((cut_to(series, series.time < end),))
    assert "duration" not in cut.figures
    assert_two(cut, 22.0, 5.0, 200.0)


def test_a_log_that_ends_under_the_drogue_shows_one_speed() -> None:
    (series,) = log(TRUTH, BARO, np.random.default_rng(6))
    low = np.interp(series.time, TRUTH.time, TRUTH.height) > 260
    cut = measure((cut_to(series, low | (series.time < TRUTH.apogee_time)),))
    assert "drogue_speed" not in cut.figures
    assert cut.figures["descent_speed"].value == pytest.approx(22, rel=0.15)


def test_a_gap_while_the_main_opens_widens_the_uncertainty_of_its_height() -> None:
    (series,) = log(TRUTH, BARO, np.random.default_rng(6))
    opens = TRUTH.time[np.flatnonzero((TRUTH.height < 200) & (TRUTH.speed < 0))[0]]
    seen = cut_to(series, np.abs(series.time - opens) > 3)
    recorded = measure((seen,))
    whole = of(TRUTH).figures["main_altitude"]
    figure = recorded.figures["main_altitude"]
    assert abs(figure.value - 200) < 3 * figure.sd
    assert figure.sd > whole.sd
    assert recorded.figures["descent_speed"].value == pytest.approx(4.9, rel=0.1)


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE, replace(SMALL, sink=12.0), replace(LARGE, sink=25.0)])
@pytest.mark.parametrize("late", [-1.0, 0.0, 3.0])
def test_one_device_has_one_speed_even_after_a_late_charge(rocket: object, late: float) -> None:
    recorded = of(fly(replace(rocket, delay=rocket.delay + late)))  # type: ignore[type-var,attr-defined]
    assert "drogue_speed" not in recorded.figures


def test_a_landing_after_a_fast_drogue_and_a_slow_main_is_not_the_opening_of_the_main() -> None:
    """At an eighth of the drogue's speed the main once passed for the rocket at rest: 40 s too short."""
    truth = fly(replace(DUAL, sink=29.0, main_sink=3.3))
    recorded = of(truth)
    duration = recorded.figures["duration"]
    assert abs(duration.value - truth.readouts()["duration"]) < 3 * duration.sd
    assert recorded.figures["descent_speed"].value == pytest.approx(3.3, rel=0.05)


@pytest.mark.parametrize(
    ("speeds", "two"),
    [((15.0, 5.0), True), ((7.0, 4.5), False), ((5.0, 15.0), False), ((20.0, 0.3), False), ((15.0, 12.0), False)],
    ids=["drogue and main", "sinking air", "torn parachute", "hung in a tree", "tangled main"],
)
def test_only_a_slower_second_device_of_at_least_twice_the_area_counts(speeds: tuple[float, float], two: bool) -> None:
    recorded = measure((with_descent(*speeds),))
    assert ("drogue_speed" in recorded.figures) == two


@pytest.mark.sampled
@pytest.mark.parametrize("rest", [0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
@pytest.mark.parametrize("speed", [5.0, 9.0, 15.0])
def test_a_short_rest_after_landing_is_not_a_descent_on_a_main(speed: float, rest: float) -> None:
    """In the log of a bdureau board a rest of about two seconds once passed for a main."""
    series = with_descent(speed, speed, rocket=replace(SMALL, burn=0.8))
    landed = series.time[np.flatnonzero(np.asarray(series.altitude) > 2)[-1]]
    recorded = measure((cut_to(series, series.time < landed + rest),))
    assert "drogue_speed" not in recorded.figures
    assert recorded.figures["descent_speed"].value == pytest.approx(speed, rel=0.15)


@pytest.mark.sampled
@pytest.mark.parametrize("seed", range(4))
def test_gusts_and_thermals_do_not_make_two_devices_of_one(seed: int) -> None:
    recorded = measure((with_descent(5.0, 5.0, np.random.default_rng(seed)),))
    assert "descent_speed" in recorded.figures
    assert "drogue_speed" not in recorded.figures


def with_descent(
    first: float, second: float, random: np.random.Generator | None = None, rocket: Rocket = LARGE
) -> Series:
    """A log of a flight whose descent changes its speed halfway down, in thermals of 1 m/s with `random`. [m/s]"""
    up = fly(rocket)
    top = int(np.argmax(up.height))
    apogee, step = float(up.height[top]), 0.1
    until = np.cumsum([apogee / 2 / first, apogee / 2 / second])
    time = np.arange(0.0, min(until[1], 600.0) + 10, step)
    wind: Array = np.zeros(time.size)
    if random is not None:
        for i in range(1, time.size):
            wind[i] = wind[i - 1] * (1 - step / 40) + random.normal(0, np.sqrt(2 * step / 40))
    fall = np.where(time < until[0], first, second) - wind
    fall = np.minimum(fall, 9.8 * time)
    down = np.maximum(apogee - np.cumsum(fall) * step, 0.0)
    climb = np.arange(-3.0, up.time[top], step)
    rise = np.interp(climb, up.time, up.height, left=0.0)
    height = np.concatenate([rise, down])
    noise = np.random.default_rng(1).normal(0, 0.4, height.size)
    return Series(time=np.asarray(np.arange(height.size) * step, np.float64), altitude=height + noise)


def cut_to(series: Series, chosen: Array) -> Series:
    there = [name for name in series.__slots__ if getattr(series, name) is not None]
    return Series(**{name: getattr(series, name)[chosen] for name in there})


REAL = {
    "altos_csv__2012-11-17-serial-209-flight-013.csv": (19.0, 27.0, 6.5, 9.0),
    "altos_csv__prometheus_2022-06-24-serial-5115-flight-0001-TeleMetrum.csv": (22.0, 27.0, 5.7, 7.2),
    "blueraven_app_lr__SN0829_2024-05-11.csv": (14.0, 15.5, 5.5, 6.7),
    "entacore_aim_xtra__e190_h148r.csv": (17.0, 24.0, 5.5, 8.0),
    "featherweight_gps__adventurer_j510w.csv": (15.0, 18.0, 6.2, 7.0),
    "generic__ncsu_firm_jackpot_launch_1.csv": (24.0, 37.0, 4.2, 5.6),
    "raven_fip_variant__ndrt_2020_flight_data.csv": (22.0, 26.5, 3.0, 6.6),
}
"""Recordings on two devices: lowest and highest speeds under drogue and main that the heights show in parts of a few
seconds. [m/s]"""
ONE = (
    "altos_csv__2012-04-07-serial-882-flight-001.csv",
    "cats__hedy_flightInfo.csv",
    "featherweight_gps_derived__juno3_cots_GNSS.csv",
    "generic__andromeda_flight_data.csv",
    "generic__polito_altimeter_cavour.csv",
    "perfectflite__pnut_tarc2023_f6.pf2",
    "perfectflite__pnut_tarc2023_f7.pf2",
    "perfectflite__pnut_top_shot.pf2",
    "raven_fip__top_shot.csv",
)
"""Recordings in which the rocket descends at one speed from its apogee to the end."""


@pytest.mark.skipif(not LOGS.is_dir(), reason="the real logs are not beside this checkout")
@pytest.mark.sampled
@pytest.mark.parametrize("name", REAL)
def test_real_logs_on_two_devices_show_both_speeds(name: str) -> None:
    _, recorded = flown(name)
    slowest, fastest, low, high = REAL[name]
    assert slowest < recorded.figures["drogue_speed"].value < fastest
    assert low < recorded.figures["descent_speed"].value < high


@pytest.mark.skipif(not LOGS.is_dir(), reason="the real logs are not beside this checkout")
@pytest.mark.sampled
@pytest.mark.parametrize("name", ONE)
def test_real_logs_of_one_descent_show_one_speed(name: str) -> None:
    _, recorded = flown(name)
    assert "drogue_speed" not in recorded.figures


def test_a_descent_that_slows_all_the_way_has_no_well_known_speed() -> None:
    """One device descends at one speed, so the mean of a trend may be off by half of its range."""
    rows = (SAMPLES / "altos_csv__version_5_with_cells_too_many.csv").read_text().splitlines(keepends=True)
    found = [
        next(
            one for one in read("".join(rows[:count]).encode(), "a.csv", lambda motor: None).recorded if one is not None
        )
        for count in (len(rows), len(rows) * 9 // 10)
    ]
    whole, cut = (one.figures["descent_speed"] for one in found)
    assert abs(whole.value - cut.value) < 2 * cut.sd

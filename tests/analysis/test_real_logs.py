"""Real recordings beside the repository, read by the parser that recognizes them, and measured."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.analysis import Recorded, measure
from fieldkit.analysis.channels import heights
from fieldkit.analysis.drag_and_impulse import PORTS_SD
from fieldkit.errors import FieldkitError
from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.read import read_recordings

LOGS = Path(__file__).parents[3] / "shared" / "logs"
FLIGHTS = {
    "altos_csv__2012-04-07-serial-882-flight-001.csv": None,
    "altos_csv__2012-11-17-serial-209-flight-013.csv": 13.68,
    "altos_csv__prometheus_2022-06-24-serial-5115-flight-0001-TeleMetrum.csv": 29.1,
    "blueraven_app_lr__SN0829_2024-05-11.csv": 14.75,
    "cats__hedy_flightInfo.csv": 33.45,
    "cats__hedy_filteredDataInfo.csv": 33.58,
    "entacore_aim_xtra__e190_h148r.csv": 12.21,
    "featherweight_gps__adventurer_j510w.csv": None,
    "featherweight_gps_derived__juno3_cots_GNSS.csv": 27.84,
    "generic__andromeda_flight_data.csv": 26.59,
    "generic__ncsu_firm_jackpot_launch_1.csv": None,
    "generic__polito_altimeter_cavour.csv": 23.33,
    "perfectflite__pnut_top_shot.pf2": 8.81,
    "raven_fip__top_shot.csv": None,
    "raven_fip_variant__ndrt_2020_flight_data.csv": 17.34,
}
"""Logs with an apogee in them, and its time on the log's clock if the samples show it: the top of the parabola
through the 11-sample medians from four seconds before the highest of them to one after. [s]"""

pytestmark = pytest.mark.skipif(not LOGS.is_dir(), reason="the real logs are not beside this checkout")


def flown(name: str) -> tuple[Reading, Recorded]:
    """The one flight of a log; skips if no parser recognizes it, or it cannot be read without a mapping."""
    path = LOGS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    try:
        readings = read_recordings(path.read_bytes(), name)
    except FieldkitError as error:
        pytest.skip(f"not read yet: {error}")
    (reading,) = [one for one in readings if one.describes == "flight"]
    return reading, measure(reading.clocks, reading.events)


def robust_apogee(clocks: tuple[Series, ...]) -> float:
    """The highest 11-sample median of the heights, if needed above the first median in the minute before."""
    for name in ("altitude", "pressure", "altitude_msl", "gps_altitude_msl"):
        for series in clocks:
            values = getattr(series, name)
            if values is None:
                continue
            there = np.isfinite(values)
            time, values = series.time[there], values[there]
            if name == "pressure":
                values = 44330.77 * (1 - (values / 101325) ** 0.190263)
            medians = np.median(np.lib.stride_tricks.sliding_window_view(values, 11), axis=1)
            pad = values[time > time[np.argmax(medians)] - 60][:11]
            return float(medians.max() - (0 if name == "altitude" else np.median(pad)))
    raise AssertionError("no heights")


@pytest.mark.sampled
@pytest.mark.parametrize("name", FLIGHTS)
def test_apogee_is_within_half_a_percent_of_the_robust_one(name: str) -> None:
    reading, recorded = flown(name)
    right = robust_apogee(reading.clocks)
    if name.startswith("raven_fip__"):
        right = 313.3 - 4.5  # thinned to 4 Hz, its first samples are in the boost: the other device, less its spikes
    assert abs(recorded.figures["apogee"].value - right) < max(1.0, 0.005 * right)


@pytest.mark.sampled
@pytest.mark.parametrize("name", [name for name, time in FLIGHTS.items() if time is not None])
def test_apogee_is_at_the_vertex_of_the_samples(name: str) -> None:
    _, recorded = flown(name)
    assert recorded.events["apogee"].time == pytest.approx(FLIGHTS[name], abs=0.2)


def test_a_flight_whose_logger_moved_its_zero_has_the_apogee_of_its_pressures() -> None:
    """The motor threw the rocket, and the pressure at its failure moved the zero of the heights by 72 m."""
    reading, recorded = flown("altos_csv__2012-08-31-serial-334-flight-003.csv")
    (series,) = reading.clocks
    assert series.altitude_msl is not None
    level = np.median(series.altitude_msl[:12])
    medians = np.median(np.lib.stride_tricks.sliding_window_view(series.altitude_msl[series.time > 1], 11), axis=1)
    assert abs(np.median(series.altitude_msl[-100:]) - level) < 6
    assert recorded.figures["apogee"].value == pytest.approx(medians.max() - level, abs=3)
    assert recorded.figures["top_speed"].value < 45


def test_a_jump_of_the_pressure_in_the_boost_is_not_a_top_speed() -> None:
    """The heights rise by 83 m within a fifth of a second, and then at 7 m/s."""
    _, recorded = flown("perfectflite__pnut_tarc2023_f7.pf2")
    assert "top_speed" not in recorded.figures
    assert recorded.figures["apogee"].value == pytest.approx(179.2, abs=1.5)


def test_the_spike_of_a_rocket_that_broke_up_is_not_the_apogee() -> None:
    _, recorded = flown("altos_csv__2012-05-28-serial-319-flight-005.csv")
    apogee = recorded.figures.get("apogee")
    assert apogee is None or apogee.value < 155


def test_spikes_from_charges_near_apogee_are_not_the_apogee() -> None:
    """The last five seconds of its coast that no charge disturbs are a parabola whose top is at 3161 m and 26.0 s."""
    reading, recorded = flown("rrc3__juno3_cots_altimeter.csv")
    (series,) = reading.clocks
    calm = (series.time > 19.5) & (series.time < 24.5)
    assert series.altitude is not None
    bend, slope, level = np.polyfit(series.time[calm] - 26, series.altitude[calm], 2)
    assert -2 * bend == pytest.approx(9.8, abs=0.4)
    assert recorded.figures["apogee"].value == pytest.approx(level - slope**2 / (4 * bend), rel=0.005)
    assert recorded.events["apogee"].time == pytest.approx(26 - slope / (2 * bend), abs=0.25)
    assert "duration" not in recorded.figures


def test_two_devices_on_one_flight_agree() -> None:
    _, one = flown("perfectflite__pnut_top_shot.pf2")
    _, other = flown("raven_fip__top_shot.csv")
    for name, difference in {"apogee": 2.0, "top_speed": 6.0, "duration": 1.5, "descent_speed": 0.3}.items():
        assert abs(one.figures[name].value - other.figures[name].value) < difference


HEIGHTS = ("altitude", "altitude_msl", "gps_altitude_msl", "inertial_altitude", "pressure")
SCALE_HEIGHT = 8400.0
"""Scale height of the pressure near the ground. [m]"""
Change = Callable[[Series, float, np.random.Generator], Series]


def risen(series: Series, by: np.ndarray) -> Series:
    """Samples with their heights changed. [m]"""
    there = [name for name in HEIGHTS if getattr(series, name) is not None]
    changed = {name: getattr(series, name) + by for name in there if name != "pressure"}
    pressure = series.pressure
    return replace(series, **changed, pressure=None if pressure is None else pressure * np.exp(-by / SCALE_HEIGHT))


def noisier(series: Series, noise: float, random: np.random.Generator) -> Series:
    return risen(series, random.normal(0, max(noise, 0.3), series.time.size))


def drifting(series: Series, noise: float, random: np.random.Generator) -> Series:
    return risen(series, 0.01 * (series.time - series.time[0]))


def spiked(series: Series, noise: float, random: np.random.Generator) -> Series:
    far = random.random(series.time.size) < 0.005
    return risen(series, far * random.choice([-1, 1], far.size) * random.uniform(20, 900, far.size))


def halved(series: Series, noise: float, random: np.random.Generator) -> Series:
    there = [name for name in series.__slots__ if getattr(series, name) is not None]
    return Series(**{name: getattr(series, name)[::2] for name in there})


@pytest.mark.slow
@pytest.mark.parametrize("change", [noisier, drifting, spiked, halved])
@pytest.mark.parametrize("name", FLIGHTS)
def test_a_degraded_log_gives_the_same_readouts_within_their_uncertainty(name: str, change: Change) -> None:
    reading, recorded = flown(name)
    track = heights(reading.clocks)
    assert track is not None
    random = np.random.default_rng(1)
    worse = measure([change(series, track.noise, random) for series in reading.clocks], reading.events)
    for figure in sorted(recorded.figures.keys() & worse.figures.keys()):
        one, other = recorded.figures[figure], worse.figures[figure]
        moved = 0.5 if change is drifting else 0.0  # of which the pad's own part is included in the figure
        if figure == "coast_drag" and one.source != other.source:  # static ports are an error of the rocket
            moved += 3 * PORTS_SD * one.value
        assert abs(one.value - other.value) < 3 * np.hypot(one.sd, other.sd) + moved, figure
    assert "apogee" in worse.figures


@pytest.mark.slow
@pytest.mark.parametrize("name", FLIGHTS)
def test_a_log_without_its_pad_has_the_same_apogee_within_its_uncertainty(name: str) -> None:
    reading, whole = flown(name)
    begin = whole.events["liftoff"].time - 0.2 if "liftoff" in whole.events else -np.inf
    cut = measure([_from(series, begin) for series in reading.clocks if series.time[-1] > begin], reading.events)
    one, other = whole.figures["apogee"], cut.figures["apogee"]
    assert abs(one.value - other.value) < 3 * np.hypot(one.sd, other.sd)
    assert cut.events["apogee"].time == pytest.approx(whole.events["apogee"].time, abs=0.2)


def _from(series: Series, begin: float) -> Series:
    kept = series.time >= begin
    there = [name for name in series.__slots__ if getattr(series, name) is not None]
    return Series(**{name: getattr(series, name)[kept] for name in there})

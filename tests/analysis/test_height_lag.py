"""Heights that a filter or small vents delay: the measurements are averaged over the lag."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import NO_FLIGHT, Event, Figure, Recorded, measure
from fieldkit.analysis.channels import heights
from fieldkit.analysis.height_lag import averaged, possible_lags
from fieldkit.analysis.initial_guess import lagged
from fieldkit.analysis.liftoff import liftoff
from fieldkit.analysis.phases import outline
from fieldkit.analysis.smooth import Grid, design, fit
from fieldkit.flight import Series
from fieldkit.motors import catalogue
from fieldkit.units import FOOT
from tests.analysis.recordings import FAST, LARGE, SMALL, Logger, Rocket, Truth, fly, log

LIFT = Event(0.0, 0.1, "pressure")
READOUTS = ("apogee", "top_speed", "burn_time", "avg_accel", "time_to_apogee", "coast_to_apogee", "duration")


def recording(truth: Truth) -> tuple[Series, ...]:
    """A log of the barometer alone."""
    return log(truth, Logger(), np.random.default_rng(2))


def behind(series: Series, lag: float) -> Series:
    """The heights of a recording after a first-order filter."""
    assert series.altitude is not None
    fine = np.arange(series.time[0], series.time[-1], 0.002)
    height = np.interp(fine, series.time, series.altitude)
    return replace(series, altitude=np.interp(series.time, fine, lagged(height, float(height[0]), 0.002, lag)))


@pytest.mark.sampled
@pytest.mark.parametrize("rocket", [SMALL, LARGE], ids=["small", "large"])
@pytest.mark.parametrize("lag", [0.25, 0.4])
def test_small_vents_bias_no_readout_beyond_its_standard_deviation(rocket: Rocket, lag: float) -> None:
    truth = fly(rocket)
    figures = measure([behind(recording(truth)[0], lag)]).figures
    right = truth.readouts()
    assert {name for name in READOUTS if abs(figures[name].value - right[name]) > 2.5 * figures[name].sd} == set()
    assert figures["burn_time"].value == pytest.approx(right["burn_time"], rel=0.25)


@pytest.mark.parametrize("lag", [0.5, 1.0])
def test_a_slow_filter_biases_no_readout_of_a_barometer_alone_beyond_its_standard_deviation(lag: float) -> None:
    """The missing noise shows that there is a filter, and hardly more of it."""
    truth = fly(SMALL)
    figures = measure([behind(recording(truth)[0], lag)]).figures
    right = truth.readouts()
    known = set(READOUTS) & figures.keys()
    assert {"apogee", "top_speed", "time_to_apogee", "duration"} <= known
    assert {name for name in known if abs(figures[name].value - right[name]) > 3 * figures[name].sd} == set()
    assert "peak_accel" not in figures
    assert figures["time_to_apogee"].sd > 3 * measure(recording(truth)).figures["time_to_apogee"].sd


def test_a_coarse_resolution_hides_the_noise_that_shows_a_filter() -> None:
    series = behind(recording(fly(SMALL))[0], 1.0)
    assert series.altitude is not None
    track = heights([replace(series, altitude=np.round(series.altitude / FOOT) * FOOT)])
    assert track is not None
    seen = outline(track)
    assert seen is not None
    assert {one.counts for one in possible_lags(track, seen, liftoff(track, None, seen))} == {1.0}


def test_a_satellite_receiver_that_follows_the_boost_late_biases_no_time_beyond_its_standard_deviation() -> None:
    """Its filter has half a second under thrust and hardly any later."""
    truth = fly(SMALL)
    fine = np.arange(-20.0, truth.time[-1] + 10, 0.02)
    height = np.interp(fine, truth.time, truth.height)
    late = 0.5 * np.exp(-np.maximum(fine - truth.burnout - 0.5, 0) / 1.0) * (fine > 0)
    seen = np.interp(fine - late, fine, height)[::10] + np.random.default_rng(4).normal(0, 0.3, fine[::10].size)
    figures = measure([Series(fine[::10], gps_altitude_msl=seen + 300.0)]).figures
    right = truth.readouts()
    for name in ("time_to_apogee", "duration"):
        assert abs(figures[name].value - right[name]) < 3 * figures[name].sd
    assert figures["duration"].sd > 0.5


@pytest.mark.parametrize(("lag", "counts"), [(0.0, (0.8, 1.0)), (0.5, (0.0, 0.3))])
def test_noise_at_rest_shows_a_filter(lag: float, counts: tuple[float, float]) -> None:
    """Steps of a height held for two rows, as by a barometer that is read less often, are of the same noise."""
    series = behind(recording(fly(SMALL))[0], lag)
    assert series.altitude is not None
    for height in (series.altitude, np.repeat(series.altitude[::2], 2)[: series.time.size]):
        track = heights([replace(series, altitude=height)])
        assert track is not None
        seen = outline(track)
        assert seen is not None
        lags = possible_lags(track, seen, liftoff(track, None, seen))
        assert counts[0] <= lags[0].counts <= counts[1]
        assert (lags[0].prior < 0.2) == (lag > 0)  # 0.34 before the noise is known
        assert sum(one.prior for one in lags) == pytest.approx(1.0)


def test_an_accelerometer_shows_the_filter_that_heights_are_behind() -> None:
    """The heights of a team's own filter: what they show late is that uncertain, and a note says why."""
    truth = fly(SMALL)
    series, felt = log(truth, Logger(accelerometer=100.0), np.random.default_rng(2))
    found = measure([behind(series, 1.0), felt])
    right = truth.readouts()
    assert any("behind a filter of about 1.0 s" in note for note in found.notes)
    known = right.keys() & found.figures & set(READOUTS)
    assert {"apogee", "coast_to_apogee", "duration"} <= known
    off = {name for name in known if abs(found.figures[name].value - right[name]) > 2.5 * found.figures[name].sd}
    assert off == set()
    plain = measure([series, felt])
    assert not any("filter" in note for note in plain.notes)
    assert plain.figures["duration"].sd < found.figures["duration"].sd / 3


@pytest.mark.parametrize("rocket", [Rocket(mass=0.2, area=0.0009, delay=7.0), FAST], ids=["regressive thrust", "sonic"])
def test_a_lag_that_thrust_or_shocks_hide_biases_no_readout_beyond_its_standard_deviation(rocket: Rocket) -> None:
    """Thrust that decreases throughout looks like a lag, and near the speed of sound shocks hide one."""
    truth = fly(rocket, None if rocket is FAST else catalogue().find("D13").motor)
    figures = measure([behind(recording(truth)[0], 0.4)]).figures
    right = truth.readouts()
    assert {
        name for name in right.keys() & figures if abs(figures[name].value - right[name]) > 2.5 * figures[name].sd
    } == set()


def test_heights_without_a_lag_are_unchanged() -> None:
    truth = fly(LARGE)
    found = measure(recording(truth)).figures["time_to_apogee"]
    assert found.value == pytest.approx(truth.readouts()["time_to_apogee"], abs=0.15)
    assert found.sd < 0.2


def test_a_lag_delays_a_ramp_by_itself() -> None:
    time = np.arange(0.0, 3.0, 0.01)
    shown = lagged(20 * time, 0.0, 0.01, 0.2)
    assert shown == pytest.approx(20 * (time - 0.2 + 0.2 * np.exp(-time / 0.2)), abs=1e-9)


def test_the_evidence_of_a_lag_equals_that_from_dense_matrices() -> None:
    """If samples show m, the third differences of the heights ahead of the lag have independent errors."""
    random = np.random.default_rng(3)
    grid = Grid(0.0, 0.1, 30)
    time, noise, lag = np.sort(random.uniform(0, 3, 80)), 50.0, np.where(np.arange(30) > 4, 0.25, 0.0)
    samples, height, error = design(grid, time), 5 * random.standard_normal(80), random.standard_normal(80)
    rows = np.zeros((80, 33))
    for place in range(4):
        rows[np.arange(80), samples.rows.first + place] = samples.rows.value[:, place]

    def dense(late: np.ndarray, extra: np.ndarray) -> float:
        walk = np.diff(np.eye(33), 3, axis=0)
        walk[1:] += (late / grid.step)[1:, None] * np.diff(walk, axis=0)
        walk /= np.sqrt(noise * grid.step**5)
        certain = np.linalg.inv(np.eye(80) / 4 + np.outer(extra, extra))
        precision = walk.T @ walk + rows.T @ certain @ rows
        right = rows.T @ certain @ height
        misfit = height @ certain @ height - right @ np.linalg.solve(precision, right)
        sizes = [np.linalg.slogdet(one)[1] for one in (walk @ walk.T, certain, precision)]
        return float(sizes[0] + sizes[1] - sizes[2] - misfit) / 2

    def found(late: np.ndarray | None, extra: np.ndarray | None) -> float:
        return fit(samples, height, np.full(80, 4.0), np.full(30, noise), late, extra).evidence

    none = np.zeros(80)
    assert found(lag, error) - found(lag, None) == pytest.approx(dense(lag, error) - dense(lag, none), abs=1e-4)
    assert found(lag, None) - found(None, None) == pytest.approx(dense(lag, none) - dense(0 * lag, none), abs=1e-4)


def test_an_error_that_samples_share_moves_the_curve_and_widens_its_draws() -> None:
    """The mean and the covariance are those of the same model with dense matrices."""
    random = np.random.default_rng(4)
    grid = Grid(0.0, 0.1, 10)
    time = np.sort(random.uniform(0, 1, 40))
    samples, height, error = design(grid, time), 5 * random.standard_normal(40), 3 * time**2
    rows = np.zeros((40, 13))
    for place in range(4):
        rows[np.arange(40), samples.rows.first + place] = samples.rows.value[:, place]
    walk = np.diff(np.eye(13), 3, axis=0) / np.sqrt(50.0 * grid.step**5)
    certain = np.linalg.inv(np.eye(40) / 4 + np.outer(error, error))
    covariance = np.linalg.inv(walk.T @ walk + rows.T @ certain @ rows)
    found = fit(samples, height, np.full(40, 4.0), np.full(10, 50.0), error=error)
    assert found.mean == pytest.approx(covariance @ rows.T @ certain @ height, abs=1e-4)
    drawn = np.cov(found.draws(20_000, random).T)
    assert np.diag(drawn) == pytest.approx(np.diag(covariance), rel=0.06)


def test_samples_too_noisy_for_a_second_curve_are_not_a_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    """The accelerometer contradicts the heights at the top, and no curve fits the heights alone."""
    module = sys.modules["fieldkit.analysis.measure"]
    fitted = module.ascend  # type: ignore[attr-defined]

    def ascend(track: object, push: object, *others: object) -> object:
        if push is None:
            raise np.linalg.LinAlgError
        return fitted(track, push, *others)

    monkeypatch.setattr(module, "ascend", ascend)
    monkeypatch.setattr(module, "_misses_the_top", lambda *_: True)
    found = measure(log(fly(SMALL), Logger(accelerometer=100.0), np.random.default_rng(2)))
    assert found.notes == (NO_FLIGHT,)


def test_the_sd_of_an_average_includes_the_spread_between_figures() -> None:
    def recorded(speed: float, burn: float) -> Recorded:
        figures = {"top_speed": Figure(speed, 3.0, "pressure"), "burn_time": Figure(burn, 0.1, "pressure")}
        return Recorded({"liftoff": LIFT, "burnout": Event(burn, 0.1, "pressure")}, figures)

    found = averaged([recorded(100.0, 1.0), recorded(80.0, 2.0)], [0.75, 0.25], np.arange(-5.0, 20.0, 0.1))
    assert found.figures["top_speed"].value == 95.0
    assert found.figures["top_speed"].sd == pytest.approx(np.sqrt(9 + 0.75 * 25 + 0.25 * 225))
    assert found.events["burnout"].time == 1.25
    assert found.events["burnout"].sd == pytest.approx(np.sqrt(0.01 + 0.75 * 0.0625 + 0.25 * 0.5625))

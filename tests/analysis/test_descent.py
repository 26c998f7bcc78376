"""Landing after a fall, and the descent speed if no sensor shows when the parachute was ejected."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.descent import _braked, _from_unseen_ejection
from fieldkit.analysis.records import Event
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import SMALL, Logger, fly, log

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("after", [-1.5, -1.0, 0.0, 0.8])
def test_an_unseen_ejection_up_to_one_and_a_half_seconds_early_is_within_the_uncertainty(after: float) -> None:
    height, lasts = 177.0, 25.0
    true = (height - GRAVITY * after**2 / 2) / (lasts - after)
    mean, sd = _from_unseen_ejection(height / lasts, height, lasts)
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
    assert recorded.figures["apogee"].value == pytest.approx(max(fraction, 1.0) * truth.readouts()["apogee"], rel=0.01)
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
    assert abs(braked.time - 4.0) < 2 * braked.sd

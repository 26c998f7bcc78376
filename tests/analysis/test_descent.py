"""Landing after a fall, and the descent speed if no sensor shows when the parachute was ejected."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.descent import _from_unseen_ejection
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


@pytest.mark.parametrize("rate", [5.0, 20.0])
@pytest.mark.parametrize("part", [0.4, 0.6])
def test_a_fall_without_a_parachute_lands_when_it_hits_the_ground(part: float, rate: float) -> None:
    """It still accelerates in its last seconds, so that the line through these reaches the ground too late."""
    truth = fly(replace(SMALL, burn=part * SMALL.burn, delay=1000.0))
    recorded = measure(log(truth, Logger(start=0.0, wait=3.0, rate=rate), np.random.default_rng(6)))
    duration = recorded.figures["duration"]
    assert abs(duration.value - truth.readouts()["duration"]) < 2 * duration.sd

"""Thrust and drag from an accelerometer that starts or stops within the climb."""

import numpy as np
import pytest

from fieldkit.analysis.channels import Push
from fieldkit.analysis.forces import forces
from fieldkit.analysis.records import MeasuredClimb
from fieldkit.physics.standard_atmosphere import standard_density

pytestmark = pytest.mark.fast


def test_drag_is_whole_up_to_the_last_sample_of_an_accelerometer() -> None:
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

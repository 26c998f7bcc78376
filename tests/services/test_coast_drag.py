"""Drag against time along a coast."""

import numpy as np
import pytest

from fieldkit.analysis.force_profile import DragLikelihood, DragProfile, PortError
from fieldkit.services.coast_drag import against_time


def profile(truth: np.ndarray, sd: float) -> DragProfile:
    """A log that measures relative drag in each interval with this standard deviation. [1]"""
    count = len(truth)
    precision = np.eye(count) / sd**2
    one = DragLikelihood(0.0, precision, precision @ truth, 1e-6 * np.eye(count), PortError(np.zeros(count), 0.0, 0.0))
    time = 1.0 + 0.1 * np.arange(count)
    return DragProfile(time, 0.1, np.linspace(60.0, 20.0, count), 0.002, (one, one), "acceleration")


def test_a_switch_in_drag_is_followed_and_lies_within_its_interval() -> None:
    truth = np.where(np.arange(30) < 15, 1.0, 1.8)
    found = against_time(profile(truth, 0.02))
    assert found.mean == pytest.approx(truth, abs=0.02)
    assert np.all((found.low < truth) & (truth < found.high))


def test_the_interval_is_as_wide_as_the_measurement_where_it_decides() -> None:
    found = against_time(profile(np.ones(30), 0.02))
    assert (found.high - found.low)[15] == pytest.approx(2 * 1.645 * 0.02, rel=0.1)


def test_what_the_log_does_not_show_stays_open() -> None:
    found = against_time(profile(np.ones(30), 50.0))
    assert np.all(found.high - found.low > 2.0)

"""The ratio of peak thrust to the mean over a window, computed again from the catalog, and peaks from it."""

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.peak import BEYOND_MEAN, BEYOND_WINDOW
from fieldkit.motors import catalogue
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import LARGE, Logger, fly, log

STEP, PEAK = 0.01, 0.05
"""Time step of the curves, and the time over which a peak is taken. [s]"""


def strongest(thrust: np.ndarray, window: float) -> float:
    """The greatest mean thrust over a window. [N]"""
    width = max(1, round(window / STEP))
    total = np.concatenate(([0.0], np.cumsum(thrust)))
    return float(((total[width:] - total[:-width]) / width).max())


def beyond() -> tuple[np.ndarray, np.ndarray]:
    """Per motor: peak over mean of each window, that of the burn, and the motor's weight."""
    rows, classes = [], []
    for motor in catalogue().motors:
        burn = float(motor.burnout)
        time = np.arange(-1.6 * burn, 2.6 * burn, STEP)
        thrust = np.interp(time, motor.time, motor.thrust, left=0.0, right=0.0)
        windows = [strongest(thrust, part * burn) for part, _, _ in BEYOND_WINDOW]
        burning = thrust[(time >= 0) & (time <= burn)]
        rows.append(strongest(thrust, PEAK) / np.array([*windows, burning.mean()]))
        classes.append(motor.impulse_class)
    weight = np.array([1 / classes.count(one) for one in classes])
    return np.array(rows), weight / weight.sum()


def test_peak_ratios_agree_with_the_catalog() -> None:
    ratios, weight = beyond()
    mean = weight @ ratios
    spread = np.sqrt(weight @ (ratios - mean) ** 2)
    expected = np.array([(ratio, sd) for _, ratio, sd in BEYOND_WINDOW] + [BEYOND_MEAN])
    np.testing.assert_allclose(mean, expected[:, 0], atol=0.03)
    np.testing.assert_allclose(spread, expected[:, 1], atol=0.03)
    assert mean[:-1] == pytest.approx(sorted(mean[:-1]))


def test_the_peak_of_a_log_that_begins_after_ignition_may_have_come_before_it() -> None:
    """So it is that of motors with this mean, whose thrust is the mean acceleration plus gravity and drag."""
    figures = measure(log(fly(LARGE), Logger(rate=50.0, noise=0.05, late=0.2), np.random.default_rng(2))).figures
    mean, peak = figures["avg_accel"], figures["peak_accel"]
    assert peak.value > mean.value + (BEYOND_MEAN[0] - 1) * (mean.value + GRAVITY)
    assert peak.sd > BEYOND_MEAN[1] * (mean.value + GRAVITY)

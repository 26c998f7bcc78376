"""The ratio of peak thrust to the mean over a window, computed again from the catalog."""

import numpy as np
import pytest

from fieldkit.analysis.peak import BEYOND_MEAN, BEYOND_WINDOW
from fieldkit.motors import catalogue

STEP, PEAK = 0.01, 0.05
"""Time step of the curves, and the time over which a peak is taken. [s]"""


def strongest(thrust: np.ndarray, window: float) -> float:
    """The greatest mean thrust over a window. [N]"""
    width = max(1, round(window / STEP))
    total = np.concatenate(([0.0], np.cumsum(thrust)))
    return float(((total[width:] - total[:-width]) / width).max())


def beyond() -> tuple[np.ndarray, np.ndarray]:
    """Per motor: the logarithm of peak over mean of each window, that of the burn, and the motor's weight."""
    rows, classes = [], []
    for motor in catalogue().motors:
        burn = float(motor.burnout)
        time = np.arange(-1.6 * burn, 2.6 * burn, STEP)
        thrust = np.interp(time, motor.time, motor.thrust, left=0.0, right=0.0)
        windows = [strongest(thrust, part * burn) for part, _, _ in BEYOND_WINDOW]
        burning = thrust[(time >= 0) & (time <= burn)]
        rows.append(np.log(strongest(thrust, PEAK) / np.array([*windows, burning.mean()])))
        classes.append(motor.impulse_class)
    weight = np.array([1 / classes.count(one) for one in classes])
    return np.array(rows), weight / weight.sum()


def test_peak_ratios_agree_with_the_catalog() -> None:
    logs, weight = beyond()
    mean = weight @ logs
    spread = np.sqrt(weight @ (logs - mean) ** 2)
    expected = np.array([(log, sd) for _, log, sd in BEYOND_WINDOW] + [BEYOND_MEAN])
    np.testing.assert_allclose(mean, expected[:, 0], atol=0.03)
    np.testing.assert_allclose(spread, expected[:, 1], atol=0.03)
    assert mean[:-1] == pytest.approx(sorted(mean[:-1]))

"""The ratio of peak thrust to the mean over a window, computed again from the catalog, and peaks from it."""

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.analysis.peak import BEYOND_MEAN, BEYOND_SAMPLES, BEYOND_WINDOW
from fieldkit.motors import catalogue
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import LARGE, Logger, fly, log

STEP, PEAK = 0.01, 0.05
"""Time step of the curves, and the time over which a peak is taken. [s]"""
WEIGHTS, BOOST = 8.0, 0.5
"""Mean thrust in weights [1], and the shortest boost that is sampled, in burns [1]."""


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


def beyond_samples(every: float) -> tuple[float, float]:
    """Mean and standard deviation of the peak above the highest sample, in the largest differences of neighbors."""
    found, classes = [], []
    for motor in catalogue().motors:
        burn = float(motor.burnout)
        time = np.arange(-1.0, burn + 1.0, STEP)
        thrust = np.interp(time, motor.time, motor.thrust, left=0.0, right=0.0)
        net = WEIGHTS * thrust / thrust[(time >= 0) & (time <= burn)].mean() - 1
        net[time < 0] = 0.0
        width = round(every / STEP)
        if every < BOOST * burn:
            peak, phases = strongest(net, PEAK), [net[start::width] for start in range(width)]
            found.append([(peak - one.max()) / np.abs(np.diff(one)).max() for one in phases])
            classes.append(motor.impulse_class)
    weight = np.array([1 / classes.count(one) for one in classes])
    rows = np.array(found)
    mean = np.average(rows.mean(axis=1), weights=weight)
    return float(mean), float(np.sqrt(np.average(((rows - mean) ** 2).mean(axis=1), weights=weight)))


def test_peaks_above_samples_agree_with_the_catalog() -> None:
    for every, mean, sd in BEYOND_SAMPLES:
        assert beyond_samples(every) == pytest.approx((mean, sd), abs=0.03)


def test_the_peak_of_a_log_that_begins_after_ignition_may_have_come_before_it() -> None:
    """So it is that of motors with this mean, whose thrust is the mean acceleration plus gravity and drag."""
    figures = measure(log(fly(LARGE), Logger(rate=50.0, noise=0.05, late=0.2), np.random.default_rng(2))).figures
    mean, peak = figures["avg_accel"], figures["peak_accel"]
    assert peak.value > mean.value + (BEYOND_MEAN[0] - 1) * (mean.value + GRAVITY)
    assert peak.sd > BEYOND_MEAN[1] * (mean.value + GRAVITY)

"""The typical decrease of thrust in a burn and its process noise, computed again from the catalog."""

import numpy as np
import pytest

from fieldkit.analysis.initial_guess import THRUST_DECREASE, boost
from fieldkit.analysis.liftoff import _IGNITION
from fieldkit.analysis.process_noise import THRUST_NOISE, THRUST_NOISE_SPREAD
from fieldkit.motors import catalogue
from fieldkit.physics.standard_atmosphere import GRAVITY

PARTS, GAP = 401, 80
"""Number of times in a burn at which thrust is compared, and how many of them are between two that are. [1]"""
NORMAL_RANGE = 1.349
"""Interquartile range of a standard normal. [1]"""


def quantiles(values: np.ndarray, weights: np.ndarray, levels: list[float]) -> np.ndarray:
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.asarray(np.interp(levels, below / weights.sum(), values[order]))


def test_the_typical_thrust_agrees_with_the_catalog() -> None:
    """The decrease is that of the line with the same mean time of impulse; the ends are left out of
    the noise, because thrust starts and ends with a jump."""
    part, inner = np.linspace(0, 1, PARTS), slice(PARTS // 20, -PARTS // 20)
    decreases, noises, classes = [], [], []
    for motor in catalogue().motors:
        thrust = np.interp(part * motor.burnout, motor.time, motor.thrust, left=0.0, right=0.0)
        thrust /= thrust.mean()
        decreases.append(-12 * np.trapezoid(thrust * (part - 0.5), part))
        rest = (thrust + THRUST_DECREASE * (part - 0.5))[inner]
        noises.append(np.log(np.mean((rest[GAP:] - rest[:-GAP]) ** 2) / (GAP / (PARTS - 1))))
        classes.append(motor.impulse_class)
    weights = 1 / np.array([classes.count(one) for one in classes])
    low, middle, high = quantiles(np.array(noises), weights, [0.25, 0.5, 0.75])
    assert quantiles(np.array(decreases), weights, [0.5])[0] == pytest.approx(THRUST_DECREASE, abs=0.01)
    assert np.exp(middle) == pytest.approx(THRUST_NOISE, abs=0.01)
    assert (high - low) / NORMAL_RANGE == pytest.approx(THRUST_NOISE_SPREAD, abs=0.05)


def test_the_rise_of_thrust_agrees_with_the_catalog() -> None:
    """From the weight of a rocket of an eighth of the mean thrust to a fifth of the mean net thrust."""
    rises, classes = [], []
    for motor in catalogue().motors:
        time = np.linspace(0, min(motor.burnout, 1.0), 2001)
        thrust = np.interp(time, motor.time, motor.thrust)
        mean = np.trapezoid(motor.thrust, motor.time) / motor.burnout
        bars = mean / 8, mean / 8 + 0.2 * (mean - mean / 8)
        rises.append(float(np.diff([time[int(np.argmax(thrust > bar))] for bar in bars])[0]))
        classes.append(motor.impulse_class)
    weights = 1 / np.array([classes.count(one) for one in classes])
    assert np.sqrt(np.average(np.square(rises), weights=weights)) == pytest.approx(_IGNITION, abs=0.005)
    assert np.median(rises) < _IGNITION / 3


def test_a_typical_boost_reaches_its_top_speed() -> None:
    time = np.linspace(0, 1.5, 1001)
    net = boost(time, 90.0, 1.5)
    assert np.trapezoid(net, time) == pytest.approx(90.0)
    assert (net[0] - net[-1]) / (60.0 + GRAVITY) == pytest.approx(THRUST_DECREASE)

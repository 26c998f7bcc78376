"""Finding the rocket's axis among three, and the unit of an accelerometer that was never at rest."""

import numpy as np
import pytest

from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.importing.tables.pad_state import along_thrust
from fieldkit.importing.tables.unit_inference import rest, settle_felt
from fieldkit.units import STANDARD_GRAVITY
from tests.analysis.recordings import LARGE, SMALL, Logger, fly, log

MOUNTED = [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (-0.48, 0.64, 0.6)]
"""Directions along the rocket in the axes of its accelerometer."""


def felt_on(direction: tuple[float, float, float], late: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, three axes with noise across the rocket, and the specific force along it."""
    settings = Logger(accelerometer=100.0, scale=1.0, bias=0.0, start=0.0, late=late)
    _, felt = log(fly(LARGE), settings, np.random.default_rng(1))
    along = np.array(direction)
    across = np.random.default_rng(2).normal(0, 0.5, (3, felt.time.size))
    return felt.time, along[:, None] * felt.felt + across - along[:, None] * (along @ across), felt.felt


@pytest.mark.sampled
@pytest.mark.parametrize("direction", MOUNTED)
@pytest.mark.parametrize("late", [0.0, 0.5])
def test_the_axis_is_found_however_it_is_mounted(direction: tuple[float, float, float], late: float) -> None:
    time, axes, felt = felt_on(direction, late)
    found = along_thrust(time, axes)
    assert found is not None
    climbing = (time > 0) & (time < fly(LARGE).apogee_time)
    assert np.abs(found - felt)[climbing].max() < 0.03 * np.abs(felt).max()


@pytest.mark.parametrize("direction", MOUNTED[3:])
def test_axes_that_are_not_saturated_show_what_a_saturated_one_hides(direction: tuple[float, float, float]) -> None:
    time, axes, felt = felt_on(direction)
    limit = 0.85 * float(np.abs(axes).max())
    found = along_thrust(time, np.clip(axes, -limit, limit))
    assert found is not None
    pushed = felt > 0.95 * felt.max()
    assert (np.abs(axes[:, pushed]).max(axis=0) > limit).all()
    assert found[pushed].mean() == pytest.approx(felt[pushed].mean(), rel=0.05)


def test_no_axis_is_found_if_gravity_was_across_the_thrust() -> None:
    time, axes, _ = felt_on((0.0, 0.0, 1.0))
    axes[:, time < 0] = np.array([[STANDARD_GRAVITY], [0.0], [0.0]])
    assert along_thrust(time, axes) is None


def test_without_thrust_no_axis_is_found() -> None:
    time = np.arange(0, 20, 0.01)
    axes = np.stack([np.zeros(time.size), np.zeros(time.size), np.full(time.size, STANDARD_GRAVITY)])
    assert along_thrust(time, axes) is None


def test_a_table_of_three_axes_is_measured_along_the_rocket() -> None:
    truth = fly(SMALL)
    settings = Logger(rate=100.0, accelerometer=100.0, start=0.0)
    barometer, felt = log(truth, settings, np.random.default_rng(1))
    heights = np.interp(felt.time, barometer.time, barometer.altitude)
    rows = zip(felt.time, heights, 0.1 * felt.felt, -0.995 * felt.felt, 0.0 * felt.felt, strict=True)
    table = "time (s),altitude (m),ax (m/s2),ay (m/s2),az (m/s2)\n"
    table += "".join(f"{t:.3f},{h:.2f},{x:.3f},{y:.3f},{z:.3f}\n" for t, h, x, y, z in rows)
    (reading,) = (one for one in open_log(table.encode(), "own.csv", None).found if isinstance(one, Reading))
    from fieldkit.analysis import measure

    recorded = measure(reading.clocks)
    for name in ("top_speed", "burn_time", "peak_accel"):
        figure = recorded.figures[name]
        assert "acceleration" in figure.source
        assert figure.value == pytest.approx(truth.readouts()[name], abs=3 * figure.sd)


def test_constant_thrust_is_not_rest() -> None:
    boost = np.full(400, 32.2) + np.random.default_rng(0).normal(0, 0.01, 400)
    coast = np.linspace(-4.0, -0.3, 900) + np.random.default_rng(1).normal(0, 0.4, 900)
    assert settle_felt(np.concatenate([boost, coast])) is None


@pytest.mark.parametrize(("unit", "one"), [("g", 1.0), ("m/s2", 9.807), ("ft/s2", 32.17)])
def test_a_rest_before_a_boost_settles_the_unit(unit: str, one: float) -> None:
    rest = np.full(400, one) * (1 + np.random.default_rng(0).normal(0, 0.001, 400))
    boost = 9 * one * (1 + np.random.default_rng(1).normal(0, 0.02, 100))
    settled = settle_felt(np.concatenate([rest, boost, np.linspace(-one, 0, 500)]))
    assert settled is not None
    assert settled.unit == unit


@pytest.mark.parametrize("net", [False, True])
def test_the_shock_of_a_charge_is_not_taken_for_the_boost(net: bool) -> None:
    random, time = np.random.default_rng(2), np.arange(0, 40, 0.002)
    felt = np.select([time < 3, time < 4.7, time < 9.6], [9.8, 50.0, 0.0], 9.0)
    felt = felt + 150 * np.exp(-(((time - 9.7) / 0.03) ** 2)) + random.normal(0, 0.4, time.size)
    assert rest(felt - 9.8 * net, time) == pytest.approx(0.0 if net else 9.8, abs=0.5)

"""Drag from an accelerometer on the axis: exact on exact samples, whatever its zero and the static ports."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import Figure, measure
from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Push
from fieldkit.analysis.drag_and_impulse import PORT_ERROR, PORTS_SD
from fieldkit.analysis.felt_drag import felt_drag
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import START, learned
from fieldkit.physics.atmosphere import pad_air
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import LARGE, SMALL, Logger, Rocket, fly, log

CHECK_SHAPES = False
END = 4.0
"""Duration of the coast that is used. [s]"""


def drag_of(rocket: Rocket) -> float:
    """The true drag of a coast at the pad. [1/m]"""
    air = pad_air(*(np.array(x) for x in (rocket.elevation, np.nan, np.nan, np.nan)))
    return float(0.5 * air.density * rocket.area / rocket.mass)


def coasting(zero: float = 0.0, noise: float = 0.0, lowest: float = -np.inf) -> tuple[Push, Ascent]:
    """The exact ascent of a small rocket, and its accelerometer with some zero, noise and lowest number. [m/s^2]"""
    truth = fly(SMALL)
    climb = truth.time < truth.apogee_time
    time, height, speed = (values[climb][::5] for values in (truth.time, truth.height, truth.speed))
    felt = truth.felt[climb][::5] + zero + noise * np.random.default_rng(1).standard_normal(time.size)
    drawn = np.zeros((1, time.size))
    ascent = Ascent(time, height, speed, felt - GRAVITY, drawn, drawn, drawn, 0.3, 0.0, fused=True)
    return Push(time, np.maximum(felt, lowest), vertical=False, source="axial acceleration"), ascent


def measured(zero: float = 0.0, noise: float = 0.0, lowest: float = -np.inf) -> float:
    """The drag from those samples relative to the truth, in its standard deviations without those of the scales."""
    found = felt_drag(*coasting(zero, noise, lowest), SMALL.burn + 0.3, SMALL.burn + END)
    assert found is not None
    assert found.sd < 0.06 * found.value
    return found.value / drag_of(SMALL) - 1


@pytest.mark.parametrize("zero", [-1.4, 0.0, 1.4])
def test_exact_samples_have_the_exact_drag_with_any_zero(zero: float) -> None:
    assert measured(zero) == pytest.approx(0.0, abs=0.01)


def test_noisy_samples_have_about_that_drag() -> None:
    assert measured(noise=0.5) == pytest.approx(0.0, abs=0.04)


def test_a_sensor_that_was_saturated_in_the_fast_part_has_the_drag_of_the_rest() -> None:
    truth = coasting()[0].felt
    assert measured(lowest=0.7 * float(truth.min())) == pytest.approx(0.0, abs=0.02)


def test_a_vertical_acceleration_does_not_show_drag() -> None:
    push, ascent = coasting()
    assert felt_drag(replace(push, vertical=True), ascent, SMALL.burn + 0.3, SMALL.burn + END) is None


def test_an_accelerometer_with_an_implausible_zero_does_not_show_drag() -> None:
    assert felt_drag(*coasting(zero=2.0), SMALL.burn + 0.3, SMALL.burn + END) is None


def test_a_coast_of_constant_speed_does_not_show_drag() -> None:
    push, ascent = coasting()
    constant = replace(ascent, speed=np.full(ascent.time.size, 50.0))
    assert felt_drag(push, constant, SMALL.burn + 0.3, SMALL.burn + END) is None


def measured_with_static_ports(rocket: Rocket, error: float, accelerometer: float = 0.0) -> Mapping[str, Figure]:
    """Figures of a log whose static ports are off by a fraction of the dynamic pressure."""
    truth = fly(rocket)
    shown = replace(truth, height=truth.height - error * truth.speed * np.abs(truth.speed) / (2 * GRAVITY))
    logger = Logger(rate=50, noise=0.05, accelerometer=accelerometer)
    return measure(log(shown, logger, np.random.default_rng(2))).figures


def test_static_ports_change_a_drag_from_heights_by_the_stated_multiple_of_their_error() -> None:
    for rocket in (SMALL, LARGE):
        high, low = (measured_with_static_ports(rocket, error)["coast_drag"].value for error in (0.02, -0.02))
        assert np.log(high / low) / 0.04 == pytest.approx(PORT_ERROR, rel=0.3)


def impulse_of(rocket: Rocket) -> float:
    """Thrust over mass, integrated over the burn: the mass is constant. [m/s]"""
    truth = fly(rocket)
    burning = truth.time <= rocket.burn
    return float(np.trapezoid((truth.felt + drag_of(rocket) * truth.speed**2)[burning], truth.time[burning]))


@pytest.mark.parametrize("error", [-0.04, 0.04])
def test_static_ports_do_not_change_what_an_accelerometer_shows(error: float) -> None:
    found = measured_with_static_ports(SMALL, error, accelerometer=100)
    for name, truth, within in (("coast_drag", drag_of(SMALL), 0.07), ("burn_impulse", impulse_of(SMALL), 0.04)):
        assert "acceleration" in found[name].source
        assert found[name].value == pytest.approx(truth, rel=within)


@pytest.mark.parametrize("error", [-0.04, 0.04])
def test_an_impulse_from_heights_is_within_two_standard_deviations_of_such_ports(error: float) -> None:
    found = measured_with_static_ports(SMALL, error)["burn_impulse"]
    assert abs(found.value - impulse_of(SMALL)) < 2 * found.sd


def test_the_prior_of_the_ports_is_the_figure_of_the_analysis() -> None:
    for hyperprior in (START, learned(), CERTIFIED_PRIOR):
        assert hyperprior.sd("coast_drag", "ports") == PORTS_SD
    assert PORTS_SD > PORT_ERROR * STATIC_SD

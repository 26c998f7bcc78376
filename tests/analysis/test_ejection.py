"""When the first charge fired, in logs whose logger marks when it switched its drogue output on."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.analysis import Recorded, measure
from fieldkit.analysis.channels import Push
from fieldkit.analysis.ejection import perhaps_of_opening, shock
from fieldkit.physics.standard_atmosphere import GRAVITY
from tests.analysis.recordings import LARGE, SMALL, Logger, Rocket, Truth, fly, log

flown = cache(fly)
BEGINS = 100.0
"""Lift-off on the clock of the logs. [s]"""


def ejecting(rocket: Rocket, late: float) -> Truth:
    """A flight whose motor ejects this long after the apogee it would have without. [s]"""
    coast = flown(replace(rocket, delay=60.0)).apogee_time - rocket.burn
    return flown(replace(rocket, delay=coast + late))


def marked(truth: Truth, mark: float, accelerometer: float) -> Recorded:
    """What is measured of a log whose drogue event is at a time of the flight. [s]"""
    return measure(log(truth, Logger(accelerometer=accelerometer), np.random.default_rng(1)), {"drogue": BEGINS + mark})


def errors(recorded: Recorded, truth: Truth) -> list[float]:
    """The errors of what follows from the ejection, in standard deviations."""
    names, right = ("apogee_to_eject", "eject_altitude", "descent_speed"), truth.readouts()
    return [abs(recorded.figures[name].value - right[name]) / recorded.figures[name].sd for name in names]


@pytest.mark.parametrize(
    ("late", "accelerometer"), [(-0.7, 100.0), (0.8, 100.0), (1.5, 0.0), (1.5, 100.0), (2.5, 0.0), (4.0, 100.0)]
)
def test_a_motor_ejects_though_the_logger_marks_its_own_output(late: float, accelerometer: float) -> None:
    """A shock, or a braking after a free fall, shows the charge; no charge is connected to the output."""
    truth = ejecting(SMALL, late)
    recorded = marked(truth, truth.apogee_time + 0.1, accelerometer)
    assert recorded.events["ejection"].source != "drogue event of the logger"
    assert recorded.figures["apogee_to_eject"].sd < 0.25
    assert max(errors(recorded, truth)) < 3


@pytest.mark.parametrize("late", [-0.7, -0.1, 0.8])
def test_a_mark_that_no_sample_confirms_is_as_uncertain_as_an_unseen_charge(late: float) -> None:
    truth = ejecting(SMALL, late)
    recorded = marked(truth, truth.apogee_time + 0.1, 0.0)
    assert recorded.events["ejection"].source == "drogue event of the logger"
    assert max(errors(recorded, truth)) < 3


def test_a_mark_whose_charge_is_felt_is_kept() -> None:
    truth = ejecting(LARGE, 0.2)
    recorded = marked(truth, truth.ejection, 100.0)
    assert recorded.events["ejection"].source == "drogue event of the logger"
    assert recorded.events["ejection"].sd < 0.15


@pytest.mark.parametrize(("rate", "speed", "sd"), [(100.0, 2.0, 0.012), (10.0, 2.0, 0.52), (10.0, -50.0, 0.09)])
def test_a_shock_between_wide_samples_may_be_that_of_the_parachute(rate: float, speed: float, sd: float) -> None:
    time = np.arange(0.0, 20.0, 1 / rate)
    push = Push(time, np.where(np.abs(time - 10.0) < 0.3 / rate, 20 * GRAVITY, 0.0), False, "acceleration")
    felt = shock(push, 2.0, 9.4)
    assert felt is not None
    assert perhaps_of_opening(felt, push, speed).sd == pytest.approx(sd, rel=0.1)


@pytest.mark.parametrize("sink", [12.0, 15.0])
def test_a_fall_that_a_main_brakes_later_was_not_free(sink: float) -> None:
    """A fast drogue is hardly slower than a free fall at first, but stays as fast."""
    slow = replace(SMALL, thrust=30.0)
    coast = flown(replace(slow, delay=60.0)).apogee_time - slow.burn
    truth = flown(replace(slow, delay=coast + 0.1, sink=sink, main_sink=5.0, main_height=100.0))
    for seed in (1, 2, 3):
        found = measure(log(truth, Logger(rate=10.0, resolution=1.0), np.random.default_rng(seed)))
        assert "ejection" not in found.events


def test_thrust_before_a_long_climb_is_no_charge() -> None:
    """A log that begins in the boost shows no burnout, and the end of thrust may look like a shock."""
    truth = ejecting(SMALL, 1.2)
    heights, felt = log(truth, Logger(accelerometer=100.0, late=0.4), np.random.default_rng(1))
    time = felt.time - BEGINS
    pulse = np.where(np.abs(time - truth.apogee_time + 6.0) < 0.03, 20 * GRAVITY, 0.0)
    recorded = measure((heights, replace(felt, felt=felt.felt + pulse)))
    assert abs(recorded.figures["apogee_to_eject"].value - truth.readouts()["apogee_to_eject"]) < 0.3

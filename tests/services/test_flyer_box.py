"""The range box: which motors with which delays are in it."""

import pytest

from fieldkit.motors import catalogue
from fieldkit.services.flyer_card import motors_in_box
from fieldkit.settings import BoxedMotors, FlyerCard

pytestmark = pytest.mark.fast


def test_a_boxed_motor_has_only_the_delays_that_are_in_the_box() -> None:
    box = (BoxedMotors("C6-5", 3), BoxedMotors("C6-3", 1), BoxedMotors("H128W-14A", 1), BoxedMotors("D12", 2))
    found = motors_in_box(FlyerCard(box=box), catalogue())
    assert {motor.designation: (motor.delays, count) for motor, count in found.items()} == {
        "C6": ((3.0, 5.0), 4),
        "H128W": ((14.0,), 1),
        "D12": (catalogue().resolve("D12").motor.delays, 2),
    }
    assert motors_in_box(FlyerCard(box=box), catalogue()).keys() == found.keys(), "the same objects each time"


def test_a_motor_that_is_not_in_the_catalog_is_left_out_of_the_box() -> None:
    assert motors_in_box(FlyerCard(box=(BoxedMotors("Z99-3", 1),)), catalogue()) == {}

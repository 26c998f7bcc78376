"""The program finds each item by the name that forms offer for it while a flyer types."""

import pytest

from fieldkit.motors import catalogue
from fieldkit.services.pickers import Names

pytestmark = pytest.mark.fast

NAMES = Names({"rocket": (), "config": (), "site": (), "motor": ()}, catalogue())


def offered(typed: str) -> list[str]:
    return [one.text for one in NAMES.sources()["motor"](typed)]


def test_a_motor_is_offered_with_each_delay_whatever_its_name() -> None:
    assert offered("53F32")[:3] == ["Cesaroni 53F32-3", "Cesaroni 53F32-5", "Cesaroni 53F32-7"]
    assert offered("HP-G75M")[:2] == ["AeroTech HP-G75M-4", "AeroTech HP-G75M-6"]
    assert offered("F24W")[0] == "AeroTech F24W-4"


def test_a_delay_in_the_text_is_offered_before_others() -> None:
    assert offered("c6-5")[:2] == ["Estes C6-5", "Quest C6-5"]
    assert offered("f24-7")[0] == "AeroTech F24W-7"
    assert offered("c6-p")[0] == "Klima C6-P"
    assert offered("c6")[0] == "Estes C6-0"


def test_every_offered_name_finds_its_motor() -> None:
    motors = catalogue()
    for motor in motors.motors:
        names = [one.text for one in NAMES.with_delays(motor)]
        found = [motors.resolve(name) for name in names]
        alone = f"{motor.maker} {motor.designation}"
        assert names == [alone] or all(one.motor is motor and one.delay in motor.delays for one in found)
        assert len(names) == len(set(names))


def test_nearly_all_motors_are_offered_with_all_their_delays() -> None:
    """All except those whose name is already read as another motor."""
    several = [motor for motor in catalogue().motors if len(motor.delays) > 1]
    whole = [motor for motor in several if len(list(NAMES.with_delays(motor))) == len(motor.delays)]
    assert len(whole) > 0.98 * len(several) > 300

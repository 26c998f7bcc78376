"""A rocket exactly at a mass limit is within it, whatever the rounding of the sum with its motor."""

import math

import pytest

from fieldkit.flight import Flight
from fieldkit.messages import message
from fieldkit.motors import Found, catalogue
from fieldkit.planning.check import compared, ratio
from fieldkit.planning.classification import build_of, legal_class, why_high_power
from fieldkit.planning.contest import season
from fieldkit.planning.contest_limits import allowed
from fieldkit.planning.rules import rule_sets
from fieldkit.quantities import in_system

pytestmark = pytest.mark.fast
MOTORS = [motor for motor in catalogue().motors if motor.total_impulse <= 80]


@pytest.mark.parametrize(("over", "verdict"), [(0.0, "ok"), (1e-5, "unsafe")])
def test_a_contest_rocket_of_exactly_the_maximum_mass_is_allowed(over: float, verdict: str) -> None:
    rule = season(2027)
    assert rule.mass is not None
    for motor in MOTORS:
        plan = Flight(dry_mass=rule.mass - motor.loaded_mass + over)
        lines = {line.name: line for line in allowed(rule, plan, Found(motor, None))}
        assert lines["contest mass"].verdict == verdict, motor
        assert lines["contest mass"].text.startswith("650 g") is not bool(over), motor


@pytest.mark.parametrize(("over", "least"), [(0.0, 1), (1e-5, 2)])
def test_a_rocket_of_exactly_1500_g_is_a_model_rocket(over: float, least: int) -> None:
    sets = rule_sets()
    law = next(one for one in sets if one.classes)
    for motor in MOTORS:
        build = build_of(motor, round(1500 - motor.loaded_mass * 1e3, 4) * 1e-3 + over)
        assert legal_class(build, law.classes) == least, motor
        assert over or "at lift-off" not in why_high_power(build, sets), motor


def test_a_value_beyond_a_limit_never_looks_like_the_limit() -> None:
    assert [in_system(message(one), "SI") for one in compared(1.50002, 1.5, "g")] == ["1500.02 g", "1500.00 g"]
    assert [in_system(message(one), "SI") for one in compared(1.4, 1.5, "g")] == ["1400 g", "1500 g"]
    assert in_system(message(compared(math.nan, 1.5, "g")[1]), "SI") == "1500 g"
    assert (ratio(4.96, 5.0, 3.0), ratio(2.999, 5.0, 3.0), ratio(5.04, 5.0)) == ("4.96", "2.99", "5.0")

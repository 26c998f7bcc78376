"""The motor guide at once, by the history network."""

import pytest

from fieldkit.flight.site import Site
from fieldkit.motors import Motor, catalogue
from fieldkit.planning.forecasts import RocketData
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import guide, label
from fieldkit.planning.quick_guide import quick_guide
from tests.inference.history.histories import history

CHECK_SHAPES = False
FLOWN = history(8)
PLAN = FLOWN.flights[-1]


def rocket(flights: int) -> RocketData:
    """A rocket with its first flights."""
    return RocketData(tuple(zip(FLOWN.flights[:flights], FLOWN.found[:flights], strict=True)), ())


def motor(name: str) -> Motor:
    """A motor, or a cluster."""
    return catalogue().resolve_several(name).motor


def test_forecasts_are_near_those_of_the_fit() -> None:
    motors = [motor(name) for name in ("AeroTech F24W", "AeroTech F39T", "Estes D12")]
    by_fit = guide(rocket(8), PLAN, motors, limits(), Site(), draws=400)
    quick = quick_guide(rocket(8), PLAN, motors)
    assert [one.motor for one in quick] == motors
    assert [one.flown for one in quick] == [one.flown for one in by_fit] == [True, False, False]
    for one, fitted in zip(quick, by_fit, strict=True):
        low, middle, high = one.interval
        assert low < middle == one.apogee < high
        assert middle == pytest.approx(fitted.apogee, rel=0.06)
        assert high / low == pytest.approx(
            fitted.interval[2] / fitted.interval[0], rel=0.35
        )  # the network is more cautious
        assert one.top_speed == pytest.approx(fitted.json()["top_speed_mps"], rel=0.05)
        assert (one.first_thrust, one.average_thrust) == (fitted.first_thrust, fitted.average_thrust)


def test_motors_without_an_answer_are_left_out() -> None:
    """A cluster, and one that barely lifts the rocket, whose interval was from 0 to 3000 km."""
    good, weak, cluster = motor("AeroTech F24W"), motor("Estes A3T"), motor("2 x Estes E12")
    (alone,) = quick_guide(rocket(8), PLAN, [good])
    (beside,) = quick_guide(rocket(8), PLAN, [weak, good, cluster])
    assert label(beside.motor) == "AeroTech F24W"
    assert beside.interval == pytest.approx(alone.interval)
    assert quick_guide(rocket(8), PLAN, [cluster]) == []
    assert quick_guide(rocket(8), PLAN.with_changes(dry_mass=5.0), [good]) == []
    assert quick_guide(rocket(0), PLAN, [good]) == []

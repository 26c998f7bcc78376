"""The flights of one rocket as one value."""

import numpy as np
import pytest

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.launch_conditions import AS_USUAL, check_conditions
from fieldkit.flight.plausibility import implausible
from fieldkit.motors import catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import History, flown_and_planned, history_of, together
from fieldkit.physics.thrust_steps import Resolution

pytestmark = pytest.mark.fast

MOTOR = catalogue().resolve("F24-4W")


def flight(number: int, **known: object) -> Flight:
    return Flight(f"F{number}", "Astra", motor="F24-4W", dry_mass=0.3, apogee=200.0).with_changes(**known)


def history() -> History:
    flown = [flight(0, diameter=0.05), flight(1, tags=("off_axis",)), flight(2)]
    return flown_and_planned([(one, MOTOR) for one in flown], [(flight(3).unflown(), MOTOR)] * 2)


def test_a_wind_that_cannot_be_read_is_in_no_fit_and_one_that_can_is_typed() -> None:
    extra = {"wind_aloft": "twelve", "rail_direction": "sideways"}
    with pytest.raises(BadValue, match="wind aloft"):
        check_conditions(flight(0, extra=extra))
    assert implausible(flight(0, extra=extra), MOTOR.motor), "it is in no fit"
    assert history_of([flight(0, extra=extra)], [MOTOR]).conditions == (AS_USUAL,)
    (typed,) = history_of(
        [flight(0, rail_angle=0.1, extra={"wind_aloft": "36km/h", "rail_direction": "away"})], [MOTOR]
    ).conditions
    assert (typed.wind_aloft, typed.rail_direction) == (pytest.approx(10.0), pytest.approx(np.pi))


def test_alternative_plans_share_the_next_place_and_only_clean_flights_are_used() -> None:
    assert history().flight_index == (0, 1, 2, 3, 3)
    assert history().used_in_fit == (True, False, True)


def test_a_part_keeps_the_area_that_its_flights_have_among_all() -> None:
    whole = history()
    part = whole.part(slice(1, None))
    np.testing.assert_array_equal(part.area, whole.area[1:])
    assert (part.flown, part.used_in_fit, part.flight_index) == (2, (False, True), (1, 2, 3, 3))
    assert history_of(part.flights, part.found, 2).area[0] != part.area[0]


def test_the_setup_is_built_once() -> None:
    whole = history()
    assert whole.setup() is whole.setup()
    assert whole.setup() is not whole.setup(Resolution(steps=4))


def test_rockets_simulated_together_fly_as_alone() -> None:
    other = history_of([flight(0, dry_mass=0.5, wind=3.0, extra={"wind_aloft": "12"})], [MOTOR])
    both = fly(together([history(), other]).setup())
    alone = [fly(one.setup()).apogee for one in (history(), other)]
    np.testing.assert_allclose(both.apogee, np.concatenate(alone))

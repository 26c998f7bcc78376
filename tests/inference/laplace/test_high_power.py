"""High-power flights and designs: simulated first flights give back the figures with which they were simulated."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.high_power import (
    Departure,
    DesignForecast,
    departure,
    learn_high_power,
    log_density,
    matched,
)
from fieldkit.model.hyperprior import DESIGN_DRAG, START
from fieldkit.motors import catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup

DIAMETER = 0.1016
FRESH = replace(START, high_power=1.0, design_drag=DESIGN_DRAG)


@cache
def forecast_of(dry_mass: float, cd: float, motor: str = "K550W") -> DesignForecast:
    """A forecast by this simulator for a rocket with a known mass and drag."""
    found = catalogue().resolve(motor)
    plan = Flight("1", "Four Inch", "A", motor, dry_mass=dry_mass, diameter=DIAMETER)
    area = np.array([np.pi / 4 * DIAMETER**2])
    shown = fly(field_setup([replace(plan, delay=60.0)], [found], cd * area)).readouts()
    apogee, speed = (float(np.ravel(shown[name])[0]) for name in ("apogee", "top_speed"))
    return DesignForecast(replace(plan, dry_mass=None, apogee=1.05 * apogee), found, (apogee,), speed)


def simulated(scale: float, drag: float, count: int = 400) -> list[Departure]:
    """Departures drawn with these figures."""
    rng, one = np.random.default_rng(1), departure(forecast_of(3.0, 0.5), FRESH)
    mean, sd = one.moments(replace(FRESH, high_power=scale, design_drag=drag))
    return [replace(one, rocket=str(i), ratios=(mean + sd * rng.normal(),)) for i in range(count)]


@pytest.mark.parametrize(("dry_mass", "cd"), [(3.0, 0.5), (6.0, 0.35), (2.0, 0.8)])
def test_the_rocket_can_be_recovered_from_its_forecast(dry_mass: float, cd: float) -> None:
    assert matched(forecast_of(dry_mass, cd)) == pytest.approx((dry_mass, cd), rel=0.02)


@pytest.mark.thorough
@pytest.mark.sampled
@pytest.mark.parametrize("scale", [0.3, 0.8])
def test_the_total_spread_of_many_simulated_flights_is_learned(scale: float) -> None:
    flights = simulated(scale, scale * DESIGN_DRAG)
    found = learn_high_power(flights, FRESH)
    true = replace(FRESH, high_power=scale, design_drag=scale * DESIGN_DRAG)
    assert flights[0].moments(found)[1] == pytest.approx(flights[0].moments(true)[1], rel=0.12)
    assert sum(log_density(one, found) for one in flights) > sum(log_density(one, FRESH) for one in flights)


def test_without_flights_the_figures_keep_their_starting_values() -> None:
    found = learn_high_power([], FRESH)
    assert (found.high_power, found.design_drag) == pytest.approx((1.0, DESIGN_DRAG), rel=1e-3)


def test_two_programs_that_agree_about_a_flight_count_as_one() -> None:
    once = simulated(0.5, 0.1, 30)
    twice = [replace(one, ratios=one.ratios * 2) for one in once]
    assert learn_high_power(twice, FRESH).high_power == pytest.approx(
        learn_high_power(once, FRESH).high_power, rel=1e-3
    )

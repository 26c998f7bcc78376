"""Designed rockets on high-power motors differ less from their simulation; other flights are unchanged."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.high_power import HIGH_POWER_IMPULSE, closer_to_designs, is_high_power
from fieldkit.model.hyperprior import START
from fieldkit.model.rocket_model import apogee_scatter, base_model
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.planning.rules import rule_sets

pytestmark = pytest.mark.fast

HALF = replace(START, high_power=0.5)
MOTORS = {"designed on F": ("A", "F24"), "designed on I": ("A", "I284W"), "other on I": ("B", "I284W")}
FLIGHTS = [Flight(name, "R", config, motor, dry_mass=1.0, diameter=0.066) for name, (config, motor) in MOTORS.items()]
FOUND = [catalogue().resolve(flight.motor) for flight in FLIGHTS]


def test_mass_thrust_and_apogee_of_designed_high_power_flights_are_scaled_and_drag_is_not() -> None:
    plain = base_model(history_of(FLIGHTS, FOUND), HALF)
    closer = closer_to_designs(plain, {"A": 0.5})
    for before, after in zip(plain.terms, closer.terms, strict=True):
        scaled = before.bends in ("mass", "thrust", "apogee")
        np.testing.assert_allclose(after.weight, before.weight * [1.0, 0.5 if scaled else 1.0, 1.0])
    np.testing.assert_allclose(apogee_scatter(closer), apogee_scatter(plain) * [1.0, 0.5, 1.0])
    np.testing.assert_allclose(apogee_scatter(closer.part(slice(1, 2))), apogee_scatter(plain)[1:2] * 0.5)


def test_a_cluster_of_model_rocket_motors_is_not_high_power() -> None:
    cluster = catalogue().resolve_several("4xF24")
    assert cluster.motor.total_impulse > HIGH_POWER_IMPULSE
    assert not is_high_power(cluster)


def test_the_limit_agrees_with_the_rules() -> None:
    limits = {one.definition["impulse_of_one_ns"] for one in rule_sets() if one.definition}
    assert limits == {HIGH_POWER_IMPULSE}

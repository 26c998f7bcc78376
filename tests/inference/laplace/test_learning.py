"""Learning the hyperprior finds how far things differ that were simulated to differ so, and never loses evidence."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.learning import evidence, learn_hyperprior
from fieldkit.model.hyperprior import START, Hyperprior, Scale
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import Found, catalogue

ROCKETS, FLIGHTS = 8, 4
MOTORS = ("F24", "F39", "E35")
COARSE = replace(START, scatter=Scale((0.5, 1.0, 2.0), 1.0, 0.7), reading=Scale((1.0,), 1.0, 0.7))
"""Few scales: quick, and rockets do not differ in scatter here."""


def fleet(rocket_sd: float, flight_sd: float, seed: int = 3) -> list[list[tuple[Flight, Found]]]:
    """Rockets whose log drag and whose flights' log apogees differ by these standard deviations."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(ROCKETS):
        plans = [
            Flight(f"{i}", f"R{number}", "A", MOTORS[i % 3], dry_mass=0.32, diameter=0.066) for i in range(FLIGHTS)
        ]
        motors = [catalogue().resolve(plan.motor) for plan in plans]
        model = base_model(plans, motors, START)
        truth = np.array([[term.mean for term in model.terms]])
        truth[0, model.names.index("drag")] += rocket_sd * rng.normal()
        shows = shown(model, truth, {})["apogee"][0] * np.exp(flight_sd * rng.normal(size=FLIGHTS))
        found.append(
            [(one.with_changes(apogee=float(x)), motor) for one, x, motor in zip(plans, shows, motors, strict=True)]
        )
    return found


@cache
def taught(rocket_sd: float, flight_sd: float) -> Hyperprior:
    return learn_hyperprior([fleet(rocket_sd, flight_sd)], COARSE, rounds=1, steps=12)


def test_flights_that_scatter_more_are_learned_to() -> None:
    calm, wild = taught(0.3, 0.02), taught(0.3, 0.15)
    assert calm.sd("apogee", "flight") < START.sd("apogee", "flight") < wild.sd("apogee", "flight")
    assert wild.sd("apogee", "flight") == pytest.approx(0.15, rel=0.4)


def test_rockets_that_differ_more_are_learned_to() -> None:
    assert taught(0.05, 0.03).sd("drag", "rocket") < 0.75 * taught(0.6, 0.03).sd("drag", "rocket")


def test_what_is_learned_makes_the_flights_more_likely() -> None:
    flights = [fleet(0.6, 0.12)]
    assert evidence(flights, taught(0.6, 0.12)) > evidence(flights, COARSE) + 1.0


def test_effects_that_the_start_does_not_have_stay_out() -> None:
    assert set(taught(0.3, 0.02).sds) == set(START.sds)
    assert taught(0.3, 0.02).reading.log_sd == START.reading.log_sd

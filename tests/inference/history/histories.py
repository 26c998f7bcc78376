"""Histories of one rocket for tests: readouts simulated without scatter, multiplied by factors chosen in the test."""

from datetime import datetime, timedelta

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import History, history_of
from tests.recorded_curves import recorded as recorded_curve

MOTORS = ("F24-4W", "E35-5W")
READOUTS = ("apogee", "top_speed", "coast_to_apogee")


def history(
    count: int, *, wear: float = 0.0, scatter: float = 0.02, seed: int = 0, recorded: tuple[str, ...] = READOUTS
) -> History:
    """A rocket on two motors, with their curves as recorded, and the plan to fly the first again; drag grows by the
    fraction `wear` per flight, and single flights have the standard deviation `scatter` in drag and thrust."""
    rng = np.random.default_rng(seed)
    plans = [
        Flight(
            flight_id=str(number),
            rocket="Test",
            config="A",
            motor=MOTORS[number % 2],
            dry_mass=0.322,
            diameter=0.066,
            date_time=datetime(2025, 4, 1, 10) + timedelta(days=7 * (number // 3), hours=number % 3),
        )
        for number in range(count + 1)
    ]
    found = [recorded_curve(catalogue().resolve(plan.motor)) for plan in plans]
    model = base_model(history_of(plans, found, flown=count), CERTIFIED_PRIOR)
    truth = np.array([[term.mean for term in model.terms]])
    drag = np.log1p(wear * np.arange(count + 1)) + scatter * rng.normal(size=count + 1)
    readings = shown(model, truth, {"drag": drag[None], "thrust": scatter * rng.normal(size=(1, count + 1))})
    flown = [
        plan.with_changes(**{name: float(readings[name][0, number]) for name in recorded})
        for number, plan in enumerate(plans[:-1])
    ]
    return history_of([*flown, plans[-1]], found, count)

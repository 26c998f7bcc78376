"""Draws of a forecast reach the apogees that their rocket has flown."""

from datetime import datetime

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.term_draws import _sampled, simulated_again
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.model.hyperprior import START
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of

CHECK_SHAPES = False


def test_draws_far_along_the_ridge_of_drag_and_thrust_are_not_too_low() -> None:
    motor = catalogue().resolve("F24-4W")
    flights = [
        Flight(
            flight_id=str(number),
            rocket="Law",
            config="A",
            motor="F24-4W",
            dry_mass=0.322,
            diameter=0.066,
            apogee=250.0 + number % 2,
            date_time=datetime(2025, 5, 1 + number),
        )
        for number in range(6)
    ]
    history = history_of(flights, [motor] * 6)
    model = base_model(history, START)
    result = fit_robustly(model, observe(history, START))
    plain, which = _sampled(result, 400, np.random.default_rng(1))
    moved, _ = simulated_again(result, plain, which)

    def bias(terms: np.ndarray) -> float:
        return float(np.mean(np.log(shown(result.model, terms, {})["apogee"] / 250.5)))

    assert bias(plain) < -0.004, "the tangent plane is above the simulator"
    assert abs(bias(moved)) < 0.3 * abs(bias(plain))

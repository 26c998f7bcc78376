"""The name of a configuration changes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import base_model
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of

MOTOR = catalogue().resolve("C6-5")
ONE = Flight("1", "Law", "A", "C6-5", dry_mass=0.08, diameter=0.034, apogee=150.0)


def rocket(config: str, apogee: float) -> list[tuple[Flight, Found]]:
    """Two flights of a rocket in one configuration."""
    return [(replace(ONE, flight_id=f"{i}", config=config, apogee=apogee + i), MOTOR) for i in range(2)]


@pytest.mark.sampled
@pytest.mark.parametrize("name", ["Estes C6", "the fleet", "fins on tape", "A of Estes C6"])
def test_no_configuration_is_mistaken_for_a_motor_or_the_fleet(name: str) -> None:
    def forecast(config: str) -> list[float]:
        other = [rocket_fit(rocket(config, 220.0), learned())]
        plan = replace(ONE, flight_id="next", config=f"{config}, new", apogee=None)
        (prediction,) = predict(rocket(config, 150.0), [(plan, MOTOR)], Assumed(shared=shared_prior(other)), draws=200)
        return [float(end) for end in np.quantile(prediction.apogee, (0.05, 0.5, 0.95))]

    assert forecast(name) == pytest.approx(forecast("B"))


def test_every_term_of_a_model_has_its_own_name() -> None:
    flights = [replace(ONE, config=config) for config in ("", "the fleet", "Estes C6", "A")]
    names = base_model(history_of(flights, [MOTOR] * 4), learned()).names
    assert len(names) == len(set(names))

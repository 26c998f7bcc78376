"""Quick forecasts: they rest on the hyperprior in use."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import forecast_model
from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.forecast.predict import predict
from fieldkit.inference.history import quick_forecast
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import learned
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from tests.model.test_fleet_drift import MOTOR, RATE, fleet, flown

CHECK_SHAPES = False


def test_quick_answers_follow_a_fleet_that_gets_heavier(monkeypatch: pytest.MonkeyPatch) -> None:
    rockets = fleet(RATE)
    period = period_of(one for own in rockets for one, _ in own)
    shared = shared_prior([rocket_fit(own, learned(), period) for own in rockets[1:]], period)
    *earlier, (last, _) = flown("R0", [0.1, 1, 2, 8.5], RATE)
    assert last.apogee is not None
    plan = last.unflown(), MOTOR
    quick = forecast_at_once(earlier, plan, shared=shared)
    without = replace(learned(), sds={key: sd for key, sd in learned().sds.items() if key != "mass.drift"})
    monkeypatch.setattr(quick_forecast, "learned", lambda: without)
    constant = forecast_at_once(earlier, plan, shared=shared)
    assert last.apogee < constant.apogee_at(0.05)
    assert abs(quick.apogee_at(0.5) - last.apogee) < 0.5 * abs(constant.apogee_at(0.5) - last.apogee)


@pytest.mark.parametrize("motor", ["F39", "D12-5"])
def test_a_rocket_far_from_the_reference_gets_the_forecast_of_the_fit_on_another_motor(motor: str) -> None:
    """Little drag, a strong motor, and less mass than recorded: linear around the reference, the medians were 3% too
    high and 3% too low."""
    plan = Flight("1", "Test", "A", "E35", dry_mass=0.322, diameter=0.066, delay=10.0, rail_length=1.2)
    found = catalogue().resolve(plan.motor)
    model = forecast_model(history_of([plan], [found]))
    off = {"drag": -0.6, "thrust": 0.1, "mass": -0.1}
    levels = {str(term.bends): term.name for term in reversed(model.terms) if term.weight.all()}
    at = [
        term.mean + off.get(str(term.bends), 0.0) * (levels.get(str(term.bends)) == term.name) for term in model.terms
    ]
    apogee = float(shown(model, np.array([at]), {})["apogee"][0, 0])
    flown = [(plan.with_changes(apogee=apogee), found)]
    ahead = plan.with_changes(flight_id="2", motor=motor), catalogue().resolve(motor)
    (fitted,) = predict(flown, [ahead])
    assert forecast_at_once(flown, ahead).apogee_at(0.5) == pytest.approx(np.median(fitted.apogee), rel=0.02)

"""Quick forecasts: they rest on the hyperprior in use."""

from dataclasses import replace

import pytest

from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.inference.history import quick_forecast
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import learned
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

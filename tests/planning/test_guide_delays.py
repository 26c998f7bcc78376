"""The motor guide's times of ejection are those of the coast without a charge."""

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Found, catalogue
from fieldkit.planning.forecasts import Rocket, forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import guide


def test_a_charge_before_apogee_does_not_hide_how_early_it_fires() -> None:
    motor = catalogue().find("AeroTech F24W").motor
    rocket = Rocket((), (), None, 0)
    plan = Flight(rocket="Swift", dry_mass=0.15, diameter=0.03)
    (choice,) = guide(rocket, plan, [motor], limits(), Site())
    (uncharged,) = forecasts(rocket, [(plan.with_changes(motor="AeroTech F24W"), Found(motor, None))], draws=300)
    coast = float(np.median(uncharged.coast_time))
    assert coast > 9.0  # the longest delay for sale is 7 s
    assert dict(choice.ejections) == pytest.approx({4.0: 4.0 - coast, 7.0: 7.0 - coast}, abs=0.2)

"""The motor guide: ejection times refer to the coast without a charge, and flown motors are marked."""

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Found, catalogue
from fieldkit.planning.forecasts import Rocket, forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import guide


def test_it_is_shown_how_early_a_charge_before_apogee_fires() -> None:
    motor = catalogue().find("AeroTech F24W").motor
    rocket = Rocket((), ())
    plan = Flight(rocket="Swift", dry_mass=0.15, diameter=0.03)
    (choice,) = guide(rocket, plan, [motor], limits(), Site())
    (uncharged,) = forecasts(rocket, [(plan.with_changes(motor="AeroTech F24W"), Found(motor, None))], draws=300)
    coast = float(np.median(uncharged.coast_time))
    assert coast > 9.0  # the longest delay for sale is 7 s
    assert dict(choice.ejections) == pytest.approx({4.0: 4.0 - coast, 7.0: 7.0 - coast}, abs=0.2)


def test_a_motor_flown_with_a_longer_delay_than_listed_has_been_flown() -> None:
    motors = catalogue()
    printed = motors.resolve("AeroTech H128W-17A")
    listed = motors.find("AeroTech H128W").motor
    assert printed.motor is not listed
    flight = Flight(
        flight_id="1", rocket="Swift", motor="AeroTech H128W-17A", dry_mass=0.6, diameter=0.04, apogee=900.0
    )
    rocket = Rocket(((flight, printed),), ())
    (choice,) = guide(rocket, Flight(rocket="Swift", dry_mass=0.6, diameter=0.04), [listed], limits(), Site())
    assert choice.flown

"""The motor guide: ejection times refer to the coast without a charge, and flown motors are marked."""

import re
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Found, catalogue
from fieldkit.planning.forecasts import RocketData, forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import guide


def test_it_is_shown_how_early_a_charge_before_apogee_fires() -> None:
    motor = catalogue().find("AeroTech F24W").motor
    rocket = RocketData((), ())
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
    rocket = RocketData(((flight, printed),), ())
    (choice,) = guide(rocket, Flight(rocket="Swift", dry_mass=0.6, diameter=0.04), [listed], limits(), Site())
    assert choice.flown


def test_a_delay_that_often_outlasts_the_flight_is_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """14 s on a rocket that coasts for 5: the flights whose charge fires at all looked like one that fires 6 s late."""
    plan = ["--motor", "H128W-14A", "--dry-mass", "1800g", "--diameter", "4in", "--rail-length", "8ft"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), "delay", "--rocket", "Cert", *plan]) == 0
    text = capsys.readouterr().out
    rows = {line.split()[0]: line for line in text.splitlines() if line.startswith("  ") and " s" in line[:9]}
    assert re.search(r"\d\d% hit the ground", rows["14"])
    assert "hit the ground" not in rows["6"]
    assert "time and speed are of the others" in " ".join(text.split())


@pytest.mark.parametrize(("motor", "wanted", "delay"), [("AeroTech H128W", 8.0, 8.0), ("Estes C6", 4.0, 5.0)])
def test_the_delay_of_the_plan_is_that_of_motors_sold_or_drilled_with_it(
    motor: str, wanted: float, delay: float
) -> None:
    mass = 0.06 if motor == "Estes C6" else 1.4
    plan = Flight(rocket="Swift", dry_mass=mass, diameter=0.025 if mass < 1 else 0.1, delay=wanted)
    (choice,) = guide(RocketData((), ()), plan, [catalogue().find(motor).motor], limits(), Site())
    assert choice.delay == choice.plan.delay == delay
    assert delay in dict(choice.ejections)


def test_a_motor_in_an_open_forecast_has_the_delay_of_that_forecast_unless_the_plan_names_one() -> None:
    motors = catalogue()
    saved = [motors.resolve("Estes C6-3"), motors.resolve("Estes C6-7")]
    plan = Flight(rocket="Swift", dry_mass=0.06, diameter=0.025)
    for delay, expected in ((None, 3.0), (5.0, 5.0)):
        asked = plan.with_changes(delay=delay)
        (choice,) = guide(RocketData((), ()), asked, [saved[0].motor], limits(), Site(), saved=saved)
        assert choice.delay == expected

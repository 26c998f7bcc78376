"""Cd and alpha of single flights come from the forecast model."""

from pathlib import Path

import numpy as np
import pytest
from jaxtyping import config

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import each_at_once
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services.flight_facts import drag_facts
from fieldkit.services.inferred import FlightInference, infer_flights

ONE = Flight(
    "1", "Law", "A", "F24-4W", dry_mass=0.322, diameter=0.066, apogee=250.0, top_speed=72.0, coast_to_apogee=5.5
)


@pytest.fixture
def ledger(tmp_path: Path) -> Ledger:
    return Ledger.open(str(tmp_path / "ledger.db"))


def test_flights_of_any_rockets_are_inferred_the_same_together_and_alone() -> None:
    """All flights are simulated in one batch, and their answers are independent."""
    motors = [catalogue().resolve(name) for name in ("F24-4W", "C6-5", "F39-6T")]
    small = Flight("2", "Small", "A", "C6-5", dry_mass=0.05, diameter=0.025, apogee=180.0)
    bare = ONE.with_changes(flight_id="3", rocket="Bare", motor="F39-6T", diameter=None)
    flights = list(zip((ONE, small, bare), motors, strict=True))
    for (flight, motor), estimate in zip(flights, each_at_once(flights, [None] * 3), strict=True):
        (alone,) = each_at_once([(flight, motor)], [None])
        assert estimate.log_cd == pytest.approx(alone.log_cd, abs=1e-6)
        assert estimate.log_alpha == pytest.approx(alone.log_alpha, abs=1e-6)


def test_more_height_means_less_drag_or_more_thrust(ledger: Ledger) -> None:
    flights = [ONE.with_changes(flight_id=str(n), apogee=height) for n, height in enumerate((230.0, 250.0, 270.0))]
    found = FlightInference(ledger, catalogue()).infer(flights).inferred
    assert found[0].cd > found[1].cd > found[2].cd
    assert all(one.model == "field" and one.json()["provisional"] for one in found)


def test_other_rockets_of_the_flyer_inform_a_flight(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve rockets that all flew low: the next low flight is less surprising and more certain."""
    monkeypatch.setattr(config, "jaxtyping_disable", True)  # the other tests check the shapes of the same functions
    before = FlightInference(ledger, catalogue()).infer([ONE]).inferred[0]
    for n in range(12):
        low = ONE.with_changes(flight_id=f"{n}", rocket=f"R{n}", apogee=205.0, top_speed=64.0, coast_to_apogee=5.0)
        ledger.add([low])
    after = FlightInference(ledger, catalogue()).infer([ONE]).inferred[0]
    assert after.cd_sd < before.cd_sd


def test_a_tagged_flight_is_inferred_like_any_other(ledger: Ledger) -> None:
    ask = FlightInference(ledger, catalogue())
    plain, tagged = ask.infer([ONE, ONE.with_changes(flight_id="2", tags=("weak_launch",))]).inferred
    assert (plain.cd, plain.alpha) == pytest.approx((tagged.cd, tagged.alpha))


def test_without_a_diameter_there_is_thrust_but_no_cd(ledger: Ledger) -> None:
    bare = ONE.with_changes(diameter=None)
    (found,) = FlightInference(ledger, catalogue()).infer([bare]).inferred
    assert found.cd is None
    assert 0.5 < found.alpha < 1.5
    drawn, in_inches = (drag_facts(bare, ledger, catalogue(), system) for system in ("SI", "US"))
    assert (drawn.drag_name, in_inches.drag_name) == ("drag area cm²", "drag area in²")
    assert float(np.median(in_inches.drag / drawn.drag)) == pytest.approx(1 / 2.54**2, rel=0.1)


def test_the_draws_of_a_flight_agree_with_the_printed_figures(ledger: Ledger) -> None:
    ledger.add([ONE])
    (printed,) = infer_flights(ledger, catalogue(), []).inferred
    drawn = drag_facts(ONE, ledger, catalogue())
    assert drawn.drag.mean() == pytest.approx(printed.cd, rel=0.03)
    assert drawn.thrust.mean() == pytest.approx(printed.alpha, rel=0.01)
    assert drawn.drag.std() == pytest.approx(printed.cd_sd, rel=0.06)

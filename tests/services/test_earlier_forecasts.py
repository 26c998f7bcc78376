"""The next forecast is mixed with a simpler method that has forecast the flyer's flights better."""

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.fleet_ratio import fleet_ratio
from fieldkit.forecast.evaluation.uncalibrated import simulate
from fieldkit.forecast.prediction import Prediction
from fieldkit.ledger import Ledger, NewPrediction
from fieldkit.motors import catalogue
from fieldkit.services.forecasts import earlier_forecasts, forecast_from_others, predict_plans, rocket_of
from fieldkit.services.plausible_flights import followed
from tests.commands import Run

CHECK_SHAPES = False
FLIGHTS = 30


def flown(number: int) -> Flight:
    """A flight of a rocket whose apogees rise a little."""
    when = datetime(2026, 5, 1 + number % 28, 8 + number // 28)
    return Flight(str(number), "Astra", "A", "F24-4W", when, dry_mass=0.32, diameter=0.066, apogee=250.0 + number / 10)


def remembered(ledger: Ledger, ahead: float, first: bool = False) -> None:
    """Saved forecasts in which the fleet ratio's log score is higher than the model's by `ahead`. [nat]"""
    payloads = [
        {
            "flight_id": one.flight_id,
            "rocket": one.rocket,
            "flown_m": one.apogee,
            "interval_m": [200.0, 250.0, 300.0],
            "earlier": 0 if first else 5,
            "log_scores": [0.0, ahead, -5.0, -5.0],
        }
        for one in ledger.flights()
    ]
    ledger.keep_predictions([NewPrediction(one, str(n), "Astra", one["flight_id"]) for n, one in enumerate(payloads)])


def forecast(ledger: Ledger) -> Prediction:
    plan = flown(FLIGHTS).unflown(flight_id="")
    (made,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
    return made


@pytest.fixture
def book(tmp_path: Path) -> Path:
    path = tmp_path / "ledger.db"
    with Ledger.open(path) as ledger:
        ledger.add([flown(number) for number in range(FLIGHTS)])
    return path


def test_a_rival_that_did_better_is_mixed_into_forecasts_plans_and_guides(book: Path, run: Run) -> None:
    with Ledger.open(book) as ledger:
        alone = forecast(ledger)
        known = simulate(followed(ledger.flights(), catalogue()))
        (plan,) = simulate([(alone.plan, alone.found)])
        rival = float(np.median(fleet_ratio(known, plan)))
        remembered(ledger, 2.0)
        mixed = forecast(ledger)
        assert rocket_of(ledger, catalogue(), "Astra").earlier == earlier_forecasts(ledger, catalogue())
        left_out = forecast_from_others(ledger, catalogue(), ledger.flights()[3])
    assert mixed.mixed_with["fleet_ratio"] > 0.6
    assert left_out.mixed_with
    before, after = (float(np.median(one.apogee)) for one in (alone, mixed))
    assert abs(after - rival) < abs(before - rival)
    np.testing.assert_array_equal(np.argsort(mixed.apogee), np.argsort(alone.apogee))
    doubled = alone.mixed(2 * alone.apogee, {"scalar": 1.0})
    np.testing.assert_allclose(doubled.apogee / doubled.true_apogee, alone.apogee / alone.true_apogee)
    command = ["predict", "--rocket", "Astra", "--motor", "F24-4W"]
    printed = " ".join(run(*command).out.split())
    assert "mixed with simpler methods that forecast the earlier flights better" in printed
    assert run(*command, "--json").document["predictions"][0]["interval"]["mixed_with"]["fleet_ratio"] > 0.6


@pytest.mark.parametrize(("ahead", "first"), [(-0.1, False), (2.0, True)], ids=["behind", "better at first flights"])
def test_the_model_forecasts_alone_if_no_rival_did_better_at_such_flights(
    book: Path, ahead: float, first: bool
) -> None:
    with Ledger.open(book) as ledger:
        alone = forecast(ledger)
        remembered(ledger, ahead, first)
        found = forecast(ledger)
    assert not found.mixed_with
    assert float(np.median(found.apogee)) == pytest.approx(float(np.median(alone.apogee)))


def test_the_next_flight_of_a_rocket_without_an_apogee_is_a_first_flight_as_in_the_scores(book: Path) -> None:
    other = flown(FLIGHTS).with_changes(rocket="Bumble", flight_id="b1", apogee=None, top_speed=70.0)
    with Ledger.open(book) as ledger:
        ledger.add([other])
        remembered(ledger, 2.0, first=True)
        (made,) = predict_plans(ledger, catalogue(), [other.unflown(flight_id="")], save="nothing")
        assert made.rests_on == 1
        assert made.mixed_with["fleet_ratio"] > 0.6
        assert not forecast(ledger).mixed_with


def test_scores_of_flights_that_changed_no_longer_count(book: Path) -> None:
    with Ledger.open(book) as ledger:
        remembered(ledger, 2.0)
        for number in range(FLIGHTS - 5):
            ledger.tag(str(number), "off_axis")
        assert earlier_forecasts(ledger, catalogue()).count == 5
        assert not forecast(ledger).mixed_with

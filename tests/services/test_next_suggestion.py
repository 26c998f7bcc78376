"""The suggestion after a flight follows from the forecasts' results and the target."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, StoredPrediction
from fieldkit.motors import catalogue
from fieldkit.presentation.after_flight_text import suggestion_line
from fieldkit.services.after_flight import Outcome, outcome
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.next_suggestion import chance_of, suggestion
from fieldkit.services.saved_forecasts import SavedForecast
from fieldkit.settings import Settings

pytestmark = pytest.mark.fast

CHECK_SHAPES = False

FLOWN = [
    Flight(str(n), "Astra", "A", "F24-4W", datetime(2026, 5, n), dry_mass=0.32, diameter=0.066, apogee=apogee)
    for n, apogee in enumerate([250.0, 246.0, 253.0, 249.0, 251.0], start=1)
]


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(FLOWN)
        yield ledger


@pytest.fixture
def last(ledger: Ledger) -> Outcome:
    found = outcome(ledger, catalogue(), ledger.flights("Astra")[-1])
    assert found is not None
    return found


def forecast(flown: float) -> SavedForecast:
    """A forecast of 230 to 270 m, and the flight that followed it."""
    at = {"apogee_m": {"p05": 230.0, "p50": 250.0, "p95": 270.0}}
    made = StoredPrediction(1, datetime.now(UTC), "", "Astra", "", at)
    return SavedForecast(made, replace(FLOWN[0], apogee=flown), ())


def test_without_a_target_repeating_the_flight_is_suggested_with_the_narrower_interval(
    ledger: Ledger, last: Outcome
) -> None:
    found = suggestion(ledger, catalogue(), Settings(), last)
    assert found.kind == "repeat"
    assert 0 < found.narrows < 0.5
    assert "One more flight on F24-4W narrows the interval by" in suggestion_line(found, "SI")


def test_with_a_target_a_motor_that_passes_the_checks_and_ends_near_it_is_named(ledger: Ledger, last: Outcome) -> None:
    found = suggestion(ledger, catalogue(), Settings(target=230.0), last)
    assert found.kind == "motor"
    assert found.apogee is not None
    assert found.apogee[0] <= 230.0 <= found.apogee[2]
    again = FLOWN[-1].unflown(flight_id="", date_time=None).with_changes(motor=found.motor)
    (made,) = predict_plans(ledger, catalogue(), [again], save="nothing")
    assert found.apogee == made.apogee_quantiles(), "the forecast that would be saved"
    assert f"{found.motor}, " in suggestion_line(found, "SI")
    assert "nearest to 230" in suggestion_line(found, "SI")
    assert suggestion(ledger, catalogue(), Settings(target=4.0), last).kind == "repeat", "no motor goes so low"


def test_more_misses_than_by_chance_lead_to_the_loop_and_one_in_ten_does_not(ledger: Ledger, last: Outcome) -> None:
    poor = [forecast(flown) for flown in (250.0, 290.0, 300.0, 285.0)]
    found = suggestion(ledger, catalogue(), Settings(), last, poor)
    assert (found.kind, found.outside, found.forecasts) == ("loop", 3, 4)
    assert suggestion_line(found, "SI").startswith("3 of the last 4 flights ended outside")
    tagged = [replace(one, flight=one.flight.with_changes(tags=("cato",))) for one in poor if one.flight]
    assert suggestion(ledger, catalogue(), Settings(), last, tagged).kind == "repeat", "no model explains an anomaly"
    good = [forecast(flown) for flown in (*[250.0] * 9, 290.0)]
    assert suggestion(ledger, catalogue(), Settings(), last, good).kind == "repeat"


def test_the_probability_of_misses_is_a_binomial_tail() -> None:
    assert chance_of(0, 7) == pytest.approx(1.0)
    assert chance_of(1, 1) == pytest.approx(0.1)
    assert chance_of(2, 3) == pytest.approx(3 * 0.01 * 0.9 + 0.001)

"""Intervals corrected by the results of earlier forecasts."""

import json
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.conformal import (
    MAX_STRETCH,
    MIN_FORECASTS_TO_CORRECT,
    MIN_FORECASTS_TO_NARROW,
    saved_surprises,
    stretch,
    stretched,
    surprise,
)
from fieldkit.forecast.evaluation.forward_in_time import Forecast, corrected_by_earlier
from fieldkit.forecast.prediction import spread_out
from fieldkit.ledger import Ledger, NewPrediction
from fieldkit.motors import catalogue
from fieldkit.presentation.forecast_text import in_words
from fieldkit.services.forecast_record import forecast_record
from fieldkit.services.forecasts import earlier_forecasts, keep_forecasts, predict_plans

pytestmark = pytest.mark.fast

INTERVAL = (80.0, 100.0, 130.0)


def forecast(number: int, flown: float, rocket: str = "Astra") -> Forecast:
    """One of a series of identical forecasts."""
    when = datetime(2026, 1, 1) + timedelta(days=number)
    return Forecast(rocket, str(number), "F24-4", 3, flown, *INTERVAL, np.array(INTERVAL), when=when)


def inside(row: Forecast) -> bool:
    """Whether a flight was in its corrected interval."""
    assert row.corrected is not None
    return row.corrected[0] <= row.flown <= row.corrected[1]


def test_a_flight_at_the_end_of_its_interval_has_a_ratio_of_one() -> None:
    assert [surprise(flown, INTERVAL) for flown in (100.0, 80.0, 130.0)] == pytest.approx([0, 1, 1])
    assert surprise(169.0, INTERVAL) == pytest.approx(2.0)
    assert surprise(150.0, (100.0, 100.0, 100.0)) == float("inf")


def test_too_few_forecasts_change_nothing() -> None:
    assert stretch([3.0] * (MIN_FORECASTS_TO_CORRECT - 1)) is None
    assert stretch([3.0] * MIN_FORECASTS_TO_CORRECT) == 3.0


def test_an_interval_narrows_only_after_a_hundred_forecasts() -> None:
    assert stretch([0.4] * (MIN_FORECASTS_TO_NARROW - 1)) == 1.0
    assert stretch([0.4] * MIN_FORECASTS_TO_NARROW) == pytest.approx(0.4)


def test_an_interval_is_stretched_about_its_median_by_ratio() -> None:
    low, middle, high = stretched(INTERVAL, 2.0)
    assert (low, middle, high) == pytest.approx((64.0, 100.0, 169.0))
    assert stretched(INTERVAL, 1.0) == pytest.approx(INTERVAL)


@pytest.mark.parametrize("spread", [0.05, 0.4])
def test_nine_in_ten_later_flights_are_inside_however_wrong_the_model_is(spread: float) -> None:
    rng = np.random.default_rng(3)
    rows = [forecast(n, float(100 * np.exp(spread * rng.normal()))) for n in range(600)]
    found = corrected_by_earlier(rows)
    own = np.mean([row.p05 <= row.flown <= row.p95 for row in found])
    assert not 0.85 < own < 0.95
    assert 0.86 < np.mean([inside(row) for row in found[MIN_FORECASTS_TO_CORRECT:]]) < 0.94


def test_only_flights_that_flew_before_correct_an_interval() -> None:
    rows = [forecast(-1, 100.0, "Luna"), *(forecast(n, 200.0) for n in range(MIN_FORECASTS_TO_CORRECT))]
    found = {row.flight_id: row for row in corrected_by_earlier(rows)}
    assert found["-1"].corrected is None
    assert found["18"].corrected is None
    assert found["19"].stretch == pytest.approx(surprise(200.0, INTERVAL))


def test_a_flight_scored_twice_is_used_once() -> None:
    one = {"rocket": "Astra", "flight_id": "1", "interval_m": list(INTERVAL)}
    kept = [one | {"flown_m": 130.0}, one | {"flown_m": 169.0}, {"rocket": "Astra", "flight_id": "2", "apogee_m": {}}]
    assert saved_surprises(kept) == pytest.approx([2.0])


@pytest.mark.parametrize(
    "damage",
    [
        {"rocket": ["Astra"]},
        {"flight_id": None},
        {"flown_m": "169"},
        {"flown_m": 10**400},
        {"interval_m": None},
        {"interval_m": [1.0]},
        {"interval_m": [1.0, "2", 3.0]},
        {"interval_m": [[1.0], [2.0], [3.0]]},
        {"interval_m": [1e-320, 1.0, 1e308]},
    ],
)
def test_damaged_results_of_forecasts_are_left_out(damage: dict[str, object], tmp_path: Path) -> None:
    flights = [Flight(str(n), "Astra", apogee=169.0) for n in range(MIN_FORECASTS_TO_CORRECT)]
    saved = {"rocket": "Astra", "flown_m": 169.0, "interval_m": list(INTERVAL), "log_scores": [0.0, 1.0, 1.0]}
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(flights)
        whole = [saved | {"flight_id": one.flight_id} for one in flights]
        payloads = [*whole, whole[0] | damage]
        ledger.keep_predictions([NewPrediction(one, str(n), "Astra", "") for n, one in enumerate(payloads)])
        assert earlier_forecasts(ledger, catalogue()).count == len(flights)


def test_a_score_that_is_not_finite_is_saved_as_missing(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        keep_forecasts(ledger, [replace(forecast(1, 169.0), log_scores=(0.0, float("-inf"), 1.0))])
        (kept,) = ledger.predictions()
    json.dumps(kept.payload, allow_nan=False)  # a server stores only such documents
    assert kept.payload["log_scores"] == [0.0, None, 1.0]


def test_no_record_of_earlier_forecasts_makes_an_interval_infinite() -> None:
    absurd = surprise(260.0, (1e-320, 1.0, 1.0000001))
    assert stretch([absurd] * MIN_FORECASTS_TO_CORRECT) == MAX_STRETCH
    assert np.isfinite(spread_out(np.array([0.0, 1.0, 1e5]), MAX_STRETCH)).all()


def test_a_forecast_is_widened_as_scored_ones_required_and_reports_it(tmp_path: Path) -> None:
    plan = Flight(rocket="Astra", motor="F24-4W", dry_mass=0.3, diameter=0.066)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(str(n), "Astra", apogee=169.0) for n in range(MIN_FORECASTS_TO_CORRECT)])
        (own,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
        keep_forecasts(ledger, [forecast(n, 169.0) for n in range(MIN_FORECASTS_TO_CORRECT)])
        (wide,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
    assert own.stretched_by == 1
    assert not any("earlier forecasts" in line for line in in_words(own))
    interval = forecast_record(wide)["interval"]
    assert (interval["stretched_by"], interval["earlier_forecasts"]) == (pytest.approx(2.0), MIN_FORECASTS_TO_CORRECT)
    assert interval["narrowed_by_flights"] == pytest.approx(forecast_record(own)["interval"]["narrowed_by_flights"])
    assert any(
        f"2.00 times the model's own, calibrated on {MIN_FORECASTS_TO_CORRECT} earlier forecasts" in line
        for line in in_words(wide)
    )
    spans = [np.ptp(np.log(one.apogee_quantiles())) for one in (own, wide)]
    assert spans[1] == pytest.approx(2 * spans[0], rel=1e-5)


@pytest.mark.parametrize("changes", [{"apogee": 100.0}, {"tags": ("cato",)}, None])
def test_a_flight_that_was_changed_tagged_or_removed_no_longer_corrects_intervals(
    tmp_path: Path, changes: dict[str, object] | None
) -> None:
    plan = Flight(rocket="Astra", motor="F24-4W", dry_mass=0.3, diameter=0.066)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(str(n), "Astra", apogee=169.0) for n in range(MIN_FORECASTS_TO_CORRECT)])
        keep_forecasts(ledger, [forecast(n, 169.0) for n in range(MIN_FORECASTS_TO_CORRECT)])
        if changes:
            ledger.edit("Astra/3", **changes)
        else:
            ledger.remove("Astra/3")
        (made,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
    assert made.stretched_by == 1.0

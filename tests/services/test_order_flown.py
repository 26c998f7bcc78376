"""Forecasts follow the order flown: a past flight in its position, and an effect that starts at a renamed flight."""

from collections.abc import Iterator
from dataclasses import asdict
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.conformal import MIN_FORECASTS_TO_CORRECT
from fieldkit.ledger import Ledger, NewPrediction
from fieldkit.motors import catalogue
from fieldkit.planning.forecasts import forecasts
from fieldkit.rocket import Configuration
from fieldkit.selection.candidates import Pattern, Place
from fieldkit.services.forecasts import forecast_from_others, predict_plans, rocket_of
from fieldkit.services.model_versions import version_places

pytestmark = pytest.mark.fast

CHECK_SHAPES = False

CHANGED = 6
"""Flights from this row on are 13% higher."""
FLOWN = [
    Flight(f"F{row}", "Astra", "A", "F24-4W", datetime(2026, 5, 1 + row), dry_mass=0.32, diameter=0.066, apogee=apogee)
    for row, apogee in enumerate([250.0, 246.0, 253.0, 249.0, 251.0, 248.0, 283.0, 280.0, 284.0, 281.0])
]

LASTING_PLACES = [Place("altimeter_scale", "", "F6"), Place(pattern=Pattern("lasting", "F6"))]


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(FLOWN)
        yield ledger


def accept(ledger: Ledger, place: Place) -> None:
    sets = [{"probability": 1.0, "places": [asdict(place)]}]
    names = [flight.flight_id for flight in FLOWN]
    ledger.keep_version("Astra", {"effects": [], "averaged": sets, "flights": names})


def median(ledger: Ledger, flight: Flight) -> float:
    return float(np.median(forecast_from_others(ledger, catalogue(), flight).apogee))


@pytest.mark.parametrize("place", LASTING_PLACES)
def test_a_lasting_change_acts_only_on_flights_after_it(ledger: Ledger, place: Place) -> None:
    accept(ledger, place)
    for row in (2, CHANGED, 8):
        flown = FLOWN[row].apogee
        assert flown is not None
        assert median(ledger, FLOWN[row]) == pytest.approx(flown, rel=0.06)


def test_a_flight_does_not_inform_its_own_forecast_after_an_edit(ledger: Ledger) -> None:
    other = FLOWN[9].with_changes(apogee=150.0)
    made = forecast_from_others(ledger, catalogue(), other)
    assert made.rests_on == len(FLOWN) - 1
    assert float(np.median(made.apogee)) == pytest.approx(median(ledger, FLOWN[9]))


def test_a_flight_before_any_other_starts_from_the_design(ledger: Ledger) -> None:
    new = FLOWN[0].with_changes(rocket="New", flight_id="N0", config="B")
    plain = forecast_from_others(ledger, catalogue(), new)
    ledger.keep_design(Configuration("New", "B", cd=0.3))
    designed = forecast_from_others(ledger, catalogue(), new)
    assert designed.cd.mean() < 0.8 * plain.cd.mean()


def test_an_interval_is_corrected_by_the_forecasts_of_other_flights(ledger: Ledger) -> None:
    before = forecast_from_others(ledger, catalogue(), FLOWN[9])
    others = [Flight(str(number), "Bolt", apogee=300.0) for number in range(1, MIN_FORECASTS_TO_CORRECT)]
    ledger.add(others)
    for flight in (FLOWN[9], *others):
        payload: dict[str, object] = {"flown_m": flight.apogee, "interval_m": [240.0, 250.0, 260.0]}
        payload |= {"rocket": flight.rocket, "flight_id": flight.flight_id}
        ledger.keep_predictions([NewPrediction(payload, flight.flight_id, flight.rocket, flight.flight_id)])
    assert forecast_from_others(ledger, catalogue(), FLOWN[9]).stretched_by == 1.0, "its own result does not count"
    after = forecast_from_others(ledger, catalogue(), FLOWN[8])
    assert after.stretched_by > 4
    assert np.ptp(after.apogee_quantiles()) > 3 * np.ptp(before.apogee_quantiles())


@pytest.mark.parametrize("place", LASTING_PLACES)
def test_a_lasting_change_stays_if_its_first_flight_is_renamed_or_removed(ledger: Ledger, place: Place) -> None:
    accept(ledger, place)
    plan = FLOWN[9].with_changes(flight_id="", apogee=None, date_time=None)

    def draws() -> tuple[np.ndarray, np.ndarray]:
        (made,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
        (planned,) = forecasts(rocket_of(ledger, catalogue(), "Astra"), [(plan, made.found)], draws=1000)
        return made.apogee_quantiles(), planned.apogee_quantiles()

    before = draws()[0]
    (first,) = ledger.ids([FLOWN[CHANGED]])
    ledger.edit(first, flight_id="new name")
    for renamed in draws():
        np.testing.assert_allclose(renamed, before, rtol=1e-6)
    ledger.remove("Astra/new name")
    for removed in draws():
        assert removed[1] == pytest.approx(before[1], rel=0.02)
    ledger.remove(*(f"Astra/F{row}" for row in (7, 8, 9)))
    assert draws()[0][1] == pytest.approx(250.0, rel=0.03), "no flight shows it any longer"


@pytest.mark.parametrize(
    "pattern",
    [
        Pattern("day", "2026-05-02"),
        Pattern("site", "the north field"),
        Pattern("hour"),
        Pattern("count", smooth=True),
        Pattern("lasting", "F6"),
        Pattern("repeated", "F1", every=3),
        Pattern("number", "temperature", smooth=True),
        Pattern("text", "paint", "rough"),
    ],
)
def test_patterns_of_older_versions_of_a_model_are_read(pattern: Pattern) -> None:
    """They were saved as a sentence; now they are saved as a value."""
    older, newer = {"effect": "", "where": str(pattern)}, asdict(Place(pattern=pattern))
    assert version_places({"effects": [older, newer]}) == (Place(pattern=pattern),) * 2

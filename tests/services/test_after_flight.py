"""The plan is the default of the next entry, and an entered flight is compared with its forecast."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.ledger import Ledger, models
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model
from fieldkit.motors import PLUGGED_DELAY, catalogue
from fieldkit.presentation.after_flight_text import apogee_question, outcome_lines
from fieldkit.rocket import Configuration
from fieldkit.services.after_flight import expected_instead, outcome
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.manual_entry import enter, offer, planned_answers, setup_answers
from fieldkit.services.one_offs import flight_beside_others
from fieldkit.services.saved_forecasts import of_flight

pytestmark = pytest.mark.fast

CHECK_SHAPES = False

PAST = [
    Flight(str(n), "Astra", "A", "F24-4W", datetime(2026, 5, n), dry_mass=0.32, diameter=0.066, apogee=apogee)
    for n, apogee in enumerate([250.0, 246.0, 253.0, 249.0], start=1)
]
OTHER = Flight("9", "Bolt", "C", "F39-6T", datetime(2026, 5, 20), dry_mass=0.4, diameter=0.05, apogee=210.0)
PLAN = Flight(rocket="Astra", config="A", motor="F24W", dry_mass=0.33, diameter=0.066, delay=4.0, wind=3.0, site="Mead")


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([*PAST, OTHER])
        yield ledger


def decide(ledger: Ledger, plan: Flight = PLAN) -> None:
    predict_plans(ledger, catalogue(), [plan], save="plan")


def offered(ledger: Ledger, **answers: object) -> dict[str, str]:
    """The defaults of the form, question by question, accepted unless another answer is given."""
    plan, flight, found = planned_answers(ledger), Flight(), {}
    for one in QUESTIONS:
        found[one.name] = text = offer(ledger, flight, one, plan)
        if one.name in ("rocket", "config", "motor"):
            flight = flight.with_changes(**{one.name: answers.get(one.name, text)})
    return found


def test_an_entered_flight_takes_two_fits_of_its_rocket(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    """One without it and one with it, for the next flight as for its comparison with the others."""
    fitted: list[int] = []

    def noted(model: Model, data: Data, **given: bool) -> Fit:
        fitted.append(int(data.seen.any(axis=1).sum()))
        return fit_robustly(model, data, **given)

    monkeypatch.setattr("fieldkit.forecast.predict.fit_robustly", noted)
    new, _ = enter(ledger, PLAN.with_changes(apogee=240.0, site=""))
    assert outcome(ledger, catalogue(), new)
    assert fitted == [len(PAST), len(PAST) + 1]


def test_the_saved_plan_is_offered_next(ledger: Ledger) -> None:
    assert offered(ledger)["rocket"] == "Bolt"
    decide(ledger)
    expected = {"rocket": "Astra", "config": "A", "motor": "F24W-4", "dry_mass": "330 g", "site": "Mead"}
    found = offered(ledger)
    assert {name: found[name] for name in expected} == expected
    assert found["wind"] == "3 m/s"


def test_an_unsaved_forecast_offers_nothing(ledger: Ledger) -> None:
    predict_plans(ledger, catalogue(), [PLAN])
    assert planned_answers(ledger) == {}


def test_another_rocket_or_configuration_has_its_own_defaults(ledger: Ledger) -> None:
    decide(ledger)
    assert offered(ledger, rocket="Bolt")["dry_mass"] == "400 g"
    assert offered(ledger, config="B")["motor"] == "F24-4W"


def test_a_plan_expires_once_it_has_flown_or_after_two_weeks(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    long_ago = (datetime.now(UTC) - timedelta(days=15)).isoformat()
    with monkeypatch.context() as patch:
        patch.setattr(models, "now", lambda: long_ago)
        decide(ledger)
    assert planned_answers(ledger) == {}
    decide(ledger, PLAN.with_changes(wind=4.0))
    assert planned_answers(ledger)
    enter(ledger, PLAN.with_changes(apogee=248.0))
    assert planned_answers(ledger) == {}


def test_saving_a_plan_is_in_the_history_and_can_be_undone_and_redone(ledger: Ledger) -> None:
    decide(ledger)
    assert (ledger.history()[-1].command, ledger.history()[-1].what) == ("forecast", "Astra A on F24W")
    ledger.undo()
    assert ledger.predictions() == []
    assert len(ledger.flights()) == 5
    ledger.redo()
    assert planned_answers(ledger)["rocket"] == "Astra"


def test_redo_does_not_overwrite_a_forecast_made_instead(ledger: Ledger) -> None:
    decide(ledger)
    ledger.undo()
    predict_plans(ledger, catalogue(), [PLAN.with_changes(wind=5.0)])
    with pytest.raises(LedgerError, match="a newer forecast exists"):
        ledger.redo()
    (one,) = ledger.predictions()
    assert "plan" not in one.payload


def test_a_flight_entered_in_the_minute_of_its_forecast_is_compared_with_it(ledger: Ledger) -> None:
    decide(ledger)
    flight, _ = enter(ledger, PLAN.with_changes(motor="F24-4W", apogee=248.0))
    found = of_flight(ledger, catalogue(), flight)
    assert found is not None
    assert found.flown == 248.0


def test_a_flight_without_a_saved_forecast_is_compared_as_on_every_page(ledger: Ledger) -> None:
    flight, _ = enter(ledger, PLAN.with_changes(motor="F24-4W", apogee=248.0))
    found = outcome(ledger, catalogue(), flight)
    beside = flight_beside_others(ledger, catalogue(), flight)
    assert found is not None
    assert beside is not None
    assert not found.kept
    assert found.forecast == beside.interval
    assert found.miss == beside.miss


def test_an_apogee_in_the_wrong_unit_is_questioned_and_a_poor_flight_is_not(ledger: Ledger) -> None:
    flown = PLAN.with_changes(motor="F24-4W")
    for apogee in (245.0, 200.0, 280.0):
        assert expected_instead(ledger, catalogue(), flown.with_changes(apogee=apogee)) is None
    expected = expected_instead(ledger, catalogue(), flown.with_changes(apogee=20.0))
    assert expected is not None
    low, middle, high = expected
    assert low < middle < high
    assert middle == pytest.approx(245.0, rel=0.1)
    assert apogee_question(expected, 20.0, "US").startswith("The apogee is 66 ft. This flight was expected to reach ")


@pytest.mark.parametrize("missing", ["motor", "dry_mass", "apogee"])
def test_without_an_expectation_nothing_is_questioned(ledger: Ledger, missing: str) -> None:
    flown = PLAN.with_changes(motor="F24-4W", apogee=20.0)
    assert (
        expected_instead(ledger, catalogue(), flown.with_changes(**{missing: None if missing != "motor" else ""}))
        is None
    )


def test_a_flight_is_compared_with_its_forecast_and_moves_the_next(ledger: Ledger) -> None:
    decide(ledger)
    flight, _ = enter(ledger, PLAN.with_changes(motor="F24-4W", apogee=225.0))
    found = outcome(ledger, catalogue(), flight)
    assert found is not None
    assert found.kept
    assert found.miss is not None
    assert found.miss < 0
    assert found.next_flight[1] < found.forecast[1]
    assert found.cd[1] != pytest.approx(found.cd[0], rel=1e-3)  # up or down: the wind may explain the miss
    assert np.isfinite([*found.forecast, *found.next_flight, *found.cd]).all()
    lines_shown = " ".join(outcome_lines(found, "US"))
    assert "flown 738 ft" in lines_shown
    assert "low" in lines_shown
    assert "Next on F24-4W: " in lines_shown


def test_a_flight_without_a_forecast_is_compared_with_earlier_flights(ledger: Ledger) -> None:
    flight, _ = enter(ledger, PLAN.with_changes(motor="F24-4W", apogee=245.0))
    found = outcome(ledger, catalogue(), flight)
    assert found is not None
    assert not found.kept
    assert next(iter(outcome_lines(found, "SI"))).startswith("Forecast without it ")


def test_a_first_flight_is_compared_with_the_forecast_from_its_design(ledger: Ledger) -> None:
    ledger.keep_design(Configuration("Comet", "A", 0.32, 0.066, None, 1.4, "comet.ork"))
    plan = Flight(rocket="Comet", config="A", motor="F24W-4", dry_mass=0.32, diameter=0.066)
    (lines_shown,) = predict_plans(ledger, catalogue(), [plan], save="nothing")
    flight = plan.with_changes(flight_id="1", apogee=float(np.median(lines_shown.apogee)))
    ledger.add([flight])
    found = outcome(ledger, catalogue(), flight)
    assert found is not None
    assert found.forecast == pytest.approx(tuple(lines_shown.apogee_quantiles()), rel=0.06)  # no draws, but a normal
    assert found.cd[0] == pytest.approx(lines_shown.cd.mean(), rel=0.01)


@pytest.mark.parametrize(
    ("motor", "text"),
    [
        ("AeroTech HP-I205W", "AeroTech HP-I205W-6"),
        ("Q-Jet D16", "Q-Jet D16-6"),
        ("3 x C6-5", "3 x C6-5"),
        ("3 x C6", "3 x C6-6"),
        ("F24-6W", "F24-6W"),
        ("F24-4W", "F24-6W"),
        ("H128W-14A", "H128W-6"),  # drilled to six seconds
        ("Cesaroni 53F32-12A", "Cesaroni 53F32-6"),
    ],
)
def test_the_delay_of_a_plan_is_offered_with_its_motor(motor: str, text: str) -> None:
    assert setup_answers(PLAN.with_changes(motor=motor, delay=6.0))["motor"] == text
    assert catalogue().resolve_several(text).delay == (5.0 if motor == "3 x C6-5" else 6.0)


def test_a_plugged_motor_is_offered_as_plugged() -> None:
    assert setup_answers(PLAN.with_changes(motor="G69N", delay=PLUGGED_DELAY))["motor"] == "G69N-P"


@pytest.mark.parametrize("apogee", [0.15, 0.5, 1.5, 5.0, 150_000.0])
def test_the_forecast_of_a_flight_does_not_spread_with_its_own_wrong_apogee(ledger: Ledger, apogee: float) -> None:
    """A reading of 0.15 m has a relative error of several hundred percent, the forecast of 250 m has not."""
    flight = PAST[0].with_changes(flight_id="5", date_time=datetime(2026, 5, 9), apogee=apogee)
    ledger.add([flight])
    found = flight_beside_others(ledger, catalogue(), flight)
    if found is not None and found.interval is not None:
        low, middle, high = found.interval
        assert 170 < low < middle < high < 300
        assert not low <= apogee <= high

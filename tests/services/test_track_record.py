"""Saved predictions are scored with the data known when they were made."""

from datetime import datetime
from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services import forecasts
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.saved_forecasts import list_forecasts
from fieldkit.services.track_record import as_planned, record
from tests.commands import Run

CHECK_SHAPES = False


def test_a_saved_prediction_is_scored_with_what_was_known_then(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    base = Flight("1", "Astra", "A", "F24-4W", datetime(2026, 5, 1), dry_mass=0.32, diameter=0.066, apogee=250.0)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([base])
        predict_plans(ledger, catalogue(), [base.unflown(flight_id="3", dry_mass=0.35)])
        ledger.add([base.with_changes(flight_id="2", apogee=240.0)])
        ledger.add([base.with_changes(flight_id="3", dry_mass=0.36, apogee=230.0)])
        made = list_forecasts(ledger, catalogue())
        (row,) = record(ledger, catalogue(), made)
        plan = as_planned(base, made[0].made.payload["made_from"])
        ledger.tag("3", "off_axis")
        assert record(ledger, catalogue(), list_forecasts(ledger, catalogue())) == []
        ledger.undo()
    assert (row.earlier, row.rivals["flight_before"].tolist(), row.flown) == (1, [250.0], 230.0)
    assert (plan.dry_mass, plan.apogee) == (pytest.approx(0.35), None)
    assert row.rivals["scalar"][0] > 0
    assert len(row.draws) == forecasts.QUANTILE_COUNT
    assert made[0].stale
    picture = tmp_path / "score.svg"
    monkeypatch.setenv("COLUMNS", "80")
    out = run("score", "--out", picture).out
    assert "Saved forecasts, made before the flight: 1" in out
    assert "Too few flights to compare the methods" in out
    assert [line for line in out.splitlines() if len(line) > 80] == []
    assert picture.read_bytes().startswith(b"<?xml")
    document = run("score", "--json").document
    assert document["saved"]["stale"] == 1
    assert {"flights", "errors", "coverage90", "corrected", "evaluation", "rivals", "calibration"} <= document.keys()
    assert 0 <= document["flights"][0]["pit"] <= 1


def test_scores_since_a_day_leave_out_earlier_forecasts(tmp_path: Path, run: Run) -> None:
    base = Flight("1", "Astra", "A", "F24-4W", datetime(2026, 5, 1), dry_mass=0.32, diameter=0.066, apogee=250.0)
    later = [base.with_changes(flight_id=str(day), date_time=datetime(2026, 5, day)) for day in (2, 3)]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([base, *later])
    found = []
    for since in ([], ["--since", "2026-05-03"]):
        document = run("score", "--json", *since).document
        found.append([(row["flight_id"], row["p50"]) for row in document["flights"]])
        assert len(document["first_flights"]["flights"]) == (0 if since else 1)
    assert [flight for flight, _ in found[0]] == ["2", "3"]
    assert found[1] == found[0][1:]
    refused = run("score", "--since", "2026-06-01", status=1)
    assert "found no normal flight with an apogee and a dry mass since 2026-06-01" in refused.err

"""How good forecasts were: proper scores, calibration beside chance, and rivals on the same flights."""

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.forward_in_time import Forecast, beside_rivals, corrected_by_earlier, unflown
from fieldkit.forecast.evaluation.rivals import against, judged_report
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.presentation.report.score import check_picture, write_picture
from fieldkit.presentation.score_text import against_the_bar
from fieldkit.scoring.proper_scores import calibration, crps, pit
from fieldkit.services import forecasts
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.saved_forecasts import kept
from fieldkit.services.track_record import as_planned, record

CHECK_SHAPES = False

LEVELS = (np.arange(400) + 0.5) / 400


def season(count: int, bias: float = 0.0, wide: float = 1.0, seed: int = 1, rocket: str = "Astra") -> list[Forecast]:
    """Forecasts of flights that scatter by 5 %, off by a share and as wide as they should be times `wide`."""
    from scipy.special import ndtri

    rng = np.random.default_rng(seed)
    rows = []
    for number in range(count):
        flown = float(200 * np.exp(0.05 * rng.normal()))
        middle = 200 * (1 + bias)
        draws = middle * np.exp(0.05 * wide * ndtri(LEVELS))
        low, high = middle * np.exp(np.array([-1, 1]) * 0.05 * wide * 1.645)
        when = datetime(2026, 1, 1) + timedelta(days=number)
        rivals = (260.0, 230.0 if number % 2 else 170.0, 206.0)
        rows.append(
            Forecast(rocket, str(number), "F24-4", 3, flown, low, middle, high, *rivals, when=when, draws=draws)
        )
    return rows


# Proper scores


def test_the_score_of_one_number_is_its_error_and_of_a_normal_what_the_formula_says() -> None:
    assert crps(np.array([210.0]), 200.0) == 10.0
    draws = np.random.default_rng(2).normal(0.0, 1.0, 40_000)
    assert crps(draws, 0.0) == pytest.approx((np.sqrt(2) - 1) / np.sqrt(np.pi), rel=0.02)  # Gneiting and Raftery, 2007


def test_the_score_is_best_for_the_truth() -> None:
    rng = np.random.default_rng(3)
    truth = rng.normal(0.0, 1.0, 600)
    mean = {
        (shift, wide): np.mean([crps(shift + wide * rng.normal(size=300), y) for y in truth])
        for shift, wide in ((0.0, 1.0), (0.7, 1.0), (0.0, 2.0), (0.0, 0.4))
    }
    assert min(mean, key=lambda key: mean[key]) == (0.0, 1.0)


def test_shares_below_are_even_where_forecasts_are_right_and_not_where_they_are_narrow() -> None:
    right, narrow = (judged_report(season(400, wide=wide, seed=2)).calibration for wide in (1.0, 0.4))
    assert all(one.honest for one in right.intervals)
    low, high = right.expected
    assert sum(low <= count <= high for count in right.counts) >= 8
    assert not any(one.honest for one in narrow.intervals)
    assert narrow.counts[0] > high < narrow.counts[-1]
    assert sum(narrow.counts) == 400


def test_chance_is_the_binomial_range() -> None:
    found = calibration([0.5] * 20)
    assert found.expected == (0.0, 4.0)
    assert found.intervals[-1].expected == (0.8, 1.0)
    assert pit(np.array([1.0, 2.0, 3.0]), 2.0) == 0.5


# Rivals


def test_rivals_are_compared_on_the_same_flights_with_an_interval() -> None:
    found = {one.rival: one for one in judged_report(season(40)).against}
    assert found["certified"].verdict == "better"
    assert found["certified"].less == pytest.approx(found["certified"].theirs - found["certified"].error)
    low, high = found["certified"].interval
    assert 0 < low < found["certified"].less < high
    assert found["persistence"].flights == 40


def test_where_the_scalar_correction_is_better_it_is_said() -> None:
    rows = season(30, bias=0.15) + season(30, seed=2, rocket="Luna")
    report = judged_report(rows)
    assert against(season(30, bias=0.15), "scaled").verdict == "worse"
    assert [rocket for rocket, _ in report.behind] == ["Astra"]
    assert any("Not beaten on Astra" in line and "chance" not in line for line in against_the_bar(report))
    few = judged_report(season(3, bias=0.15))
    assert {one.verdict for one in few.against} == {"unclear"}


def test_a_rival_with_a_spread_is_scored_by_it() -> None:
    rows = season(20)
    from dataclasses import replace

    spread = [replace(row, scaled=row.p50, spreads={"scaled": row.draws}) for row in rows if row.draws is not None]
    assert against(spread, "scaled").crps_less == pytest.approx(0.0)
    assert against(rows, "scaled").crps_less > 0


def test_the_scalar_correction_is_one_plus_the_mean_relative_bias() -> None:
    found = catalogue().resolve("F24-4W")
    flown = [Flight(str(n), "Astra", motor="F24-4W", apogee=apogee) for n, apogee in enumerate((220.0, 260.0, 200.0))]
    earlier = [(flight, found, np.full(5, 200.0)) for flight in flown]
    now = Flight("4", "Astra", motor="F24-4W", apogee=230.0)
    row = beside_rivals(now, found, np.full(9, 225.0), np.full(5, 210.0), earlier, (200.0, 225.0, 250.0))
    bias = np.mean([(flight.apogee or 0) / 200 - 1 for flight in flown])
    assert row.scaled == pytest.approx(210 * (1 + bias))
    assert (row.certified, row.persistence, row.repeated) == (210.0, 200.0, 200.0)
    assert np.median(row.spreads["scaled"]) == pytest.approx(row.scaled)


def test_draws_are_corrected_with_their_interval() -> None:
    rows = corrected_by_earlier(season(60, wide=0.4))
    late = [row for row in rows if row.corrected and row.draws is not None]
    assert late
    ends = np.quantile(late[-1].draws, (0.05, 0.95))
    np.testing.assert_allclose(ends, late[-1].corrected, rtol=0.02)


# Kept predictions


def test_a_kept_prediction_is_scored_against_what_was_known_then(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    base = Flight("1", "Astra", "A", "F24-4W", datetime(2026, 5, 1), dry_mass=0.32, diameter=0.066, apogee=250.0)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([base])
        predict_plans(ledger, catalogue(), [unflown(base).with_changes(flight_id="3", dry_mass=0.35)])
        ledger.add([base.with_changes(flight_id="2", apogee=240.0)])
        ledger.add([base.with_changes(flight_id="3", dry_mass=0.36, apogee=230.0)])
        made = kept(ledger, catalogue())
        (row,) = record(ledger, catalogue(), made)
        plan = as_planned(base, made[0].made.payload["made_from"])
        ledger.tag("3", "off_axis")
        assert record(ledger, catalogue(), kept(ledger, catalogue())) == []
        ledger.undo()
    assert (row.earlier, row.persistence, row.flown) == (1, 250.0, 230.0)
    assert (plan.dry_mass, plan.apogee) == (pytest.approx(0.35), None)
    assert row.scaled > 0
    assert row.draws is not None
    assert len(row.draws) == forecasts.LIKELY
    assert made[0].stale
    picture = tmp_path / "score.svg"
    monkeypatch.setenv("COLUMNS", "80")
    arguments = ["--ledger", str(tmp_path / "ledger.db"), "score"]
    assert main([*arguments, "--out", str(picture)]) == 0
    out = capsys.readouterr().out
    assert "Predictions kept, made before the flight: 1" in out
    assert "these flights cannot tell" in " ".join(out.split())
    assert [line for line in out.splitlines() if len(line) > 80] == []
    assert picture.read_bytes().startswith(b"<?xml")
    assert main([*arguments, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["kept"]["stale"] == 1
    assert {"flights", "errors", "coverage90", "corrected", "evaluation", "rivals", "calibration"} <= document.keys()
    assert document["flights"][0]["pit"] == pytest.approx(document["flights"][0]["pit"])


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_the_calibration_is_drawn(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"score.{kind}"
    write_picture({"kept": None, "replayed": judged_report(season(12))}, file)
    assert file.read_bytes()[:4] == {"png": b"\x89PNG", "pdf": b"%PDF"}[kind]
    with pytest.raises(BadValue, match=r"found 'score\.doc'"):
        check_picture(Path("score.doc"))

"""The model and its rivals on the same flights: scores, differences, verdicts, and their report."""

import json
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.comparison import OWN_FORECAST, against, judged_report, tally
from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.forecast.evaluation.rivals import LABELS, MIXTURE
from fieldkit.forecast.evaluation.stacking import STACKED_RIVALS
from fieldkit.ledger import Ledger
from fieldkit.presentation.report.score import check_picture, write_picture
from fieldkit.presentation.score_text import (
    DIFFERENCE_HEADERS,
    behind_the_bar,
    difference_rows,
    verdict_lines,
    way_rows,
)
from fieldkit.services.scores import LedgerScores
from tests.commands import Run

CHECK_SHAPES = False

LEVELS = (np.arange(400) + 0.5) / 400


def season(count: int, bias: float = 0.0, wide: float = 1.0, seed: int = 1, rocket: str = "Astra") -> list[Forecast]:
    """Forecasts of flights that scatter by 5%, with a bias and an interval width `wide` times the right one."""
    from scipy.special import ndtri

    rng = np.random.default_rng(seed)
    rows = []
    for number in range(count):
        flown = float(200 * np.exp(0.05 * rng.normal()))
        middle = 200 * (1 + bias)
        draws = middle * np.exp(0.05 * wide * ndtri(LEVELS))
        low, high = middle * np.exp(np.array([-1, 1]) * 0.05 * wide * 1.645)
        when = datetime(2026, 1, 1) + timedelta(days=number)
        points = {"uncalibrated": 260.0, "flight_before": 230.0 if number % 2 else 170.0, "scalar": 206.0}
        rivals = {name: np.array([point]) for name, point in points.items()}
        rows.append(Forecast(rocket, str(number), "F24-4", 3, flown, low, middle, high, draws, rivals, when))
    return rows


def test_the_scores_of_every_method_are_those_of_its_draws() -> None:
    rows = season(40)
    own, point = tally(rows, OWN_FORECAST), tally(rows, "uncalibrated")
    flown = np.array([row.flown for row in rows])
    assert point.mean_share == pytest.approx(np.mean(260 / flown - 1))
    assert point.crps == pytest.approx(point.mean_share)
    assert point.interval_score == pytest.approx(20 * point.mean_share)
    assert (point.coverage90, point.bias) == (0.0, pytest.approx(np.mean(260 - flown)))
    assert own.crps < own.mean_share
    assert own.coverage90 == np.mean([row.p05 <= row.flown <= row.p95 for row in rows])
    assert tally(rows, "fleet_ratio").flights == 0


def test_fractions_below_are_uniform_if_forecasts_are_right_and_not_if_they_are_too_narrow() -> None:
    right, narrow = (judged_report(season(400, wide=wide, seed=2)).calibration for wide in (1.0, 0.4))
    assert all(one.honest for one in right.intervals)
    low, high = right.expected
    assert sum(low <= count <= high for count in right.counts) >= 8
    assert not any(one.honest for one in narrow.intervals)
    assert narrow.counts[0] > high < narrow.counts[-1]
    assert sum(narrow.counts) == 400


def test_rivals_are_compared_on_the_same_flights_with_an_interval() -> None:
    found = {one.rival: one for one in judged_report(season(40)).against}
    one = found["uncalibrated"]
    assert (one.verdict, one.crps.verdict, one.interval_score.verdict) == ("better",) * 3
    assert one.error.less == pytest.approx(one.error.theirs - one.error.ours)
    low, high = one.error.interval
    assert 0 < low < one.error.less < high
    assert found["flight_before"].flights == 40
    assert found.keys() == {"uncalibrated", "flight_before", "scalar"}
    half = [replace(row, rivals={} if number % 2 else row.rivals) for number, row in enumerate(season(40))]
    assert against(half, "scalar").flights == 20


def test_the_same_forecasts_have_the_same_scores() -> None:
    rows = [replace(row, rivals={"stacked": row.draws, "fleet_ratio": row.draws[::-1]}) for row in season(40)]
    rows = [replace(row, p05=p05, p50=p50, p95=p95) for row in rows for p05, p50, p95 in [row.issued]]
    for rival in ("stacked", "fleet_ratio"):
        found = against(rows, rival)
        assert (found.error.less, found.crps.less, found.interval_score.less) == (0.0, 0.0, 0.0)
        assert found.verdict == "unclear"


def test_the_coverage_of_the_90_percent_interval_is_one_figure() -> None:
    rows = [replace(row, p05=row.p05 - 30.0, p95=row.p95 + 30.0) for row in season(60)]
    found = judged_report(rows)
    assert found.coverage90 == found.calibration.intervals[-1].held == 1.0


def test_if_the_scalar_correction_is_better_it_is_reported() -> None:
    rows = season(30, bias=0.15) + season(30, seed=2, rocket="Luna")
    report = judged_report(rows)
    assert against(season(30, bias=0.15), "scalar").verdict == "worse"
    assert [rocket for rocket, _ in report.behind] == ["Astra"]
    assert any(
        "Not better than the scalar correction on Astra" in line and "chance" not in line
        for line in behind_the_bar(report)
    )
    assert any(line.startswith("WORSE than: scalar") for line in verdict_lines(judged_report(rows[:30])))
    few = judged_report(season(3, bias=0.15))
    assert {one.verdict for one in few.against} == {"unclear"}


def test_the_verdict_on_the_scalar_correction_is_printed_once() -> None:
    report = judged_report(season(30))
    assert not list(behind_the_bar(report)), "the command prints these after the verdicts on all rivals"
    assert sum("scalar correction" in line for line in verdict_lines(report)) == 1


def test_the_mixture_is_shown_only_if_it_differs() -> None:
    rows = season(20)
    same = judged_report([replace(row, rivals={**row.rivals, MIXTURE: row.draws}) for row in rows])
    other = judged_report([replace(row, rivals={**row.rivals, MIXTURE: row.draws * 1.01}) for row in rows])
    shown = [
        LABELS[MIXTURE] in "".join(map(str, (way_rows(one), difference_rows(one), *verdict_lines(one))))
        for one in (same, other)
    ]
    assert shown == [False, True]


def test_a_rival_with_a_spread_is_scored_by_it() -> None:
    rows = season(20)
    same = [replace(row, rivals={"scalar": row.draws}) for row in rows]
    assert against(same, "scalar").crps.less == pytest.approx(0.0)
    assert against(rows, "scalar").crps.less > 0


def test_a_report_on_no_flights_is_empty() -> None:
    found = judged_report([])
    assert (found.ways, found.against, found.behind) == ((), (), ())


def test_a_whole_ledger_or_one_rocket_can_be_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    base = Flight(config="A", motor="F24-4W", dry_mass=0.32, diameter=0.066)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        for number, rocket in enumerate(("Astra", "Luna", "Astra", "Luna")):
            when = datetime(2026, 5, 1 + number)
            ledger.add([base.with_changes(flight_id=str(number), rocket=rocket, date_time=when, apogee=210.0 + number)])
    monkeypatch.setenv("COLUMNS", "80")
    whole = run("score", "--json").document
    assert [row["flight_id"] for row in whole["flights"]] == ["2", "3"]
    assert [row["flight_id"] for row in whole["first_flights"]["flights"]] == ["0", "1"]
    assert {
        "flights",
        "errors",
        "coverage90",
        "corrected",
        "evaluation",
        "rivals",
        "calibration",
        "saved",
    } <= whole.keys()
    assert whole["stacking"]["weights"] == {"fieldkit": 1.0, **dict.fromkeys(STACKED_RIVALS, 0.0)}
    assert whole["flights"][0]["persistence"] == 210.0
    assert {one["rival"] for one in whole["rivals"]} >= {"uncalibrated", "scalar", "fleet_ratio", "stacked"}
    one = run("score", "--rocket", "Luna", "--json").document
    assert one["flights"][0]["p50"] == whole["flights"][1]["p50"]
    assert [row["rocket"] for row in one["flights"]] == ["Luna"]
    out = run("score").out
    assert [line for line in out.splitlines() if len(line) > 80] == []
    assert "First flights of a rocket: 2" in out
    assert out.count("Too few flights to compare the methods: at least 5 are needed.") == 2
    assert DIFFERENCE_HEADERS[0] not in out


def test_another_hyperprior_can_be_scored_and_nothing_is_saved(tmp_path: Path, run: Run) -> None:
    from fieldkit.model.hyperprior import learned

    card = tmp_path / "card.json"
    card.write_text(json.dumps(learned().with_sds(drag__rocket=0.02, drag__fleet=0.02).json()))
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([Flight("1", "Astra", motor="F24-4W", dry_mass=0.32, diameter=0.066, apogee=210.0)])
    narrow = run("score", "--json", "--hyperprior", card).document["first_flights"]["flights"][0]
    with Ledger.open(file) as ledger:
        assert ledger.predictions() == []
    own = run("score", "--json").document["first_flights"]["flights"][0]
    assert narrow["p95"] / narrow["p05"] < 0.9 * own["p95"] / own["p05"]
    assert "expected a hyperprior card" in run("score", "--hyperprior", tmp_path / "none.json", status=1).err


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_the_calibration_is_plotted(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"score.{kind}"
    write_picture(LedgerScores(None, 0, judged_report(season(12)), judged_report([]), {}, {}, None), file)
    assert file.read_bytes()[:4] == {"png": b"\x89PNG", "pdf": b"%PDF"}[kind]
    with pytest.raises(BadValue, match=r"found 'score\.doc'"):
        check_picture(Path("score.doc"))

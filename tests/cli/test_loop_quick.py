"""`loop --quick` and `predict --quick`: the contract's keys, probabilities of all effects, and nothing is saved."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.inference.history.check import Check
from fieldkit.inference.history.features import effect_names
from fieldkit.ledger import Ledger
from fieldkit.services import quick_look

CHECK_SHAPES = False


@pytest.fixture
def ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A ledger of twelve flights on two days."""
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    rng = np.random.default_rng(0)
    rows = [
        f"{i},2025-05-{1 + i // 6:02d}T{10 + i % 6}:00,Astra,A,322,66,F24-4W,{250 * np.exp(0.02 * rng.normal()):.1f}"
        for i in range(12)
    ]
    table = tmp_path / "flights.csv"
    table.write_text("\n".join(["flight_id,date_time,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m", *rows]))
    path = str(tmp_path / "ledger.db")
    assert main(["--ledger", path, "import", str(table)]) == 0
    return path


def test_every_effect_has_a_probability_and_nothing_is_saved(ledger: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["--ledger", ledger, "loop", "--rocket", "Astra", "--quick", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["evaluation"] == "amortized"
    assert answer["n_flights"] == 12
    chances = answer["probabilities"]
    assert {"none", "unexplained"} < set(chances) <= {"none", "unexplained", *effect_names()}
    assert all(0 <= chance <= 1 for chance in chances.values())
    ranked = [one["probability"] for one in answer["candidates"]]
    assert ranked == sorted(ranked, reverse=True)
    assert len(ranked) == len(chances) - 2
    assert answer["verdict"]["effect"]
    assert 0 < answer["verdict"]["confidence"] <= 1
    assert answer["before"]["mae_m"] > 0
    assert {"mae_m", "rmse_m", "bias_m"} <= set(answer["candidates"][0]["after"])
    with Ledger.open(ledger) as book:
        assert not book.versions("Astra")
        assert not book.predictions()


def test_lines_for_a_flyer_name_the_verdict(ledger: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["--ledger", ledger, "loop", "--quick"]) == 0
    out = capsys.readouterr().out
    assert "verdict:" in out
    assert "none" in out
    assert "unexplained" in out


def test_more_flights_than_in_training_give_a_warning(
    ledger: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    warning = "the network was trained with at most"
    capsys.readouterr()
    assert main(["--ledger", ledger, "loop", "--quick"]) == 0
    assert warning not in capsys.readouterr().out
    monkeypatch.setattr("fieldkit.selection.quick_look.MAX_FLIGHTS", 11)
    assert main(["--ledger", ledger, "loop", "--quick"]) == 0
    assert warning in capsys.readouterr().out
    assert main(["--ledger", ledger, "loop", "--quick", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["beyond_training"] is True


def test_too_few_flights_and_options_of_a_search_are_refused(ledger: str, capsys: pytest.CaptureFixture[str]) -> None:
    for option in ("--effect", "--decline"):
        assert main(["--ledger", ledger, "loop", "--quick", option, "wind"]) == 1
        assert f"{option}: found together with --quick" in capsys.readouterr().err
    with Ledger.open(ledger) as book:
        ids = [flight.flight_id for flight in book.flights()]
    for id in ids[:9]:
        assert main(["--ledger", ledger, "tag", id, "weak_launch"]) == 0
    capsys.readouterr()
    assert main(["--ledger", ledger, "loop", "--quick"]) == 1
    assert "expected at least 4" in capsys.readouterr().err


def test_a_quick_forecast_is_near_that_of_the_fit_and_is_not_saved(
    ledger: str, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    command = ["--ledger", ledger, "predict", "--motor", "F24-4W", "--rocket", "Astra", "--json"]
    assert main([*command, "--quick"]) == 0
    (quick,) = json.loads(capsys.readouterr().out)["predictions"]
    with Ledger.open(ledger) as book:
        assert not book.predictions()
    assert main(command) == 0
    (fit,) = json.loads(capsys.readouterr().out)["predictions"]
    assert quick["apogee_m"]["p50"] == pytest.approx(fit["apogee_m"]["p50"], rel=0.05)
    assert quick["apogee_m"]["p05"] < quick["apogee_m"]["p50"] < quick["apogee_m"]["p95"]
    assert quick["check"]["agrees"] == (quick["evaluation"] == "amortized")
    assert quick["coast_s"] == pytest.approx(fit["coast_s"], rel=0.08)
    assert quick["top_speed_mps"] == pytest.approx(fit["top_speed_mps"], rel=0.05)
    assert quick["ejection_s"] == pytest.approx(fit["ejection_s"], abs=0.3)
    assert quick["rests_on"] == 12


def answered(command: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[dict[str, Any], str]:
    """A quick forecast as a document and as a line."""
    capsys.readouterr()
    assert main([*command, "--quick", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)["predictions"]
    assert main([*command, "--quick"]) == 0
    return document, capsys.readouterr().out


@pytest.mark.parametrize(("k", "effective", "agrees"), [(0.3, 0.9, True), (0.71, 0.9, False), (0.3, 0.2, False)])
def test_an_answer_is_marked_as_checked_only_if_the_check_passed_and_else_the_fit_answers(
    ledger: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    k: float,
    effective: float,
    agrees: bool,
) -> None:
    monkeypatch.setattr(quick_look, "check", lambda answer, linear: Check(k, 0.5, effective, 400))
    command = ["--ledger", ledger, "predict", "--motor", "F24-4W", "--rocket", "Astra"]
    document, line = answered(command, capsys)
    assert document["check"]["agrees"] is agrees
    assert document["evaluation"] == ("amortized" if agrees else "fit")
    assert ("by the network, checked by the fit" in line) is agrees
    capsys.readouterr()
    assert main([*command, "--json"]) == 0
    (fit,) = json.loads(capsys.readouterr().out)["predictions"]
    assert (document["apogee_m"]["p50"] == pytest.approx(fit["apogee_m"]["p50"], rel=1e-3)) is not agrees

"""`loop --quick` and `predict --quick`: the contract's keys, probabilities of all effects, and nothing is saved."""

from pathlib import Path

import numpy as np
import pytest

from fieldkit.inference.history.check import Check
from fieldkit.ledger import Ledger
from fieldkit.physics.effect import effects, spoken
from fieldkit.planning.quick_guide import QUICK_ERROR
from fieldkit.services import quick_look
from tests.commands import Run

CHECK_SHAPES = False
PREDICT = ("predict", "--motor", "F24-4W", "--rocket", "Astra")


@pytest.fixture
def ledger(run: Run, tmp_path: Path) -> Path:
    """A ledger of twelve flights on two days."""
    rng = np.random.default_rng(0)
    rows = [
        f"{i},2025-05-{1 + i // 6:02d}T{10 + i % 6}:00,Astra,A,322,66,F24-4W,{250 * np.exp(0.02 * rng.normal()):.1f}"
        for i in range(12)
    ]
    table = tmp_path / "flights.csv"
    table.write_text("\n".join(["flight_id,date_time,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m", *rows]))
    run("import", table)
    return tmp_path / "ledger.db"


def test_every_effect_has_a_probability_and_nothing_is_saved(ledger: Path, run: Run) -> None:
    answer = run("loop", "--rocket", "Astra", "--quick", "--json").document
    assert answer["evaluation"] == "amortized"
    assert answer["n_flights"] == 12
    chances = answer["probabilities"]
    assert {"none", "unexplained"} < set(chances) <= {"none", "unexplained", *map(spoken, effects())}
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


@pytest.mark.usefixtures("ledger")
def test_lines_for_a_flyer_name_the_verdict(run: Run) -> None:
    out = run("loop", "--quick").out
    assert "verdict:" in out
    assert "none" in out
    assert "unexplained" in out


def test_too_few_flights_and_options_of_a_search_are_refused(ledger: Path, run: Run) -> None:
    for option in ("--effect", "--decline"):
        assert f"{option}: found together with --quick" in run("loop", "--quick", option, "wind", status=1).err
    with Ledger.open(ledger) as book:
        ids = [flight.flight_id for flight in book.flights()]
    for id in ids[:9]:
        run("tag", id, "weak_launch")
    assert "expected at least 4" in run("loop", "--quick", status=1).err


def test_a_quick_forecast_is_near_that_of_the_fit_and_is_not_saved(ledger: Path, run: Run) -> None:
    (quick,) = run(*PREDICT, "--quick", "--json").document["predictions"]
    with Ledger.open(ledger) as book:
        assert not book.predictions()
    (fit,) = run(*PREDICT, "--json").document["predictions"]
    assert quick["apogee_m"]["p50"] == pytest.approx(fit["apogee_m"]["p50"], rel=0.05)
    assert quick["apogee_m"]["p05"] < quick["apogee_m"]["p50"] < quick["apogee_m"]["p95"]
    assert quick["check"]["agrees"] == (quick["evaluation"] == "amortized")
    assert quick["coast_s"] == pytest.approx(fit["coast_s"], rel=0.08)
    assert quick["top_speed_mps"] == pytest.approx(fit["top_speed_mps"], rel=0.05)
    assert quick["ejection_s"] == pytest.approx(fit["ejection_s"], abs=0.3)
    assert quick["rests_on"] == 12


@pytest.mark.usefixtures("ledger")
@pytest.mark.parametrize(("k", "effective", "agrees"), [(0.3, 0.9, True), (0.71, 0.9, False), (0.3, 0.2, False)])
def test_an_answer_is_marked_as_checked_only_if_the_check_passed_and_else_the_fit_answers(
    run: Run, monkeypatch: pytest.MonkeyPatch, k: float, effective: float, agrees: bool
) -> None:
    monkeypatch.setattr(quick_look, "check", lambda answer: Check(k, 0.5, effective, 400))
    (document,) = run(*PREDICT, "--quick", "--json").document["predictions"]
    line = run(*PREDICT, "--quick").out
    assert document["check"]["agrees"] is agrees
    assert document["evaluation"] == ("amortized" if agrees else "fit")
    assert ("at once, checked with the simulator" in line) is agrees
    (fit,) = run(*PREDICT, "--json").document["predictions"]
    assert (document["apogee_m"]["p50"] == pytest.approx(fit["apogee_m"]["p50"], rel=1e-3)) is not agrees


def test_the_quick_motor_guide_lists_the_motors_of_the_guide_and_refuses_what_it_cannot_answer(
    ledger: Path, run: Run
) -> None:
    guide = ("motors", "--fit", "Astra", "--class", "E", "--target", "200m")
    quick, fit = (run(*guide, *more, "--json").document for more in (["--quick"], []))
    assert quick["evaluation"] == "amortized"
    assert {one["motor"] for one in quick["motors"]} == {one["motor"] for one in fit["motors"]}
    thrusts = [one["thrust_to_weight"] for one in quick["motors"]]
    weak = [min(thrust.values()) < 3 for thrust in thrusts]
    assert weak == sorted(weak)  # those too weak last
    offs = [abs(one["apogee_m"]["p50"] - 200) for one, slow in zip(quick["motors"], weak, strict=True) if not slow]
    assert offs == sorted(offs)
    out = " ".join(run(*guide, "--quick").out.split())
    assert QUICK_ERROR in out
    assert f"{quick['motors'][0]['motor']} * {quick['motors'][0]['apogee_m']['p50']:.0f}" in out
    for option in (["--all"], ["--season", "2026"]):
        assert "found --quick with" in run(*guide, "--quick", *option, status=2).err
    new = ("motors", "--fit", "Comet", "--dry-mass", "300g", "--diameter", "60mm", "--mount", "29mm", "--quick")
    assert "found no flights" in run(*new, status=1).err


def test_drag_from_a_log_is_left_to_the_fit(ledger: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A linear pass does not use it, so its answer cannot agree with the fit's."""
    monkeypatch.setattr(quick_look, "check", lambda answer: Check(0.3, 0.5, 0.9, 400))
    with Ledger.open(ledger) as book:
        flight = book.flights()[0]
        book.edit(flight.flight_id, coast_drag=0.003, sd={"coast_drag": 1e-4}, source={"coast_drag": "accel"})
    (document,) = run(*PREDICT, "--quick", "--json").document["predictions"]
    assert document["evaluation"] == "fit"
    assert "a quick answer does not use drag and impulse from logs" in run(*PREDICT, "--quick").out

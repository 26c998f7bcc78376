"""What the planning commands say about plans at the edge: too heavy, too wide, without a charge, pointing downwind."""

import json
from pathlib import Path

import pytest

from tests.commands import Run

SMALL = ("--rocket", "R", "--dry-mass", "60g", "--diameter", "24.8mm")


@pytest.mark.parametrize("command", ["landing", "predict", "daysheet"])
def test_a_rocket_that_does_not_lift_gets_a_sentence_and_no_nan(command: str, run: Run, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.svg"
    out = ("--out", sheet) if command == "daysheet" else ()
    printed = run(command, "--rocket", "R", "--motor", "F24-4W", "--dry-mass", "20kg", "--diameter", "66mm", *out)
    text = printed.out + printed.err + (sheet.read_text(encoding="utf-8") if out else "")
    assert "nan" not in text.lower().replace("finance", "")
    if command == "landing":
        assert "the motor does not lift the rocket off the rail" in text


@pytest.mark.parametrize("command", ["predict", "landing", "delay", "contest"])
def test_a_motor_wider_than_the_body_is_refused(command: str, run: Run) -> None:
    printed = run(command, *SMALL, "--motor", "AeroTech G40W-7", status=1)
    assert "found a motor of 29 mm in a body of 24.8 mm" in printed.err
    assert not printed.out


def test_a_booster_motor_coasts_to_its_apogee_without_a_charge(run: Run) -> None:
    """Its charge lights the next stage; as an ejection it would end the climb at burnout."""
    booster, plugged = (
        json.loads(run("predict", *SMALL, "--motor", name, "--json").out)["predictions"][0]
        for name in ("Estes C6-0", "Estes C6-P")
    )
    assert booster["apogee_m"]["p50"] == pytest.approx(plugged["apogee_m"]["p50"], rel=1e-9)
    assert booster["ejection_s"] is None
    assert "none: a booster motor has no charge" in run("predict", *SMALL, "--motor", "Estes C6-0").out


def test_a_negative_rail_angle_points_away_from_the_wind(run: Run) -> None:
    printed = run("landing", *SMALL, "--motor", "C6-5", "--wind", "3m/s", "--rail-angle", "-25")
    assert "at 25° away from the wind" in printed.out
    assert (
        "at 25° into the wind" in run("landing", *SMALL, "--motor", "C6-5", "--wind", "3m/s", "--rail-angle", "25").out
    )


def test_the_best_delay_is_named_last_of_the_answer(run: Run) -> None:
    last = run("delay", *SMALL, "--motor", "Estes C6").out.partition("\n\n")[0].splitlines()[-1]
    assert last.startswith("  best      ")
    assert "the least likely to open too fast" in last


def test_stages_have_the_checks_of_their_rail_ejection_and_landing(run: Run) -> None:
    stages = ("simulate", "--motor", "D12-0/C6-7", "--booster-mass", "60g", "--dry-mass", "100g", "--diameter", "30mm")
    found = json.loads(run(*stages, "--cd", "0.6", "--json").out)
    lines = {line["check"]: line for line in found["safety"]}
    assert {"rail exit speed", "ejection speed", "landing speed", "stability"} <= set(lines)
    assert lines["ejection speed"]["verdict"] == "ok"
    assert lines["landing speed"]["verdict"] == "unknown"
    assert found["rail_speed_mps"] == pytest.approx(13.3, abs=0.2)


def test_points_of_a_flight_are_printed_to_the_hundredth(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "flights.csv"
    table.write_text("flight_id,rocket,motor,apogee_ft,duration_s\n1,Egg,F39T-6,801,36.55\n2,Egg,F39T-6,805,38\n")
    run("import", table)
    printed = run("contest", "--season", "2027", "--declared", "1,2")
    assert "  2.80 points" in printed.out
    assert "7.80 points, the best 2 of 1, 2" in printed.out

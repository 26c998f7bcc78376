"""Motors by expected points: the fewest first, and a change only if the gain is clear."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import catalogue
from fieldkit.planning.contest import season
from fieldkit.planning.forecasts import RocketData
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_advice import in_season, motor_advice
from fieldkit.planning.motor_guide import MotorChoice, guide, label
from fieldkit.presentation.planning_text import advice_in_words

CHECK_SHAPES = False
RULE = season(2027)


@pytest.fixture(scope="module")
def choices() -> list[MotorChoice]:
    motors = [catalogue().resolve(name).motor for name in ("F39T", "F24W", "G40W")]
    plan = Flight(rocket="Comet", dry_mass=0.4, diameter=0.066, rail_length=2.0)
    return guide(RocketData((), ()), plan, motors, limits(), Site(), 100)


def test_the_fewest_points_are_first_and_motors_that_the_season_forbids_are_left_out(
    choices: list[MotorChoice], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A G of 97 N s is beyond the 80 N s of a season."""
    advice = motor_advice([in_season(one, RULE) for one in choices], RULE, None)
    names = [one.choice.motor.designation for one in advice.ranked]
    assert "G40W" not in names
    means = [one.mean for one in advice.ranked]
    assert means == sorted(means)
    assert (advice.current, advice.gain, advice.clear) == (None, None, False)
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "seasons").mkdir()
    (tmp_path / "seasons" / "2027_motors.txt").write_text("f24w\n")
    judged = {one.motor.designation: in_season(one, RULE) for one in choices}
    reasons = {name: [line.name for line in one.beyond_season] for name, one in judged.items()}
    assert reasons["F24W"] == []
    assert reasons["F39T"] == ["contest motor list"]
    assert reasons["G40W"] == ["contest impulse", "contest motor class", "contest motor list"]
    assert not judged["F39T"].fits
    assert {"contest impulse", "contest motor list"} <= set(judged["G40W"].json()["why_not"])
    listed = motor_advice(list(judged.values()), RULE, None)
    assert [one.choice.motor.designation for one in listed.ranked] == [name for name, one in judged.items() if one.fits]


def test_no_change_is_advised_unless_the_gain_is_clear(choices: list[MotorChoice]) -> None:
    usable = motor_advice(choices, RULE, None).ranked
    best, worst = usable[0].choice, usable[-1].choice
    stay = motor_advice(choices, RULE, label(best.motor))
    assert (stay.gain, stay.clear) == (0.0, False)
    assert f"no change: {best.motor.designation}, flown last" in " ".join(advice_in_words(stay, RULE, listed=False))
    on_target = np.full(100, RULE.target)
    sharp = [
        replace(one, prediction=replace(one.prediction, apogee=on_target + shift))
        for one, shift in ((best, 0.0), (worst, 100.0))
    ]
    move = motor_advice(sharp, RULE, label(worst.motor))
    assert move.gain is not None
    assert move.clear == (move.gain > max(2 * (move.gain_error or 0.0), 1.0))
    assert move.gain > 50
    assert move.json()["change"] == move.clear


@pytest.mark.parametrize("listed", [False, True])
def test_checking_the_motor_list_is_advised_unless_the_flyer_has_a_copy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, listed: bool
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    if listed:
        (tmp_path / "seasons").mkdir()
        (tmp_path / "seasons" / "2027_motors.txt").write_text("AeroTech F39T\n")
    plan = ["--fit", "new", "--class", "F", "--mount", "24mm", "--dry-mass", "400g", "--diameter", "66mm"]
    assert main(["--ledger", f"{tmp_path}/ledger.db", "motors", *plan, "--season", "2027"]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert ("check the season's motor list" in words) != listed
    assert ("only motors on your copy of the season's list; check the rule" in words) == listed

"""Planning: one fit and one batch say what predictions say, and every limit is told in its own line."""

import json
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.loop.desk import flown, predict_plans
from fieldkit.loop.paper.reference import TABLE
from fieldkit.motors import Catalogue, catalogue
from fieldkit.plan.ballast import ballast
from fieldkit.plan.delay import delays
from fieldkit.plan.desk import learn_rocket
from fieldkit.plan.guide import Wanted, fitting, guide, mount_of
from fieldkit.plan.learnt import Learnt, outcomes
from fieldkit.plan.limits import limits
from fieldkit.plan.safety import first_thrust, safety_lines

PLAN = Flight(rocket="Astra", config="A", motor="F24-4W")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The path of a ledger that holds the reference flights."""
    path = str(tmp_path_factory.mktemp("plan") / "ledger.db")
    assert main(["--ledger", path, "import", str(TABLE)]) == 0
    return path


@pytest.fixture(scope="module")
def motors() -> Catalogue:
    return catalogue()


@pytest.fixture(scope="module")
def learnt(path: str, motors: Catalogue) -> Learnt:
    with Ledger.open(path) as ledger:
        return learn_rocket(ledger, motors, PLAN, draws=600)


def test_one_fit_for_all_says_what_a_prediction_says(path: str, motors: Catalogue, learnt: Learnt) -> None:
    names = ["F24-4W", "E16-6W"]
    with Ledger.open(path) as ledger:
        plans = [PLAN.with_changes(motor=name) for name in names]
        predicted = np.array([one.apogee_quantiles() for one in predict_plans(ledger, motors, plans, keep=False)]).T
    flown = outcomes(learnt, [learnt.plan] * 2, [motors.resolve(name) for name in names]).quantiles("apogee")
    assert flown == pytest.approx(predicted, rel=0.04)


def test_the_guide_puts_the_nearest_to_the_target_first(path: str, motors: Catalogue, learnt: Learnt) -> None:
    with Ledger.open(path) as ledger:
        mount = mount_of([motor for _, motor in flown(ledger, motors, "Astra")])
    wanted = Wanted(mount=mount, classes=("E", "F"), impulse=80.0)
    choices = guide(learnt, fitting(motors, wanted), limits(), target=250.0)
    misses = [abs(choice.apogee[1] - 250.0) for choice in choices]
    assert misses == sorted(misses)
    assert all(choice.motor.total_impulse <= 80.0 and choice.motor.available for choice in choices)
    assert all(len(choice.lines) == 6 for choice in choices)


def test_the_first_half_second_is_averaged(motors: Catalogue) -> None:
    motor = motors.resolve("F24-4W").motor
    time = np.linspace(0, 0.5, 20001)
    assert first_thrust(motor) == pytest.approx(np.interp(time, motor.time, motor.thrust).mean(), rel=1e-3)


def test_wind_raises_the_rail_speed_that_is_wanted(motors: Catalogue) -> None:
    motor, some = motors.resolve("F24-4W").motor, np.full(10, 16.0)
    calm, gusty = (Flight(dry_mass=0.3, wind=wind) for wind in (1.0, 9.5))
    verdicts = [
        [line.verdict for line in safety_lines(plan, motor, some, some, 10 * some, limits(), waiver=100.0)]
        for plan in (calm, gusty)
    ]
    assert verdicts[0][0] == "ok"
    assert verdicts[1][:1] + verdicts[1][2:3] == ["unsafe", "unsafe"]
    assert verdicts[0][4] == "unsafe"  # 160 m under a ceiling of 100 m


def test_a_threshold_of_ones_own_is_taken_and_a_strange_one_named(tmp_path: Path) -> None:
    own = tmp_path / "limits.toml"
    own.write_text('[rail_speed]\nvalue = 44\nunit = "ft/s"\n')
    assert limits(own)["rail_speed"].value == pytest.approx(13.41, abs=0.01)
    own.write_text("[rail_sped]\nvalue = 1\n")
    with pytest.raises(BadValue, match="rail_sped"):
        limits(own)


def test_the_best_delay_fires_nearest_to_apogee(motors: Catalogue, learnt: Learnt) -> None:
    judged = delays(learnt, motors.resolve("F67W"), limit=15.0, step=1.0)
    assert judged.delays[0].speed[1] == min(one.speed[1] for one in judged.delays)
    assert judged.delays[0].too_fast < judged.delays[-1].too_fast
    early = next(one for one in judged.delays if one.delay == 1.0)
    assert early.after_apogee[1] < 0
    assert not early.on_sale


def test_the_commands_answer_as_json(path: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["--ledger", path, "motors", "--fit", "Astra", "--class", "F", "--target", "800ft", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["motors"][0]["safety"]
    assert main(["--ledger", path, "delay", "--motor", "F67W", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["coast_s"]["p50"] > 0


def test_ballast_beats_both_neighbours_and_today(motors: Catalogue, learnt: Learnt) -> None:
    found = motors.resolve("F24-4W")
    best = ballast(learnt, found, target=240.0, within=10.0)
    masses = [best.mass + change for change in (-0.03, 0.0, 0.03)]
    plans = [learnt.plan.with_changes(dry_mass=mass) for mass in masses]
    apogee = outcomes(learnt, plans, [found] * 3).of("apogee")
    chances = (np.abs(apogee - 240.0) < 10.0).mean(axis=0)
    assert best.met
    assert chances[1] == max(chances)
    assert best.chance == pytest.approx(chances[1], abs=0.05)
    assert best.chance >= best.today[0]
    assert best.slope < 0


def test_a_target_out_of_reach_says_what_can_be(motors: Catalogue, learnt: Learnt) -> None:
    best = ballast(learnt, motors.resolve("F24-4W"), target=2000.0, within=3.0)
    assert not best.met
    assert best.reach[0] < best.reach[1] < 2000.0


def test_ballast_is_printed_in_grams(path: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["--ledger", path, "ballast", "--target", "800ft", "--motor", "F24"]) == 0
    out = capsys.readouterr().out
    assert "a gram more is -" in out
    assert "dry mass" in out

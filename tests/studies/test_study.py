"""The reference study: each part compared with known values, and the page with the command that writes it."""

import os
import re
import subprocess
import sys
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.uncalibrated import simulate
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.reference.flights import Reference, reference
from studies.histories import histories
from studies.histories import page as histories_page
from studies.paper.assumption_steps import AssumptionStep, step, worlds
from studies.paper.study import parts_of
from studies.paper.two_flights import MAX_PRIOR_SDS, TwoFlights, two_flights
from studies.shortfall import page as shortfall_page
from studies.shortfall import restricted, shortfall
from tests.commands import Run

CHECK_SHAPES = False

DAY = datetime(2026, 5, 2, 10)

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def flights() -> Reference:
    every = reference()
    return every.part(every.valid)


@pytest.fixture(scope="module")
def steps(flights: Reference) -> tuple[AssumptionStep, ...]:
    return tuple(step(world, flights) for world in worlds())


@pytest.fixture(scope="module")
def pair() -> TwoFlights:
    return two_flights(reference())


@pytest.mark.slow
def test_the_page_is_the_output_of_the_command(tmp_path: Path) -> None:
    """In a separate process, because it is the longest computation of all tests."""
    command = [sys.executable, "-m", "fieldkit.cli.main", "study", "reference", "--out", str(tmp_path / "page.md")]
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    written = (ROOT / "docs" / "measured" / "reference_study.md").read_text(encoding="utf-8")
    here = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert_similar(written, here)


def test_the_page_of_the_manual_has_the_tables_and_figures_of_the_study() -> None:
    page, study = (
        (ROOT / "docs" / name).read_text(encoding="utf-8")
        for name in ("reference-study.md", "measured/reference_study.md")
    )
    assert [line for line in page.splitlines() if line.startswith("|") and line not in study] == []
    assert set(NUMBER.findall(page)) - set(NUMBER.findall(study)) == set()


def assert_similar(written: str, here: str) -> None:
    """Check for the same words, and for figures that differ by no more than rounding on another machine."""
    assert NUMBER.sub("#", " ".join(written.split())) == NUMBER.sub("#", " ".join(here.split()))
    for stated, computed in zip(NUMBER.findall(written), NUMBER.findall(here), strict=True):
        assert float(computed) == pytest.approx(float(stated), rel=0.03, abs=0.11)


def test_the_parts_add_up_to_the_published_bias(flights: Reference, steps: tuple[AssumptionStep, ...]) -> None:
    assert sum(part.bias for part in parts_of(flights, steps)) == pytest.approx(12.3, abs=0.05)


def test_the_profile_causes_most_of_the_bias_and_shrinkage_less_than_a_meter(
    flights: Reference, steps: tuple[AssumptionStep, ...]
) -> None:
    biases = [part.bias for part in parts_of(flights, steps)]
    assert sum(biases[:3]) == pytest.approx(13.7, abs=0.1)
    assert 0 < biases[-2] < 1


def test_the_profile_of_a_motor_changes_only_flights_on_it(
    flights: Reference, steps: tuple[AssumptionStep, ...]
) -> None:
    for motor, (before, after) in enumerate(pairwise(steps[:4])):
        moved = np.abs(after.rebuilt - before.rebuilt) > 1e-6
        assert moved.any()
        assert not moved[flights.motor != motor].any()


def test_five_flights_are_below_the_range_of_the_prior_at_first_and_none_later(
    steps: tuple[AssumptionStep, ...],
) -> None:
    assert [step.below for step in steps] == [5, 5, 3, 0, 0, 0, 0, 0]


def test_the_lighter_rocket_should_have_flown_much_higher(pair: TwoFlights) -> None:
    assert pair.flown_gain == pytest.approx(4.9)
    assert pair.lighter_by == pytest.approx(0.126)
    assert 40 < pair.expected_gain[1.0] < 70
    assert pair.expected_gain[0.8] > pair.expected_gain[1.0] > pair.expected_gain[1.2] > pair.flown_gain


def test_every_cause_reproduces_the_apogee_of_the_lighter_flight(pair: TwoFlights) -> None:
    possible = [cause for cause in pair.causes if cause.possible]
    assert {"early_ejection", "motor_thrust", "wind"} <= {
        cause.effect for cause in possible if cause.away < MAX_PRIOR_SDS
    }
    for cause in possible:
        assert cause.shows["apogee"] == pytest.approx(174.7, abs=3.0)


def test_the_apogee_does_not_distinguish_the_causes_but_other_readouts_do(pair: TwoFlights) -> None:
    by_readout = {one.readout: one for one in pair.discriminations}
    assert by_readout["apogee"].distinguished == 0
    assert by_readout["top_speed"].distinguished > 0
    assert by_readout["all five"].distinguished >= max(one.distinguished for one in pair.discriminations)


def test_short_histories_are_left_out() -> None:
    motor = catalogue().resolve("F24")
    flights = [(Flight(str(n), "Kestrel", motor="F24", dry_mass=0.3, apogee=250.0 + n), motor) for n in range(3)]
    assert histories({"Kestrel": flights}) == []
    assert "No rocket has enough flights." in histories_page([], [])


def test_a_history_is_forecast_forward_in_time() -> None:
    motor = catalogue().resolve("F24")
    heights = (250.0, 255.0, 248.0, 252.0, 251.0)
    flights = [
        (Flight(str(n), "Kes|trel", motor="F24", dry_mass=0.3, apogee=height), motor)
        for n, height in enumerate(heights)
    ]
    (one,) = histories({"Kes|trel": flights})
    assert (one.flights, len(one.before), len(one.verdicts)) == (5, 1, 1)
    assert abs(one.before[0]) < 0.1
    assert r"| Kes\|trel | 5 |" in histories_page([one], [])
    assert "| 1 | 5 |" in histories_page([one], [], unnamed=True)


@pytest.mark.thorough
def test_the_shortfall_is_traced_to_its_true_cause() -> None:
    """Flights 20% lower than simulated with Cd 0.6: the bias is present at first and gone with all causes."""
    plans = [
        Flight(str(n), rocket=f"R{n % 3}", motor="F24", dry_mass=0.3 + 0.03 * (n % 3), diameter=0.066, date_time=DAY)
        for n in range(9)
    ]
    flown = [(plan, catalogue().resolve(plan.motor)) for plan in plans]
    low = [
        (one.flight.with_changes(apogee=0.8 * one.simulated * (1 + 0.02 * (-1) ** row)), one.found)
        for row, one in enumerate(simulate(flown))
    ]
    found = shortfall(low)
    assert found.flights == 9
    assert abs(found.ratio - 0.8) < 0.03
    first, last = (np.log1p(step.errors).mean() for step in (found.steps[0], found.steps[-1]))
    assert first > 0.15
    assert abs(last) < 0.5 * first
    assert found.launch_angle_worth < 0
    written = shortfall_page(found, unnamed=True)
    assert "| drag |" in written
    assert "| 3 | 3 |" in written


@pytest.mark.thorough
def test_rockets_of_the_shortfall_may_have_readouts_from_logs_beside_displayed_ones() -> None:
    motor = catalogue().resolve("F24")
    plans = [Flight(str(n), rocket=f"R{n % 2}", motor="F24", dry_mass=0.3, apogee=250.0 + n) for n in range(4)]
    speedy = [plan.with_changes(top_speed=85.0) for plan in plans]
    flown = [(one.with_source(["top_speed"], "baro" if n % 2 else "typed"), motor) for n, one in enumerate(speedy)]
    found = shortfall(flown)
    assert TermName("top_speed", "fleet") in found.joint.names
    assert np.isfinite(found.worth).all()


def test_only_added_causes_are_free_and_no_mean_is_learned() -> None:
    bare, whole = restricted(()), restricted(("drag", "mass", "apogee"))
    assert dict(bare.means) == dict(whole.means) == {"drag": pytest.approx(np.log(0.6))}
    assert bare.sd("drag", "rocket") < 0.01 < 0.1 < whole.sd("drag", "rocket")
    assert bare.sd("mass", "fleet") == 0 < whole.sd("mass", "fleet")


def test_a_page_is_written_to_the_given_file_or_the_reason_is_reported(tmp_path: Path, run: Run) -> None:
    run("study", "rockets", "--out", tmp_path / "page.md")
    assert "No rocket has enough flights." in (tmp_path / "page.md").read_text()
    assert "cannot be written" in run("study", "rockets", "--out", tmp_path / "nowhere" / "page.md", status=1).err


LOGS = ROOT.parent / "shared" / "logs"


@pytest.mark.slow
@pytest.mark.skipif(not LOGS.is_dir(), reason="the published logs are not beside the checkout")
def test_the_page_on_the_journal_is_the_output_of_the_command(tmp_path: Path, run: Run) -> None:
    tables = [str(LOGS / f"altimetertwo__rocketlaunchjournal_{name}.csv") for name in ("rockets", "launches")]
    run("import", *tables)
    run("study", "rockets", "--unnamed", "--out", tmp_path / "page.md")
    _, _, written = (ROOT / "docs" / "journal.md").read_text(encoding="utf-8").partition("---\n\n")
    title, _, printed = (tmp_path / "page.md").read_text(encoding="utf-8").partition("\n\n")
    assert title == "# Effects in real histories"
    assert_similar(written, printed)

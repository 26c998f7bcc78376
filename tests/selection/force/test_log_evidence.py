"""The evidence of several flights' logs, reported with the verdict: recurring terms are named, and one flight decides
nothing."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fieldkit.analysis import Recorded
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure
from fieldkit.selection.force.flights import FREE_TERMS, TOO_SHORT, FlightForce, flight_force
from fieldkit.selection.force.log_evidence import LogEvidence, _comparison, document
from fieldkit.selection.force.one_flight import missing_force
from fieldkit.selection.force.regression import Regression, regression
from fieldkit.selection.force.several_flights import Common, common_law
from fieldkit.selection.force.terms import library
from fieldkit.selection.force.text import climbs_in_words
from fieldkit.services import flight_logs
from fieldkit.services.flight_logs import OLDER_LOGS_NOTE
from tests.commands import Run
from tests.selection.force.test_missing_force import SLOW, climb, forces, noisy

CHECK_SHAPES = False
FLIGHTS = 6
SCATTER_SDS = [CERTIFIED_PRIOR.sd(name, "flight") for name in ("thrust", "drag", "stretch")]
"""Scatter of single flights in thrust, drag and burn time, as in the model. [1]"""


@cache
def flown(term: str, strength: float, seed: int, random_draw_sd: tuple[float, ...] | None = None) -> Regression:
    """A flight compared with the model without its force and scatter, which is random unless it is `random_draw_sd`."""
    thrust, drag, stretch = np.exp(random_draw_sd or np.random.default_rng(seed).normal(size=3) * SCATTER_SDS)
    motor = replace(SLOW.motor, time=SLOW.motor.time * stretch, thrust=SLOW.motor.thrust * thrust / stretch)
    rocket = replace(SLOW, motor=motor, drag_area=SLOW.drag_area * drag)
    return regression(missing_force(noisy(climb(rocket, term, strength), seed, smooth=5), SLOW), library(), FREE_TERMS)


def shared(term: str, strength: float, flights: int = FLIGHTS) -> tuple[Common, ...]:
    return common_law([flown(term, strength, seed) for seed in range(flights)], library())


@pytest.mark.thorough
def test_a_force_in_every_flight_is_found() -> None:
    (found,) = shared("base drag", 0.4)
    assert found.term.effect == "base_drag"
    assert found.value == pytest.approx(0.4, abs=3 * found.sd)
    assert (found.flights, found.seen) == (FLIGHTS, FLIGHTS)


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.25])
def test_a_fraction_of_the_drag_refers_to_the_true_drag(factor: float) -> None:
    """If the model lacks a drag in the coast, its fitted drag is too large, and the fraction does not refer to that."""
    rocket = replace(SLOW, drag_area=factor * SLOW.drag_area)
    climb_ = missing_force(noisy(climb(SLOW, "base drag", 0.4), 1, smooth=5), rocket)
    (value,), (sd,) = regression(climb_, library(), FREE_TERMS).solve(["base drag"])
    assert value == pytest.approx(0.4, abs=3 * sd)


def test_the_scatter_of_single_flights_is_not_a_law() -> None:
    climbs, random = [flown("", 0.0, seed) for seed in range(12)], np.random.default_rng(0)
    drawn = [random.choice(12, 3, replace=False) for _ in range(20)]
    alarms = [bool(common_law([climbs[number] for number in three], library())) for three in drawn]
    assert sum(alarms) <= 1


def test_equal_motor_errors_by_chance_are_not_a_law() -> None:
    same = [flown("", 0.0, seed, (0.025, 0.0, 0.0)) for seed in range(3)]
    assert common_law(same, library()) == ()
    law = common_law(same, [replace(term, random_draw_sd=0.0) for term in library()])
    assert "thrust" in [name for found in law for name in (found.term.name, *found.also)]


def test_a_coefficient_varies_with_its_part_of_the_scatter() -> None:
    scatter_sds = {term.name: term.random_draw_sd for term in library() if term.random_draw_sd}
    climb = flown("", 0.0, 0)
    both = climb.random_draw_sd(["thrust", "longer burn"], scatter_sds)
    assert both == pytest.approx([scatter_sds["thrust"], scatter_sds["longer burn"]])
    pushed = replace(climb, wanted=climb.wanted + 0.025 * climb.columns["thrust"])
    moved = pushed.solve(["rail"])[0] - climb.solve(["rail"])[0]
    assert abs(moved) == pytest.approx(climb.random_draw_sd(["rail"], {"thrust": 0.025}))


@pytest.mark.usefixtures("shapes_checked")
def test_one_flight_decides_nothing_however_strong_its_force() -> None:
    another = flown("base drag", 0.8, 9)
    assert another.cost([]) - another.cost(["base drag"]) > 100
    assert common_law([another], library()) == ()
    together = common_law([another, *(flown("", 0.0, seed) for seed in range(FLIGHTS - 1))], library())
    assert "base drag" not in [found.term.name for found in together]


def test_flights_with_opposite_signs_have_no_common_law() -> None:
    both = [flown("base drag", strength, 1) for strength in (0.4, -0.4)]
    assert all(one.cost([]) > one.cost(["base drag"]) for one in both)
    assert common_law(both, library()) == ()


def one(smoothed: bool = False) -> FlightForce:
    shown_force = flight_force(
        "F1", Recorded(forces=forces(noisy(climb(SLOW, "base drag", 0.4), 1), smoothed=smoothed)), SLOW
    )
    assert isinstance(shown_force, FlightForce)
    return shown_force


@pytest.mark.usefixtures("shapes_checked")
def test_a_climb_is_summarized_in_a_few_points() -> None:
    points = one().points
    assert [point.burning for point in points] == [True] * 4 + [False] * 8
    assert all(np.diff([point.time_from_liftoff for point in points]) > 0)
    assert points[5].force < -3 * points[5].sd


def test_smoothed_heights_constrain_only_the_coast() -> None:
    shown_force = one(smoothed=True)
    assert not any(point.burning for point in shown_force.points)
    assert not {"thrust", "longer burn", "rail"} & set(shown_force.regression.columns)


def test_for_a_log_without_a_climb_the_reason_is_given() -> None:
    assert flight_force("F1", Recorded(notes=("no heights",)), SLOW) == "no heights"
    few = forces(climb(SLOW, "", 0.0).part(np.arange(len(climb(SLOW, "", 0.0).speed)) < 12))
    assert flight_force("F1", Recorded(forces=few), SLOW) == TOO_SHORT


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        ("base_drag", "agrees"),
        ("wind+base_drag", "agrees"),
        ("wind", "another effect"),
        ("none", "more"),
        ("unexplained", "more"),
    ],
)
def test_the_law_is_reported_with_the_verdict(verdict: str, says: str) -> None:
    assert _comparison(verdict, shared("base drag", 0.4), FLIGHTS) == says
    assert _comparison(verdict, (), 1) == ""


def test_a_verdict_that_the_logs_should_show_but_do_not_is_reported() -> None:
    assert _comparison("base_drag", (), FLIGHTS) == "nothing of it"
    assert _comparison("wind", (), FLIGHTS) == ""


def test_without_a_log_nothing_is_reported() -> None:
    silent = LogEvidence((), (), (), "")
    assert list(climbs_in_words(silent)) == []
    assert document(silent)["flights"] == document(silent)["law"] == []


def test_logs_without_evidence_for_the_same_reason_share_a_line() -> None:
    silent = LogEvidence((), (("F1", OLDER_LOGS_NOTE), ("F2", OLDER_LOGS_NOTE), ("F3", "no heights")), (), "")
    assert list(climbs_in_words(silent)) == [
        f"2 logs without a missing force, F1 and 1 more: {OLDER_LOGS_NOTE}",
        "1 log without a missing force, F3: no heights",
    ]


def test_for_a_single_log_it_is_stated_that_it_decides_nothing() -> None:
    (line,) = climbs_in_words(LogEvidence((one(),), (), (), ""))
    assert "base drag" in line
    assert line.endswith("one flight alone is not enough")


def log(seed: int) -> tuple[str, dict[str, float]]:
    """A logger's file of a flight with base drag, and readouts of it."""
    track, random = climb(SLOW, "base drag", 0.4), np.random.default_rng(seed)
    pad, after = np.arange(-2, 0, 0.01), np.arange(0.01, 4, 0.01)
    time = np.concatenate([pad, track.time_from_liftoff, track.time_from_liftoff[-1] + after])
    top = float(track.height[-1])
    height = np.concatenate([0 * pad, track.height, top - 5 * after])
    net = np.concatenate([0 * pad, track.push - GRAVITY, 0 * after]) + 0.3 * random.normal(size=len(time))
    pressure = height_pressure(height) + 3 * random.normal(size=len(time))
    rows = [
        f"6,1,1,{t:.2f},0,x,{a:.3f},{p:.1f},{h:.2f}" for t, a, p, h in zip(time, net, pressure, height, strict=True)
    ]
    head = "#version,serial,flight,time,state,state_name,acceleration,pressure,height"
    fastest = int(np.argmax(track.speed))
    coast = float(track.time_from_liftoff[-1] - track.time_from_liftoff[fastest])
    readouts = {
        "apogee_m": top + random.normal(),
        "top_speed_mps": float(track.speed.max()),
        "coast_to_apogee_s": coast,
    }
    return "\n".join([head, *rows, ""]), readouts


@pytest.mark.slow
def test_the_loop_reports_the_missing_force_of_the_latest_logs(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_logs, "MAX_LOGS", 3)
    rows = ["flight_id,rocket,motor,dry_mass_g,diameter_mm,log,apogee_m,top_speed_mps,coast_to_apogee_s"]
    for number in range(4):
        text, readouts = log(number)
        name = f"f{number}.csv"
        rows.append(f"F{number},Comet,F24-4W,322,66,{name}," + ",".join(f"{value:.2f}" for value in readouts.values()))
        (tmp_path / name).write_text(text)
    (tmp_path / "flights.csv").write_text("\n".join(rows) + "\n")
    run("import", tmp_path / "flights.csv")
    page = tmp_path / "page.html"
    shown_force = run("loop", "--look", "--json", "--report", page).document["missing_force"]
    assert [flight["flight_id"] for flight in shown_force["flights"]] == ["F1", "F2", "F3"]
    assert shown_force["silent"] == [{"flight_id": "F0", "why": OLDER_LOGS_NOTE}]
    assert shown_force["law"][0]["effect"] == "base_drag"
    assert shown_force["law"][0]["flights"] == 3
    assert {point["phase"] for point in shown_force["flights"][0]["points"]} == {"boost", "coast"}
    assert "Missing force along each climb" in page.read_text(encoding="utf-8")

"""A rocket is remembered: what is stated once completes every later plan and flight, and flights count more."""

from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.rocket import Configuration, Rocket
from fieldkit.services.launch_day import save_plan
from fieldkit.services.manual_entry import offer
from fieldkit.services.plans import body, completed, keep_bodies
from fieldkit.settings import Settings
from tests.commands import Run

CHECK_SHAPES = False

STATED = ["--rocket", "Bertha", "--motor", "C6-5"]
BODY = ["--dry-mass", "80g", "--diameter", "41.6mm"]


def masses(run: Run) -> list[object]:
    return [flight.get("dry_mass_g") for flight in run("flights", "--json").document["flights"]]


@pytest.mark.parametrize("command", [["predict"], ["delay"], ["landing", "--wind", "2m/s"]], ids=lambda one: one[0])
def test_a_rocket_planned_by_a_command_is_known_when_its_flight_is_added(run: Run, command: list[str]) -> None:
    saved = run(*command, *STATED, *BODY).err
    assert "saved dry mass 80 g and diameter 41.6 mm of Bertha" in " ".join(saved.split())
    added = " ".join(run("add", *STATED, "--apogee", "420ft").err.split())
    assert "excluded" not in added
    (flight,) = run("flights", "--json").document["flights"]
    assert (flight["dry_mass_g"], flight["diameter_mm"]) == pytest.approx((80.0, 41.6))
    assert run("predict", *STATED, "--json").document["predictions"][0]["flights"] == 1


def test_a_rocket_with_only_a_plan_can_be_planned_again_and_is_listed(run: Run) -> None:
    run("predict", *STATED, *BODY)
    assert "Bertha: dry mass 80 g, diameter 41.6 mm" in run("flights", "--rocket", "Bertha").out
    assert run("predict", *STATED, "--json").document["predictions"][0]["flights"] == 0
    assert "rocket Bertha" in run("undo").out
    assert "--dry-mass" in run("predict", *STATED, status=1).err


def test_a_known_mass_is_saved_once_and_a_new_one_replaces_it(run: Run) -> None:
    run("predict", *STATED, *BODY)
    assert "saved" not in run("predict", *STATED, *BODY).err
    run("predict", *STATED, "--dry-mass", "85g")
    run("add", *STATED, "--apogee", "120m")
    assert masses(run) == pytest.approx([85.0])


def test_an_impossible_mass_is_not_saved(run: Run) -> None:
    run("predict", *STATED, *BODY)
    run("predict", *STATED, "--dry-mass", "20kg", status=None)
    run("add", *STATED, "--apogee", "120m")
    assert masses(run) == pytest.approx([80.0])


def test_a_plan_of_a_flown_configuration_changes_nothing_and_the_flight_counts(run: Run) -> None:
    run("add", *STATED, *BODY, "--apogee", "120m")
    assert "saved" not in run("predict", *STATED, "--dry-mass", "95g").err
    run("add", *STATED, "--apogee", "121m")
    assert masses(run) == pytest.approx([80.0, 80.0])


def test_flights_of_a_rocket_with_a_design_have_its_mass(tmp_path: Path, run: Run) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.keep_design(Configuration("Bertha", "", 0.08, 0.0416, 0.6, 0.7, "bertha.ork"))
    run("add", *STATED, "--apogee", "120m")
    assert masses(run) == pytest.approx([80.0])
    run("predict", *STATED)


def test_a_design_read_again_keeps_what_was_weighed_and_the_plan_uses_it(tmp_path: Path) -> None:
    design = Configuration("Bertha", "A", 0.07, 0.0416, 0.6, 0.7, "bertha.ork")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.keep_design(design)
        assert keep_bodies(ledger, [Flight(rocket="Bertha", config="A", dry_mass=0.08)])
        assert not ledger.keep_design(design)
        (plan,) = completed(ledger, catalogue(), [Flight(rocket="Bertha", config="A", motor="C6-5")])
        assert (plan.dry_mass, plan.diameter) == (0.08, 0.0416)
        assert ledger.rocket("Bertha").cds(["A"]) == {"A": 0.7}


def test_plans_that_differ_on_a_mass_save_none_and_neither_does_one_on_stages(tmp_path: Path) -> None:
    plans = [Flight(rocket="Bertha", motor="C6-5", dry_mass=mass, diameter=0.0416) for mass in (0.08, 0.09)]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        (saved,) = keep_bodies(ledger, plans)
        assert (saved.weighed_mass, saved.measured_diameter) == (None, 0.0416)
        assert keep_bodies(ledger, [Flight(rocket="Two", motor="D12-0/C6-7", dry_mass=0.2)]) == []
        assert keep_bodies(ledger, [Flight(motor="C6-5", dry_mass=0.2)]) == []


def test_a_flight_takes_no_mass_of_another_build_but_a_plan_may() -> None:
    flights, rocket = [Flight("1", "Bertha", "A", dry_mass=0.08, diameter=0.0416)], Rocket("Bertha")
    new = Flight(rocket="Bertha", config="B")
    assert body(new, flights, rocket) == {"dry_mass": None, "diameter": 0.0416}
    assert body(new, flights, rocket, other_builds=True) == {"dry_mass": 0.08, "diameter": 0.0416}
    stated = Rocket("Bertha", (Configuration("Bertha", "B", weighed_mass=0.09),))
    assert body(new, flights, stated)["dry_mass"] == 0.09
    assert body(Flight(rocket="Bertha", config="A"), flights, stated)["dry_mass"] == 0.08


def test_what_is_stated_without_a_configuration_applies_to_all_of_them() -> None:
    rocket = Rocket("Bertha", (Configuration("Bertha", "", weighed_mass=0.08),))
    assert rocket.body("A")["dry_mass"] == 0.08
    named = Rocket("Bertha", (Configuration("Bertha", "A", weighed_mass=0.08),))
    assert (named.body("")["dry_mass"], named.body("B")["dry_mass"]) == (0.08, None)


def test_the_apps_plan_is_remembered_when_its_flight_is_added(tmp_path: Path) -> None:
    mass = next(question for question in QUESTIONS if question.name == "dry_mass")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert save_plan(ledger, {"rocket": "Bertha", "dry_mass": "80 g", "diameter": "41.6 mm"})
        assert offer(ledger, Flight(rocket="Bertha"), mass) == "80 g"
        ledger.undo()
        assert offer(ledger, Flight(rocket="Bertha"), mass) == ""


def test_the_rows_of_a_table_are_completed_like_a_plan_given_by_options(tmp_path: Path, run: Run) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(
            [Flight("1", "Bertha", "A", "C6-5", site="Mead", site_elevation=1500.0, dry_mass=0.08, apogee=120.0)]
        )
        (plan,) = completed(ledger, catalogue(), [Flight(rocket="Bertha", config="A")], Settings(rail_length=2.0))
    assert (plan.site, plan.site_elevation, plan.rail_length) == ("Mead", 1500.0, 2.0)
    table = tmp_path / "plans.csv"
    table.write_text("flight_id,rocket,config,motor\np1,Bertha,A,C6-5\n")
    single, row = (
        run("predict", *given, "--json").document["predictions"][0]
        for given in (["--rocket", "Bertha", "--config", "A", "--motor", "C6-5"], ["--flights", str(table)])
    )
    assert row["conditions"] == single["conditions"]
    assert row["apogee_m"]["p50"] == pytest.approx(single["apogee_m"]["p50"], rel=1e-6)


def test_a_flight_without_a_configuration_has_the_only_one_of_its_rocket_and_its_mass(run: Run) -> None:
    run("add", *STATED, *BODY, "--config", "A", "--apogee", "120m")
    assert "configuration A, the only one of Bertha" in run("add", *STATED, "--apogee", "121m").err
    assert masses(run) == pytest.approx([80.0, 80.0])
    assert [one["config"] for one in run("flights", "--json").document["flights"]] == ["A", "A"]


def test_among_several_configurations_a_flight_names_none_for_its_flyer(run: Run) -> None:
    for name in ("A", "B"):
        run("add", *STATED, *BODY, "--config", name, "--apogee", "120m", "--again")
    assert "which has flown as A, B" in run("add", *STATED, "--apogee", "123m").err
    assert run("flights", "--json").document["flights"][-1]["config"] == ""

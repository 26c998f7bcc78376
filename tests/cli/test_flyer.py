"""The flyer's card: certification, age, rules, rails and the range box, from which planning starts."""

import json
from dataclasses import replace
from datetime import date

import pytest

from fieldkit.settings import BoxedMotors, FlyerCard, read_settings
from tests.commands import Run

PLAN = ("predict", "--rocket", "Big", "--motor", "K550W", "--dry-mass", "5kg", "--diameter", "100mm", "--json")


def check(run: Run, name: str, *more: str) -> dict[str, str]:
    """The check of a plan by its name."""
    (made,) = json.loads(run(*PLAN, *more).out)["predictions"]
    return next(one for one in made["safety"] if one["check"] == name)


@pytest.mark.parametrize(("level", "verdict"), [("none", "unsafe"), ("1", "caution"), ("2", "ok"), ("3", "ok")])
def test_a_plan_is_checked_against_the_certification_of_the_flyer(run: Run, level: str, verdict: str) -> None:
    """1,539 N s require level 2, NAR certification pages; level 1 may fly it as a certification flight."""
    run("flyer", "--certification", level)
    assert check(run, "certification")["verdict"] == verdict


def test_a_card_without_a_level_is_asked_for_it(run: Run) -> None:
    found = check(run, "certification")
    assert found["verdict"] == "caution"
    assert "fieldkit flyer --certification" in found["text"]


def test_the_age_of_the_flyer_counts_on_the_day_of_the_flight(run: Run) -> None:
    run("flyer", "--born", "2009-06-01")
    assert FlyerCard(born="2009-06-01").age(date(2027, 5, 31)) == 17
    assert FlyerCard(born="2009-06-01").age(date(2027, 6, 1)) == 18
    assert FlyerCard(born="2009").age(date(2027, 12, 30)) == 17
    young = check(run, "age", "--date-time", "2027-05-31T10:00")
    assert (young["verdict"], young["mark"]) == ("caution", "U")
    assert check(run, "age", "--date-time", "2027-06-01T10:00")["verdict"] == "ok"


def test_a_plan_takes_the_rules_and_the_longest_rail_of_the_card(run: Run) -> None:
    run("flyer", "--rules", "UKRA", "--rails", "3ft, 1.8m")
    assert read_settings().flyer.rails == pytest.approx((0.9144, 1.8))
    assert "UKRA" in check(run, "ground wind")["source"]
    (made,) = json.loads(run(*PLAN).out)["predictions"]
    assert "assumed" not in next(one for one in made["safety"] if one["check"] == "rail exit speed")["text"]


def test_the_box_holds_motors_with_counts_and_lots_and_narrows_the_guide(run: Run) -> None:
    run("flyer", "--motor", "C6-5", "--count", "3", "--lot", "0412")
    run("flyer", "--motor", "B6-4", "--count", "2")
    run("flyer", "--motor", "B6-4", "--count", "1")
    box = [replace(one, counted="") for one in read_settings().flyer.box]
    assert box == [BoxedMotors("C6-5", 3, "0412"), BoxedMotors("B6-4", 1)]
    body = ("--dry-mass", "60g", "--diameter", "25mm", "--mount", "18mm")
    guide = json.loads(run("motors", "--fit", "Alpha", *body, "--box", "--json").out)
    assert {one["motor"] for one in guide["motors"]} == {"C6", "B6"}
    run("flyer", "--motor", "C6-5", "--count", "0", "--lot", "0412")
    (only,) = json.loads(run("flyer", "--json").out)["box"]
    assert (only["motor"], only["count"], only["lot"]) == ("B6-4", 1, "")


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (("--certification", "4"), "none, 1, 2, 3"),
        (("--born", "soon"), "2009-05-31"),
        (("--motor", "C6-5"), "--count 3"),
        (("--rules", "Nobody"), "expected one of"),
        (("--motor", "ZZ9", "--count", "1"), "ZZ9"),
    ],
)
def test_what_the_card_cannot_hold_is_refused(run: Run, given: tuple[str, ...], why: str) -> None:
    printed = run("flyer", *given, status=None)
    assert printed.status
    assert why in printed.err
    assert read_settings().flyer == FlyerCard()


def test_the_guide_names_the_fitting_motors_that_are_in_the_box(run: Run) -> None:
    run("flyer", "--motor", "C6-5", "--count", "3")
    run("flyer", "--motor", "G80T-7", "--count", "1")
    fit = ("motors", "--fit", "Small", "--dry-mass", "60g", "--diameter", "25mm", "--mount", "18mm", "--class", "B-C")
    assert "in your range box: C6 (3); --box" in " ".join(run(*fit).out.split())
    assert [one["motor"] for one in run(*fit, "--box", "--json").document["motors"]] == ["C6"]


def test_a_flight_takes_its_motor_out_of_the_box_until_it_is_undone(run: Run) -> None:
    run("flyer", "--motor", "C6-5", "--count", "3")
    flight = ("--rocket", "Small", "--motor", "C6-5", "--dry-mass", "60g", "--diameter", "25mm", "--apogee", "150m")
    assert "Taken from your range box: 1 x C6-5, 2 left." in run("add", *flight).err
    assert "box            2 x C6-5 (3 counted on" in run("flyer").out
    assert run("flyer", "--json").document["box"][0]["count"] == 2
    assert "range box" not in run("add", *flight, "--again", "--date-time", "2020-05-01T10:00").err
    run("undo")
    run("undo")
    assert run("flyer").out.splitlines()[-1] == "box            3 x C6-5"

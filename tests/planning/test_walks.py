"""Three flyers from their kit to the result, by commands: a kit that never flew, a contest season, a certification."""

from pathlib import Path

import pytest

from tests.commands import Run

CHECK_SHAPES = False
pytestmark = pytest.mark.thorough


def printed(run: Run, *arguments: object) -> str:
    """What a command prints, on one line."""
    found = run(*arguments)
    return " ".join(f"{found.out} {found.err}".split())


def test_a_kit_that_never_flew_is_planned_from_the_range_box_and_flown(run: Run, tmp_path: Path) -> None:
    bertha = ("--rocket", "Big Bertha")
    run("kits", "Big Bertha", "--dry-mass", "80g", "--diameter", "42mm", "--mount", "18mm")
    run("flyer", "--born", "2012-05-01", "--rails", "3ft", "--motor", "C6-5", "--count", "3")
    boxed = printed(run, "motors", "--fit", "Big Bertha", "--box", "--dry-mass", "80g")
    assert "5:+" in boxed, "only the delay in the box"
    assert "3:-" not in boxed
    plan = ("--kit", "Big Bertha", "--motor", "C6-5", "--wind", "5mph")
    untested = printed(run, "predict", *plan, "--checks")
    assert "rail 0.9 m" in untested
    assert "no static margin, and this rocket has not flown: check it before flight" in untested
    checked = (*plan, "--stability-cal", "1.6", "--parachute-diameter", "18in", "--field-size", "400ft")
    assert "not flown: check it" not in printed(run, "predict", *checked, "--checks")
    assert "best" in printed(run, "delay", *checked)
    run("landing", *checked, "--safety-sheet", tmp_path / "sheet.pdf", "--card", tmp_path / "card.pdf")
    assert all((tmp_path / name).read_bytes().startswith(b"%PDF") for name in ("sheet.pdf", "card.pdf"))
    flown = printed(run, "add", *bertha, "--motor", "C6-5", "--apogee", "420ft", "--duration", "30s")
    assert "inside the 90% interval" in flown
    assert "flown" in printed(run, "predictions", *bertha)
    assert "1 normal flight" in printed(run, "predict", *bertha, "--motor", "C6-5")


def test_a_contest_season_from_the_first_flight_to_the_finals_card(run: Run, tmp_path: Path) -> None:
    team = ("--rocket", "Team", "--motor", "F39T-6", "--season", "2027")
    body = ("--dry-mass", "520g", "--diameter", "66mm")
    first = printed(run, "season", *team, *body, "--rocket-length", "700mm")
    assert "0 flown, 0 timed" in first
    assert "time one, or give --parachute-diameter" in first
    for apogee, seconds in ((760, 41.0), (790, 39.5), (805, 38.6)):
        readouts = ("--apogee", f"{apogee}ft", "--timer-1-s", seconds, "--timer-2-s", seconds + 0.1)
        run("add", "--rocket", "Team", "--motor", "F39T-6", *body, *readouts, "--wind", "2m/s")
    guided = printed(run, "season", *team, "--declared", "2,3", "--cut", "60")
    assert "3 flown, 3 timed" in guided
    assert "2 of 3 declared, 1 left" in guided
    assert "dry mass 5" in guided.partition("mass and parachute together")[2]
    assert "the next: timed, at a dry mass of" in guided
    assert "chance of a score up to 60" in guided
    assert "the best 2 of 2, 3" in printed(run, "contest", "--rocket", "Team", "--season", "2027", "--declared", "2,3")
    card = printed(run, "finals", *team, "--temperature", "25c", "--wind", "3m/s", "--card", tmp_path / "finals.pdf")
    assert "805" in card
    assert (tmp_path / "finals.pdf").read_bytes().startswith(b"%PDF")
    announced = ("--target", "785ft", "--window", "37-40")
    assert "points" in printed(run, "contest", *team, *announced)


LEVEL_1 = (
    *("--rocket", "Level One", "--dry-mass", "1.4kg", "--diameter", "102mm", "--wind", "3mph", "--rail-angle", "5deg"),
    *("--field-size", "2500ft", "--waiver", "3000ft", "--people", "200ft", "--bystanders", "1500ft"),
    *("--parachute-diameter", "45in", "--stability-cal", "2"),
)


def test_a_certification_flight_is_checked_flown_and_entered_on_the_card(run: Run, tmp_path: Path) -> None:
    run(
        "flyer",
        "--certification",
        "none",
        "--born",
        "1990-05-01",
        "--rails",
        "6ft",
        "--motor",
        "H128W-14A",
        "--count",
        1,
    )
    long = printed(run, "predict", *LEVEL_1, "--motor", "H128W-14A")
    assert "ejection speed: unsafe" in long
    assert "best 6 s, drilled" in printed(run, "delay", *LEVEL_1, "--motor", "H128W-14A")
    plan = (*LEVEL_1, "--motor", "H128W-6")
    checks = {one["check"]: one for one in run("predict", *plan, "--json").document["predictions"][0]["safety"]}
    assert checks["certification"]["verdict"] == "caution"
    assert "only as a certification flight, with its witnesses" in printed(run, "predict", *plan)
    fine = ("stability", "thrust to weight", "field size", "pad distance", "bystanders", "ceiling", "landing speed")
    assert {name: checks[name]["verdict"] for name in fine} == dict.fromkeys(fine, "ok")
    assert not [name for name, one in checks.items() if one["verdict"] == "unsafe"]
    assert "requires certification level 2; you have none" in printed(run, "predict", *LEVEL_1, "--motor", "J350W-14A")
    run("landing", *plan, "--safety-sheet", tmp_path / "sheet.pdf")
    flown = printed(run, "add", "--rocket", "Level One", "--motor", "H128W-6", "--apogee", "980ft", "--duration", "60s")
    assert "inside the 90% interval" in flown
    run("flyer", "--certification", "1")
    (again,) = run("predict", *LEVEL_1, "--motor", "I284W-14A", "--json").document["predictions"]
    assert {one["check"]: one["verdict"] for one in again["safety"]}["certification"] == "ok"

"""The practice flights that narrow a contest's finals most, and a season step by step."""

import csv
import io
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from fieldkit.planning import practice as module
from fieldkit.planning.contest import season as season_of
from fieldkit.planning.practice import _left, _Shared, final_scores
from tests.commands import Run

CHECK_SHAPES = False
FLIGHTS = [
    (1, 500, 250.0, 41.0),
    (2, 500, 246.0, 40.5),
    (3, 520, 238.0, 39.8),
    (4, 480, 259.0, 42.0),
    (5, 510, 242.0, 40.1),
]
BODY = ["--rocket", "Team", "--motor", "F39T-6"]


def table(flights: list[tuple[int, int, float, float]]) -> str:
    out = io.StringIO()
    rows = csv.writer(out)
    rows.writerow(
        ["flight_id", "date_time", "rocket", "motor", "dry_mass_g", "diameter_mm", "apogee_m", "timer_1_s", "eggs"]
    )
    for id, mass, apogee, seconds in flights:
        rows.writerow([id, f"2026-10-0{id}", "Team", "F39T-6", mass, 66, apogee, seconds, "intact"])
    return out.getvalue()


@pytest.fixture
def season(run: Run, tmp_path: Path) -> Run:
    (tmp_path / "f.csv").write_text(table(FLIGHTS))
    run("import", tmp_path / "f.csv")
    return run


def shared() -> _Shared:
    """Two masses that share most of what is unknown, the second with less scatter."""
    return _Shared((0.4, 0.5), np.array([[0.010, 0.008], [0.008, 0.009]]), np.array([0.004, 0.001]))


def test_without_practice_everything_stays() -> None:
    one = shared()
    assert _left(one, ()) == pytest.approx(np.diag(one.cov) + one.own)


def test_one_flight_leaves_the_conditional_variance_of_two_normals() -> None:
    one = shared()
    expected = 0.010 + 0.004 - 0.008**2 / (0.009 + 0.001)
    assert _left(one, (1,))[0] == pytest.approx(expected)


def test_many_flights_leave_the_scatter_of_the_flight_itself_and_never_more_than_fewer() -> None:
    one = shared()
    left = [_left(one, (1,) * count)[1] for count in range(6)]
    assert left == sorted(left, reverse=True)
    assert _left(one, (1,) * 2000)[1] == pytest.approx(one.own[1], rel=1e-3)


def test_the_flight_that_is_advised_narrows_more_than_any_other_single_one(season: Run) -> None:
    found = season("season", *BODY, "--season", "2027", "--json").document
    sds = [one["apogee_relative_sd"] for one in found["next_practice"]]
    assert sds == sorted(sds)
    plans = [one["apogee_relative_sd"] for one in found["practice"]]
    assert plans == sorted(plans, reverse=True)
    assert plans[1] == sds[0] < plans[0]
    assert [len(one["dry_masses_g"]) for one in found["practice"]] == list(range(module.MOST_PRACTICE_FLIGHTS + 1))
    points = [one["finals_points"] for one in found["practice"]]
    assert points == sorted(points, reverse=True)


def test_more_flights_set_mass_and_parachute_more_surely(run: Run, tmp_path: Path) -> None:
    sds = []
    for count in (1, 5):
        (tmp_path / "f.csv").write_text(table(FLIGHTS[:count]))
        run("import", tmp_path / "f.csv")
        found = run("season", *BODY, "--season", "2027", "--json").document["setting"]
        sds.append((found["dry_mass_sd_g"], found["parachute_area_sd"]))
    assert sds[1][0] < sds[0][0]
    assert sds[1][1] < sds[0][1]


def test_a_season_counts_declared_flights_and_names_what_is_missing(season: Run) -> None:
    shown = season("season", *BODY, "--season", "2027", "--declared", "4,5", "--cut", "60").out
    assert "qualification: 2 of 3 declared, 1 left" in shown
    assert "score so far: " in shown
    assert "chance of a score up to 60" in shown
    assert "test flights: 5 flown, 5 timed" in shown
    assert "Check it against the season's rules" in " ".join(shown.split())
    assert "fieldkit finals --rocket Team --motor F39T-6 --season 2027" in " ".join(shown.split())


def test_the_command_for_the_finals_runs_as_printed_whatever_the_flyer_gave(season: Run) -> None:
    season("edit", "1", "rocket=Team 2", "temperature_c=12")
    season("units", "US")
    for given in (["--rocket", "Team", "--motor", "AeroTech F39T-6"], ["--rocket", "Team 2"]):
        printed = " ".join(season("season", *given, "--season", "2027").out.split())
        found = re.search(r"`fieldkit (finals [^`]*77f) --card finals.pdf`", printed)
        assert found
        assert "target" in season(*shlex.split(found[1])).out


def test_a_kit_that_never_flew_has_a_season_too(run: Run) -> None:
    shown = run("season", "--rocket", "New", "--motor", "F39T-6", "--dry-mass", "450g", "--diameter", "66mm").out
    assert "test flights: 0 flown" in shown
    assert "parachute: no flight is timed" in shown


def test_declared_flights_count_as_flown_in_the_score_at_the_end() -> None:
    rule = season_of(2027)
    ahead = np.array([[5.0, 50.0, 70.0], [60.0, 8.0, 9.0]])
    assert final_scores(rule, [10.0, 20.0], ahead, 1) == pytest.approx([15.0, 30.0])
    assert final_scores(rule, [10.0, 20.0], ahead, 0) == pytest.approx([30.0, 30.0])
    assert final_scores(rule, [], ahead, 3) == pytest.approx([55.0, 17.0])
    assert final_scores(rule, [10.0], ahead, 0) is None

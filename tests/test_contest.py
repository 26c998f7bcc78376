"""Contest seasons: the rule is in the file, and the points are those of the rule."""

import json

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.loop.paper.reference import TABLE
from fieldkit.plan.contest import chance_to_qualify, descent_speeds, score, season, seasons
from fieldkit.units import FOOT


def test_every_season_is_read_and_says_that_it_was_not_checked() -> None:
    assert seasons() == list(range(2020, 2028))
    assert not any(season(year).checked for year in seasons())
    with pytest.raises(BadValue, match="2027"):
        season(1999)


def test_feet_and_seconds_outside_cost_points() -> None:
    rule = season(2027)
    flights = [
        Flight(apogee=810 * FOOT, duration=38.0),
        Flight(apogee=795 * FOOT, duration=42.0),
        Flight(apogee=800 * FOOT),
        Flight(),
    ]
    assert [points for _, points in score(rule, flights)] == pytest.approx([10.0, 13.0, 0.0], abs=1e-9)


def test_descent_is_read_or_follows_from_the_duration() -> None:
    flights = [Flight(descent_speed=6.0), Flight(apogee=240.0, duration=50.0), Flight(tags=("damaged",), duration=9.0)]
    assert descent_speeds(flights) == pytest.approx([6.0, 6.0])


def test_the_two_best_of_three_are_summed() -> None:
    assert chance_to_qualify(season(2027), np.full(10, 8.0), 16.0) == 1.0
    assert chance_to_qualify(season(2027), np.full(10, 8.0), 15.9) == 0.0


def test_the_command_scores_flights_and_a_plan(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ["--ledger", f"{tmp_path}/ledger.db"]
    assert main([*ledger, "import", str(TABLE)]) == 0
    capsys.readouterr()
    assert main([*ledger, "contest", "--season", "2027", "--motor", "F24", "--cut", "60", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["flights"]) == 12
    assert 0 <= document["qualifies"]["chance"] <= 1
    assert not document["plan"]["timed"]

"""The whole bench of undeclared effects: present effects are found, absent ones are not, and forecasts improve.

Each promised rate is tested at the 1% level.
"""

import sys
from collections.abc import Sequence

import pytest
from scipy.stats import binom

from bench.make import make
from bench.result import Result
from bench.scenarios import SCENARIOS
from bench.score import results, to_score

SEED, FIRST, EACH = 909, 1, 2
"""Seed of the histories, and the number for each scenario."""
COMMAND = [sys.executable, "-m", "fieldkit.cli.main"]
CHANCE = 0.01


def rarely_so_few(count: int, of: int, promised: float) -> bool:
    """Whether a count this low has a probability below 1% at the promised rate."""
    return bool(binom.cdf(count, of, promised) < CHANCE)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> list[Result]:
    folder = tmp_path_factory.mktemp("sets")
    labels = make(folder, SCENARIOS, EACH, SEED, "fast", FIRST)
    return list(results(to_score(folder, labels, COMMAND, 900.0), None, 2, ""))


def decidable(found: Sequence[Result]) -> list[Result]:
    return [one for one in found if one.decidable and one.label != "unexplained"]


@pytest.mark.slow
def test_every_history_gets_a_verdict(found: list[Result]) -> None:
    assert len(found) == EACH * len(SCENARIOS)
    assert not [one.error for one in found if one.error]


@pytest.mark.slow
def test_nine_in_ten_effects_that_matter_are_named(found: list[Result]) -> None:
    tried = decidable(found)
    assert len(tried) >= 10
    assert not rarely_so_few(sum(one.right for one in tried), len(tried), 0.9)


@pytest.mark.slow
def test_at_most_one_in_twenty_verdicts_is_a_false_alarm(found: list[Result]) -> None:
    nulls = [one for one in found if one.label == "none"]
    assert not rarely_so_few(sum(one.verdict == "none" for one in nulls), len(nulls), 0.95)


@pytest.mark.slow
def test_nine_tenths_of_the_possible_gain_are_achieved(found: list[Result]) -> None:
    errors = [(one.before, one.after, one.given) for one in decidable(found)]
    possible = sum(before.mae - given.mae for before, _, given in errors if before and given)
    made = sum(before.mae - after.mae for before, after, _ in errors if before and after)
    assert made >= 0.9 * possible > 0


@pytest.mark.slow
def test_nine_in_ten_later_flights_are_in_their_interval_after_the_loop(found: list[Result]) -> None:
    after = [one.after for one in found if one.after]
    flights, covered = sum(one.flights for one in after), sum(one.covered for one in after)
    assert not rarely_so_few(covered, flights, 0.85)
    assert not rarely_so_few(flights - covered, flights, 0.05)

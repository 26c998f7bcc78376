"""The reliability diagram: right probabilities have no calibration error, and overconfident ones have one."""

import numpy as np
import pytest

from bench.calibration import PRIOR_EFFECTS, at_their_frequency, calibration_error, calibration_lines, reliability
from bench.result import Errors, Result
from bench.tables import IDEAL_INTERVAL, NORMAL_90, summary
from fieldkit.selection.prior import inclusion_probabilities

pytestmark = pytest.mark.fast


def results(sharpened: float) -> list[Result]:
    """Two thousand sets in which an effect is present with its probability, before that is made overconfident."""
    rng = np.random.default_rng(5)
    found = []
    for number, chance in enumerate(rng.uniform(0, 1, 2000)):
        label = "wind" if rng.uniform() < chance else "none"
        odds = (chance / (1 - chance)) ** sharpened
        output = {"wind": odds / (1 + odds)}
        found.append(Result(str(number), "wind", label, 0.5, 1.0, "none", probabilities=output))
    return found


def test_right_probabilities_are_calibrated_and_overconfident_ones_are_not() -> None:
    right, sure = (reliability(results(sharpened)) for sharpened in (1.0, 4.0))
    assert calibration_error(right) < 0.03
    assert calibration_error(sure) > 0.08
    assert sum(one.cases for one in right) == 2000


def test_odds_change_with_the_frequency_of_effects_relative_to_the_prior() -> None:
    """Every history has one effect and half have a second: 1.5 on average, so odds of 1 are multiplied by 1.5 over the
    prior's number."""
    labels = ("wind", "wind+wear", "wear", "wind+wear")
    given = [Result(label, "pair", label, 0.5, 1.0, "none", probabilities={"wind": 0.5}) for label in labels]
    moved = at_their_frequency(given)
    odds = [one.probabilities["wind"] / (1 - one.probabilities["wind"]) for one in moved]
    np.testing.assert_allclose(odds, 1.5 / PRIOR_EFFECTS)
    assert sum(inclusion_probabilities().values()) == pytest.approx(PRIOR_EFFECTS, abs=0.005)


def test_sets_without_probabilities_have_no_diagram() -> None:
    assert list(calibration_lines([Result("1", "wind", "wind", 0.5, 1.0)])) == []
    lines = list(calibration_lines(results(1.0)))
    assert lines[0].startswith("| probability")
    assert "expected calibration error" in lines[-1]


def test_the_ideal_interval_score_is_that_of_a_known_normal_distribution() -> None:
    error = np.random.default_rng(3).normal(size=400_000)
    width = 2 * NORMAL_90
    score = width + 20 * np.maximum(np.abs(error) - NORMAL_90, 0.0)
    assert pytest.approx(score.mean() / np.abs(error).mean(), rel=0.01) == IDEAL_INTERVAL


def test_the_summary_compares_forecasts_with_the_plain_model_the_truth_given_and_the_ideal() -> None:
    def one(scenario: str, label: str, before: float, after: float, given: float | None, covered: int) -> Result:
        mae = [Errors(m, 0.0, covered, 10, IDEAL_INTERVAL * m) if m else None for m in (before, after, given)]
        return Result("s", scenario, label, 0.5, 5.0, label, before=mae[0], after=mae[1], given=mae[2])

    output = summary(
        [
            one("wind", "wind", 20.0, 10.0, 10.0, 9),
            one("wear", "wear", 20.0, 40.0, 20.0, 7),
            one("null", "none", 10.0, 10.0, None, 10),
        ]
    )
    assert "the fit with the true effect: 1.41 (geometric mean), highest 2.00 (wear)" in output
    assert "more than 5% above that without a correction: 1 of 3" in output
    assert "coverage after by scenario: 70% (wear) to 100%" in output
    assert "interval score after relative to before: 1.00, to the ideal: 3.17 (geometric mean)" in output

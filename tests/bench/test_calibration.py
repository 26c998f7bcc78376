"""The reliability diagram: probabilities that are right have no calibration error, and overconfident ones have."""

import numpy as np
import pytest

from bench.calibration import calibration_error, calibration_lines, reliability
from bench.result import Result

pytestmark = pytest.mark.fast


def results(sharpened: float) -> list[Result]:
    """Two thousand sets in which an effect is there as often as its probability says, before that is sharpened."""
    rng = np.random.default_rng(5)
    found = []
    for number, chance in enumerate(rng.uniform(0, 1, 2000)):
        label = "wind" if rng.uniform() < chance else "none"
        odds = (chance / (1 - chance)) ** sharpened
        said = {"wind": odds / (1 + odds)}
        found.append(Result(str(number), "wind", label, 0.5, 1.0, "none", probabilities=said))
    return found


def test_probabilities_that_are_right_are_calibrated_and_overconfident_ones_are_not() -> None:
    right, sure = (reliability(results(sharpened)) for sharpened in (1.0, 4.0))
    assert calibration_error(right) < 0.03
    assert calibration_error(sure) > 0.08
    assert sum(one.cases for one in right) == 2000


def test_sets_without_probabilities_have_no_diagram() -> None:
    assert list(calibration_lines([Result("1", "wind", "wind", 0.5, 1.0)])) == []
    lines = list(calibration_lines(results(1.0)))
    assert lines[0].startswith("| probability")
    assert "expected calibration error" in lines[-1]

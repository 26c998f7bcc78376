"""Running medians over time in logs whose sampling rate changes."""

import numpy as np
import pytest

from fieldkit.analysis.robust_statistics import running_median, running_median_over, stretches, student_line

FAST, SLOW = np.arange(0.0, 10.0, 0.01), np.arange(10.0, 200.0, 0.1)


def test_stretches_begin_where_the_sampling_rate_changes() -> None:
    found = stretches(np.concatenate((FAST, SLOW)))
    assert [step for _, step in found] == pytest.approx([0.01, 0.1])
    assert found[1][0].start == pytest.approx(FAST.size, abs=15)


def test_a_jittery_clock_is_one_stretch() -> None:
    time = SLOW + 0.03 * np.random.default_rng(1).standard_normal(SLOW.size)
    assert len(stretches(np.sort(time))) == 1


def test_each_stretch_has_the_median_over_the_same_time() -> None:
    """Half of a window of one second with an error is enough to move a median; a tenth of it is not."""
    time = np.concatenate((FAST, SLOW))
    wrong = ((time > 4.0) & (time < 4.3)) | ((time > 100.0) & (time < 100.3))
    found = running_median_over(time, np.where(wrong, 50.0, 0.0), 1.0, 3, 201)
    assert not found.any()
    uniform = np.random.default_rng(1).standard_normal(SLOW.size)
    assert running_median_over(SLOW, uniform, 1.05, 3, 201) == pytest.approx(running_median(uniform, 11))


def test_a_robust_line_is_that_of_least_squares_without_outliers_and_ignores_one() -> None:
    rng = np.random.default_rng(3)
    x = np.sort(rng.uniform(5.0, 9.0, 40))
    y = 12.0 - 3.0 * x + 0.1 * rng.standard_normal(40)
    exact = np.polyfit(x, y, 1)
    assert student_line(x, y, 0.1) == pytest.approx(exact, rel=0.02)
    y[7] += 40.0
    assert student_line(x, y, 0.1) == pytest.approx(exact, rel=0.02)
    assert np.polyfit(x, y, 1) != pytest.approx(exact, rel=0.02)

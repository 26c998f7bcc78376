"""Duration and mean acceleration of a boost from few samples."""

import numpy as np
import pytest

from fieldkit.analysis import Event, Figure
from fieldkit.analysis.boost_length import burn_time, mean_acceleration

LIFT, BURNOUT = Event(10.0, 0.25, "barometric altitude"), Event(11.4, 0.2, "barometric altitude")
BURN = Figure(1.4, float(np.hypot(0.25, 0.2)), "barometric altitude")


def test_errors_of_lift_off_and_burnout_add_up_if_few_samples_show_the_boost() -> None:
    assert burn_time(BURN, LIFT, BURNOUT, np.arange(0.0, 60.0)).sd == pytest.approx(0.45)
    assert burn_time(BURN, LIFT, BURNOUT, np.arange(0.0, 60.0, 0.1)) == BURN


def test_a_mean_acceleration_allows_for_a_burn_time_much_shorter_than_the_most_likely_one() -> None:
    speed = Figure(84.0, 7.5, "barometric altitude")
    mean = mean_acceleration(60.0, [speed], [Figure(1.4, 0.42, "barometric altitude")], [1.0])
    assert mean.value == pytest.approx(60.0)
    assert mean.sd > 1.3 * 60 * np.hypot(7.5 / 84, 0.42 / 1.4)


def test_a_mean_acceleration_has_the_errors_of_a_precise_speed_and_burn_time_in_quadrature() -> None:
    mean = mean_acceleration(60.0, [Figure(84.0, 0.84, "acceleration")], [Figure(1.4, 0.014, "acceleration")], [1.0])
    assert mean.sd == pytest.approx(60 * np.hypot(0.01, 0.01), rel=0.01)


def test_a_mean_acceleration_whose_burn_time_is_no_boost_is_unknown() -> None:
    mean = mean_acceleration(8400.0, [Figure(84.0, 7.5, "pressure")], [Figure(0.01, 0.001, "pressure")], [1.0])
    assert np.isinf(mean.sd)

"""The descent speed if no sensor shows when the parachute was ejected."""

import pytest

from fieldkit.analysis.descent import _from_unseen_ejection
from fieldkit.physics.standard_atmosphere import GRAVITY

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("after", [-1.5, -1.0, 0.0, 0.8])
def test_an_unseen_ejection_up_to_one_and_a_half_seconds_early_is_within_the_uncertainty(after: float) -> None:
    height, lasts = 177.0, 25.0
    true = (height - GRAVITY * after**2 / 2) / (lasts - after)
    mean, sd = _from_unseen_ejection(height / lasts, height, lasts)
    assert abs(mean - true) < 2.5 * sd
    assert sd < 0.08 * mean

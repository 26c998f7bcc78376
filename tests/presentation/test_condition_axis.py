"""Axes of conditions: the unit in the title is that of the values."""

import numpy as np
import pytest

from fieldkit.presentation.condition_axis import in_units

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("header", "value", "system", "title", "shown"),
    [
        ("wind_mps", 10.0, "SI", "wind [m/s]", 10.0),
        ("wind_mps", 10.0, "US", "wind [mph]", 22.369),
        ("temperature_c", 293.15, "SI", "temperature [°C]", 20.0),
        ("temperature_c", 293.15, "US", "temperature [°F]", 68.0),
        ("expected_top_speed_mps", 100.0, "US", "expected top speed [mph]", 223.69),
        ("hour", 14.5, "US", "hour", 14.5),
    ],
)
def test_an_axis_is_in_the_units_of_the_chosen_system(
    header: str, value: float, system: str, title: str, shown: float
) -> None:
    name, values = in_units(header, np.array([value, np.nan]), system)
    assert name == title
    assert values[0] == pytest.approx(shown, rel=1e-3)
    assert np.isnan(values[1])

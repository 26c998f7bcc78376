"""Curves and minima agree with those of scipy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar

from fieldkit.curves import MonotoneCurve, lowest

pytestmark = pytest.mark.fast


@given(seed=st.integers(0, 2**32 - 1), points=st.integers(2, 8), level=st.booleans())
def test_a_monotone_curve_is_that_of_scipy(seed: int, points: int, level: bool) -> None:
    rng = np.random.default_rng(seed)
    at = np.cumsum(rng.uniform(0.1, 2.0, points))
    values = rng.normal(size=(3, 2, points))
    values = np.round(values) if level else values  # with equal neighbors
    ours, theirs = MonotoneCurve(at, values), PchipInterpolator(at, values, axis=-1)
    places = np.linspace(at[0], at[-1], 23)
    np.testing.assert_allclose(ours(places), theirs(places), atol=1e-12)
    np.testing.assert_allclose(ours.slope(places), theirs(places, 1), atol=1e-10)
    np.testing.assert_allclose(ours(places[7]), theirs(places[7]), atol=1e-12)


@given(place=st.floats(-1.5, 2.5), power=st.sampled_from((1, 2, 4)))
def test_the_lowest_point_is_that_of_scipy(place: float, power: int) -> None:
    def cost(x: float) -> float:
        return float(abs(x - place) ** power)

    found, least = lowest(cost, -1.0, 2.0, 1e-5)
    theirs = minimize_scalar(cost, bounds=(-1.0, 2.0), method="bounded", options={"xatol": 1e-6})
    assert found == pytest.approx(min(max(place, -1.0), 2.0), abs=2e-5 if power < 4 else 0.01)
    assert least <= theirs.fun + 3e-5
    assert least == cost(found)

"""The optimizers used in measurements, compared with those of scipy."""

import numpy as np
import pytest

from fieldkit.analysis.optimize import least_soft_squares, nelder_mead

pytestmark = pytest.mark.fast


def banana(values: np.ndarray) -> float:
    return float(100 * (values[1] - values[0] ** 2) ** 2 + (1 - values[0]) ** 2)


@pytest.mark.parametrize("evaluations", [20, 45, 400])
def test_the_simplex_finds_the_same_minimum_as_scipy(evaluations: int) -> None:
    from scipy.optimize import minimize

    simplex = np.array([[-1.2, 1.0], [-0.5, 1.0], [-1.2, 2.0]])
    options = {"initial_simplex": simplex, "maxfev": evaluations}
    expected = minimize(banana, simplex[0], method="Nelder-Mead", options=options)
    assert banana(nelder_mead(banana, simplex, evaluations)) <= expected.fun * (1 + 1e-6) + 1e-12


def test_robust_least_squares_agree_with_scipy() -> None:
    from scipy.optimize import least_squares

    rng = np.random.default_rng(4)
    time = np.linspace(0, 10, 80)
    shown = 50 * np.exp(-0.3 * time) + 4 + rng.normal(0, 1, time.size)
    shown[::9] += 60.0  # outliers

    def misfit(values: np.ndarray) -> np.ndarray:
        return values[0] * np.exp(-values[1] * time) + values[2] - shown

    start, scale, room = np.array([30.0, 1.0, 0.0]), np.array([10.0, 0.3, 1.0]), np.full(3, 1e3)
    expected = least_squares(misfit, start, loss="soft_l1", x_scale=scale)
    found = least_soft_squares(misfit, start, scale, room, 60)
    np.testing.assert_allclose(found, expected.x, rtol=1e-3)
    assert found[0] == pytest.approx(50, abs=3)


def test_values_stay_within_bounds() -> None:
    found = least_soft_squares(lambda values: values - 10.0, np.zeros(2), np.ones(2), np.array([1.0, 20.0]), 50)
    np.testing.assert_allclose(found, [1.0, 10.0], atol=1e-3)

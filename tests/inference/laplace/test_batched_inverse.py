"""Inverses of many small matrices at once."""

import numpy as np
import pytest

from fieldkit.inference.batched_inverse import inverses

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("size", [1, 2, 6, 9])
@pytest.mark.parametrize("many", [(), (7,), (18, 5)])
def test_inverses_and_determinants_agree_with_lapack(many: tuple[int, ...], size: int) -> None:
    rng = np.random.default_rng(2)
    half = rng.normal(size=(*many, size, 5))
    matrices = half @ np.swapaxes(half, -1, -2) + rng.uniform(1e-3, 1.0, (*many, size, 1)) * np.eye(size)
    kept = matrices.copy()
    inverse, log_det = inverses(matrices)
    np.testing.assert_allclose(inverse @ matrices, np.broadcast_to(np.eye(size), matrices.shape), atol=1e-9)
    np.testing.assert_allclose(log_det, np.linalg.slogdet(matrices)[1], rtol=1e-12)
    np.testing.assert_array_equal(matrices, kept)


def test_unobserved_rows_do_not_mix_with_observed_ones() -> None:
    seen = np.array([[2e-6, 1e-6], [1e-6, 3e-6]])
    inverse, log_det = inverses(np.block([[seen, np.zeros((2, 1))], [np.zeros((1, 2)), np.array([[1e6]])]]))
    np.testing.assert_allclose(inverse[:2, :2], np.linalg.inv(seen), rtol=1e-12)
    assert (inverse[2] == [0, 0, 1e-6]).all()
    assert log_det == pytest.approx(np.log(np.linalg.det(seen)) + np.log(1e6), rel=1e-12)

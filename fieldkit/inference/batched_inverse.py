"""Many small symmetric matrices inverted at once.

Source: the sweep operator (Goodnight, A Tutorial on the SWEEP Operator, The American Statistician 33, 1979), for all
matrices at once; it needs no pivoting for positive definite matrices. Larger ones by LU factorization (LAPACK).
"""

import numpy as np

from fieldkit.shapes import Array, Float

LARGEST_SWEPT = 9
"""Up to this size, sweeping takes less time than LAPACK, which inverts matrix by matrix."""


def inverses(matrices: Float[Array, "*many n n"]) -> tuple[Float[Array, "*many n n"], Float[Array, "*many"]]:
    """The inverse of each positive definite matrix and the logarithm of its determinant; any units."""
    size = matrices.shape[-1]
    if size == 1:
        return 1 / matrices, np.log(matrices[..., 0, 0])
    if size > LARGEST_SWEPT:
        return np.asarray(np.linalg.inv(matrices), float), np.asarray(np.linalg.slogdet(matrices).logabsdet, float)
    swept = np.moveaxis(matrices, (-2, -1), (0, 1)).copy(order="C")
    log_det = np.zeros(matrices.shape[:-2])
    for pivot in range(size):
        value = swept[pivot, pivot].copy()
        log_det += np.log(value)
        column, row = swept[:, pivot] / value, swept[pivot].copy()
        swept -= column[:, None] * row
        swept[:, pivot], swept[pivot] = -column, row / value
        swept[pivot, pivot] = 1 / value
    return np.ascontiguousarray(np.moveaxis(swept, (0, 1), (-2, -1))), log_det

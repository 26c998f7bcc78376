"""Many small symmetric matrices turned over at once: LAPACK, called for each, takes three times as long."""

import numpy as np

from fieldkit.shapes import Array, Float


def inverses(matrices: Float[Array, "*many n n"]) -> tuple[Float[Array, "*many n n"], Float[Array, "*many"]]:
    """The inverse of each positive definite matrix and the logarithm of its determinant.

    By sweeps, one pivot after the other, none of which has to be sought in such a matrix (Goodnight, A tutorial on
    the sweep operator, The American Statistician 33, 1979). The matrices' own axes go first, so that what is done to
    one element is done to all matrices in a row.
    """
    swept = np.array(np.moveaxis(matrices, (-2, -1), (0, 1)), order="C")
    taken, log_det = np.empty_like(swept), np.zeros(swept.shape[2:])
    for k in range(len(swept)):
        pivot = swept[k, k].copy()
        log_det += np.log(pivot)
        row, column = swept[k] / pivot, swept[:, k].copy()
        swept -= np.multiply(column[:, None], row, out=taken)
        swept[k] = row
        swept[:, k] = column / -pivot
        swept[k, k] = 1 / pivot
    return np.ascontiguousarray(np.moveaxis(swept, (0, 1), (-2, -1))), log_det

"""Many small symmetric matrices inverted at once.

Source: LU factorization by LAPACK, as NumPy calls it.
"""

import numpy as np

from fieldkit.shapes import Array, Float


def inverses(matrices: Float[Array, "*many n n"]) -> tuple[Float[Array, "*many n n"], Float[Array, "*many"]]:
    """The inverse of each positive definite matrix and the logarithm of its determinant; any units."""
    if matrices.shape[-1] == 1:
        return 1 / matrices, np.log(matrices[..., 0, 0])
    return np.asarray(np.linalg.inv(matrices), float), np.asarray(np.linalg.slogdet(matrices).logabsdet, float)

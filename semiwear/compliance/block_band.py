"""Block-banded systems with many right-hand sides, by Cholesky factors of the blocks.

LAPACK's banded solver takes one right-hand side after the other, at a fifth of the speed of these products.
"""

from __future__ import annotations

from scipy.linalg import cholesky, solve_triangular

from semiwear.arrays import FloatArray


def solve_block_band(band: FloatArray, right: FloatArray) -> FloatArray:
    """Solution of a system whose matrix is symmetric and positive definite; both arguments are overwritten.

    Parameters
    ----------
    band : (N, d + 1, r, r) array
        Blocks on and below the diagonal: that of rows k + j and columns k at [k, j].
    right : (N, r, columns) array

    Returns
    -------
    (N, r, columns) array
    """
    count, below = band.shape[0], band.shape[1] - 1
    for k in range(count):
        for j in range(min(below, count - 1 - k) + 1):
            for left in range(1, min(below - j, k) + 1):
                band[k, j] -= band[k - left, j + left] @ band[k - left, left].T
            if j == 0:
                band[k, 0] = cholesky(band[k, 0], lower=True, check_finite=False)
            else:
                band[k, j] = solve_triangular(band[k, 0], band[k, j].T, lower=True, check_finite=False).T
        for j in range(1, min(below, k) + 1):
            right[k] -= band[k - j, j] @ right[k - j]
        right[k] = solve_triangular(band[k, 0], right[k], lower=True, check_finite=False)
    for k in range(count - 1, -1, -1):
        for j in range(1, min(below, count - 1 - k) + 1):
            right[k] -= band[k, j].T @ right[k + j]
        right[k] = solve_triangular(band[k, 0], right[k], lower=True, trans=1, check_finite=False)
    return right

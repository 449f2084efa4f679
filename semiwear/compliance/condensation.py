"""Static condensation of symmetric stiffness matrices, many at a time, by their Cholesky factors."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtrtrs

from semiwear.arrays import FloatArray


def factors_of(stiffness: FloatArray) -> FloatArray:
    """Lower triangular factors L L^T of positive definite matrices: (n, u, u) arrays."""
    return np.asarray(np.linalg.cholesky(stiffness), dtype=np.float64)


def halves(factors: FloatArray, right: FloatArray) -> FloatArray:
    """Halves L^-1 C of the symmetric products C^T K^-1 C, from factors (n, u, u) and C (n, u, v)."""
    # scipy.linalg.solve_triangular takes several times as long for matrices of some ten unknowns
    pairs = zip(factors, right, strict=True)
    return np.array([dtrtrs(factor.T, of_one, lower=0, trans=1)[0] for factor, of_one in pairs])

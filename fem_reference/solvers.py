"""Factorisation of a symmetric positive definite stiffness matrix by the best direct solver at hand.

CHOLMOD (package scikit-sparse) first, then MKL Pardiso (pypardiso), then SuperLU, which scipy always brings and
which is good up to some 30 thousand unknowns.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, spmatrix, triu
from scipy.sparse.linalg import splu

from semiwear.errors import MissingExtraError

__all__ = ["Factor", "factorise"]

FloatArray = NDArray[np.float64]


class Factor(Protocol):
    """A factorised matrix.

    Attributes
    ----------
    name : str
        The solver: ``"cholmod"``, ``"pardiso"`` or ``"superlu"``.
    """

    name: str

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution for one right-hand side (n,) or several (n, k), in the same shape."""
        ...


class _Cholmod:
    name = "cholmod"

    def __init__(self, matrix: spmatrix):
        cholesky = import_module("sksparse.cholmod").cholesky
        _warn_of_reference_blas()
        self._solve = cholesky(csc_matrix(matrix), ordering_method="metis", mode="supernodal")

    def solve(self, rhs: FloatArray) -> FloatArray:
        return self._solve(np.asfortranarray(rhs, dtype=float))


class _Pardiso:
    name = "pardiso"

    def __init__(self, matrix: spmatrix):
        self._matrix = csr_matrix(triu(matrix, format="csr"))
        self._matrix.sort_indices()
        self._solver = import_module("pypardiso").PyPardisoSolver(
            mtype=2
        )  # real, symmetric, positive definite: upper triangle only
        self._solver.factorize(self._matrix)

    def solve(self, rhs: FloatArray) -> FloatArray:
        return self._solver.solve(self._matrix, np.asfortranarray(rhs, dtype=float)).reshape(rhs.shape)


class _SuperLU:
    name = "superlu"

    def __init__(self, matrix: spmatrix):
        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        self._factor = splu(csc_matrix(matrix), **symmetric)

    def solve(self, rhs: FloatArray) -> FloatArray:
        return self._factor.solve(np.asarray(rhs, dtype=float))


_SOLVERS: dict[str, Callable[[spmatrix], Factor]] = {"cholmod": _Cholmod, "pardiso": _Pardiso, "superlu": _SuperLU}


def factorise(matrix: spmatrix, *, prefer: str = "auto") -> Factor:
    """Factorise a symmetric positive definite sparse matrix.

    Parameters
    ----------
    matrix : sparse matrix, (n, n)
        Stiffness of the free unknowns [N/mm].
    prefer : str
        ``"auto"`` takes the first that can be imported of ``"cholmod"``, ``"pardiso"`` and ``"superlu"``; one of
        these names insists on it.

    Raises
    ------
    ValueError
        For an unknown name.
    MissingExtraError
        If the solver insisted on is not installed.

    Source: Y. Chen et al., ACM Trans. Math. Softw. 35 (2008) 22 (CHOLMOD); X. S. Li, ibid. 31 (2005) 302 (SuperLU).
    """
    if prefer != "auto" and prefer not in _SOLVERS:
        raise ValueError(f"prefer must be 'auto' or one of {', '.join(_SOLVERS)}, not {prefer!r}")
    for name in _SOLVERS if prefer == "auto" else (prefer,):
        try:
            return _SOLVERS[name](matrix)
        except ImportError:
            continue
    package = {"cholmod": "scikit-sparse", "pardiso": "pypardiso"}[prefer]
    raise MissingExtraError(package, "fem", f"the solver {prefer!r}")


_warned: set[str] = set()


def _warn_of_reference_blas() -> None:
    """Say once if CHOLMOD runs on the reference BLAS, which is some twenty times slower (Linux only)."""
    maps = Path("/proc/self/maps")
    if "blas" in _warned or not maps.exists():
        return
    _warned.add("blas")
    loaded = {line.split()[-1] for line in maps.read_text().splitlines() if "libblas" in line}
    slow = [path for path in loaded if not any(name in path for name in ("openblas", "mkl", "blis", "atlas"))]
    if slow:
        warnings.warn(
            f"CHOLMOD uses the reference BLAS {slow[0]}, which is about 20 times slower than OpenBLAS; "
            "install libopenblas (Debian: apt-get install libopenblas0) or uninstall scikit-sparse",
            stacklevel=3,
        )

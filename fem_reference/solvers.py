"""Factorisation of a symmetric positive definite stiffness matrix by the best available direct solver.

MKL Pardiso (package pypardiso, extra `fem`) where it is installed; else, if the coordinates of the nodes are given,
our own nested dissection (`substructures.DissectionFactor`), which needs scipy alone; else scipy's SuperLU, suitable
up to some 30 thousand unknowns: beyond, a warning is given.
"""

from __future__ import annotations

import warnings
import weakref
from collections.abc import Callable
from importlib import import_module
from typing import Protocol

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, spmatrix, triu
from scipy.sparse.linalg import splu

from fem_reference.arrays import FloatArray
from fem_reference.substructures import DissectionFactor
from semiwear.errors import MissingExtraError

SOLVERS = ("pardiso", "dissection", "superlu")
"""By preference."""

_SUPERLU_SLOW = 30_000  # unknowns


class SlowSolverWarning(UserWarning):
    """A factorisation takes many times as long as another solver would."""


class Factor(Protocol):
    """A factorised matrix.

    Attributes
    ----------
    name : str
        The solver, one of `SOLVERS`.
    """

    name: str

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution for one right-hand side (n,) or several (n, k), in the same shape."""


class _Pardiso:
    name = "pardiso"

    def __init__(self, matrix: spmatrix):
        self._matrix = csr_matrix(triu(matrix, format="csr"))
        self._matrix.sort_indices()
        # real, symmetric, positive definite: upper triangle only
        solver = import_module("pypardiso").PyPardisoSolver(mtype=2)
        solver.factorize(self._matrix)
        self._solver = solver
        # pypardiso never frees what MKL has allocated
        weakref.finalize(self, _free, solver.free_memory)

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._solver.solve(self._matrix, np.asfortranarray(rhs, dtype=float)).reshape(rhs.shape))


def _free(free_memory: Callable[..., object]) -> None:
    free_memory(everything=True)


class _SuperLU:
    name = "superlu"

    def __init__(self, matrix: spmatrix):
        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        self._factor = splu(csc_matrix(matrix), **symmetric)

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._factor.solve(np.asarray(rhs, dtype=float)))


def factorise(matrix: spmatrix, *, places: FloatArray | None = None, prefer: str = "auto") -> Factor:
    """Factorise a symmetric positive definite sparse matrix.

    Parameters
    ----------
    matrix : sparse matrix, (n, n)
        Stiffness of the free unknowns [N/mm].
    places : (n, 3) array, optional [mm]
        Coordinates of the nodes of the unknowns; those of one node follow one another.
    prefer : str
        ``"auto"`` takes the first available of `SOLVERS`: ``"dissection"`` needs places; one of these names
        requires it.

    Raises
    ------
    ValueError
        For an unknown name, or ``"dissection"`` without places.
    MissingExtraError
        If the required solver is not installed.

    Warns
    -----
    SlowSolverWarning
        When SuperLU is taken for a matrix that another solver factorises in a tenth of the time.

    Source: Schenk and Gaertner, Future Gener. Comput. Syst. 20 (2004) 475 (Pardiso); George, SIAM J. Numer. Anal. 10
    (1973) 345 (nested dissection); X. S. Li, ACM Trans. Math. Softw. 31 (2005) 302 (SuperLU).
    """
    if prefer != "auto" and prefer not in SOLVERS:
        raise ValueError(f"prefer must be 'auto' or one of {', '.join(SOLVERS)}, not {prefer!r}")
    if prefer == "dissection" and places is None:
        raise ValueError("prefer='dissection' needs the places of the unknowns")
    if prefer in ("auto", "pardiso"):
        try:
            return _Pardiso(matrix)
        except ImportError:
            if prefer == "pardiso":
                raise MissingExtraError("pypardiso", "fem", "the solver 'pardiso'") from None
    if prefer != "superlu" and places is not None:
        return DissectionFactor(csr_matrix(matrix), places)
    if matrix.shape[0] > _SUPERLU_SLOW:
        warnings.warn(
            f"SuperLU factorises {matrix.shape[0]} unknowns, which takes some ten times as long as MKL Pardiso: "
            'pip install "semiwear[fem]", or give the places of the unknowns',
            SlowSolverWarning,
            stacklevel=2,
        )
    return _SuperLU(matrix)

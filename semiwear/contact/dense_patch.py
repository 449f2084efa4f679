"""Contact of a few cells, solved directly: faster than transforms as long as the matrix is small."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

__all__ = ["DensePatch", "solve_dense_patch"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

_SETS = 60  # active sets tried; two or three suffice, and a failure leaves the work to the iterative solver
_AT_ONCE = 20  # of them that change freely; then only the worst cell changes


@dataclass(frozen=True)
class DensePatch:
    """Pressure on a few cells.

    Attributes
    ----------
    pressure : (n,) array [MPa]
    approach : float [mm]
    iterations : int
        Active sets tried.
    solved : bool
    """

    pressure: FloatArray
    approach: float
    iterations: int
    solved: bool


@njit(cache=True, error_model="numpy")
def _influence(coefficients, rows, columns):  # type: ignore[no-untyped-def]
    """Compliance matrix of cells at the given rows and columns of the grid."""
    n = rows.shape[0]
    matrix = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            matrix[i, j] = coefficients[abs(rows[i] - rows[j]), abs(columns[i] - columns[j])]
            matrix[j, i] = matrix[i, j]
    return matrix


@njit(cache=True, error_model="numpy")
def _subsystem(matrix, gap, on):  # type: ignore[no-untyped-def]
    """Matrix of the pressed cells (in LAPACK's order) and the right-hand sides: gap and one."""
    m = on.shape[0]
    part, sides = np.empty((m, m)), np.ones((2, m))
    for i in range(m):
        sides[0, i] = gap[on[i]]
        for j in range(m):
            part[i, j] = matrix[on[i], on[j]]
    return part.T, sides.T


@njit(cache=True, error_model="numpy")
def _update(matrix, gap, approach, on, solved, pressed, one_at_a_time):  # type: ignore[no-untyped-def]
    """Change the set of pressed cells in place; number of changes."""
    n, m = gap.shape[0], on.shape[0]
    separation = np.empty(n)
    worst, worst_value = -1, 0.0
    largest = 0.0
    for j in range(m):
        largest = max(largest, solved[j])
    changes = 0
    pull = np.zeros(n)
    for j in range(m):
        pull[on[j]] = -solved[j] / largest
    for i in range(n):
        separation[i] = gap[i] - approach
        for j in range(m):
            separation[i] += matrix[i, on[j]] * solved[j]
    reference = matrix[0, 0] * largest
    for i in range(n):
        wrong = pull[i] if pressed[i] else -separation[i] / reference - 1e-13
        if wrong > 0.0:
            changes += 1
            if wrong > worst_value:
                worst, worst_value = i, wrong
            if not one_at_a_time:
                pressed[i] = not pressed[i]
    if one_at_a_time and worst >= 0:
        pressed[worst] = not pressed[worst]
    return changes


def solve_dense_patch(
    coefficients: FloatArray,
    gap: FloatArray,
    rows: IntArray,
    columns: IntArray,
    pressed: BoolArray,
    *,
    load: float | None,
    approach: float | None,
) -> DensePatch:
    """Contact of a list of cells by a primal-dual active set (Hintermueller, Ito & Kunisch 2002) and Cholesky.

    Parameters
    ----------
    coefficients : (nx, ny) array [mm/MPa]
        `love_coefficients` over the effective modulus.
    gap : (n,) array [mm]
    rows, columns : (n,) int arrays
        Place of the cells in the grid.
    pressed : (n,) bool array
        First guess of the cells in contact (warm start).
    load, approach : float [MPa], [mm]
        One of them, the other None: sum of the pressures, or approach.
    """
    matrix = _influence(coefficients, rows, columns)
    pressed = pressed.copy()
    if not pressed.any():
        pressed[np.argmin(gap)] = True
    level = 0.0 if approach is None else approach
    pressure = np.zeros(gap.size)
    for attempt in range(1, _SETS + 1):
        on = np.flatnonzero(pressed)
        if on.size == 0:
            if approach is not None and gap.min() >= approach:
                return DensePatch(pressure, level, attempt, True)
            on = np.array([int(np.argmin(gap))])
            pressed[on] = True
        part, sides = _subsystem(matrix, gap, on)
        _, solved, failed = dposv(part, sides, lower=0, overwrite_a=1, overwrite_b=1)
        if failed:
            break
        if load is not None:
            level = float((load + solved[:, 0].sum()) / solved[:, 1].sum())
        force = level * solved[:, 1] - solved[:, 0]
        if not force.max() > 0.0:
            break
        if _update(matrix, gap, level, on, force, pressed, attempt > _AT_ONCE) == 0:
            pressure[on] = force
            return DensePatch(pressure, level, attempt, True)
    return DensePatch(pressure, level, _SETS, False)

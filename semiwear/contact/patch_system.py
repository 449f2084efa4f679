"""Cells of all tooth pairs that may touch at a mesh position: their compliance, and what preconditions it.

Forces f >= 0 on cells and one rotation phi of the driving body with

    gap + C f - a phi >= 0,   f (gap + C f - a phi) = 0,   sum of a f = torque

are what `patch_sharing` solves. C is the half-space under each pair, plus what one slice feels of another as a
whole (teeth, rims, wear), plus the tilt of bent teeth: a force nearer to a tip bends its tooth more, and a bent flank
leans away from its partner, most beside its tip. Of what teeth and half-space both count there is less for a point
aside: the square of the distance, where that is less than the depth of the tooth. Cells free to change are
preconditioned with the half-space of every slice by itself, exact, and the coupling between slices as a whole, exact
but for its shape across the line. That takes a handful of convolutions, whatever the cells' width.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

from semiwear.compliance.half_space import HalfSpace
from semiwear.kernel_cache import njit

__all__ = ["PatchSystem", "RowPreconditioner"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_EVEN_ACROSS = 0.6  # of a half-width: there a slice's displacement is about its mean over the next one's contact
_DEFINITE = 0.1  # least eigenvalue of the coupling of slices, when it has to be lifted


@dataclass(frozen=True)
class PatchSystem:
    """Compliance of rows of cells of several pairs, one after the other.

    Attributes
    ----------
    starts : (pairs + 1,) int array
        First row of each pair.
    half_spaces : tuple of HalfSpace
        One for each pair, per pressure.
    per_force : float [1/mm^2]
        Pressure of a unit force on a cell.
    smooth : (rows, rows) array [mm/N]
        What a row feels of another as a whole: tooth compliance less the half-space at the mid-surface, and wear.
    tilt : (rows, rows) array [1/N]
        Change of its row i by the distance that a point of the slice moves across the line.
    aside : (rows, rows) array [1/(N mm)]
        Its change by the square of the distance, across the line, between force and point.
    across : (rows, columns) array [mm]
        Distance of each cell from where its row's tooth compliance was taken.
    coefficients : (rows of the longest pair, columns) array [mm/N]
        Half-space influence of a unit force on a cell.
    """

    starts: IntArray
    half_spaces: tuple[HalfSpace, ...]
    per_force: float
    smooth: FloatArray
    tilt: FloatArray
    aside: FloatArray
    across: FloatArray
    coefficients: FloatArray

    def apply(self, force: FloatArray, *, roughly: bool = False) -> FloatArray:
        """C f [mm] for cell forces [N], (rows, columns); half-spaces in single precision if roughly."""
        out = np.empty_like(force)
        for half_space, start, stop in zip(self.half_spaces, self.starts[:-1], self.starts[1:], strict=True):
            out[start:stop] = half_space.apply(force[start:stop], roughly=roughly)
        out *= self.per_force
        whole, moment, second = _moments(force, self.across)
        even = self.smooth @ whole + self.tilt.T @ moment + self.aside @ second
        _add_across(out, self.across, even, self.tilt @ whole - 2.0 * (self.aside @ moment), self.aside @ whole)
        return out


@njit(cache=True, error_model="numpy")
def _moments(force, across):  # type: ignore[no-untyped-def]
    """Sum of the forces of every row, and their first and second moments: (3, rows)."""
    out = np.zeros((3, force.shape[0]))
    for r in range(force.shape[0]):
        whole, first, second = 0.0, 0.0, 0.0
        for c in range(force.shape[1]):
            moment = across[r, c] * force[r, c]
            whole += force[r, c]
            first += moment
            second += across[r, c] * moment
        out[0, r], out[1, r], out[2, r] = whole, first, second
    return out


@njit(cache=True, error_model="numpy")
def _add_across(out, across, even, linear, square):  # type: ignore[no-untyped-def]
    """Add a parabola across every row."""
    for r in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[r, c] += even[r] + across[r, c] * (linear[r] + across[r, c] * square[r])


@njit(cache=True, error_model="numpy")
def _factor_row(own, members, m, factor, ones):  # type: ignore[no-untyped-def]
    """Cholesky factor of m cells of a row, their response to an even displacement, and its sum."""
    total = 0.0
    for i in range(m):
        for j in range(i + 1):
            value = own[abs(members[i] - members[j])]
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            factor[i, j] = sqrt(value) if i == j else value / factor[j, j]
        value = 1.0
        for k in range(i):
            value -= factor[i, k] * ones[k]
        ones[i] = value / factor[i, i]
    for i in range(m - 1, -1, -1):
        value = ones[i]
        for k in range(i + 1, m):
            value -= factor[k, i] * ones[k]
        ones[i] = value / factor[i, i]
        total += ones[i]
    return total


@njit(cache=True, error_model="numpy")
def _factor_rows(active, before, own, factors, ones, compliance, members, counts):  # type: ignore[no-untyped-def]
    """`_factor_row` of every row whose active cells are not those that they were before."""
    rows, columns = active.shape
    for r in range(rows):
        if np.array_equal(active[r], before[r]):
            continue
        m = 0
        for c in range(columns):
            if active[r, c]:
                members[r, m] = c
                m += 1
        counts[r] = m
        compliance[r] = _factor_row(own, members[r], m, factors[r], ones[r])


@njit(cache=True, error_model="numpy")
def _solve_rows(residual, factors, members, counts, out, sums):  # type: ignore[no-untyped-def]
    """Every row's cells by themselves; `out` is zero elsewhere."""
    rows, columns = residual.shape
    x = np.empty(columns)
    for r in range(rows):
        m = counts[r]
        for c in range(columns):
            out[r, c] = 0.0
        for i in range(m):
            value = residual[r, members[r, i]]
            for k in range(i):
                value -= factors[r, i, k] * x[k]
            x[i] = value / factors[r, i, i]
        total = 0.0
        for i in range(m - 1, -1, -1):
            value = x[i]
            for k in range(i + 1, m):
                value -= factors[r, k, i] * x[k]
            x[i] = value / factors[r, i, i]
            out[r, members[r, i]] = x[i]
            total += x[i]
        sums[r] = total


@njit(cache=True, error_model="numpy")
def _add_even(out, ones, members, counts, amount):  # type: ignore[no-untyped-def]
    for r in range(out.shape[0]):
        for i in range(counts[r]):
            out[r, members[r, i]] += amount[r] * ones[r, i]


@njit(cache=True, error_model="numpy")
def _couple_rows(on, counts, starts, coefficients, smooth, root, coupling, matrix):  # type: ignore[no-untyped-def]
    """Deflection of active rows under one another's forces [mm/N], times `root` from the left; 1 + that from both."""
    n = on.shape[0]
    pair = 0
    pairs = np.empty(n, dtype=np.int64)
    for i in range(n):
        while pair < starts.shape[0] - 2 and on[i] >= starts[pair + 1]:
            pair += 1
        pairs[i] = pair
    for i in range(n):
        for j in range(i + 1):
            value = smooth[on[i], on[j]]
            if i != j and pairs[i] == pairs[j]:
                middle = int(0.5 * _EVEN_ACROSS * sqrt(counts[on[i]] * counts[on[j]]) + 0.5)
                value += coefficients[on[i] - on[j], middle]
            coupling[i, j] = root[i] * value
            coupling[j, i] = root[j] * value
            matrix[i, j] = matrix[j, i] = root[i] * value * root[j]
        matrix[i, i] += 1.0


class RowPreconditioner:
    """Forces that answer a displacement: rows of free cells by themselves, coupled as a whole (Woodbury).

    Factors are kept until other cells are free.
    """

    def __init__(self, system: PatchSystem, columns: int):
        rows = int(system.starts[-1])
        self._system = system
        self._free = np.zeros((rows, columns), dtype=bool)
        self._factors, self._ones = np.empty((rows, columns, columns)), np.empty((rows, columns))
        self._members, self._counts = np.empty((rows, columns), np.int64), np.zeros(rows, np.int64)
        self._compliance = np.zeros(rows)

    def __call__(self, residual: FloatArray, free: BoolArray) -> FloatArray:
        """Forces [N] for a displacement [mm], (rows, columns); zero on cells that are not free."""
        if not np.array_equal(free, self._free):
            self._factor(free)
        out, sums = np.empty_like(residual), np.empty(residual.shape[0])
        _solve_rows(residual, self._factors, self._members, self._counts, out, sums)
        # (D + E c E')^-1 = D^-1 - D^-1 E R (1 + R c R)^-1 R c E' D^-1, with R^2 = E' D^-1 E
        amount, on = np.zeros(residual.shape[0]), self._on
        amount[on] = -dpotrs(self._whole, self._coupling @ sums[on], lower=1)[0] / self._root
        _add_even(out, self._ones, self._members, self._counts, amount)
        return out

    def _factor(self, free: BoolArray) -> None:
        system = self._system
        _factor_rows(
            free, self._free, system.coefficients[0], self._factors, self._ones, self._compliance, self._members,
            self._counts,
        )  # fmt: skip
        self._free = free.copy()
        self._on = on = np.flatnonzero(self._counts)
        self._root = np.sqrt(self._compliance[on])
        self._coupling, matrix = np.empty((on.size, on.size)), np.empty((on.size, on.size))
        _couple_rows(
            on, self._counts, system.starts, system.coefficients, system.smooth, self._root, self._coupling, matrix
        )
        # LAPACK itself: scipy's wrappers take longer than matrices of this size
        self._whole, failed = dpotrf(matrix, lower=1)
        if failed:
            # a preconditioner has to be positive definite, whatever it stands for
            matrix.ravel()[:: on.size + 1] += _DEFINITE - float(np.linalg.eigvalsh(matrix)[0])
            self._whole, _ = dpotrf(matrix, lower=1)

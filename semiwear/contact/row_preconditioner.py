"""Preconditioner of the cells of a mesh position: forces on rows of free cells for a displacement.

Cells free to change are preconditioned with the half-space of each slice by itself, exactly, and with the coupling
between whole slices, exact but for its shape across the line. A handful of convolutions is then enough for any width
of the cells.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.kernel_cache import ZERO, inner_njit, njit

_EVEN_ACROSS = 0.6  # of a half-width, where a slice's displacement is about its mean over the next one's contact
_FEW_CHANGED = 0.05  # of the free cells: while fewer have changed, the coupling of rows is kept
_TOGETHER = 4  # rows that are solved at a time
_DEFINITE = 0.1  # least eigenvalue of the coupling of slices, if it has to be raised


@inner_njit(cache=True, error_model="numpy")
def _factor_cells(own, members, known, m, factor):  # type: ignore[no-untyped-def]
    """Cholesky factor (its diagonal inverse) of m cells of a row; the first `known` rows are given."""
    for i in range(known, m):
        for j in range(i + 1):
            value = own[abs(members[i] - members[j])]
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            factor[i, j] = 1.0 / sqrt(value) if i == j else value * factor[j, j]


@inner_njit(cache=True, error_model="numpy")
def _answer_evenly(factor, m, ones):  # type: ignore[no-untyped-def]
    """Forces on m cells under a uniform displacement, and their sum."""
    total = 0.0
    for i in range(m):
        value = 1.0
        for k in range(i):
            value -= factor[i, k] * ones[k]
        ones[i] = value * factor[i, i]
    for i in range(m - 1, -1, -1):
        value = ones[i]
        for k in range(i + 1, m):
            value -= factor[k, i] * ones[k]
        ones[i] = value * factor[i, i]
        total += ones[i]
    return total


class RowPreconditioner(NamedTuple):
    """Forces for a displacement: rows of free cells by themselves, coupled as a whole (Woodbury).

    Cells side by side have the same factor in all rows, fewer cells its first rows. The factor of a row with gaps is
    kept until other cells of it are free; that of the rows' coupling, until more than a few are.

    Attributes
    ----------
    free : (rows, columns) bool array
        Free cells of the present factors.
    together : (columns, columns) array
        Cholesky factor of cells side by side; of its diagonal, the inverse.
    evenly : (columns + 1, columns) array [N/mm]
        Row m: forces on m of them under a uniform displacement.
    stiff : (columns + 1,) array [N/mm]
        Their sum; zero where it is not computed yet.
    known : (1,) int array
        Rows of `together` that are computed.
    apart : (rows,) bool array
        Rows whose free cells are not side by side.
    factors : (rows, columns, columns) array
        Cholesky factor of each of these.
    ones : (rows, columns) array [N/mm]
        Forces on the free cells under a uniform displacement.
    members : (rows, columns) int array
        Their columns.
    counts : (rows,) int array
        Their number.
    stiffness : (rows,) array [N/mm]
        Sum of these forces.
    on : (rows,) int array
        Rows that have free cells; `used` of them.
    used : (1,) int array
    changed : (1,) int array
        Cells that have changed since the coupling was made.
    coupling : (rows, rows) array
        Deflection of these rows under one another's forces, times the square root of the stiffness from both sides.
    whole : (rows, rows) array
        Cholesky factor of 1 plus that; of its diagonal, the inverse.
    """

    free: BoolArray
    together: FloatArray
    evenly: FloatArray
    stiff: FloatArray
    known: IntArray
    apart: BoolArray
    factors: FloatArray
    ones: FloatArray
    members: IntArray
    counts: IntArray
    stiffness: FloatArray
    on: IntArray
    used: IntArray
    changed: IntArray
    coupling: FloatArray
    whole: FloatArray


@njit(cache=True, error_model="numpy")
def row_preconditioner(rows, columns):  # type: ignore[no-untyped-def]
    """A preconditioner without free cells yet."""
    return RowPreconditioner(
        np.zeros((rows, columns), dtype=np.bool_),
        np.empty((columns, columns)),
        np.empty((columns + 1, columns)),
        np.zeros(columns + 1),
        np.zeros(1, dtype=np.int64),
        np.zeros(rows, dtype=np.bool_),
        np.empty((rows, columns, columns)),
        np.empty((rows, columns)),
        np.empty((rows, columns), dtype=np.int64),
        np.zeros(rows, dtype=np.int64),
        np.zeros(rows),
        np.empty(rows, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.empty((rows, rows)),
        np.empty((rows, rows)),
    )


@njit(cache=True, error_model="numpy", nogil=True)
def precondition(kept, system, residual, free, out):  # type: ignore[no-untyped-def]
    """Forces [N] for a displacement [mm], (rows, columns); zero on cells that are not free.

    Parameters
    ----------
    kept : RowPreconditioner, changed
    system : PatchSystem
    residual : (rows, columns) array [mm]
    free : (rows, columns) bool array
    out : (rows, columns) array [N], changed
    """
    if _factor_rows(kept, system.coefficients[0], free):
        kept.changed[0] = 0
        _couple_rows(kept, system.starts, system.coefficients, system.smooth)
        lift = 0.0
        while not _factor_whole(kept, lift):
            # a preconditioner has to be positive definite, even if the coupling is not
            lift = max(2.0 * lift, _DEFINITE)
        if lift > 0.0:
            _factor_whole(kept, lift + _DEFINITE)
    _solve(kept, residual, out)


@inner_njit(cache=True, error_model="numpy")
def _factor_row(kept, own, r, m):  # type: ignore[no-untyped-def]
    """Forces of a row of m free cells under a uniform displacement, by its own or the common factor."""
    members = kept.members[r]
    kept.apart[r] = m > 0 and members[m - 1] - members[0] >= m
    if kept.apart[r]:
        _factor_cells(own, members, ZERO, m, kept.factors[r])
        kept.stiffness[r] = _answer_evenly(kept.factors[r], m, kept.ones[r])
        return
    if kept.known[0] < m:
        _factor_cells(own, members, kept.known[0], m, kept.together)
        kept.known[0] = m
    if m > 0 and kept.stiff[m] == 0.0:
        kept.stiff[m] = _answer_evenly(kept.together, m, kept.evenly[m])
    kept.stiffness[r] = kept.stiff[m]
    for k in range(m):
        kept.ones[r, k] = kept.evenly[m, k]


@inner_njit(cache=True, error_model="numpy")
def _factor_rows(kept, own, free):  # type: ignore[no-untyped-def]
    """Factors of every row whose free cells have changed; whether the coupling has to be computed again.

    It has if more than a few cells have changed since the last time, or a row has its first free cells.
    """
    rows, columns = free.shape
    count, due = 0, False
    for r in range(rows):
        same = True
        for c in range(columns):
            same &= free[r, c] == kept.free[r, c]
        if same:
            continue
        m = ZERO
        for c in range(columns):
            kept.changed[0] += free[r, c] != kept.free[r, c]
            kept.free[r, c] = free[r, c]
            if free[r, c]:
                kept.members[r, m] = c
                m += 1
        due |= kept.counts[r] == 0
        kept.counts[r] = m
        _factor_row(kept, own, r, m)
    for r in range(rows):
        count += kept.counts[r]
    return due or kept.changed[0] > _FEW_CHANGED * count


@njit(cache=True, error_model="numpy")
def _couple_rows(kept, starts, coefficients, smooth):  # type: ignore[no-untyped-def]
    """Coupling of the rows that have free cells."""
    n = ZERO
    most = kept.on.shape[0]
    pairs, width, root = np.empty(most, dtype=np.int64), np.empty(most), np.empty(most)
    for pair in range(starts.shape[0] - 1):
        for r in range(starts[pair], starts[pair + 1]):
            if kept.counts[r] > 0:
                kept.on[n], pairs[n], width[n] = r, pair, sqrt(0.5 * _EVEN_ACROSS * kept.counts[r])
                root[n] = sqrt(kept.stiffness[r])
                n += 1
    kept.used[0] = n
    for i in range(n):
        for j in range(i + 1):
            r, s = kept.on[i], kept.on[j]
            value = smooth[r, s]
            if i != j and pairs[i] == pairs[j]:
                value += coefficients[r - s, int(width[i] * width[j] + 0.5)]
            kept.coupling[i, j] = kept.coupling[j, i] = root[i] * value * root[j]


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _factor_whole(kept, lift):  # type: ignore[no-untyped-def]
    """Factor of the rows' coupling with `lift` added to its diagonal; False if it is not definite."""
    a = kept.whole
    for i in range(kept.used[0]):
        for j in range(i):
            total = kept.coupling[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            a[i, j] = total * a[j, j]
        total = 1.0 + lift + kept.coupling[i, i]
        for k in range(i):
            total -= a[i, k] * a[i, k]
        if not total > 0.0:
            return False
        a[i, i] = 1.0 / sqrt(total)
    return True


@inner_njit(cache=True, error_model="numpy")
def _solve_apart(kept, residual, r, x, out):  # type: ignore[no-untyped-def]
    """Forces on the cells of a row with gaps by themselves, and their sum."""
    m, factor, members, total = kept.counts[r], kept.factors[r], kept.members[r], 0.0
    for i in range(m):
        value = residual[r, members[i]]
        for k in range(i):
            value -= factor[i, k] * x[k, 0]
        x[i, 0] = value * factor[i, i]
    for i in range(m - 1, -1, -1):
        value = x[i, 0]
        for k in range(i + 1, m):
            value -= factor[k, i] * x[k, 0]
        x[i, 0] = value * factor[i, i]
        out[r, members[i]] = x[i, 0]
        total += x[i, 0]
    return total


@inner_njit(cache=True, error_model="numpy")
def _solve_together(kept, residual, some, x, out, sums):  # type: ignore[no-untyped-def]
    """Forces on the cells of four rows without gaps, and their sums; one row alone would wait for each addition."""
    factor, counts, members = kept.together, kept.counts, kept.members
    most = max(counts[some[0]], counts[some[1]], counts[some[2]], counts[some[3]])
    for row in range(_TOGETHER):
        r = some[row]
        for i in range(most):
            x[i, row] = residual[r, members[r, 0] + i] if i < counts[r] else 0.0
    for i in range(most):
        a, b, c, d = x[i, 0], x[i, 1], x[i, 2], x[i, 3]
        for k in range(i):
            f = factor[i, k]
            a, b, c, d = a - f * x[k, 0], b - f * x[k, 1], c - f * x[k, 2], d - f * x[k, 3]
        f = factor[i, i]
        x[i, 0] = a * f if i < counts[some[0]] else 0.0
        x[i, 1] = b * f if i < counts[some[1]] else 0.0
        x[i, 2] = c * f if i < counts[some[2]] else 0.0
        x[i, 3] = d * f if i < counts[some[3]] else 0.0
    for i in range(most - 1, -1, -1):
        a, b, c, d = x[i, 0], x[i, 1], x[i, 2], x[i, 3]
        for k in range(i + 1, most):
            f = factor[k, i]
            a, b, c, d = a - f * x[k, 0], b - f * x[k, 1], c - f * x[k, 2], d - f * x[k, 3]
        f = factor[i, i]
        x[i, 0], x[i, 1], x[i, 2], x[i, 3] = a * f, b * f, c * f, d * f
    for row in range(_TOGETHER):
        r, total = some[row], 0.0
        for i in range(counts[r] - 1, -1, -1):
            out[r, members[r, 0] + i] = x[i, row]
            total += x[i, row]
        sums[r] = total


@njit(cache=True, error_model="numpy")
def _solve_rows(kept, residual, out, sums):  # type: ignore[no-untyped-def]
    """Every row's cells by themselves, and the sum of their forces; zero elsewhere."""
    rows, columns = residual.shape
    x, some, n = np.empty((columns, _TOGETHER)), np.zeros(_TOGETHER, dtype=np.int64), 0
    for r in range(rows):
        sums[r] = 0.0
        for c in range(columns):
            out[r, c] = 0.0
    for r in range(rows):
        if kept.apart[r]:
            sums[r] = _solve_apart(kept, residual, r, x, out)
        elif kept.counts[r] > 0:
            some[n] = r
            n += 1
        if n == _TOGETHER or (n > 0 and r == rows - 1):
            for row in range(n, _TOGETHER):  # if fewer are left, the first is solved again
                some[row] = some[0]
            _solve_together(kept, residual, some, x, out, sums)
            n = 0


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _solve(kept, residual, out):  # type: ignore[no-untyped-def]
    """(D + E c E')^-1 = D^-1 - D^-1 E / R (1 + R c R)^-1 R c R / R E' D^-1, with R^2 = E' D^-1 E.

    R c R may belong to slightly different free cells: the difference remains positive.
    """
    n, sums = kept.used[0], np.empty(residual.shape[0])
    _solve_rows(kept, residual, out, sums)
    x, on, a, even = np.empty(n), kept.on, kept.whole, np.empty(n)
    for i in range(n):
        stiffness = kept.stiffness[on[i]]
        even[i] = 1.0 / sqrt(stiffness) if stiffness > 0.0 else 0.0
        sums[i] = sums[on[i]] * even[i]
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += kept.coupling[i, j] * sums[j]
        for k in range(i):
            total -= a[i, k] * x[k]
        x[i] = total * a[i, i]
    for i in range(n - 1, -1, -1):
        x[i] *= a[i, i]
        for k in range(i):
            x[k] -= a[i, k] * x[i]
    for i in range(n):
        r = on[i]
        for k in range(kept.counts[r]):
            out[r, kept.members[r, k]] -= x[i] * even[i] * kept.ones[r, k]

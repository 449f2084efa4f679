"""Pressed cells in plane strain: an elastic half-plane under a line load, on cells with or without contact.

p >= 0 on narrow cells, gap + u - approach >= 0 and their product zero, with Flamant's logarithmic influence
(Johnson 1985, eq. 2.25). Units are such that a line load q deflects the surface by q.
"""

from __future__ import annotations

from math import log
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_solve, toeplitz

from semiwear.arrays import FloatArray
from semiwear.contact.active_set import cholesky_solve, substitute
from semiwear.kernel_cache import inner_njit

_SETS = 60  # of cells in contact that are tried


class Cells(NamedTuple):
    """Compliance of the cells across a slice.

    Attributes
    ----------
    influence : (n, n) array
        Deflection -(ln s) up to a constant that keeps it definite.
    factor : (n, n) array
        Its Cholesky factor if all cells are alike, of which the first rows are those of fewer cells side by side.
        No rows otherwise.
    response : (n + 1, n) array
        Row m: forces on m cells side by side under a unit approach.
    """

    influence: FloatArray
    factor: FloatArray
    response: FloatArray


def even_cells(count: int) -> Cells:
    """Cells of a single band, all of one width."""
    s = np.arange(count, dtype=float)
    high, low = s + 0.5, np.abs(s - 0.5)
    whole = high * np.log(high) - np.where(s > 0, 1.0, -1.0) * low * np.log(low) - 1.0
    influence = np.ascontiguousarray(toeplitz(log(2.0 * count) - whole))
    factor = np.ascontiguousarray(np.linalg.cholesky(influence))
    response = np.zeros((count + 1, count))
    for m in range(1, count + 1):
        response[m, :m] = cho_solve((factor[:m, :m], True), np.ones(m))
    return Cells(influence, factor, response)


@inner_njit(cache=True, error_model="numpy")
def mean_log(distance, width):  # type: ignore[no-untyped-def]
    """Mean of the logarithm of the distance from a point to a cell."""
    high, low = distance + 0.5 * width, distance - 0.5 * width
    total = high * log(high) - width
    if low != 0.0:
        total -= low * log(abs(low))
    return total / width


@inner_njit(cache=True, error_model="numpy")
def _log_integral(distance):  # type: ignore[no-untyped-def]
    """Integral of the logarithm from zero to a distance > 0, plus that distance."""
    return distance * log(distance)


@inner_njit(cache=True, error_model="numpy")
def _between_bands(x, width, before, begin, count, constant, out):  # type: ignore[no-untyped-def]
    """Deflection of the cells of a band, from `begin` on, by those of one below it, from `before` on.

    The mean of both cells' means: integrals up to an end of a cell serve its neighbour, too.
    """
    for i in range(begin, begin + count):
        last = _log_integral(x[i] - (x[before] - 0.5 * width[before]))
        for j in range(before, before + count):
            following = _log_integral(x[i] - (x[j] + 0.5 * width[before]))
            out[i, j] = constant + 1.0 - 0.5 * (last - following) / width[before]
            last = following
    for j in range(before, before + count):
        last = _log_integral(x[begin] - 0.5 * width[begin] - x[j])
        for i in range(begin, begin + count):
            following = _log_integral(x[i] + 0.5 * width[begin] - x[j])
            out[i, j] -= 0.5 * (following - last) / width[begin]
            last = following


@inner_njit(cache=True, error_model="numpy")
def influences(x, width, n, per_band, span, out):  # type: ignore[no-untyped-def]
    """Deflection of cells under unit loads on cells, -(ln s) up to a constant that keeps it definite; symmetric.

    All bands have `per_band` cells, alike within a band, and follow one another.
    """
    constant = log(2.0 * span)
    for begin in range(0, n, per_band):
        for i in range(begin, begin + per_band):
            out[i, begin] = constant - mean_log(abs(x[i] - x[begin]), width[begin])
            for j in range(begin + 1, i + 1):
                out[i, j] = out[i - 1, j - 1]
        for before in range(0, begin, per_band):
            _between_bands(x, width, before, begin, per_band, constant, out)
    for i in range(n):
        for j in range(i):
            out[j, i] = out[i, j]


@inner_njit(cache=True, error_model="numpy")
def respond(gap, influence, on, a, x, y):  # type: ignore[no-untyped-def]
    """Forces on the pressed cells that close the gap (x) and that a unit approach causes (y).

    False when the influence is not positive definite.
    """
    m = on.shape[0]
    for i in range(m):
        for j in range(i + 1):
            a[i, j] = influence[on[i], on[j]]
        x[i], y[i] = gap[on[i]], 1.0
    return cholesky_solve(a, m, x, y)


@inner_njit(cache=True, error_model="numpy")
def _respond_among(gap, cells, on, a, x, y):  # type: ignore[no-untyped-def]
    """As `respond`, with the stored factor if the cells lie side by side."""
    m = on.shape[0]
    if cells.factor.shape[0] == 0 or on[m - 1] - on[0] != m - 1:
        return respond(gap, cells.influence, on, a, x, y)
    for i in range(m):
        x[i], y[i] = gap[on[i]], cells.response[m, i]
    substitute(cells.factor, m, x)
    return True


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _take_in(gap, influence, approach, on, force, active):  # type: ignore[no-untyped-def]
    """Add cells that penetrate; whether there are any."""
    changed = False
    for i in range(gap.shape[0]):
        if not active[i]:
            slack = gap[i] - approach
            for k in range(on.shape[0]):
                slack += influence[i, on[k]] * force[on[k]]
            if slack < -1e-9 * abs(approach):
                active[i] = True
                changed = True
    return changed


@inner_njit(cache=True, error_model="numpy")
def plane_contact(gap, load, cells, active, force, a, x, y, points):  # type: ignore[no-untyped-def]
    """Forces on cells under a load; returns the approach and its derivative, NaN if unsettled.

    Parameters
    ----------
    gap : (n,) array
    load : float
    cells : Cells
    active : (n,) bool array, changed
        Cells in contact; at least one.
    force : (n,) array, changed
    a, x, y, points : (n, n), (n,), (n,) and (n,) arrays
        Memory.
    """
    for _ in range(_SETS):
        m = 0
        for i in range(gap.shape[0]):
            if active[i]:
                points[m] = i
                m += 1
        on = points[:m]
        if not _respond_among(gap, cells, on, a, x, y):
            break
        top, bottom = load, 0.0
        for i in range(m - 1, -1, -1):
            top += x[i]
            bottom += y[i]
        approach = top / bottom
        force[:] = 0.0
        tension = False
        for i in range(m):
            value = approach * y[i] - x[i]
            if value < 0.0:
                active[on[i]] = False
                tension = True
            else:
                force[on[i]] = value
        if not tension and not _take_in(gap, cells.influence, approach, on, force, active):
            return approach, 1.0 / bottom
    return np.nan, np.nan

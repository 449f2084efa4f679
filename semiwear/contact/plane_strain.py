"""Pressed cells in plane strain: an elastic half-plane under a line load, on cells that bear or lie free.

p >= 0 on narrow cells, gap + u - approach >= 0 and their product zero, with Flamant's logarithmic influence
(Johnson 1985, eq. 2.25). Forces and gaps are in the unit in which a line load q deflects by q.
"""

from __future__ import annotations

from math import log

import numpy as np

from semiwear.contact.active_set import cholesky_solve
from semiwear.kernel_cache import inner_njit

__all__ = ["influences", "mean_log", "plane_contact", "respond"]

_SETS = 60  # of pressed cells that are tried


@inner_njit(cache=True, error_model="numpy")
def mean_log(distance, width):  # type: ignore[no-untyped-def]
    """Mean of the logarithm of the distance from a place to a cell of some width."""
    high, low = distance + 0.5 * width, distance - 0.5 * width
    total = high * log(high) - width
    if low != 0.0:
        total -= low * log(abs(low))
    return total / width


@inner_njit(cache=True, error_model="numpy")
def influences(x, width, n, span, out):  # type: ignore[no-untyped-def]
    """Deflection of cells under unit loads on cells, -(ln s) up to a constant that keeps it definite; symmetric."""
    constant = log(2.0 * span)
    for i in range(n):
        for j in range(i + 1):
            away = abs(x[i] - x[j])
            out[i, j] = constant - 0.5 * (mean_log(away, width[i]) + mean_log(away, width[j]))
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


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _take_in(gap, influence, approach, on, force, active):  # type: ignore[no-untyped-def]
    """Let cells press that penetrate; whether there are any."""
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
def plane_contact(gap, load, influence, active, force, a, x, y, points):  # type: ignore[no-untyped-def]
    """Forces on cells under a load; returns the approach and its derivative, NaN if unsettled."""
    for _ in range(_SETS):
        m = 0
        for i in range(gap.shape[0]):
            if active[i]:
                points[m] = i
                m += 1
        on = points[:m]
        if not respond(gap, influence, on, a, x, y):
            break
        top, bottom = load, 0.0
        for i in range(m - 1, -1, -1):
            top += x[i]
            bottom += y[i]
        approach = top / bottom
        force[:] = 0.0
        pulls = False
        for i in range(m):
            value = approach * y[i] - x[i]
            if value < 0.0:
                active[on[i]] = False
                pulls = True
            else:
                force[on[i]] = value
        if not pulls and not _take_in(gap, influence, approach, on, force, active):
            return approach, 1.0 / bottom
    return np.nan, np.nan

"""Contact of a few points with a full compliance matrix: primal-dual active set (Hintermueller, Ito & Kunisch 2002).

Forces F >= 0 and one approach (or rotation) phi with

    s = gap + C F - lever phi >= 0,   F s = 0,   and either sum of lever F = load or phi itself

The equations are solved with s = 0 on the points in contact and F = 0 on the others; then points under tension are
released and points that penetrate are added, until neither is left. As the load is given, no rigid-body motion has
to be constrained. Used for slices of contact lines, cells of a small contact and nodes of finite elements.
"""

from __future__ import annotations

from enum import IntEnum
from math import sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.kernel_cache import inner_njit, njit

_AT_ONCE = 20  # sets in which all points may change; then one point at a time, which always ends
_ROUNDING = 1e-13  # of gap and approach


class ActiveSetStatus(IntEnum):
    """How `solve_active_set` ended."""

    CONVERGED = 0
    NO_CONTACT_SET = 2
    NOT_POSITIVE_DEFINITE = 3


_CONVERGED, _NO_CONTACT_SET, _NOT_POSITIVE_DEFINITE = (int(status) for status in ActiveSetStatus)


class ActiveSetWork(NamedTuple):
    """Work arrays of the pressed points, with factor and forces of the last set that was solved.

    Attributes
    ----------
    pressed : (1,) int array
        Number of points in contact.
    points : (n,) int array
        These points, in order.
    factor : (n, n) array
        Cholesky factor of their compliance, in its lower triangle.
    closing : (n,) array [N]
        Forces on them that close the gap.
    response : (n,) array [N/mm]
        Forces on them for a unit approach.
    """

    pressed: IntArray
    points: IntArray
    factor: FloatArray
    closing: FloatArray
    response: FloatArray


@njit(cache=True, error_model="numpy")
def active_set_work(n):  # type: ignore[no-untyped-def]
    """Memory for contacts of n points."""
    pressed, points = np.zeros(1, dtype=np.int64), np.empty(n, dtype=np.int64)
    return ActiveSetWork(pressed, points, np.empty((n, n)), np.empty(n), np.empty(n))


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _factor_row(a, i, x, y):  # type: ignore[no-untyped-def]
    """Row i of a Cholesky factor in place, and of both forward substitutions; False if its pivot is not positive."""
    for j in range(i):
        total = a[i, j]
        for k in range(j):
            total -= a[i, k] * a[j, k]
        a[i, j] = total / a[j, j]
    pivot, first, second = a[i, i], x[i], y[i]
    for k in range(i):
        pivot -= a[i, k] * a[i, k]
        first -= a[i, k] * x[k]
        second -= a[i, k] * y[k]
    if pivot <= 0.0:
        return False
    a[i, i] = sqrt(pivot)
    x[i], y[i] = first / a[i, i], second / a[i, i]
    return True


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _factor_two_rows(a, i, x, y):  # type: ignore[no-untyped-def]
    """Rows i (even) and i + 1 of the same, two columns at a time, so that each value that is read serves twice."""
    n = i + 1
    for j in range(0, i, 2):
        m = j + 1
        ij, im, nj, nm = a[i, j], a[i, m], a[n, j], a[n, m]
        for k in range(j):
            upper, lower, left, right = a[i, k], a[n, k], a[j, k], a[m, k]
            ij -= upper * left
            im -= upper * right
            nj -= lower * left
            nm -= lower * right
        ij, nj = ij / a[j, j], nj / a[j, j]
        a[i, j], a[i, m] = ij, (im - ij * a[m, j]) / a[m, m]
        a[n, j], a[n, m] = nj, (nm - nj * a[m, j]) / a[m, m]
    ii, ni, nn = a[i, i], a[n, i], a[n, n]
    first, second, third, fourth = x[i], y[i], x[n], y[n]
    for k in range(i):
        upper, lower = a[i, k], a[n, k]
        ii -= upper * upper
        ni -= upper * lower
        nn -= lower * lower
        first -= upper * x[k]
        second -= upper * y[k]
        third -= lower * x[k]
        fourth -= lower * y[k]
    if ii <= 0.0 or nn - ni * ni / ii <= 0.0:
        return False
    a[i, i], a[n, i], a[n, n] = sqrt(ii), ni / sqrt(ii), sqrt(nn - ni * ni / ii)
    x[i], y[i] = first / a[i, i], second / a[i, i]
    x[n], y[n] = (third - a[n, i] * x[i]) / a[n, n], (fourth - a[n, i] * y[i]) / a[n, n]
    return True


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def cholesky_solve(a, n, x, y):  # type: ignore[no-untyped-def]
    """Solve two right-hand sides in place with the lower triangle of a; False when a is not positive definite."""
    for i in range(0, n - 1, 2):
        if not _factor_two_rows(a, i, x, y):
            return False
    if n % 2 == 1 and not _factor_row(a, n - 1, x, y):
        return False
    for i in range(n - 1, -1, -1):
        x[i] /= a[i, i]
        y[i] /= a[i, i]
        for k in range(i):
            x[k] -= a[i, k] * x[i]
            y[k] -= a[i, k] * y[i]
    return True


@inner_njit(cache=True, error_model="numpy")
def _first_to_touch(gap, lever):  # type: ignore[no-untyped-def]
    """Point that closes first as the bodies approach."""
    first = -1
    for i in range(gap.shape[0]):
        if lever[i] > 0.0 and (first < 0 or gap[i] / lever[i] < gap[first] / lever[first]):
            first = i
    return first


@inner_njit(cache=True, error_model="numpy")
def _respond(matrix, gap, lever, on, a, x, y):  # type: ignore[no-untyped-def]
    """Forces on the pressed points that close the gap (x) and that a unit approach causes (y)."""
    for i in range(on.shape[0]):
        for j in range(i + 1):
            a[i, j] = matrix[on[i], on[j]]
        x[i], y[i] = gap[on[i]], lever[on[i]]
    return cholesky_solve(a, on.shape[0], x, y)


@inner_njit(cache=True, error_model="numpy")
def _balancing(lever, load, on, x, y):  # type: ignore[no-untyped-def]
    """Approach at which the forces of the pressed points bear the load."""
    top, bottom = load, 0.0
    for i in range(on.shape[0]):
        top += lever[on[i]] * x[i]
        bottom += lever[on[i]] * y[i]
    return top / bottom


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def separate(matrix, gap, lever, approach, force, slack):  # type: ignore[no-untyped-def]
    """Separation of every point under forces."""
    for i in range(gap.shape[0]):
        total = gap[i] - lever[i] * approach
        for j in range(gap.shape[0]):
            total += matrix[i, j] * force[j]
        slack[i] = total


@inner_njit(cache=True, error_model="numpy")
def _worst(gap, lever, approach, active, force, slack):  # type: ignore[no-untyped-def]
    """Points under greatest tension and in deepest penetration, -1 for none; rounding is no penetration."""
    pull, press = -1, -1
    for i in range(gap.shape[0]):
        if active[i]:
            if force[i] < 0.0 and (pull < 0 or force[i] < force[pull]):
                pull = i
        elif slack[i] < -_ROUNDING * (abs(approach * lever[i]) + abs(gap[i])):
            if press < 0 or slack[i] < slack[press]:
                press = i
        else:
            slack[i] = max(slack[i], 0.0)
    return pull, press


@inner_njit(cache=True, error_model="numpy")
def _change(active, force, slack, pull, press, freely):  # type: ignore[no-untyped-def]
    """Release points under tension and add those that penetrate: all of them, or the worst."""
    if freely:
        for i in range(active.shape[0]):
            active[i] = force[i] >= 0.0 if active[i] else slack[i] < 0.0
    elif pull >= 0:
        active[pull] = False
    else:
        active[press] = True


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def substitute(factor, n, x):  # type: ignore[no-untyped-def]
    """Solve a right-hand side in place by a Cholesky factor."""
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= factor[i, k] * x[k]
        x[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= factor[i, i]
        for k in range(i):
            x[k] -= factor[i, k] * x[i]


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def correct_forces(work, lever, load, approach, slack, force):  # type: ignore[no-untyped-def]
    """Close the remaining gaps of pressed points by the factor of a nearby compliance matrix.

    One step of iterative refinement (Wilkinson 1963) at a given load: far cheaper than a new factor where the
    compliance has changed by little, as it does with the widths of contact lines.

    Parameters
    ----------
    work : ActiveSetWork
        As `solve_active_set_in` left it.
    lever : (n,) array [mm]
    load : float [N mm]
    approach : float [rad]
    slack : (n,) array [mm]
        Separations that the present forces leave under the present compliance.
    force : (n,) array [N], changed

    Returns
    -------
    approach : float [rad]
    """
    x, count = work.closing, work.pressed[0]
    for i in range(count):
        x[i] = -slack[work.points[i]]
    substitute(work.factor, count, x)
    missing, stiffness = load, 0.0
    for i in range(count):
        p = work.points[i]
        missing -= lever[p] * (force[p] + x[i])
        stiffness += lever[p] * work.response[i]
    turn = missing / stiffness
    for i in range(count):
        force[work.points[i]] += x[i] + turn * work.response[i]
    return approach + turn


@njit(cache=True, error_model="numpy")
def solve_active_set(matrix, gap, lever, load, approach, by_load, active, force, slack, most):  # type: ignore[no-untyped-def]
    """Forces and approach, from a first set of points that press.

    Parameters
    ----------
    matrix : (n, n) array [mm/N]
        Symmetric, positive definite.
    gap : (n,) array [mm]
    lever : (n,) array [mm]
        Closing of the gap for a unit approach: 1, or a lever arm. At least one is positive.
    load, approach : float
        Sum of lever times force, which counts if `by_load`, and the approach [mm, or rad], which counts if not.
    by_load : bool
    active : (n,) bool array, changed
        Points in contact.
    force, slack : (n,) arrays, changed
        Forces [N] and separations [mm].
    most : int
        Contact sets to try at most.

    Returns
    -------
    status : int
        `ActiveSetStatus`.
    approach : float
    tried : int
        Contact sets that were solved.
    """
    work = active_set_work(gap.shape[0])
    return solve_active_set_in(work, matrix, gap, lever, load, approach, by_load, active, force, slack, most)


@inner_njit(cache=True, error_model="numpy")
def solve_active_set_in(work, matrix, gap, lever, load, approach, by_load, active, force, slack, most):  # type: ignore[no-untyped-def]
    """As `solve_active_set`, in an `ActiveSetWork` that keeps the factor of the last set."""
    points, n = work.points, gap.shape[0]
    for attempt in range(most):
        m = 0
        for i in range(n):
            if active[i]:
                points[m] = i
                m += 1
        if m == 0:
            first = _first_to_touch(gap, lever)
            if by_load or gap[first] < approach * lever[first]:
                active[first], points[0], m = True, first, 1
        on, work.pressed[0] = points[:m], m
        if not _respond(matrix, gap, lever, on, work.factor, work.closing, work.response):
            return _NOT_POSITIVE_DEFINITE, approach, attempt + 1
        if by_load:
            approach = _balancing(lever, load, on, work.closing, work.response)
        force[:] = 0.0
        for i in range(m):
            force[on[i]] = approach * work.response[i] - work.closing[i]
        separate(matrix, gap, lever, approach, force, slack)
        pull, press = _worst(gap, lever, approach, active, force, slack)
        if pull < 0 and press < 0:
            return _CONVERGED, approach, attempt + 1
        _change(active, force, slack, pull, press, attempt < _AT_ONCE)
    return _NO_CONTACT_SET, approach, most

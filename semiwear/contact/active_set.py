"""Complementarity of line loads under one rotation, with Hertz widths that follow the loads."""

from __future__ import annotations

from enum import IntEnum
from math import pi, sqrt

import numpy as np
from numba import njit

from semiwear.contact.stripe import add_near_stripe, average_along_lines

__all__ = ["SolveStatus", "solve_line_loads"]

_SETS = 400  # active sets tried for one matrix
_AT_ONCE = 20  # of them that change freely; then one slice at a time, which always ends


class SolveStatus(IntEnum):
    """What happened in `solve_line_loads`."""

    CONVERGED = 0
    WIDTHS_CHANGE = 1
    NO_CONTACT_SET = 2
    NOT_POSITIVE_DEFINITE = 3


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _cholesky_solve(a, n, x, y):  # type: ignore[no-untyped-def]
    """Solve two right-hand sides in place with the lower triangle of a; False when a is not positive definite."""
    for i in range(n):
        for j in range(i):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            a[i, j] = total / a[j, j]
        total = a[i, i]
        for k in range(i):
            total -= a[i, k] * a[i, k]
        if total <= 0.0:
            return False
        a[i, i] = sqrt(total)
        first, second = x[i], y[i]
        for k in range(i):
            first -= a[i, k] * x[k]
            second -= a[i, k] * y[k]
        x[i], y[i] = first / a[i, i], second / a[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= a[i, i]
        y[i] /= a[i, i]
        for k in range(i):
            x[k] -= a[i, k] * x[i]
            y[k] -= a[i, k] * y[i]
    return True


@njit(cache=True, error_model="numpy")
def _active_set(matrix, gap, lever, torque, active, force, slack):  # type: ignore[no-untyped-def]
    """Primal-dual active set (Hintermueller, Ito, Kunisch 2002): status and rotation; active, force, slack change."""
    n = gap.shape[0]
    on = np.empty(n, dtype=np.int64)
    a = np.empty((n, n))
    x, y = np.empty(n), np.empty(n)
    rotation = 0.0
    farthest = np.abs(gap).max()
    for attempt in range(_SETS):
        m = 0
        for i in range(n):
            if active[i]:
                on[m] = i
                m += 1
        if m == 0:
            least = 0
            for i in range(n):
                if gap[i] / lever[i] < gap[least] / lever[least]:
                    least = i
            active[least] = True
            on[0] = least
            m = 1
        for i in range(m):
            for j in range(i + 1):
                a[i, j] = matrix[on[i], on[j]]
            x[i], y[i] = gap[on[i]], lever[on[i]]
        if not _cholesky_solve(a, m, x, y):
            return 3, rotation
        top, bottom = torque, 0.0
        for i in range(m):
            top += lever[on[i]] * x[i]
            bottom += lever[on[i]] * y[i]
        rotation = top / bottom
        force[:] = 0.0
        for i in range(m):
            force[on[i]] = rotation * y[i] - x[i]
        tolerance = 1e-13 * (abs(rotation) * lever[on[0]] + farthest)
        changes = 0
        worst_pull, worst_press = -1, -1
        for i in range(n):
            slack[i] = gap[i] - lever[i] * rotation
            for j in range(m):
                slack[i] += matrix[i, on[j]] * force[on[j]]
            if active[i]:
                if force[i] < 0.0 and (worst_pull < 0 or force[i] < force[worst_pull]):
                    worst_pull = i
            elif slack[i] < -tolerance and (worst_press < 0 or slack[i] < slack[worst_press]):
                worst_press = i
        if worst_pull < 0 and worst_press < 0:
            return 0, rotation
        if attempt < _AT_ONCE:
            for i in range(n):
                if active[i] and force[i] < 0.0:
                    active[i] = False
                    changes += 1
                elif not active[i] and slack[i] < -tolerance:
                    active[i] = True
                    changes += 1
        elif worst_pull >= 0:
            active[worst_pull] = False
        else:
            active[worst_press] = True
    return 2, rotation


@njit(cache=True, error_model="numpy")
def solve_line_loads(  # type: ignore[no-untyped-def]
    static, gap, lever, torque, curvature, starts, arc, length, near, modulus, floor, reach, values, slopes,
    tolerance, max_iterations, active, width, force, slack,
):  # fmt: skip
    """Forces on slices whose Hertz widths follow them.

    Parameters
    ----------
    static : (n, n) array [mm/N]
        Compliance apart from the near field of the stripe kernel.
    gap, lever, curvature, arc, length : (n,) arrays [mm], [mm], [1/mm], [mm], [mm]
    torque : float [N mm]
    starts : (lines + 1,) int array
        First slice of each contact line.
    near : float [mm]
        Distance up to which the stripe kernel is not in `static`.
    modulus : float [MPa]
    floor : (n,) array [mm]
        Least half-width, for slices hardly loaded.
    reach : float [mm]
        Length of line over which a half-width is averaged.
    values, slopes : arrays
        `stripe_table`.
    tolerance : float
        Greatest change of half-widths, relative to the greatest of them.
    max_iterations : int
    active, width, force, slack : (n,) arrays, changed
        Start (active, width) and result.

    Returns
    -------
    status : int
        `SolveStatus`.
    rotation : float [rad]
    iterations : int
    change : float
        Last relative change of half-widths.
    """
    n = gap.shape[0]
    residual, last_residual = np.zeros(n), np.zeros(n)
    image, last_image = np.zeros(n), np.zeros(n)
    rotation, change = 0.0, 0.0
    for iteration in range(1, max_iterations + 1):
        matrix = static.copy()
        add_near_stripe(matrix, starts, arc, length, width, near, 1.0 / (pi * modulus), values, slopes)
        status, rotation = _active_set(matrix, gap, lever, torque, active, force, slack)
        if status != 0:
            return status, rotation, iteration, change
        even = average_along_lines(force, starts, arc, length, reach)
        change, widest = 0.0, 0.0
        for i in range(n):
            new = max(sqrt(4.0 * even[i] / (pi * modulus * curvature[i])), floor[i])
            change = max(change, abs(new - width[i]))
            widest = max(widest, new)
            image[i] = np.log(new)
            residual[i] = image[i] - np.log(width[i])
        change /= widest
        if change < tolerance:
            for i in range(n):
                width[i] = np.exp(image[i])
            return 0, rotation, iteration, change
        # widths and loads answer each other, sometimes slowly, sometimes with overshoot: Anderson 1965, depth one
        mixing = 0.0
        if iteration > 1:
            product, square = 0.0, 0.0
            for i in range(n):
                d = residual[i] - last_residual[i]
                product += residual[i] * d
                square += d * d
            if square > 0.0:
                mixing = min(max(product / square, -5.0), 5.0)
        for i in range(n):
            width[i] = np.exp(image[i] - mixing * (image[i] - last_image[i]))
            last_residual[i] = residual[i]
            last_image[i] = image[i]
    return 1, rotation, max_iterations, change

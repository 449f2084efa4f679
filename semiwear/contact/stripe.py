"""Elastic half-space response along a line contact of finite length.

A line load with Hertz half-width b acts along its own line like the kernel

    K(s) = 1/(pi E*) 4/(pi b^2) sqrt(b^2 + s^2) [K(m) - E(m)],  m = b^2/(b^2 + s^2)

(complete elliptic integrals): the displacement at the middle of a semi-elliptic stripe of zero length, a
distance s along the line (integral of the point-load solution, Johnson 1985, eq. 3.22a, over the stripe).
Far away it is 1/(pi E* s); integrated over a long line it is the Hertz approach of line contact.
"""

from __future__ import annotations

from functools import lru_cache
from math import asinh, log, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

__all__ = [
    "add_far_stripe",
    "add_near_stripe",
    "average_along_lines",
    "stripe_kernel",
    "stripe_table",
    "subtract_mid_surface",
]

FloatArray = NDArray[np.float64]

_TABLE_START = 0.01  # distance over half-width below which the logarithmic limit is used
_TABLE_END = 1000.0  # and beyond which the kernel is 1/s
_TABLE_NODES = 400


def stripe_kernel(distance: FloatArray) -> FloatArray:
    """Kernel pi E* b K(s) as a function of s/b [1]."""
    t2 = np.asarray(distance, float) ** 2
    m1 = t2 / (1.0 + t2)
    return np.asarray(4.0 / pi * np.sqrt(1.0 + t2) * (ellipkm1(m1) - ellipe(1.0 - m1)))


@lru_cache(maxsize=1)
def stripe_table() -> tuple[FloatArray, FloatArray]:
    """Integral of the kernel from 0 to s/b, and its derivative by ln(s/b), at nodes equal in ln(s/b)."""
    nodes = np.linspace(log(_TABLE_START), log(_TABLE_END), _TABLE_NODES)
    points, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * (nodes[1] - nodes[0])
    inside = np.exp((nodes[:-1] + half)[:, None] + half * points)
    pieces = half * (stripe_kernel(inside) * inside) @ weights
    # from 0 to the first node: k behaves like ln t there; Gauss points in t^2 remove most of the singularity
    first = np.polynomial.legendre.leggauss(60)
    t = 0.5 * (first[0] + 1.0)
    start = float(np.sum(0.5 * first[1] * stripe_kernel(_TABLE_START * t**2) * _TABLE_START * 2.0 * t))
    values = start + np.concatenate([[0.0], np.cumsum(pieces)])
    at = np.exp(nodes)
    return values, stripe_kernel(at) * at


@njit(cache=True, error_model="numpy")
def _integral(distance, values, slopes):  # type: ignore[no-untyped-def]
    """Integral of the kernel from 0 to s/b >= 0 by cubic Hermite in ln(s/b)."""
    if distance < _TABLE_START:
        if distance <= 0.0:
            return 0.0
        # scaled so that it meets the table
        return (4.0 / pi * distance * log(4.0 / distance)) * (
            values[0] / (4.0 / pi * _TABLE_START * log(4.0 / _TABLE_START))
        )
    if distance >= _TABLE_END:
        return values[-1] + log(distance / _TABLE_END)
    step = log(_TABLE_END / _TABLE_START) / (_TABLE_NODES - 1)
    place = log(distance / _TABLE_START) / step
    k = min(int(place), _TABLE_NODES - 2)
    x = place - k
    a, b = values[k], values[k + 1]
    da, db = slopes[k] * step, slopes[k + 1] * step
    return (
        a * (1.0 + 2.0 * x) * (1.0 - x) ** 2
        + da * x * (1.0 - x) ** 2
        + b * x * x * (3.0 - 2.0 * x)
        + db * x * x * (x - 1.0)
    )


@njit(cache=True, error_model="numpy")
def add_near_stripe(matrix, starts, arc, length, half_width, near, factor, values, slopes):  # type: ignore[no-untyped-def]
    """Add the stripe kernel between slices of one line that are nearer than `near`, as compliance [mm/N].

    Parameters
    ----------
    matrix : (n, n) array, changed
    starts : (lines + 1,) int array
        First slice of each contact line.
    arc, length, half_width : (n,) arrays [mm]
        Place along the line, length and Hertz half-width of each slice.
    near : float [mm]
    factor : float
        1/(pi E*).
    values, slopes : arrays
        `stripe_table`.
    """
    for line in range(starts.shape[0] - 1):
        for i in range(starts[line], starts[line + 1]):
            for j in range(i, starts[line + 1]):
                middle = arc[j] - arc[i]
                if middle > near:
                    break
                mean_length = sqrt(length[i] * length[j])
                width = sqrt(half_width[i] * half_width[j])
                upper, lower = middle + 0.5 * mean_length, middle - 0.5 * mean_length
                total = _integral(upper / width, values, slopes)
                if lower >= 0.0:
                    total -= _integral(lower / width, values, slopes)
                else:
                    total += _integral(-lower / width, values, slopes)
                total *= factor / mean_length
                matrix[i, j] += total
                if j > i:
                    matrix[j, i] += total


@njit(cache=True, error_model="numpy")
def add_far_stripe(matrix, starts, arc, length, half_width, near, factor):  # type: ignore[no-untyped-def]
    """Add the stripe kernel between slices of one line that are farther than `near` [mm/N]: no width shows there.

    Parameters
    ----------
    matrix, starts, arc, length, near, factor
        As in `add_near_stripe`.
    half_width : float [mm]
        Typical half-width, a small correction.
    """
    for line in range(starts.shape[0] - 1):
        for i in range(starts[line], starts[line + 1]):
            for j in range(i, starts[line + 1]):
                middle = arc[j] - arc[i]
                if middle <= near:
                    continue
                mean_length = sqrt(length[i] * length[j])
                upper, lower = middle + 0.5 * mean_length, middle - 0.5 * mean_length
                # 1/s with its first correction, b^2/(8 s^2) of it
                total = log(upper / lower) + 0.0625 * half_width**2 * (1.0 / upper**2 - 1.0 / lower**2)
                total *= factor / mean_length
                matrix[i, j] += total
                matrix[j, i] += total


@njit(cache=True, error_model="numpy")
def subtract_mid_surface(matrix, starts, arc, length, depth, shear_factor, poisson):  # type: ignore[no-untyped-def]
    """Subtract what tooth compliance counts already: the half-space displacement at the mid-surface [mm/N].

    The point-load solution at a depth (Johnson 1985, eq. 3.22a with z = depth), integrated over a slice.

    Parameters
    ----------
    matrix, starts, arc, length
        As in `add_near_stripe`.
    depth : (bodies, n) array [mm]
        Depth of the mid-surface. No rows: nothing is subtracted.
    shear_factor, poisson : (bodies,) arrays
        (1 + nu)/(2 pi E) and nu of each body.
    """
    for line in range(starts.shape[0] - 1):
        for i in range(starts[line], starts[line + 1]):
            for j in range(i, starts[line + 1]):
                middle = arc[j] - arc[i]
                mean_length = sqrt(length[i] * length[j])
                upper, lower = middle + 0.5 * mean_length, middle - 0.5 * mean_length
                total = 0.0
                for body in range(depth.shape[0]):
                    d = sqrt(depth[body, i] * depth[body, j])
                    for end, sign in ((upper, 1.0), (lower, -1.0)):
                        total += (
                            sign
                            * shear_factor[body]
                            * (end / sqrt(end * end + d * d) + 2.0 * (1.0 - poisson[body]) * asinh(end / d))
                        )
                total /= mean_length
                matrix[i, j] -= total
                if j > i:
                    matrix[j, i] -= total


@njit(cache=True, error_model="numpy")
def average_along_lines(force, starts, arc, length, reach):  # type: ignore[no-untyped-def]
    """Line load [N/mm] averaged along each line with a triangle of half-base `reach` [mm].

    A Hertz width belongs to a stretch of line about as long as it is wide. Taken slice by slice where slices are
    finer than that, width and load would drive each other into oscillation.
    """
    even = np.zeros_like(force)
    for line in range(starts.shape[0] - 1):
        start, stop = starts[line], starts[line + 1]
        for i in range(start, stop):
            total, weight = 0.0, 0.0
            for direction in (-1, 1):
                j = i if direction == 1 else i - 1
                while start <= j < stop:
                    distance = abs(arc[i] - arc[j])
                    if distance >= reach:
                        break
                    w = 1.0 - distance / reach
                    total += w * force[j]
                    weight += w * length[j]
                    j += direction
            even[i] = total / weight
    return even

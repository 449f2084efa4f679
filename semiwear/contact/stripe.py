"""Compliance of line contacts of finite length on the half-space: the stripe's, slice by slice."""

from __future__ import annotations

from math import asinh, log, sqrt

import numpy as np

from semiwear.closed_forms.stripe import stripe_integral
from semiwear.kernel_cache import njit

__all__ = ["add_far_stripe", "add_near_stripe", "average_along_lines", "subtract_mid_surface"]


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
                total = stripe_integral(upper / width, values, slopes)
                if lower >= 0.0:
                    total -= stripe_integral(lower / width, values, slopes)
                else:
                    total += stripe_integral(-lower / width, values, slopes)
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

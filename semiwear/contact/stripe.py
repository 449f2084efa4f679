"""Compliance of line contacts of finite length on the half-space, slice by slice (stripe kernel)."""

from __future__ import annotations

from math import asinh, log, sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.closed_forms.stripe import stripe_integral_to
from semiwear.kernel_cache import ZERO, inner_njit, njit

_ZERO_DISTANCE = -1e3  # logarithm that stands for a distance of zero


class NearPairs(NamedTuple):
    """Slices of one line that are near each other, each pair once; (pairs,) arrays.

    Attributes
    ----------
    first, second : int arrays
    upper, lower : arrays
        Logarithms of the distances [mm] of one slice's ends from the other's middle; `_ZERO_DISTANCE` for 0.
    beyond : array
        1 where the lower end lies beyond the middle, -1 where the middle lies within the slice.
    length : array [mm]
        Mean length of the two.
    """

    first: IntArray
    second: IntArray
    upper: FloatArray
    lower: FloatArray
    beyond: FloatArray
    length: FloatArray


@njit(cache=True, error_model="numpy")
def near_pairs(starts, arc, length, near):  # type: ignore[no-untyped-def]
    """Pairs of slices that are nearer than `near` [mm]; as in `add_far_stripe` otherwise."""
    most = ZERO
    for line in range(starts.shape[0] - 1):
        beyond = starts[line]
        for i in range(starts[line], starts[line + 1]):
            while beyond < starts[line + 1] and arc[beyond] - arc[i] <= near:
                beyond += 1
            most += beyond - i
    first, second = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    upper, lower, beyond, mean = np.empty(most), np.empty(most), np.empty(most), np.empty(most)
    n = 0
    for line in range(starts.shape[0] - 1):
        for i in range(starts[line], starts[line + 1]):
            for j in range(i, starts[line + 1]):
                middle = arc[j] - arc[i]
                if middle > near:
                    break
                first[n], second[n], mean[n] = i, j, sqrt(length[i] * length[j])
                end = middle - 0.5 * mean[n]
                upper[n], lower[n] = log(middle + 0.5 * mean[n]), log(abs(end)) if end != 0.0 else _ZERO_DISTANCE
                beyond[n] = 1.0 if end >= 0.0 else -1.0
                n += 1
    return NearPairs(first[:n], second[:n], upper[:n], lower[:n], beyond[:n], mean[:n])


@njit(cache=True, error_model="numpy")
def pairs_among(pairs, chosen, size):  # type: ignore[no-untyped-def]
    """Near pairs of `size` slices between chosen ones, by their numbers among these."""
    number = np.empty(size, dtype=np.int64)
    for i in range(size):
        number[i] = -1
    for n in range(chosen.shape[0]):
        number[chosen[n]] = n
    most = pairs.first.shape[0]
    first, second = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    upper, lower, beyond, length = np.empty(most), np.empty(most), np.empty(most), np.empty(most)
    count = ZERO
    for n in range(most):
        i, j = number[pairs.first[n]], number[pairs.second[n]]
        if i >= 0 and j >= 0:
            first[count], second[count], upper[count] = i, j, pairs.upper[n]
            lower[count], beyond[count], length[count] = pairs.lower[n], pairs.beyond[n], pairs.length[n]
            count += 1
    return NearPairs(first[:count], second[:count], upper[:count], lower[:count], beyond[:count], length[:count])


@njit(cache=True, error_model="numpy")
def near_stripe(pairs, half_width, factor, table):  # type: ignore[no-untyped-def]
    """Stripe kernel between near slices of one line, as compliance [mm/N].

    Parameters
    ----------
    pairs : NearPairs
    half_width : (n,) array [mm]
        Hertz half-width of each slice.
    factor : float
        1/(pi E*).
    table : array
        `stripe_table`.

    Returns
    -------
    (pairs,) array [mm/N]
    """
    width, out = 0.5 * np.log(half_width), np.empty(pairs.first.shape[0])
    for n in range(pairs.first.shape[0]):
        mean = width[pairs.first[n]] + width[pairs.second[n]]
        total = stripe_integral_to(pairs.upper[n] - mean, table)
        total -= pairs.beyond[n] * stripe_integral_to(pairs.lower[n] - mean, table)
        out[n] = total * factor / pairs.length[n]
    return out


@inner_njit(cache=True, error_model="numpy")
def add_pairs(matrix, pairs, between):  # type: ignore[no-untyped-def]
    """Add compliances between near slices to a symmetric matrix."""
    for n in range(pairs.first.shape[0]):
        i, j = pairs.first[n], pairs.second[n]
        matrix[i, j] += between[n]
        if j > i:
            matrix[j, i] += between[n]


@inner_njit(cache=True, error_model="numpy")
def add_far_stripe(matrix, starts, arc, length, half_width, near, factor):  # type: ignore[no-untyped-def]
    """Add the stripe kernel between slices of one line farther apart than `near` [mm/N], where widths have no effect.

    Parameters
    ----------
    matrix : (n, n) array, changed
    starts : (lines + 1,) int array
        First slice of each contact line.
    arc, length : (n,) arrays [mm]
        Position along the line and length of each slice.
    near : float [mm]
    factor : float
        1/(pi E*).
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


@inner_njit(cache=True, error_model="numpy")
def subtract_mid_surface(matrix, starts, arc, length, depth, shear_factor, poisson):  # type: ignore[no-untyped-def]
    """Subtract what tooth compliance counts already: the half-space displacement at the mid-surface [mm/N].

    The point-load solution at a depth (Johnson 1985, eq. 3.18c with z = depth), integrated over a slice.

    Parameters
    ----------
    matrix, starts, arc, length
        As in `add_far_stripe`.
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
def less_aside(starts, arc, length, depth, shear_factor, poisson):  # type: ignore[no-untyped-def]
    """Decrease of the subtracted displacement by the squared distance across the line [mm/N per mm^2], (n, n) array.

    The half-space displacement at the mid-surface falls with the square of that distance x: of the integral in
    `subtract_mid_surface` with R^2 = x^2 + y^2 + d^2, the derivative by x^2 at x = 0. Parameters as there.
    """
    out = np.zeros((arc.shape[0], arc.shape[0]))
    for line in range(starts.shape[0] - 1):
        for i in range(starts[line], starts[line + 1]):
            for j in range(i, starts[line + 1]):
                middle = arc[j] - arc[i]
                mean_length = sqrt(length[i] * length[j])
                total = 0.0
                for body in range(depth.shape[0]):
                    square = depth[body, i] * depth[body, j]
                    for end, sign in ((middle + 0.5 * mean_length, 1.0), (middle - 0.5 * mean_length, -1.0)):
                        r = sqrt(end * end + square)
                        part = end / r * (0.5 / (r * r) + (2.0 - poisson[body]) / square)
                        total += sign * shear_factor[body] * part
                out[i, j] = out[j, i] = total / mean_length
    return out


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

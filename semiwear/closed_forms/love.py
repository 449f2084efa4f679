"""Displacement of an elastic half-space under a uniformly loaded rectangle (Love 1929; Johnson 1985, eq. 3.25)."""

from __future__ import annotations

from math import log1p, pi, sqrt

import numpy as np

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray
from semiwear.kernel_cache import njit

_CLOSED = 2  # offsets, in cells, up to which the closed form keeps its digits
_FEW = 25.0  # half short sides between rectangle and singularity from which four Gauss points suffice
_SMALL = 1e-3  # square of the argument below which the series of asinh suffices
_POINTS_8, _WEIGHTS_8 = np.polynomial.legendre.leggauss(8)
_POINTS_4, _WEIGHTS_4 = np.polynomial.legendre.leggauss(4)


@njit(cache=True, error_model="numpy")
def _series(square):  # type: ignore[no-untyped-def]
    """asinh(x) / x for a small square of x."""
    return 1.0 - square * (1.0 / 6.0 - square * (3.0 / 40.0 - square * (5.0 / 112.0 - square * 35.0 / 1152.0)))


@njit(cache=True, error_model="numpy")
def _inverse_sinh(x):  # type: ignore[no-untyped-def]
    """asinh(x) of x >= 0; by its series where that is enough (most cells are far away)."""
    square = x * x
    if square < _SMALL:
        return x * _series(square)
    return log1p(x + square / (1.0 + sqrt(1.0 + square)))


@njit(cache=True, error_model="numpy")
def _segment(distance, low, length):  # type: ignore[no-untyped-def]
    """Integral of 1/r along a segment at a distance: asinh(high/distance) - asinh(low/distance)."""
    high = low + length
    if low > 0.0:  # the difference of two asinh as one, without cancellation
        r_low, r_high = sqrt(distance * distance + low * low), sqrt(distance * distance + high * high)
        return _inverse_sinh(length * (high + low) / (high * r_low + low * r_high))
    return _inverse_sinh(high / distance) + _inverse_sinh(-low / distance)


@njit(cache=True, error_model="numpy")
def _closed_form(short, long, x, y):  # type: ignore[no-untyped-def]
    """Integral of 1/r over a rectangle centred at (x, y), near the origin (Johnson 1985, eq. 3.25)."""
    x_low, x_high, y_low, y_high = x - 0.5 * short, x + 0.5 * short, y - 0.5 * long, y + 0.5 * long
    total = x_high * _segment(x_high, y_low, long) + y_high * _segment(y_high, x_low, short)
    return total - x_low * _segment(abs(x_low), y_low, long) - y_low * _segment(abs(y_low), x_low, short)


@njit(cache=True, error_model="numpy")
def _love(count_short, count_long, short, long, points_8, weights_8, points_4, weights_4):  # type: ignore[no-untyped-def]
    """Integral of 1/r over rectangles at all offsets; first axis along the short side."""
    result = np.empty((count_short, count_long))
    distance = np.empty(count_long + 1)
    for i in range(count_short):
        # beyond, the points are few and asinh is its series, without branches that would keep the lanes from it
        to_series = max(1.1 * long * long / _SMALL - (max(i - 1, 0) * short) ** 2, 0.0)
        far = 2 + int(max(sqrt(to_series) / long, (_FEW - i) * short / long, 0.0))
        for j in range(min(far, count_long)):
            if i <= _CLOSED and j <= _CLOSED:
                result[i, j] = _closed_form(short, long, i * short, j * long)
                continue
            # exact along the long side, Gauss points across: all terms positive, nothing cancels far away
            low = (j - 0.5) * long
            to_singularity = 2.0 * i + max((2.0 * j - 1.0) * long / short, 0.0)
            few = to_singularity > 2.0 * _FEW
            points, weights = (points_4, weights_4) if few else (points_8, weights_8)
            total = 0.0
            for k in range(points.shape[0]):
                total += weights[k] * _segment(abs((i + 0.5 * points[k]) * short), low, long)
            result[i, j] = 0.5 * short * total
        for j in range(far, count_long):
            result[i, j] = 0.0
        for k in range(points_4.shape[0] if far < count_long else 0):
            across = ((i + 0.5 * points_4[k]) * short) ** 2
            for j in range(far, count_long + 1):
                distance[j] = sqrt(across + ((j - 0.5) * long) ** 2)
            for j in range(far, count_long):
                low, high = (j - 0.5) * long, (j + 0.5) * long
                x = long * (high + low) / (high * distance[j] + low * distance[j + 1])
                result[i, j] += 0.5 * short * weights_4[k] * x * _series(x * x)
    return result


def love_coefficients(shape: tuple[int, int], cell: tuple[float, float]) -> FloatArray:
    """Surface displacement at cell offsets from a rectangle under unit pressure, for a unit effective modulus.

    The closed form is a difference of terms that grow with distance; away from the loaded cell the integral of
    1/r is therefore taken exactly along the long side and by Gauss points across it (relative error below 1e-13).

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float) [mm]
        Sides dx, dy of the rectangle, of any aspect.

    Returns
    -------
    (nx, ny) array [mm]
        Displacement at (i dx, j dy), to be divided by E* and multiplied by the pressure.

    Raises
    ------
    ValueError
        A number is not positive.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929); Johnson, *Contact Mechanics* (1985), eq. 3.25.
    """
    (nx, ny), (dx, dy) = shape, cell
    require_range("the number of offsets", shape, least=1)
    require_range("the sides of a cell", cell, "mm", above=0.0)
    rules = _POINTS_8, _WEIGHTS_8, _POINTS_4, _WEIGHTS_4
    if dx <= dy:
        return np.asarray(_love(nx, ny, dx, dy, *rules) / pi)
    return np.ascontiguousarray(_love(ny, nx, dy, dx, *rules).T) / pi

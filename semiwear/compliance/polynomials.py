"""Orthonormal polynomials along the width of a body (Legendre), in which loads and displacements are expanded."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray


def along_width(place: FloatArray, count: int) -> FloatArray:
    """Orthonormal polynomials at points of the width.

    They are also the components of a unit load at the point: of the distribution in these orders that does the same
    work.

    Parameters
    ----------
    place : (...) array
        As a share of the width from its middle, -1/2 to 1/2; beyond that it counts as an end.
    count : int
        Number P of orders.

    Returns
    -------
    (..., P) array
        Their products over the width integrate to 1 and 0.
    """
    inside = np.clip(2.0 * np.asarray(place), -1.0, 1.0)
    return np.asarray(np.polynomial.legendre.legvander(inside, count - 1) * np.sqrt(2.0 * np.arange(count) + 1.0))


def derivatives(count: int) -> FloatArray:
    """Derivative of each polynomial by the place in terms of the polynomials: (P, P) array, one a column."""
    scale = np.sqrt(2.0 * np.arange(count) + 1.0)
    slopes = np.zeros((count, count))
    for order in range(1, count):
        own = np.polynomial.legendre.legder(np.eye(count)[order])
        slopes[:order, order] = 2.0 * own[:order] * scale[order] / scale[:order]
    return slopes

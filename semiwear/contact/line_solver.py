"""Load sharing along contact lines: forces on slices whose Hertz widths follow them."""

from __future__ import annotations

from enum import IntEnum
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.active_set import ActiveSetStatus, solve_active_set
from semiwear.contact.stripe import add_near_stripe, average_along_lines, near_pairs
from semiwear.kernel_cache import njit

__all__ = ["LineStatus", "NearField", "Slices", "solve_line_loads"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

_SETS = 400  # active sets tried for one matrix


class LineStatus(IntEnum):
    """How `solve_line_loads` ended."""

    CONVERGED = ActiveSetStatus.CONVERGED
    WIDTHS_CHANGE = 1
    NO_CONTACT_SET = ActiveSetStatus.NO_CONTACT_SET
    NOT_POSITIVE_DEFINITE = ActiveSetStatus.NOT_POSITIVE_DEFINITE


_WIDTHS_CHANGE = int(LineStatus.WIDTHS_CHANGE)


class Slices(NamedTuple):
    """Slices of contact lines that may touch; n of them, line after line.

    Attributes
    ----------
    static : (n, n) array [mm/N]
        Compliance apart from the near field of the stripe kernel.
    gap, lever, arc, length, floor : (n,) arrays [mm]
        Separation, lever arm, place along the line, length, and least half-width of slices hardly loaded.
    curvature : (n,) array [1/mm]
    starts : (lines + 1,) int array
        First slice of each line.
    """

    static: FloatArray
    gap: FloatArray
    lever: FloatArray
    arc: FloatArray
    length: FloatArray
    floor: FloatArray
    curvature: FloatArray
    starts: IntArray


class NearField(NamedTuple):
    """Stripe kernel between slices that are near each other.

    Attributes
    ----------
    distance : float [mm]
        Up to which it is not in `Slices.static`.
    modulus : float [MPa]
        E*.
    average : float [mm]
        Length of line over which a half-width is averaged.
    values, slopes : arrays
        `stripe_table`.
    """

    distance: float
    modulus: float
    average: float
    values: FloatArray
    slopes: FloatArray


@njit(cache=True, error_model="numpy")
def _mixing(residual, last_residual):  # type: ignore[no-untyped-def]
    """Share of the step before that is taken back (Anderson 1965, depth one)."""
    product, square = 0.0, 0.0
    for i in range(residual.shape[0]):
        d = residual[i] - last_residual[i]
        product += residual[i] * d
        square += d * d
    return min(max(product / square, -5.0), 5.0) if square > 0.0 else 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def solve_line_loads(slices, near, torque, tolerance, max_iterations, active, width):  # type: ignore[no-untyped-def]
    """Forces on slices whose Hertz widths follow them.

    Parameters
    ----------
    slices : Slices
    near : NearField
    torque : float [N mm]
    tolerance : float
        Greatest change of half-widths, relative to the greatest of them.
    max_iterations : int
    active : (n,) bool array, changed
        Slices that press.
    width : (n,) array [mm], changed
        Half-widths.

    Returns
    -------
    status : int
        `LineStatus`.
    rotation : float [rad]
    force : (n,) array [N]
    slack : (n,) array [mm]
        Separation under load.
    iterations : int
    change : float
        Last relative change of half-widths.
    """
    n = slices.gap.shape[0]
    force, slack = np.zeros(n), np.zeros(n)
    residual, last_residual, image, last_image = np.zeros((4, n))
    rotation, change = 0.0, 0.0
    pairs = near_pairs(slices.starts, slices.arc, slices.length, near.distance)
    for iteration in range(1, max_iterations + 1):
        matrix = slices.static.copy()
        add_near_stripe(matrix, pairs, width, 1.0 / (pi * near.modulus), near.values, near.slopes)
        status, rotation, _ = solve_active_set(
            matrix, slices.gap, slices.lever, torque, 0.0, True, active, force, slack, _SETS
        )
        if status != 0:
            return status, rotation, force, slack, iteration, change
        even = average_along_lines(force, slices.starts, slices.arc, slices.length, near.average)
        change, widest = 0.0, 0.0
        for i in range(n):
            new = max(sqrt(4.0 * even[i] / (pi * near.modulus * slices.curvature[i])), slices.floor[i])
            change = max(change, abs(new - width[i]))
            widest = max(widest, new)
            image[i] = np.log(new)
            residual[i] = image[i] - np.log(width[i])
        change /= widest
        if change < tolerance:
            width[:] = np.exp(image)
            return 0, rotation, force, slack, iteration, change
        # widths and loads answer each other, sometimes slowly, sometimes with overshoot
        mixing = _mixing(residual, last_residual) if iteration > 1 else 0.0
        for i in range(n):
            width[i] = np.exp(image[i] - mixing * (image[i] - last_image[i]))
            last_residual[i] = residual[i]
            last_image[i] = image[i]
    return _WIDTHS_CHANGE, rotation, force, slack, max_iterations, change

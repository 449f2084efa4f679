"""Load sharing along contact lines: forces on slices whose Hertz widths follow the forces."""

from __future__ import annotations

from enum import IntEnum
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.active_set import (
    ActiveSetStatus,
    active_set_work,
    correct_forces,
    solve_active_set_in,
)
from semiwear.contact.rounded_contact import solve_rounded
from semiwear.contact.stripe import NearPairs, add_pairs, average_along_lines, near_stripe
from semiwear.kernel_cache import inner_njit, njit

_SETS = 400  # active sets tried for one matrix
_CORRECTIONS = 12  # with one factor; if these are not enough, a new one is made
_NEARLY = 1e-2  # of the tolerance of half-widths: separation in contact, over the approach, while widths change
_CLOSED = 1e-13  # of the approach: separation of pressed slices at the end


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
        Separation, lever arm, position along the line, length, and least half-width of lightly loaded slices.
    curvature : (n,) array [1/mm]
    starts : (lines + 1,) int array
        First slice of each line.
    pairs : NearPairs
        Slices near each other.
    """

    static: FloatArray
    gap: FloatArray
    lever: FloatArray
    arc: FloatArray
    length: FloatArray
    floor: FloatArray
    curvature: FloatArray
    starts: IntArray
    pairs: NearPairs


class NearField(NamedTuple):
    """Stripe kernel between slices that are near each other.

    Attributes
    ----------
    modulus : float [MPa]
        E*.
    average : float [mm]
        Length of line over which a half-width is averaged.
    table : (nodes, 4) array
        `stripe_table`.
    """

    modulus: float
    average: float
    table: FloatArray


@inner_njit(cache=True, error_model="numpy")
def _mixing(residual, last_residual):  # type: ignore[no-untyped-def]
    """Fraction of the step before that is taken back (Anderson 1965, depth one)."""
    product, square = 0.0, 0.0
    for i in range(residual.shape[0]):
        d = residual[i] - last_residual[i]
        product += residual[i] * d
        square += d * d
    return min(max(product / square, -5.0), 5.0) if square > 0.0 else 0.0


@inner_njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _separate(slices, pairs, between, rotation, force, slack):  # type: ignore[no-untyped-def]
    """Separation of every slice under forces."""
    n = slices.gap.shape[0]
    for i in range(n):
        total = slices.gap[i] - slices.lever[i] * rotation
        for j in range(n):
            total += slices.static[i, j] * force[j]
        slack[i] = total
    for p in range(pairs.first.shape[0]):
        i, j = pairs.first[p], pairs.second[p]
        slack[i] += between[p] * force[j]
        if j > i:
            slack[j] += between[p] * force[i]


@inner_njit(cache=True, error_model="numpy")
def _corrected(work, slices, pairs, between, torque, closed, active, rotation, force, slack):  # type: ignore[no-untyped-def]
    """Forces corrected by the factor of other half-widths: whether they fulfil the contact conditions, and rotation.

    They do not if the set of pressed slices has to change, or half-widths have changed by much.
    """
    n = slices.gap.shape[0]
    _separate(slices, pairs, between, rotation, force, slack)
    for _ in range(_CORRECTIONS):
        rotation = correct_forces(work, slices.lever, torque, rotation, slack, force)
        _separate(slices, pairs, between, rotation, force, slack)
        open_by, approach = 0.0, 0.0
        for i in range(n):
            if active[i]:
                open_by = max(open_by, abs(slack[i]))
                approach = max(approach, abs(rotation * slices.lever[i]))
        if open_by <= closed * approach:
            for i in range(n):
                if (active[i] and force[i] < 0.0) or (not active[i] and slack[i] < -closed * approach):
                    return False, rotation
            return True, rotation
    return False, rotation


@njit(cache=True, error_model="numpy")
def _solve(work, factored, slices, pairs, between, torque, rounding, closed, active, rotation, force, slack):  # type: ignore[no-untyped-def]
    """Forces for given half-widths, by the factor of earlier ones if that suffices: status and rotation."""
    if rounding is None and factored:
        found, rotation = _corrected(
            work, slices, pairs, between, torque, closed, active, rotation, force, slack
        )  # fmt: skip
        if found:
            return 0, rotation
    matrix = slices.static.copy()
    add_pairs(matrix, pairs, between)
    status = 0
    if rounding is None or not factored:
        status, rotation, _ = solve_active_set_in(
            work, matrix, slices.gap, slices.lever, torque, 0.0, True, active, force, slack, _SETS
        )
    if rounding is not None and status == 0:
        full = rounding.load * slices.length
        problem = (matrix, slices.gap, slices.lever, full, rounding.depth, torque, closed)
        status, rotation = solve_rounded(work, factored, *problem, rotation, force, slack)
    return status, rotation


# inlined into the one kernel that calls it: compiled by itself it takes a fifteenth of a first run
@njit(cache=True, error_model="numpy", inline="always")
def solve_line_loads(slices, near, torque, rounding, tolerance, max_iterations, active, width):  # type: ignore[no-untyped-def]
    """Forces on slices whose Hertz widths follow the forces.

    Parameters
    ----------
    slices : Slices
    near : NearField
    torque : float [N mm]
    rounding : Rounding or None
    tolerance : float
        Greatest change of half-widths, relative to the greatest of them.
    max_iterations : int
    active : (n,) bool array, changed
        Slices in contact.
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
    residual, last_residual, image, last_image = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    rotation, change = 0.0, 0.0
    pairs = slices.pairs
    work = active_set_work(n)
    for iteration in range(1, max_iterations + 1):
        between = near_stripe(pairs, width, 1.0 / (pi * near.modulus), near.table)
        closed = _NEARLY * max(0.1 * change, tolerance)
        problem = (slices, pairs, between, torque, rounding, closed)
        status, rotation = _solve(work, iteration > 1, *problem, active, rotation, force, slack)
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
            if iteration > 1:
                problem = (slices, pairs, between, torque, rounding, _CLOSED)
                status, rotation = _solve(work, True, *problem, active, rotation, force, slack)
            for i in range(n):  # an array assigned whole takes a second longer to compile
                width[i] = np.exp(image[i])
            return status, rotation, force, slack, iteration, change
        # widths and loads depend on each other: the iteration converges slowly at times, and overshoots at others
        mixing = _mixing(residual, last_residual) if iteration > 1 else 0.0
        for i in range(n):
            width[i] = np.exp(image[i] - mixing * (image[i] - last_image[i]))
            last_residual[i] = residual[i]
            last_image[i] = image[i]
    return _WIDTHS_CHANGE, rotation, force, slack, max_iterations, change

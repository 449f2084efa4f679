"""Compliance of the cells of all tooth pairs that may touch at a mesh position.

Forces f >= 0 on cells and one rotation phi of the driving body with

    gap + C f - a phi >= 0,   f (gap + C f - a phi) = 0,   sum of a f = torque

are what `patch_sharing` solves. C is the half-space under each pair, plus the coupling between slices as a whole
(teeth, rims, wear), plus the tilt of bent teeth: a force nearer to a tip bends its tooth more, and a bent flank
leans away from its mate, most beside its tip. The displacement that teeth and half-space both count, and that is
subtracted, falls with the square of the distance across the line, up to about the depth of the tooth.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.fourier import convolve
from semiwear.compliance.half_space import GridPlans, grid_plans
from semiwear.kernel_cache import njit


class PatchSystem(NamedTuple):
    """Compliance of rows of cells of several pairs, one after the other.

    Attributes
    ----------
    starts : (pairs + 1,) int array
        First row of each pair.
    cell : (float, float) [mm]
        Length of a slice and width of a cell.
    modulus : float [MPa]
        Effective modulus E*.
    smooth : (rows, rows) array [mm/N]
        Coupling between rows as a whole: tooth compliance less the half-space at the mid-surface, and wear.
    tilt : (rows, rows) array [1/N]
        Change of row i of `smooth` by the distance that a point of the slice moves across the line.
    aside : (rows, rows) array [1/(N mm)]
        Change of `smooth` by the square of the distance, across the line, between force and point.
    across : (rows, columns) array [mm]
        Distance of each cell from the point of its row's tooth compliance.
    coefficients : (rows of the longest pair, columns) array [mm/N]
        Half-space influence of a unit force on a cell.
    """

    starts: IntArray
    cell: tuple[float, float]
    modulus: float
    smooth: FloatArray
    tilt: FloatArray
    aside: FloatArray
    across: FloatArray
    coefficients: FloatArray

    def apply(self, force: FloatArray) -> FloatArray:
        """C f [mm] for cell forces [N], (rows, columns)."""
        plans, out = plans_of(self, force.shape[1]), np.empty_like(force)
        displace(self, plans, plans.work_space(), self.across, force, out)
        return out


def rows_of_pairs(starts: IntArray) -> tuple[int, ...]:
    """Number of rows of each pair, from the first row of each."""
    return tuple(stop - start for start, stop in pairwise(starts.tolist()))


def plans_of(system: PatchSystem, columns: int) -> GridPlans:
    """The half-space under each pair, with `columns` columns of cells."""
    return grid_plans(rows_of_pairs(system.starts), columns, system.cell)


@njit(cache=True, error_model="numpy", nogil=True)
def displace(system, plans, work, across, force, out):  # type: ignore[no-untyped-def]
    """C f [mm] for cell forces [N], both (rows, columns), on columns at the distances `across`."""
    per_force = 1.0 / (system.cell[0] * system.cell[1] * system.modulus)
    for pair in range(system.starts.shape[0] - 1):
        start, stop = system.starts[pair], system.starts[pair + 1]
        factors = plans.factors[plans.first_factor[pair] : plans.first_factor[pair + 1]]
        turns = plans.turns[plans.first_turn[pair] : plans.first_turn[pair + 1]]
        convolve(
            force[start:stop], out[start:stop], factors, True, turns, plans.turns_across, work,
            plans.sizes[pair, 0], plans.sizes[pair, 1],
        )  # fmt: skip
    _add_whole(system.smooth, system.tilt, system.aside, across, force, per_force, out)


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _add_whole(smooth, tilt, aside, across, force, per_force, out):  # type: ignore[no-untyped-def]
    """Scale the half-spaces' displacement, and add the coupling between rows: a parabola across each row."""
    rows, columns = force.shape
    whole, moment, second, lean = np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows)
    for r in range(rows):
        total, first, square = 0.0, 0.0, 0.0
        for c in range(columns):
            arm = across[r, c] * force[r, c]
            total += force[r, c]
            first += arm
            square += across[r, c] * arm
        whole[r], moment[r], second[r] = total, first, square
    for r in range(rows):
        for s in range(rows):
            lean[s] += tilt[r, s] * moment[r]
    for r in range(rows):
        even, linear, square = lean[r], 0.0, 0.0
        for s in range(rows):
            even += smooth[r, s] * whole[s] + aside[r, s] * second[s]
            linear += tilt[r, s] * whole[s] - 2.0 * aside[r, s] * moment[s]
            square += aside[r, s] * whole[s]
        for c in range(columns):
            out[r, c] = per_force * out[r, c] + even + across[r, c] * (linear + across[r, c] * square)

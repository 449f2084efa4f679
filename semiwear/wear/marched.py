"""Marched wear: Archard's law on the cells of fidelity `patch`, summed over the roll positions.

    dh = sum over roll positions of k p |v_s| dt

At a fixed point of the flank p is the pressure of the cell over it at that instant. With fine roll steps this tends
to the integral over the finite contact width; the swept line (`swept_line.py`) is its limit for small loads.

Large steps. The implicit wear step already contains the response of the line loads to wear, but not that of the
pressure profile: a wave of wave number kappa on the flank changes the pressure by E* kappa/2 in the contact, so that
explicit steps amplify waves shorter than the contact. The swept line updates the profile in cycles and is stable. To
its wear the difference between marched and swept wear at the start of the step is added, damped by the implicit
operator of those waves,

    (1 + k dN (E*/2) s |kappa|)^-1,   s: sliding distance of a mesh under contact,

which conserves the volume of every slice, as the load of a line is given.

For short steps this tends to marched wear alone, and no step is unstable. A node counts as under contact if either
the cells or the footprints of the swept line press on it. On a ridge that carries the whole load, only the footprints
press beside it; counting cells alone would cancel the wear at the foot of the ridge.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.fft import dct

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.contact.patch_gap import PatchCells
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.wear.cell_deposit import deposit_cells


def _sum_over_rolls(
    teeth: LoadedTeeth, cells: PatchCells, rate: FloatArray, slices: BoolArray
) -> tuple[FloatArray, float]:
    """Sum of cell values times |v_s| dt at the nodes of the flank, (face, profile), and over the area beyond them."""
    lines, out = teeth.lines, np.zeros(teeth.grid.profile.shape)
    rolls, faces = np.nonzero(rate.any(axis=-1) & slices)
    time = np.gradient(lines.roll) / teeth.pair.roll_per_time
    amount = np.ascontiguousarray(rate[rolls, faces]) * time[rolls, None]
    beyond = deposit_cells(cells, rolls, faces, amount, slices, out)
    return out, beyond


def marched_wear(
    teeth: LoadedTeeth,
    cells: PatchCells,
    loads: TeethLoads,
    slices: BoolArray,
    weight: float | FloatArray = 1.0,
) -> tuple[FloatArray, float]:
    """Sum of p |v_s| dt over one mesh at the nodes of the flank.

    Parameters
    ----------
    teeth : LoadedTeeth
    cells : PatchCells
    loads : TeethLoads
    slices : (face,) bool array
        Slices to evaluate; the others stay zero.
    weight : float, or (roll, face) array
        Factor on the pressure.

    Returns
    -------
    mesh : (face, profile) array [N/mm]
        Wear depth of one mesh over the wear coefficient.
    beyond : float [N mm]
        Force times sliding distance beyond the ends of the nodes, on the roundings of edges.
    """
    rate = cells.pressure(loads.cells) * np.asarray(weight)[..., None]
    return _sum_over_rolls(teeth, cells, rate, slices)


def sliding_distance_under_contact(
    teeth: LoadedTeeth,
    cells: PatchCells,
    loads: TeethLoads,
    slices: BoolArray,
    weight: float | FloatArray = 1.0,
) -> FloatArray:
    """Sliding distance of one mesh at each node while it is in contact, (face, profile) [mm]."""
    rate = (loads.cells > 0.0) * np.asarray(weight)[..., None]
    return _sum_over_rolls(teeth, cells, rate, slices)[0]


@lru_cache(maxsize=4)
def _absolute_wave_number(points: int) -> FloatArray:
    """Operator |kappa| on nodes of spacing 1, by a cosine transform (even at both ends), (points, points)."""
    cosines = dct(np.eye(points), type=2, norm="ortho", axis=0)
    operator = (cosines.T * (np.pi * np.arange(points) / points)) @ cosines
    operator.flags.writeable = False
    return np.asarray(operator)


def spread_by_contact(
    grid: FlankGrid, values: FloatArray, stiffness: FloatArray, area: FloatArray, slices: BoolArray
) -> FloatArray:
    """Solve x + stiffness (|kappa| x - c) = values along every slice, for waves across the line, even at both ends.

    Since the load of a line is given, c, a pressure common to the slice, is such that x has the volume of `values`.
    Without it, volume would be lost where only some of the nodes are under contact.

    Parameters
    ----------
    grid : FlankGrid
    values, stiffness : (face, profile) arrays
        The second in mm, >= 0.
    area : (face, profile) array
        Area around each node.
    slices : (face,) bool array
        Slices to evaluate; the others are zero.
    """
    points = grid.profile.shape[1]
    absolute = _absolute_wave_number(points)
    out = np.zeros_like(values)
    on = np.flatnonzero(slices & values.any(axis=1))
    spacing = np.gradient(grid.profile[on], axis=1)
    matrices = (stiffness[on] / spacing)[:, :, None] * absolute
    matrices[:, np.arange(points), np.arange(points)] += 1.0
    found = np.linalg.solve(matrices, np.stack([values[on], stiffness[on]], axis=-1))
    lost = np.sum(area[on] * (values[on] - found[..., 0]), axis=1)
    each = np.sum(area[on] * found[..., 1], axis=1)
    common = np.divide(lost, each, out=np.zeros_like(lost), where=each > 0.0)
    out[on] = found[..., 0] + common[:, None] * found[..., 1]
    return out

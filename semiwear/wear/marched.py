"""Wear summed where it happens: Archard's law on the cells of fidelity `patch`, marched through the roll positions.

    dh = sum over roll positions of k p |v_s| dt

At a fixed point of the flank p is the pressure of the cell that covers it at that instant. With fine roll steps this
tends to the integral over the finite contact width; the swept line (`swept_line.py`) is its limit at falling load.

Large steps. The response of the line loads to wear is in the loads themselves (the implicit term of a wear step).
What is left is the response of the pressure's shape: a wave of wave number kappa on the flank changes the pressure by
E* kappa/2 wherever it is touched, so that explicit steps amplify what is shorter than the contact. The swept line
follows the shape in sub-cycles and is stable; only what the marched wear of the step's start differs from the swept
one is added, through the implicit operator of those waves,

    (1 + k dN (E*/2) s |kappa|)^-1,   s: sliding distance of a mesh under contact,

that conserves the volume of every slice, as the load of a line is given.

As steps shrink this tends to marched wear alone, and no step is unstable. A node counts as under contact if either
the cells or the footprints of the swept line press on it: on a ridge that carries the load alone, the cells beside it
do not, the footprints do, and what these wore off the ridge's foot would be put back in full.
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

__all__ = ["marched_wear", "sliding_distance_under_contact", "spread_by_contact"]


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
        Slices to do; the others stay zero.
    weight : float, or (roll, face) array
        Factor on the pressure.

    Returns
    -------
    mesh : (face, profile) array [N/mm]
        Times the wear coefficient it is the wear of one mesh.
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
    """Distance that the other flank slides over each node while it is pressed, in one mesh [mm]: (face, profile)."""
    rate = (loads.cells > 0.0) * np.asarray(weight)[..., None]
    return _sum_over_rolls(teeth, cells, rate, slices)[0]


@lru_cache(maxsize=4)
def _absolute_wave_number(points: int) -> FloatArray:
    """The operator |kappa| on nodes one apart, by cosines that are even at both ends: (points, points)."""
    cosines = dct(np.eye(points), type=2, norm="ortho", axis=0)
    operator = (cosines.T * (np.pi * np.arange(points) / points)) @ cosines
    operator.flags.writeable = False
    return np.asarray(operator)


def spread_by_contact(
    grid: FlankGrid, values: FloatArray, stiffness: FloatArray, area: FloatArray, slices: BoolArray
) -> FloatArray:
    """Solve x + stiffness (|kappa| x - c) = values along every slice: waves across the line, held even at both ends.

    Where some nodes are under contact and others are not, |kappa| x alone would take pressure to where there is none.
    The load of a line is given: c, a pressure common to the slice, is such that the volume of x is that of `values`.

    Parameters
    ----------
    grid : FlankGrid
    values, stiffness : (face, profile) arrays
        The second in mm, >= 0.
    area : (face, profile) array
        That each node stands for.
    slices : (face,) bool array
        Slices to do; the others are zero.
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

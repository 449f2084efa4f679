"""Cells that follow a contact line at fidelity `patch`, and the gap over them.

Every slice is cut into cells across the line, counted from the fresh line of its roll position. Rows of cells are
the slices; a row keeps its place on the flank while wear changes, so that only the gap has to be computed again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.gap import FlankGap, fresh_at, fresh_curve, fresh_on, lowest, slice_gap
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, cubic, first_from, locate, slopes_of_cell

_COLUMNS = 4  # half rows come in multiples, so that few spectra are needed


@njit(cache=True, error_model="numpy", nogil=True)
def _gaps(rolls, faces, approach, columns, width, flank, out):  # type: ignore[no-untyped-def]
    """Gaps below `approach`; the separation is convex, so that the search ends where a greater one grows."""
    farthest = -1.0
    for r in range(rolls.shape[0]):
        gap = slice_gap(flank, rolls[r], faces[r])
        least, curve = lowest(gap.removed, gap.removed.shape[0]), fresh_curve(gap.derivatives)
        known, start, end, slope_a, slope_b = -1, 0.0, 0.0, 0.0, 0.0
        for side in (-1.0, 1.0):
            c, before = 0, gap.derivatives[0]
            while True:
                distance = (c + 0.5) * width
                place = gap.at + side * distance / gap.per_mm
                within = gap.low <= place <= gap.high
                fresh = fresh_on(curve, place - gap.at) if within else fresh_at(gap, place)
                if not fresh < np.inf:  # beyond all roundings
                    break
                if fresh + least <= approach:
                    farthest = max(farthest, distance)
                elif fresh >= before:
                    break
                before = fresh
                if c < columns // 2:
                    column = columns // 2 + c if side > 0.0 else columns // 2 - 1 - c
                    cell, x = locate(gap.nodes, gap.split, place)
                    if cell != known:
                        known, start, end = cell, gap.removed[cell], gap.removed[cell + 1]
                        slope_a, slope_b = slopes_of_cell(gap.removed, gap.nodes, gap.split, cell)
                    out[r, column] = fresh + cubic(start, end, slope_a, slope_b, x)
                c += 1
    return farthest


@inner_njit(cache=True, error_model="numpy")
def pressed_span(row):  # type: ignore[no-untyped-def]
    """First and last cell that is not zero; last < first when there is none."""
    first, last = 0, row.shape[0] - 1
    while first <= last and row[first] == 0.0:
        first += 1
    while last >= first and row[last] == 0.0:
        last -= 1
    return first, last


@inner_njit(cache=True, error_model="numpy")
def between_cells(row, x):  # type: ignore[no-untyped-def]
    """Value between the middles of cells, zero beyond."""
    c = int(np.floor(x))
    left = row[c] if 0 <= c < row.shape[0] else 0.0
    right = row[c + 1] if 0 <= c + 1 < row.shape[0] else 0.0
    return left + (x - c) * (right - left)


@njit(cache=True, error_model="numpy")
def _greatest(rolls, faces, values, width, profile, spacing, nodes, out):  # type: ignore[no-untyped-def]
    half = 0.5 * (values.shape[1] - 1)
    for r in range(rolls.shape[0]):
        k, i = rolls[r], faces[r]
        first, last = pressed_span(values[r])
        at, per_mm = profile[k, i], spacing[k, i]
        p = first_from(nodes[i], at + (first - 1 - half) * width / per_mm)
        stop = at + (last + 1 - half) * width / per_mm
        while last >= first and p < nodes.shape[1] and nodes[i, p] < stop:
            out[i, p] = max(out[i, p], between_cells(values[r], (nodes[i, p] - at) * per_mm / width + half))
            p += 1


@dataclass(frozen=True)
class PatchCells:
    """Rows of cells across the contact lines.

    Attributes
    ----------
    lines : ContactLines
    grid : FlankGrid
    width : float [mm]
        Width of a cell, normal to the line.
    """

    lines: ContactLines
    grid: FlankGrid
    width: float

    def gap(
        self, rolls: IntArray, faces: IntArray, approach: float, columns: int, flanks: FlankGap
    ) -> tuple[FloatArray, float]:
        """Separation at the nominal rotation in the middle of cells, fresh and worn together.

        Parameters
        ----------
        rolls, faces : (n,) int arrays
            Rows.
        approach : float [mm]
            Gaps that exceed it are left out: elasticity only opens gaps, so nothing touches there.
        columns : int
            Cells in a row, the line in the middle; even.
        flanks : FlankGap
            Of these lines, on flanks from which material is removed.

        Returns
        -------
        gap : (n, columns) array [mm]
            Infinite where nothing can touch, and beyond the flanks and their rounded edges.
        reach : float [mm]
            Farthest distance of a cell from the line at which something can touch; negative where nothing can.
        """
        out = np.full((rolls.size, columns), np.inf)
        reach = _gaps(rolls, faces, approach, columns, self.width, flanks, out)
        return out, reach

    def offsets(self, columns: int) -> FloatArray:
        """Distance of the middle of each cell in a row from the line [mm], (columns,)."""
        return (np.arange(columns, dtype=np.float64) - 0.5 * (columns - 1)) * self.width

    def pressure(self, forces: FloatArray) -> FloatArray:
        """Pressure [MPa] of forces on cells [N], (roll, face, columns)."""
        return forces / (self.lines.length * self.width)[..., None]

    def columns_for(self, reach: float) -> int:
        """Even number of cells in a row, in whole multiples, that covers `reach` [mm] to either side."""
        half = max(int(reach / self.width) + 2, 4)
        return 2 * (-(-half // _COLUMNS) * _COLUMNS)

    def greatest_on_flank(self, values: FloatArray) -> FloatArray:
        """Greatest of the cell values, (roll, face, columns), that pass each node of the flank: (face, profile)."""
        lines, out = self.lines, np.zeros(self.grid.profile.shape)
        rolls, faces = np.nonzero(values.any(axis=-1))
        rows = np.ascontiguousarray(values[rolls, faces])
        _greatest(rolls, faces, rows, self.width, lines.profile, lines.spacing, self.grid.profile, out)
        return out

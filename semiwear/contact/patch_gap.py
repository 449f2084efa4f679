"""Cells that follow a contact line, and the gap over them: the flank as fidelity `patch` sees it.

Every slice is cut into cells across the line, counted from the fresh line of its roll position. Rows of cells are
the slices; a row keeps its place on the flank while wear changes, so nothing but the gap has to be found again.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.between_rolls import node_width
from semiwear.contact.gap import fresh_gap, gap_beyond, gap_of_flanks, slice_gap
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, locate, smooth_value
from semiwear.meshing.removed import Removed

__all__ = ["PatchCells"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_ROUNDING = 1e-12
_COLUMNS = 4  # half rows come in multiples, so that few spectra serve all


@njit(cache=True, error_model="numpy")
def _gaps(rolls, faces, approach, columns, width, flank, out):  # type: ignore[no-untyped-def]
    """Gaps less than `approach`; the separation is convex: beyond a greater one that grows all are greater."""
    farthest = -1.0
    for r in range(rolls.shape[0]):
        gap = slice_gap(flank, rolls[r], faces[r])
        least = gap.removed.min()
        for side in (-1.0, 1.0):
            c, before = 0, gap.terms[0]
            while True:
                distance = (c + 0.5) * width
                away = side * distance / gap.per_mm
                place = gap.at + away
                if gap.low <= place <= gap.high:
                    fresh = fresh_gap(away, gap.terms)
                else:
                    fresh = gap_beyond(gap, place)
                if not fresh < np.inf:  # beyond all roundings
                    break
                if fresh + least <= approach:
                    farthest = max(farthest, distance)
                elif fresh >= before:
                    break
                before = fresh
                if c < columns // 2:
                    cell, x = locate(gap.nodes, gap.split, place)
                    column = columns // 2 + c if side > 0.0 else columns // 2 - 1 - c
                    out[r, column] = fresh + smooth_value(gap.removed, gap.nodes, gap.split, cell, x)
                c += 1
    return farthest


@njit(cache=True, error_model="numpy")
def _span(row):  # type: ignore[no-untyped-def]
    """First and last cell that is not zero; last < first when there is none."""
    first, last = 0, row.shape[0] - 1
    while first <= last and row[first] == 0.0:
        first += 1
    while last >= first and row[last] == 0.0:
        last -= 1
    return first, last


@njit(cache=True, error_model="numpy")
def _between(row, x):  # type: ignore[no-untyped-def]
    """Value between the middles of cells, zero beyond."""
    c = int(np.floor(x))
    left = row[c] if 0 <= c < row.shape[0] else 0.0
    right = row[c + 1] if 0 <= c + 1 < row.shape[0] else 0.0
    return left + (x - c) * (right - left)


@njit(cache=True, error_model="numpy")
def _speed(sliding, slope, away):  # type: ignore[no-untyped-def]
    """Length of a sliding velocity that changes with the profile coordinate."""
    v0, v1 = sliding[0] + slope[0] * away, sliding[1] + slope[1] * away
    return sqrt(v0 * v0 + v1 * v1)


@njit(cache=True, error_model="numpy")
def _share(nodes, split, weight, at, start, size, lower, upper, sliding, slope, out):  # type: ignore[no-untyped-def]
    """Add a straight stretch of a rate to nodes as straight lines between them weigh it; returns what is on them."""
    end = nodes.shape[0] - 1
    stop, laid = min(start + size, nodes[end]), 0.0
    if stop <= start:
        return laid
    p, _ = locate(nodes, split, start)
    while p < end and nodes[p] < stop:
        begin, finish = max(start, nodes[p]), min(stop, nodes[p + 1])
        a, b = lower + (upper - lower) * (begin - start) / size, lower + (upper - lower) * (finish - start) / size
        x, y = (begin - nodes[p]) / (nodes[p + 1] - nodes[p]), (finish - nodes[p]) / (nodes[p + 1] - nodes[p])
        # exact for the product of two straight lines
        whole = 0.5 * (finish - begin) * (a + b)
        above = (finish - begin) / 6.0 * (a * x + (a + b) * (x + y) + b * y)
        out[p] += (whole - above) * _speed(sliding, slope, nodes[p] - at) / weight[p]
        out[p + 1] += above * _speed(sliding, slope, nodes[p + 1] - at) / weight[p + 1]
        laid += whole
        p += 1
    return laid


@njit(cache=True, error_model="numpy")
def _deposit(  # type: ignore[no-untyped-def]
    rolls, faces, rate, width, slices, profile, spacing, length, sliding, slope, nodes, split, out
):
    half = 0.5 * (rate.shape[1] - 1)
    end = nodes.shape[1] - 1
    weight = np.empty(end + 1)
    beyond = 0.0
    for r in range(rolls.shape[0]):
        k, i = rolls[r], faces[r]
        if not slices[i]:
            continue
        for p in range(end + 1):
            weight[p] = node_width(nodes[i], p)
        first, last = _span(rate[r])
        at, cell_width = profile[k, i], width / spacing[k, i]
        for c in range(first - 1, last + 1):
            start = at + (c - half) * cell_width
            lower, upper = _between(rate[r], float(c)), _between(rate[r], c + 1.0)
            # straight between the middles of cells; even over cells up to the one that an end of the nodes cuts
            cut = start - 0.5 * cell_width < nodes[i, 0] or start + 1.5 * cell_width > nodes[i, end]
            parts = 2 if cut else 1
            for part in range(parts):
                a, b = (upper if cut and part else lower), (lower if cut and not part else upper)
                begin, size = start + 0.5 * part * cell_width, cell_width / parts
                left = 0.5 * (a + b) * size
                left -= _share(nodes[i], split[i], weight, at, begin, size, a, b, sliding[k, i], slope[k, i], out[i])
                if left > _ROUNDING * (a + b) * size:
                    speed = _speed(sliding[k, i], slope[k, i], begin + 0.5 * size - at)
                    beyond += left * spacing[k, i] * length[k, i] * speed
    return beyond


@njit(cache=True, error_model="numpy")
def _greatest(rolls, faces, values, width, profile, spacing, nodes, out):  # type: ignore[no-untyped-def]
    half = 0.5 * (values.shape[1] - 1)
    for r in range(rolls.shape[0]):
        k, i = rolls[r], faces[r]
        first, last = _span(values[r])
        at, per_mm = profile[k, i], spacing[k, i]
        p = np.searchsorted(nodes[i], at + (first - 1 - half) * width / per_mm)
        stop = at + (last + 1 - half) * width / per_mm
        while last >= first and p < nodes.shape[1] and nodes[i, p] < stop:
            out[i, p] = max(out[i, p], _between(values[r], (nodes[i, p] - at) * per_mm / width + half))
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
        self, rolls: IntArray, faces: IntArray, approach: float, columns: int, removed: Removed
    ) -> tuple[FloatArray, float]:
        """Separation at the nominal rotation in the middle of cells, fresh and worn together.

        Parameters
        ----------
        rolls, faces : (n,) int arrays
            Rows.
        approach : float [mm]
            Gaps that are surely greater are left out: elasticity only opens gaps, so nothing touches there.
        columns : int
            Cells in a row, the line in the middle; even.
        removed : Removed

        Returns
        -------
        gap : (n, columns) array [mm]
            Infinite where nothing can touch, and beyond the flanks and their rounded edges.
        reach : float [mm]
            Farthest distance of a cell from the line at which something can touch; negative where nothing can.
        """
        lines, out = self.lines, np.full((rolls.size, columns), np.inf)
        reach = _gaps(rolls, faces, approach, columns, self.width, gap_of_flanks(lines, removed), out)
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

    def add_to_flank(
        self,
        rolls: IntArray,
        faces: IntArray,
        rate: FloatArray,
        sliding: FloatArray,
        slope: FloatArray,
        slices: NDArray[np.bool_],
        out: FloatArray,
    ) -> float:
        """Add `rate` times the length of the sliding velocity to the flank's nodes, each what is about it.

        The rate is straight between the middles of cells and weighed for every node as straight lines between nodes
        do, so that the sum over the nodes is that over the cells whatever their sizes: read at the nodes alone, it
        would be 0.6 to 1.7 % off with nodes two cells apart.

        Parameters
        ----------
        rolls, faces : (n,) int arrays
            Rows.
        rate : (n, columns) array
            E.g. pressure times time.
        sliding, slope : (roll, face, 2) arrays
            Sliding velocity at the fresh line, and its derivative by the profile coordinate.
        slices : (face,) bool array
            Slices to do.
        out : (face, profile) array, changed

        Returns
        -------
        float
            What lies beyond the ends of the nodes, times its area.
        """
        lines, grid = self.lines, self.grid
        beyond = _deposit(
            rolls, faces, rate, self.width, slices, lines.profile, lines.spacing, lines.length, sliding, slope,
            grid.profile, grid.split, out,
        )  # fmt: skip
        return float(beyond)

    def greatest_on_flank(self, values: FloatArray) -> FloatArray:
        """Greatest of the cell values, (roll, face, columns), that each node of the flank meets: (face, profile)."""
        lines, out = self.lines, np.zeros(self.grid.profile.shape)
        rolls, faces = np.nonzero(values.any(axis=-1))
        rows = np.ascontiguousarray(values[rolls, faces])
        _greatest(rolls, faces, rows, self.width, lines.profile, lines.spacing, self.grid.profile, out)
        return out

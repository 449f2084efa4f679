"""Material removed in one slice between its nodes: the cubic spline of the flank, tabulated where footprints may lie.

The table is computed once for all roll positions that share a row of material removed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.flank_grid import change_above, slope_at

MOST_PARTS = 32


class FineRow(NamedTuple):
    """Profile coordinates between the nodes of a slice and the material removed there.

    Attributes
    ----------
    place, removed : (cells * `MOST_PARTS` + 1,) arrays [mm]
        The first cells * parts + 1 are in use, those between the cells of `known` filled.
    known : (3,) int array
        Parts of a cell, and the first and the end of the cells that are filled.
    """

    place: FloatArray
    removed: FloatArray
    known: IntArray


@njit(cache=True, error_model="numpy")
def fine_row(points):  # type: ignore[no-untyped-def]
    """Memory for slices of a number of nodes, not filled yet."""
    most = (points - 1) * MOST_PARTS + 1
    return FineRow(np.empty(most), np.empty(most), np.zeros(3, dtype=np.int64))


@inner_njit(cache=True, error_model="numpy")
def forget_row(row):  # type: ignore[no-untyped-def]
    """Mark all cells as not filled, for another row."""
    row.known[:] = 0


@inner_njit(cache=True, error_model="numpy")
def parts_of_cells(nodes, longest):  # type: ignore[no-untyped-def]
    """Number of parts of each cell so that none is longer than `longest`: 1, 2, 3, 4, 6, 9 ...

    In steps, so that the table of a row serves most roll positions.
    """
    last = nodes.shape[0] - 1
    width = max(nodes[1] - nodes[0], nodes[last] - nodes[last - 1])
    parts = 1
    while width > parts * longest and parts < MOST_PARTS:
        parts = min(parts + max(parts // 2, 1), MOST_PARTS)
    return parts


@inner_njit(cache=True, error_model="numpy")
def _tabulate(row, gap, parts, first, end):  # type: ignore[no-untyped-def]
    """Fill in cells from `first` up to `end`, with the last node."""
    nodes, split, removed = gap.nodes, gap.split, gap.removed
    if parts == 1:
        for cell in range(first, end + 1):
            row.place[cell], row.removed[cell] = nodes[cell], removed[cell]
        return
    slope = slope_at(removed, nodes, split, first)
    for cell in range(first, end):
        before, slope = change_above(slope, nodes, split, cell), slope_at(removed, nodes, split, cell + 1)
        rise, width = removed[cell + 1] - removed[cell], nodes[cell + 1] - nodes[cell]
        second, third = 3.0 * rise - 2.0 * before - slope, before + slope - 2.0 * rise
        for part in range(parts):
            x = part / parts
            row.place[cell * parts + part] = nodes[cell] + width * x
            row.removed[cell * parts + part] = removed[cell] + x * (before + x * (second + x * third))  # `cubic`
    row.place[end * parts], row.removed[end * parts] = nodes[end], removed[end]


@inner_njit(cache=True, error_model="numpy")
def fill_row(row, gap, parts, first, end):  # type: ignore[no-untyped-def]
    """Fill cells from `first` up to `end`, each in `parts` parts."""
    known = row.known
    if known[0] != parts or end < known[1] or first > known[2]:
        known[0], known[1], known[2] = parts, first, first
    if first < known[1]:
        _tabulate(row, gap, parts, first, known[1])
        known[1] = first
    if end > known[2]:
        _tabulate(row, gap, parts, known[2], end)
        known[2] = end

"""Where the footprints of loaded slices may lie while both flanks wear.

At every roll position another part of the driving flank meets a place of the driven one, so that its wear depth is
interpolated again in every cycle of a wear step, only at those nodes that a footprint can close.
"""

from __future__ import annotations

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.edge_share import highest_that_bears
from semiwear.contact.footprint import BESIDE, CLOSED, closed_between, depth_of, look_within
from semiwear.contact.gap import (
    ON_EDGES,
    add_arc,
    fresh_curve,
    fresh_on,
    gap_at,
    gap_of_flanks,
    reaches_ends,
    rises_within,
    slice_gap,
)
from semiwear.kernel_cache import ZERO, inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, first_from
from semiwear.meshing.removed import Removed
from semiwear.threads import in_loose_shares


@inner_njit(cache=True, error_model="numpy", nogil=True)
def _widest(loaded, flank, nodes, deepest, half_width, windows):  # type: ignore[no-untyped-def]
    last = nodes.shape[1]
    for k in range(loaded.shape[0]):
        for i in range(loaded.shape[1]):
            if not loaded[k, i] or not np.isfinite(flank.separation[0, k, i]):
                continue
            bend, width = flank.separation[2, k, i], half_width / flank.spacing[k, i]
            reach = width + rises_within(deepest + depth_of(bend, width), bend)  # as in `reached`
            low, high = flank.low[k, i], flank.high[k, i]
            start = max(low, min(flank.profile[k, i] - reach, high))
            stop = min(high, max(flank.profile[k, i] + reach, low))
            # an edge is followed on its rounding, and into the flank for as far
            if start <= low:
                start = low - flank.low_radius[k, i] / flank.spacing[k, i]
                stop = max(stop, low + flank.low_radius[k, i] / flank.spacing[k, i])
            if stop >= high:
                stop = high + flank.high_radius[k, i] / flank.spacing[k, i]
                start = min(start, high - flank.high_radius[k, i] / flank.spacing[k, i])
            windows[k, i, 0] = max(first_from(nodes[i], start) - BESIDE, 0)
            windows[k, i, 1] = min(first_from(nodes[i], stop) + BESIDE, last)


def widest(lines: ContactLines, grid: FlankGrid, loaded: BoolArray, deepest: float, half_width: float) -> IntArray:
    """Nodes between which the footprints of loaded slices lie: the first, and the one behind the last.

    Parameters
    ----------
    lines : ContactLines
    grid : FlankGrid
        Grid of the nodes.
    loaded : (roll, face) bool array
    deepest : float [mm]
        Greatest variation of the flanks' shape.
    half_width : float [mm]
        As in `footprints`.

    Returns
    -------
    (roll, face, 2) int array
        Equal where a slice is not loaded.
    """
    windows = np.zeros((*loaded.shape, 2), dtype=np.int64)
    fresh = Removed(grid, np.zeros((1, *grid.profile.shape)), np.zeros(len(loaded), dtype=np.int64))
    _widest(loaded, gap_of_flanks(lines, fresh), grid.profile, deepest, half_width, windows)
    return windows


@inner_njit(cache=True, error_model="numpy")
def _least_on_edge(gap, direction, depth, u, g):  # type: ignore[no-untyped-def]
    """Least gap on the rounding of the lower (-1) or upper edge; infinite where there is none."""
    border, radius = (gap.low, gap.low_radius) if direction < 0.0 else (gap.high, gap.high_radius)
    if radius <= 0.0:
        return np.inf
    least = gap_at(gap, border)
    for c in range(add_arc(gap, direction, depth, u, g, ZERO)):
        least = min(least, g[c])
    return least


@inner_njit(cache=True, error_model="numpy")
def _narrow_one(gap, half_width, closes, wears, window, g, edge):  # type: ignore[no-untyped-def]
    nodes, removed, points = gap.nodes, gap.removed, gap.nodes.shape[0]
    low, high = look_within(window, points)
    curve, depth = fresh_curve(gap.derivatives), depth_of(gap.derivatives[2], half_width / gap.per_mm)
    least = np.inf
    for p in range(low, high + 1):
        g[p] = fresh_on(curve, nodes[p] - gap.at) + removed[p]
        if gap.low <= nodes[p] <= gap.high:
            least = min(least, g[p])
    at_low, at_high = reaches_ends(gap, low, high)
    low_edge = _least_on_edge(gap, -1.0, depth, edge[0], edge[1]) if at_low else np.inf
    high_edge = _least_on_edge(gap, 1.0, depth, edge[0], edge[1]) if at_high else np.inf
    least = min(least, min(low_edge, high_edge)) + wears
    # an edge that does not press yet may take a share of the load of the valley beside it, and the other way round
    bears = highest_that_bears(least, depth, closes)
    low_bears, high_bears = low_edge <= bears, high_edge <= bears
    highest = bears if low_bears or high_bears else least + CLOSED * depth
    low, high = closed_between(removed, g, ZERO, low, high, highest, not low_bears, not high_bears)
    window[0], window[1] = max(low - BESIDE + 1, 0), min(high + BESIDE, points)


@njit(cache=True, error_model="numpy", nogil=True)
def _narrow(flank, half_width, closes, wears, slices, windows):  # type: ignore[no-untyped-def]
    g, edge = np.empty(flank.nodes.shape[1]), np.empty((2, ON_EDGES))
    for i in slices:
        for k in range(flank.profile.shape[0]):
            if windows[k, i, 0] < windows[k, i, 1]:
                gap = slice_gap(flank, k, i)
                _narrow_one(gap, half_width, closes[k, i], wears, windows[k, i], g, edge)


def narrow(
    lines: ContactLines, removed: Removed, half_width: float, closes: FloatArray, wears: float, slices: IntArray
) -> IntArray:
    """Windows of `removed` without the nodes that no footprint closes while the flanks wear by `wears` more.

    Parameters
    ----------
    lines : ContactLines
    removed : Removed
        With windows.
    half_width : float [mm]
        As in `footprints`.
    closes : (roll, face) array [mm]
        Gap that a Hertz contact under the line load closes.
    wears : float [mm]
        Greatest further wear of both flanks together. A gap above the lowest one by more than this and a footprint's
        depth stays open.
    slices : int array
        To compute; the windows of the others stay.
    """
    assert removed.windows is not None
    windows, flank = removed.windows.copy(), gap_of_flanks(lines, removed)
    in_loose_shares(lambda part: _narrow(flank, half_width, closes, wears, part, windows), slices)
    return windows

"""Deposit of rates on the cells of contact patches, summed at the nodes of the driven flank."""

from __future__ import annotations

from math import sqrt

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.patch_gap import PatchCells, between_cells, pressed_span
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.flank_grid import locate
from semiwear.wear.between_rolls import node_width

_ROUNDING = 1e-12


@inner_njit(cache=True, error_model="numpy")
def _speed(sliding, slope, away):  # type: ignore[no-untyped-def]
    """Magnitude of a sliding velocity that varies linearly with the profile coordinate."""
    v0, v1 = sliding[0] + slope[0] * away, sliding[1] + slope[1] * away
    return sqrt(v0 * v0 + v1 * v1)


@inner_njit(cache=True, error_model="numpy")
def _share(nodes, split, weight, at, start, size, lower, upper, sliding, slope, out):  # type: ignore[no-untyped-def]
    """Add a linear stretch of a rate to the nodes, weighted by their hat functions; returns its amount on them."""
    end = nodes.shape[0] - 1
    stop, laid = min(start + size, nodes[end]), 0.0
    if stop <= start:
        return laid
    p, _ = locate(nodes, split, start)
    while p < end and nodes[p] < stop:
        begin, finish = max(start, nodes[p]), min(stop, nodes[p + 1])
        a, b = lower + (upper - lower) * (begin - start) / size, lower + (upper - lower) * (finish - start) / size
        x, y = (begin - nodes[p]) / (nodes[p + 1] - nodes[p]), (finish - nodes[p]) / (nodes[p + 1] - nodes[p])
        # exact for the product of two linear functions
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
        first, last = pressed_span(rate[r])
        at, cell_width = profile[k, i], width / spacing[k, i]
        for c in range(first - 1, last + 1):
            start = at + (c - half) * cell_width
            lower, upper = between_cells(rate[r], float(c)), between_cells(rate[r], c + 1.0)
            # linear between the middles of cells, but constant over cells cut by an end of the nodes
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


def deposit_cells(
    cells: PatchCells, rolls: IntArray, faces: IntArray, rate: FloatArray, slices: BoolArray, out: FloatArray
) -> float:
    """Add `rate` times the magnitude of the sliding velocity to the nodes of the flank.

    The rate is linear between the middles of cells and weighted by the hat function of every node, so that the sum
    over the nodes equals that over the cells whatever their sizes. Sampled at the nodes, it would be 0.6 to 1.7 % off
    with nodes two cells apart.

    Parameters
    ----------
    cells : PatchCells
    rolls, faces : (n,) int arrays
        Rows.
    rate : (n, columns) array
        For example pressure times time.
    slices : (face,) bool array
        Slices to evaluate.
    out : (face, profile) array, changed

    Returns
    -------
    float
        Integral of the amount beyond the ends of the nodes over its area.
    """
    lines, grid = cells.lines, cells.grid
    beyond = _deposit(
        rolls, faces, rate, cells.width, slices, lines.profile, lines.spacing, lines.length, lines.sliding,
        lines.sliding_slope, grid.profile, grid.split, out,
    )  # fmt: skip
    return float(beyond)

"""Wear of single footprints: one row of node values for each roll position and slice.

The loads of a wear step are known only at its end, but footprints hardly differ under similar loads. Kept one by one,
and added up over the cycles of the step, they give the wear under any loads as a sum over rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.kernel_cache import inner_njit


class FootprintRows(NamedTuple):
    """Deposits of footprints at the nodes of a flank, footprint by footprint.

    Attributes
    ----------
    row : (roll, face) int array
        Of each footprint; -1 where none is kept.
    amount : (rows, points) array, changed
    ends : (rows, 2) int array, changed
        First node of a row that is not zero, and the one behind the last.
    taken : (rows, 2) array, changed
        Whole amount of the footprint, and its part beyond the ends of the nodes.
    share : float
        Factor with which footprints are added to their rows: the share of a cycle in the step.
    """

    row: IntArray
    amount: FloatArray
    ends: IntArray
    taken: FloatArray
    share: float


def rows_of(footprints: BoolArray, points: int) -> FootprintRows:
    """Empty rows for chosen footprints, (roll, face), on a flank with this number of nodes in each slice."""
    count = int(footprints.sum())
    row = np.full(footprints.shape, -1)
    row.T[footprints.T] = np.arange(count)  # in the order in which they are found
    ends = np.tile(np.array([points, 0]), (count, 1))
    return FootprintRows(row, np.zeros((count, points)), ends, np.zeros((count, 2)), 1.0)


def no_rows(shape: tuple[int, ...]) -> FootprintRows:
    """Rows in which no footprint is kept."""
    return rows_of(np.zeros(shape, dtype=bool), 0)


@inner_njit(cache=True, error_model="numpy")
def lay_down(laid, first, end, share, out):  # type: ignore[no-untyped-def]
    """Add a share of a footprint between two nodes to a flank or to a row."""
    for p in range(first, end):
        out[p] += share * laid[p]


@inner_njit(cache=True, error_model="numpy")
def take_up(laid, first, end, total, beyond, rows, row, taken):  # type: ignore[no-untyped-def]
    """Add a footprint to its row, if it has one, and to `taken`, (2,), and clear it."""
    taken[0] += total
    taken[1] += beyond
    if row < 0:
        laid[first:end] = 0.0
        return
    amount = rows.amount[row]
    for p in range(first, end):
        amount[p] += rows.share * laid[p]
        laid[p] = 0.0
    rows.ends[row, 0], rows.ends[row, 1] = min(rows.ends[row, 0], first), max(rows.ends[row, 1], end)
    rows.taken[row, 0] += rows.share * total
    rows.taken[row, 1] += rows.share * beyond

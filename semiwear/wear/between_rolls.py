"""Deposit of footprints between roll positions, on a flank's nodes, even where it should be."""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import njit
from semiwear.meshing.flank_grid import locate

__all__ = ["VALLEY", "lay", "node_width", "shifts_of", "step_of"]

VALLEY = 2  # stretches that lie beyond the ridge from a pressed edge, as `at_edge` marks them
_LEAST_STEP = 1e-6  # of a flank's height


@njit(cache=True, error_model="numpy")
def step_of(place, rate, k):  # type: ignore[no-untyped-def]
    """How far a place moves in the step about a roll position."""
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    return (place[after] - place[before]) / max(after - before, 1)


@njit(cache=True, error_model="numpy")
def _lay_ramp(nodes, split, foot, top, height, out):  # type: ignore[no-untyped-def]
    """Add a density that rises straight from nothing at `foot` to `height` at `top`, on either side of it.

    Returns how much of it lies on the nodes.
    """
    last = nodes.shape[0] - 1
    start, stop = max(min(foot, top), nodes[0]), min(max(foot, top), nodes[last])
    laid = 0.0
    if stop <= start:
        return laid
    steep = height / (top - foot)
    cell, _ = locate(nodes, split, start)
    while cell < last and nodes[cell] < stop:
        begin, end = max(start, nodes[cell]), min(stop, nodes[cell + 1])
        width = nodes[cell + 1] - nodes[cell]
        a, b = steep * (begin - foot), steep * (end - foot)
        x, y = (begin - nodes[cell]) / width, (end - nodes[cell]) / width
        # exact for the product of two straight lines
        upper = (end - begin) / 6.0 * (a * x + (a + b) * (x + y) + b * y)
        out[cell] += 0.5 * (end - begin) * (a + b) - upper
        out[cell + 1] += upper
        laid += 0.5 * (end - begin) * (a + b)
        cell += 1
    return laid


@njit(cache=True, error_model="numpy")
def lay(nodes, split, middle, step, amount, out):  # type: ignore[no-untyped-def]
    """Add to nodes an amount that fades out over a step to either side of a place.

    Footprints a roll step apart would leave ripples of that wavelength, so what they wear is straight in between.
    Laid evenly along a step, with its transform below zero, it would wear ripples in a flank deeper that are
    somewhat shorter than the step. What lies beyond the last node wears no flank: the amount on the nodes is
    returned.
    """
    last = nodes.shape[0] - 1
    reach = max(abs(step), _LEAST_STEP * (nodes[last] - nodes[0]))
    height = amount / reach
    below = _lay_ramp(nodes, split, middle - reach, middle, height, out)
    return below + _lay_ramp(nodes, split, middle + reach, middle, height, out)


@njit(cache=True, error_model="numpy")
def shifts_of(middle, at_edge, pieces, low, high, slack, moves, low_moves, high_moves, shift):  # type: ignore[no-untyped-def]  # noqa: C901
    """How far every stretch of a footprint moves in a roll step, from how far its centre and the slice's ends do.

    A footprint that an end of the slice cuts off stays at that end and is drawn out: nothing of it passes over the
    border.
    """
    for whole in (0, VALLEY):  # the valley by itself goes over into the whole footprint
        first, last = np.inf, -np.inf
        for c in range(pieces):
            if at_edge[c] == whole:
                first, last = min(first, middle[c]), max(last, middle[c])
        for c in range(pieces):
            if at_edge[c] != whole:
                continue
            if last >= high - slack:
                lever = max(high - first, slack)
                shift[c] = high_moves + (moves - high_moves) * max(high - middle[c], 0.0) / lever
            elif first <= low + slack:
                lever = max(last - low, slack)
                shift[c] = low_moves + (moves - low_moves) * max(middle[c] - low, 0.0) / lever
            else:
                shift[c] = moves
    for c in range(pieces):
        if at_edge[c] == -1:
            shift[c] = low_moves
        elif at_edge[c] == 1:
            shift[c] = high_moves


@njit(cache=True, error_model="numpy")
def node_width(nodes, p):  # type: ignore[no-untyped-def]
    """Width that a node stands for: half of the cells on either side."""
    left = nodes[p] - nodes[p - 1] if p > 0 else 0.0
    right = nodes[p + 1] - nodes[p] if p < nodes.shape[0] - 1 else 0.0
    return 0.5 * (left + right)

"""What a contact spreads over the driven flank: shares of every footprint, and the sum over roll positions.

A footprint is the root of the gap that is left. Where an edge of either body presses and the valley beyond it bears
as well, that root says little about their shares: there each is a footprint of its own, with its share of the load.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.edge_share import share_of_edge
from semiwear.contact.footprint import MOST_NODES, clipped, reached, segment
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, locate
from semiwear.meshing.removed import Removed

__all__ = [
    "MOST_PIECES",
    "Spread",
    "lay",
    "node_width",
    "pieces_of",
    "shifts_of",
    "spread_over_flank",
    "step_of",
]

FloatArray = NDArray[np.float64]

_EVEN = 1e-4  # of what a footprint reaches down: a stretch that slopes less has its centroid in its middle
_LEAST_STEP = 1e-6  # of a flank's height
MOST_PIECES = 2 * MOST_NODES


@dataclass(frozen=True)
class Spread:
    """What is spread over the footprints, (roll, face) and (roll, face, 2) arrays.

    Attributes
    ----------
    rate : array
        Amount per length of line, e.g. line load times time.
    centre : array
        Two components of the factor at the footprint's centre, e.g. the sliding velocity.
    slope : array
        Their change by the profile coordinate; the factor is the length of the vector.
    closes : array [mm]
        Gap that a Hertz contact under the line load closes, 2 q/(pi E*).
    """

    rate: FloatArray
    centre: FloatArray
    slope: FloatArray
    closes: FloatArray


@njit(cache=True, error_model="numpy")
def _add_pieces(u, g, start, stop, least, room, share, edge, mass, middle, at_edge, pieces):  # type: ignore[no-untyped-def]
    """Append the stretches of a footprint between two points of the outline, whose shares sum up to `share`."""
    area, begin = 0.0, pieces
    for c in range(start, stop):
        if min(g[c], g[c + 1]) - least >= room:
            continue
        u_a, u_b, t_a, t_b = clipped(room, least, u[c], g[c], u[c + 1], g[c + 1])
        if u_b > u_a:
            mass[pieces], below = segment(room, u_b - u_a, t_a, t_b)
            # its centroid: a depth that alternates from node to node would not be felt in the middle
            a, b = t_a * t_a, t_b * t_b
            inside = (below / mass[pieces] - a) / (b - a) if abs(a - b) > _EVEN * room else 0.5
            middle[pieces] = u_a + min(max(inside, 0.0), 1.0) * (u_b - u_a)
            at_edge[pieces] = edge
            area += mass[pieces]
            pieces += 1
    if area <= 0.0:
        return begin
    for piece in range(begin, pieces):
        mass[piece] *= share / area
    return pieces


@njit(cache=True, error_model="numpy")
def pieces_of(  # type: ignore[no-untyped-def]
    at, low, high, terms, per_mm, low_radius, high_radius, gone, nodes, split, half_width, closes,
    work, mass, middle, at_edge,
):  # fmt: skip
    """Stretches of a footprint: middles, shares, whether an edge presses there (-1: lower, 1: upper); how many."""
    room, count, least = reached(
        at, low, high, terms, per_mm, low_radius, high_radius, gone, nodes, split, half_width, work
    )
    u, g = work[2], work[3]
    edge, ridge, share, apart = share_of_edge(u, g, count, low, high, per_mm, closes)
    pieces = 0
    if apart < 1.0:
        pieces = _add_pieces(u, g, 0, count - 1, least, room, 1.0 - apart, 0, mass, middle, at_edge, pieces)
    if apart > 0.0:
        for side in (-1, 1):
            start, stop = (0, ridge) if side < 0 else (ridge, count - 1)
            own = share if side == edge else 1.0 - share
            if own > 0.0:
                bottom = g[start : stop + 1].min()
                pieces = _add_pieces(
                    u, g, start, stop, bottom, room, apart * own, edge if side == edge else 0, mass, middle, at_edge,
                    pieces,
                )  # fmt: skip
    return pieces


@njit(cache=True, error_model="numpy")
def step_of(place, rate, k):  # type: ignore[no-untyped-def]
    """How far a place moves in the step about a roll position."""
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    return (place[after] - place[before]) / max(after - before, 1)


@njit(cache=True, error_model="numpy")
def _lay_ramp(nodes, split, foot, top, height, out):  # type: ignore[no-untyped-def]
    """Add a density that rises straight from nothing at `foot` to `height` at `top`, on either side of it."""
    last = nodes.shape[0] - 1
    start, stop = max(min(foot, top), nodes[0]), min(max(foot, top), nodes[last])
    if stop <= start:
        return
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
        cell += 1


@njit(cache=True, error_model="numpy")
def lay(nodes, split, middle, step, amount, out):  # type: ignore[no-untyped-def]
    """Add to nodes an amount that fades out over a step to either side of a place.

    Footprints a roll step apart would leave ripples of that wavelength, so what they wear is straight in between.
    Laid evenly along a step, with its transform below zero, it would wear ripples in a flank deeper that are
    somewhat shorter than the step. What lies beyond the last node wears no flank.
    """
    last = nodes.shape[0] - 1
    reach = max(abs(step), _LEAST_STEP * (nodes[last] - nodes[0]))
    height = amount / reach
    _lay_ramp(nodes, split, middle - reach, middle, height, out)
    _lay_ramp(nodes, split, middle + reach, middle, height, out)


@njit(cache=True, error_model="numpy")
def shifts_of(middle, at_edge, pieces, low, high, slack, moves, low_moves, high_moves, shift):  # type: ignore[no-untyped-def]
    """How far every stretch of a footprint moves in a roll step, from how far its centre and the slice's ends do.

    A footprint that an end of the slice cuts off stays at that end and is drawn out: nothing of it passes over the
    border.
    """
    first, last = np.inf, -np.inf
    for c in range(pieces):
        if at_edge[c] == 0:
            first, last = min(first, middle[c]), max(last, middle[c])
    for c in range(pieces):
        if at_edge[c] != 0:
            shift[c] = low_moves if at_edge[c] < 0 else high_moves
        elif last >= high - slack:
            lever = max(high - first, slack)
            shift[c] = high_moves + (moves - high_moves) * max(high - middle[c], 0.0) / lever
        elif first <= low + slack:
            lever = max(last - low, slack)
            shift[c] = low_moves + (moves - low_moves) * max(middle[c] - low, 0.0) / lever
        else:
            shift[c] = moves


@njit(cache=True, error_model="numpy")
def node_width(nodes, p):  # type: ignore[no-untyped-def]
    """Width that a node stands for: half of the cells on either side."""
    left = nodes[p] - nodes[p - 1] if p > 0 else 0.0
    right = nodes[p + 1] - nodes[p] if p < nodes.shape[0] - 1 else 0.0
    return 0.5 * (left + right)


@njit(cache=True, error_model="numpy")
def _spread(  # type: ignore[no-untyped-def]
    rate, centre, slope, closes, at_profile, profile, low, high, separation, spacing, low_radius, high_radius,
    removed, row, nodes, split, half_width, slices, out,
):  # fmt: skip
    work, mass, middle = np.empty((4, MOST_NODES)), np.empty(MOST_PIECES), np.empty(MOST_PIECES)
    at_edge, shift = np.empty(MOST_PIECES, dtype=np.int64), np.empty(MOST_PIECES)
    rolls = profile.shape[0]
    points = nodes.shape[1]
    for i in slices:
        for k in range(rolls):
            # between two loaded positions a slice may pass beyond an end of the other body's face
            if rate[k, i] == 0.0 or not np.isfinite(separation[0, k, i]):
                continue
            per_mm = spacing[k, i]
            pieces = pieces_of(
                profile[k, i], low[k, i], high[k, i], separation[:, k, i], per_mm, low_radius[k, i],
                high_radius[k, i], removed[row[k], i], nodes[i], split[i], half_width, closes[k, i], work, mass,
                middle, at_edge,
            )  # fmt: skip
            shifts_of(
                middle, at_edge, pieces, low[k, i], high[k, i], nodes[i, 1] - nodes[i, 0],
                step_of(at_profile[:, i], rate[:, i], k), step_of(low[:, i], rate[:, i], k),
                step_of(high[:, i], rate[:, i], k), shift,
            )  # fmt: skip
            for c in range(pieces):
                away = middle[c] - at_profile[k, i]
                v0 = centre[k, i, 0] + slope[k, i, 0] * away
                v1 = centre[k, i, 1] + slope[k, i, 1] * away
                amount = rate[k, i] / per_mm * mass[c] * sqrt(v0 * v0 + v1 * v1)
                lay(nodes[i], split[i], middle[c], shift[c], amount, out[i])
        for p in range(points):
            out[i, p] /= node_width(nodes[i], p)


def spread_over_flank(
    lines: ContactLines,
    grid: FlankGrid,
    removed: Removed,
    half_width: float,
    places: FloatArray,
    what: Spread,
    slices: NDArray[np.int64],
) -> FloatArray:
    """Density on the nodes of the flank of what each line spreads over its footprint, summed over roll positions.

    Parameters
    ----------
    lines, grid, removed, half_width
        As in `footprints`.
    places : (roll, face) array [mm]
        Centres to which `what.centre` belongs.
    what : Spread
    slices : int array
        Slices to do; the others stay zero.

    Returns
    -------
    (face, profile) array
    """
    out = np.zeros(grid.profile.shape)
    _spread(
        what.rate, what.centre, what.slope, what.closes, places, lines.profile, lines.low, lines.high,
        lines.separation, lines.spacing, lines.low_edge_radius, lines.high_edge_radius, removed.depth, removed.row,
        grid.profile, grid.split, half_width, slices, out,
    )  # fmt: skip
    return out

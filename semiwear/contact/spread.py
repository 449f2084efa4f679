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

__all__ = ["MOST_PIECES", "Spread", "node_width", "pieces_of", "spread_over_flank"]

FloatArray = NDArray[np.float64]

_MOST_PARTS = 16  # of a roll step
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
            mass[pieces] = segment(room, u_b - u_a, t_a, t_b)[0]
            middle[pieces] = 0.5 * (u_a + u_b)
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
    """Stretches of a footprint: middles, shares, whether an edge presses there (-1: lower, 1: upper).

    Returns how many, and the edge that presses; 0 where none does.
    """
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
    return pieces, edge if apart > 0.0 and share > 0.0 else 0


@njit(cache=True, error_model="numpy")
def _step_of(place, rate, k, node):  # type: ignore[no-untyped-def]
    """How far a line moves in the step about a roll position, and in how many parts to spread what it leaves there.

    Footprints a step apart would leave ripples of that wavelength; spread over the step they leave none.
    """
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    moves = (place[after] - place[before]) / max(after - before, 1)
    return moves, min(int(2.0 * abs(moves) / node) + 1, _MOST_PARTS)


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
    at_edge = np.empty(MOST_PIECES, dtype=np.int64)
    rolls = profile.shape[0]
    points = nodes.shape[1]
    for i in slices:
        for k in range(rolls):
            # between two loaded positions a slice may pass beyond an end of the other body's face
            if rate[k, i] == 0.0 or not np.isfinite(separation[0, k, i]):
                continue
            per_mm = spacing[k, i]
            pieces, edge = pieces_of(
                profile[k, i], low[k, i], high[k, i], separation[:, k, i], per_mm, low_radius[k, i],
                high_radius[k, i], removed[row[k], i], nodes[i], split[i], half_width, closes[k, i], work, mass,
                middle, at_edge,
            )  # fmt: skip
            node = nodes[i, 1] - nodes[i, 0]
            moves, parts = _step_of(at_profile[:, i], rate[:, i], k, node)
            edge_moves = 0.0
            if edge < 0:
                edge_moves, edge_parts = _step_of(low[:, i], rate[:, i], k, node)
                parts = max(parts, edge_parts)
            scale = rate[k, i] / (per_mm * parts)
            for part in range(parts):
                ahead = (part + 0.5) / parts - 0.5
                for c in range(pieces):
                    # the driven flank's own upper edge stays where it is
                    step = moves if at_edge[c] == 0 else edge_moves if at_edge[c] < 0 else 0.0
                    there = middle[c] + ahead * step
                    # what an edge's rounding bears wears no flank
                    if there < nodes[i, 0] or there > nodes[i, points - 1]:
                        continue
                    away = middle[c] - at_profile[k, i]
                    v0 = centre[k, i, 0] + slope[k, i, 0] * away
                    v1 = centre[k, i, 1] + slope[k, i, 1] * away
                    cell, x = locate(nodes[i], split[i], there)
                    amount = scale * mass[c] * sqrt(v0 * v0 + v1 * v1)
                    out[i, cell] += (1.0 - x) * amount
                    out[i, cell + 1] += x * amount
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

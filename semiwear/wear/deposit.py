"""Deposit on the driven flank: shares of every footprint, and the sum over roll positions.

A footprint is the root of the gap that is left. Where an edge of either body presses and the valley beyond it bears
as well, that root says little about their shares: there each is a footprint of its own, with its share of the load.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.edge_share import highest_that_bears, lowest_of, part_of, share_of_edge
from semiwear.contact.fine_row import forget_row
from semiwear.contact.footprint import Reach, centred_segment, open_part, reach_space, reached, root_of
from semiwear.contact.gap import gap_of_flanks, slice_gap
from semiwear.kernel_cache import ZERO, inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.removed import Removed
from semiwear.threads import in_loose_shares
from semiwear.wear.between_rolls import VALLEY, lay_pieces, node_width, shifts_of, step_of
from semiwear.wear.footprint_rows import FootprintRows, lay_down, no_rows, take_up

__all__ = [
    "Nodes",
    "Spread",
    "factor_at",
    "factor_in",
    "lay_footprint",
    "over_widths",
    "piece_space",
    "pieces_of",
    "spread_over_flank",
    "sum_of_rows",
]


class Spread(NamedTuple):
    """Amounts that are spread over the footprints, (roll, face) and (roll, face, 2) arrays.

    Attributes
    ----------
    place : array [mm]
        Centre of the footprint.
    rate : array
        Amount per length of line, e.g. line load times time.
    centre : array
        Two components of the factor at the footprint's centre, e.g. the sliding velocity.
    slope : array
        Their change by the profile coordinate; the factor is the length of the vector.
    closes : array [mm]
        Gap that a Hertz contact under the line load closes, 2 q/(pi E*).
    edges : (roll, face, 4) array, changed
        What edges bore in the cycle before, as in `share_of_edge`.
    most : (face,) array [mm]
        Wear of that cycle at most.
    """

    place: FloatArray
    rate: FloatArray
    centre: FloatArray
    slope: FloatArray
    closes: FloatArray
    edges: FloatArray
    most: FloatArray


class Nodes(NamedTuple):
    """Nodes of a flank that take a deposit, (face, points) [mm], and where their spacing changes, (face,)."""

    nodes: FloatArray
    split: IntArray


class Pieces(NamedTuple):
    """Memory for one footprint: its outline, what of it an edge and the valley have, and stretches.

    Of the latter shares, middles, ends, edges and shifts.
    """

    reach: Reach
    side: FloatArray
    mass: FloatArray
    middle: FloatArray
    ends: FloatArray
    at_edge: IntArray
    shift: FloatArray


@njit(cache=True, error_model="numpy")
def piece_space(nodes):  # type: ignore[no-untyped-def]
    """Memory for the footprints of slices of these nodes."""
    reach = reach_space(nodes)
    points, most = reach.u.shape[0], 3 * reach.u.shape[0]
    return Pieces(
        reach, np.empty((2, points)), np.empty(most), np.empty(most), np.empty((most, 2)),
        np.empty(most, dtype=np.int64), np.empty(most),
    )  # fmt: skip


@inner_njit(cache=True, error_model="numpy")
def factor_in(what, k, i):  # type: ignore[no-untyped-def]
    """Vector by which an amount counts in a slice: its place, both components and their changes."""
    centre, slope = what.centre[k, i], what.slope[k, i]
    return what.place[k, i], centre[0], centre[1], slope[0], slope[1]


@inner_njit(cache=True, error_model="numpy")
def factor_at(factor, place):  # type: ignore[no-untyped-def]
    """Length of that vector at a place."""
    middle, first, second, change, other = factor
    away = place - middle
    first, second = first + change * away, second + other * away
    return sqrt(first * first + second * second)


@inner_njit(cache=True, error_model="numpy")
def _add_pieces(count, least, depth, share, space, pieces):  # type: ignore[no-untyped-def]
    """Append the stretches of a whole footprint, whose shares sum up to `share`."""
    u, g, mass, middle = space.reach.u, space.reach.g, space.mass, space.middle
    area, begin = 0.0, pieces
    b = depth - (g[0] - least)
    t_b = root_of(b)
    for c in range(count - 1):
        a, t_a = b, t_b
        b = depth - (g[c + 1] - least)
        t_b = root_of(b)
        if t_a + t_b <= 0.0:
            continue
        u_a, width = open_part(u[c], u[c + 1] - u[c], a, b)
        if width > 0.0:
            # by centroids: a depth that alternates from node to node would not be felt in the middle
            mass[pieces], middle[pieces] = centred_segment(u_a, width, t_a, t_b)
            space.ends[pieces, 0], space.ends[pieces, 1] = u_a, u_a + width
            space.at_edge[pieces] = 0
            area += mass[pieces]
            pieces += 1
    return _weighed(mass, begin, pieces, share, area)


@inner_njit(cache=True, error_model="numpy")
def _add_side(count, side, mark, upper, lift, depth, share, space, pieces):  # type: ignore[no-untyped-def]
    """Append what of a footprint belongs to one side of a ridge, the upper one or not; `lift` as in `lowest_of`."""
    u, g, mass, middle = space.reach.u, space.reach.g, space.mass, space.middle
    least, area, begin = lowest_of(side, g, count, lift), 0.0, pieces
    for c in range(count - 1):
        part, a, b = part_of(side, c), depth - (g[c] - least), depth - (g[c + 1] - least)
        if part <= 0.0 or (a <= 0.0 and b <= 0.0):
            continue
        u_a, width = open_part(u[c], u[c + 1] - u[c], a, b)
        if width > 0.0:
            whole, middle[pieces] = centred_segment(u_a, width, root_of(a), root_of(b))
            mass[pieces] = part * whole
            # its end moves on evenly as more of it counts
            space.ends[pieces, 0] = u_a + ((1.0 - part) * width if upper else 0.0)
            space.ends[pieces, 1] = u_a + (width if upper else part * width)
            space.at_edge[pieces] = mark
            area += mass[pieces]
            pieces += 1
    return _weighed(mass, begin, pieces, share, area)


@inner_njit(cache=True, error_model="numpy")
def _weighed(mass, begin, pieces, share, area):  # type: ignore[no-untyped-def]
    """Shares of stretches from their areas; without any area there are none of them. Returns how many there are."""
    if area <= 0.0:
        return begin
    for piece in range(begin, pieces):
        mass[piece] *= share / area
    return pieces


@inner_njit(cache=True, error_model="numpy")
def pieces_of(gap, half_width, what, k, i, space):  # type: ignore[no-untyped-def]
    """Stretches of a footprint: middles, shares, whether an edge presses there (-1: lower, 1: upper); how many.

    Where an edge presses, `VALLEY` marks those beyond the ridge, which touch by themselves.
    """
    depth, count, least = reached(gap, half_width, space.reach)
    closes = what.closes[k, i]
    edge, share, apart = share_of_edge(
        space.reach.u, space.reach.g, count, gap.low, gap.high, gap.per_mm, depth, closes, what.edges[k, i],
        what.most[i], space.side,
    )  # fmt: skip
    pieces = ZERO
    if apart < 1.0:
        pieces = _add_pieces(count, least, depth, 1.0 - apart, space, pieces)
    if apart > 0.0:
        lift = highest_that_bears(0.0, depth, closes)
        for row in range(2):
            own, mark, upper = (share, edge, edge > 0) if row == 0 else (1.0 - share, VALLEY, edge < 0)
            if own > 0.0:
                pieces = _add_side(count, space.side[row], mark, upper, lift, depth, apart * own, space, pieces)
    return pieces


@inner_njit(cache=True, error_model="numpy")
def lay_footprint(flank, what, grid, gap, k, i, length, pieces, space, laid):  # type: ignore[no-untyped-def]
    """Lay a footprint on the nodes of its slice, (points,), by itself; its shares are used up.

    Returns the first node that takes something, the one behind the last, what is spread, and what of it lies beyond
    the nodes.
    """
    mass, middle, shift = space.mass, space.middle, space.shift
    nodes, rate = grid.nodes[i], what.rate[:, i]
    alike = shifts_of(
        middle, space.ends, space.at_edge, pieces, gap.low, gap.high, nodes[1] - nodes[0],
        step_of(what.place[:, i], rate, k), step_of(flank.low[:, i], rate, k),
        step_of(flank.high[:, i], rate, k), shift,
    )  # fmt: skip
    total, density, factor = 0.0, rate[k] / gap.per_mm, factor_in(what, k, i)
    for c in range(pieces):
        mass[c] *= density * factor_at(factor, middle[c])
        total += mass[c]
    first, end, beyond = lay_pieces(nodes, grid.split[i], middle, shift, mass, pieces, alike, laid)
    whole = gap.per_mm * length
    return first, end, whole * total, whole * beyond


@inner_njit(cache=True, error_model="numpy")
def over_widths(nodes, amounts):  # type: ignore[no-untyped-def]
    """Turn amounts at the nodes of a slice into densities."""
    for p in range(nodes.shape[0]):
        amounts[p] /= node_width(nodes, p)


@njit(cache=True, error_model="numpy", nogil=True)
def _spread(flank, what, half_width, grid, slices, length, rows, out, taken):  # type: ignore[no-untyped-def]
    space, laid = piece_space(flank.nodes), np.zeros(grid.nodes.shape[1])
    rolls = flank.profile.shape[0]
    for i in slices:
        for k in range(rolls):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                forget_row(space.reach.row)
            # between two loaded positions a slice may pass beyond an end of the other body's face
            if what.rate[k, i] == 0.0 or not np.isfinite(flank.separation[0, k, i]):
                continue
            gap = slice_gap(flank, k, i)
            pieces = pieces_of(gap, half_width, what, k, i, space)
            first, end, total, beyond = lay_footprint(flank, what, grid, gap, k, i, length[k, i], pieces, space, laid)
            lay_down(laid, first, end, 1.0, out[i])
            take_up(laid, first, end, total, beyond, rows, rows.row[k, i], taken[i])
        over_widths(grid.nodes[i], out[i])


@njit(cache=True, error_model="numpy")
def _add_rows(rows, times, nodes, slices, out, taken):  # type: ignore[no-untyped-def]
    for i in slices:
        for k in range(times.shape[0]):
            row = rows.row[k, i]
            if row >= 0 and times[k, i] > 0.0:
                lay_down(rows.amount[row], rows.ends[row, 0], rows.ends[row, 1], times[k, i], out[i])
                taken += times[k, i] * rows.taken[row]
        over_widths(nodes[i], out[i])


def sum_of_rows(
    rows: FootprintRows, times: FloatArray, grid: FlankGrid, slices: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Density on the nodes of the driven flank from kept footprints, each so many times, (roll, face).

    Returns
    -------
    density : (face, profile) array
        In some slices; the others stay zero.
    taken : (2,) array
        As in `spread_over_flank`.
    """
    out, taken = np.zeros(grid.profile.shape), np.zeros(2)
    _add_rows(rows, times, grid.profile, slices, out, taken)
    return out, taken


def spread_over_flank(
    lines: ContactLines,
    grid: FlankGrid,
    removed: Removed,
    half_width: float,
    what: Spread,
    slices: IntArray,
    taken: FloatArray | None = None,
    rows: FootprintRows | None = None,
) -> FloatArray:
    """Density on the nodes of the flank of what each line spreads over its footprint, summed over roll positions.

    Parameters
    ----------
    lines, grid, removed, half_width
        As in `footprints`.
    what : Spread
    slices : int array
        Slices to do; the others stay zero.
    taken : (2,) array, changed
        Takes what is spread in all, and what of it lies beyond the ends of the nodes: on the rounding of an edge
        [unit of `what.rate` times mm times that of its factor].
    rows : FootprintRows, changed, optional
        Takes the footprints one by one.

    Returns
    -------
    (face, profile) array
    """
    out, rows = np.zeros(grid.profile.shape), rows or no_rows(what.rate.shape)
    flank, nodes, by_slice = gap_of_flanks(lines, removed), Nodes(grid.profile, grid.split), np.zeros((len(out), 2))
    in_loose_shares(
        lambda share: _spread(flank, what, half_width, nodes, share, lines.length, rows, out, by_slice), slices
    )
    if taken is not None:
        taken += by_slice.sum(axis=0)
    return out

"""Deposit on the driven flank: the amount of every footprint spread over the nodes, summed over roll positions.

The pressure across a footprint is proportional to the root of the depth by which the gap is closed. Where an edge of
either body is pressed and the valley beyond it carries load as well, this root gives wrong shares: edge and valley
are then two footprints, each with its own share of the load.
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


class Spread(NamedTuple):
    """Amounts to be spread over the footprints, (roll, face) and (roll, face, 2) arrays.

    Attributes
    ----------
    place : array [mm]
        Centre of the footprint.
    rate : array
        Amount per length of line, e.g. line load times time.
    centre : array
        Vector at the footprint's centre, e.g. the sliding velocity; its length is a factor on the amount.
    slope : array
        Derivative of this vector by the profile coordinate.
    closes : array [mm]
        Gap closed by a Hertz contact under the line load, 2 q/(pi E*).
    edges : (roll, face, 4) array, changed
        Load shares of edges in the previous cycle, as in `share_of_edge`.
    most : (face,) array [mm]
        Greatest wear in the previous cycle.
    """

    place: FloatArray
    rate: FloatArray
    centre: FloatArray
    slope: FloatArray
    closes: FloatArray
    edges: FloatArray
    most: FloatArray


class Nodes(NamedTuple):
    """Nodes of a flank, (face, points) [mm], and the node at which their spacing changes, (face,)."""

    nodes: FloatArray
    split: IntArray


class Pieces(NamedTuple):
    """Work arrays for one footprint.

    Its outline, the parts of it that belong to an edge and to the valley, and of its stretches the amounts,
    centroids, ends, marks of edges and shifts.
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
    """Work arrays for footprints on slices of these nodes."""
    reach = reach_space(nodes)
    points, most = reach.u.shape[0], 3 * reach.u.shape[0]
    return Pieces(
        reach, np.empty((2, points)), np.empty(most), np.empty(most), np.empty((most, 2)),
        np.empty(most, dtype=np.int64), np.empty(most),
    )  # fmt: skip


@inner_njit(cache=True, error_model="numpy")
def factor_in(spread, k, i):  # type: ignore[no-untyped-def]
    """Factor vector of a slice: the profile coordinate it holds for, both components and their derivatives."""
    centre, slope = spread.centre[k, i], spread.slope[k, i]
    return spread.place[k, i], centre[0], centre[1], slope[0], slope[1]


@inner_njit(cache=True, error_model="numpy")
def factor_at(factor, place):  # type: ignore[no-untyped-def]
    """Length of the factor vector at a profile coordinate."""
    middle, first, second, first_slope, second_slope = factor
    distance = place - middle
    first, second = first + first_slope * distance, second + second_slope * distance
    return sqrt(first * first + second * second)


@inner_njit(cache=True, error_model="numpy")
def _add_pieces(count, least, depth, share, space, pieces):  # type: ignore[no-untyped-def]
    """Append the stretches of a whole footprint, with amounts that sum up to `share`; returns the new count."""
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
            # at the centroid: the middle of a stretch would not respond to depths that alternate from node to node
            mass[pieces], middle[pieces] = centred_segment(u_a, width, t_a, t_b)
            space.ends[pieces, 0], space.ends[pieces, 1] = u_a, u_a + width
            space.at_edge[pieces] = 0
            area += mass[pieces]
            pieces += 1
    return _weighed(mass, begin, pieces, share, area)


@inner_njit(cache=True, error_model="numpy")
def _add_side(count, side, mark, upper, lift, depth, share, space, pieces):  # type: ignore[no-untyped-def]
    """Append the stretches on one side of a ridge (`upper`: the upper side); `lift` as in `lowest_of`."""
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
            # the end of a stretch moves evenly with the part of it that counts
            space.ends[pieces, 0] = u_a + ((1.0 - part) * width if upper else 0.0)
            space.ends[pieces, 1] = u_a + (width if upper else part * width)
            space.at_edge[pieces] = mark
            area += mass[pieces]
            pieces += 1
    return _weighed(mass, begin, pieces, share, area)


@inner_njit(cache=True, error_model="numpy")
def _weighed(mass, begin, pieces, share, area):  # type: ignore[no-untyped-def]
    """Turn areas of stretches into shares, and return the new count."""
    for piece in range(begin, pieces):
        mass[piece] *= share / area
    return pieces


@inner_njit(cache=True, error_model="numpy")
def pieces_of(gap, half_width, spread, k, i, space):  # type: ignore[no-untyped-def]
    """Find the stretches of a footprint and return their number.

    `at_edge` marks stretches at a pressed edge (-1: lower, 1: upper); `VALLEY` marks those of the separate footprint
    beyond the ridge.
    """
    depth, count, least = reached(gap, half_width, space.reach)
    closes = spread.closes[k, i]
    edge, share, apart = share_of_edge(
        space.reach.u, space.reach.g, count, gap.low, gap.high, gap.per_mm, depth, closes, spread.edges[k, i],
        spread.most[i], space.side,
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
def lay_footprint(flank, spread, grid, gap, k, i, length, pieces, space, laid):  # type: ignore[no-untyped-def]
    """Deposit a single footprint on the nodes of its slice, (points,); overwrites the shares of its stretches.

    Returns the first node with a deposit and the one behind the last, the whole amount, and its part beyond the
    nodes.
    """
    mass, middle, shift = space.mass, space.middle, space.shift
    nodes, rate = grid.nodes[i], spread.rate[:, i]
    alike = shifts_of(
        middle, space.ends, space.at_edge, pieces, gap.low, gap.high, nodes[1] - nodes[0],
        step_of(spread.place[:, i], rate, k), step_of(flank.low[:, i], rate, k),
        step_of(flank.high[:, i], rate, k), shift,
    )  # fmt: skip
    total, density, factor = 0.0, rate[k] / gap.per_mm, factor_in(spread, k, i)
    for c in range(pieces):
        mass[c] *= density * factor_at(factor, middle[c])
        total += mass[c]
    first, end, beyond = lay_pieces(nodes, grid.split[i], middle, shift, mass, pieces, alike, laid)
    whole = gap.per_mm * length
    return first, end, whole * total, whole * beyond


@inner_njit(cache=True, error_model="numpy")
def over_widths(nodes, amounts):  # type: ignore[no-untyped-def]
    """Divide amounts at the nodes of a slice by the width of each node's interval."""
    for p in range(nodes.shape[0]):
        amounts[p] /= node_width(nodes, p)


@njit(cache=True, error_model="numpy", nogil=True)
def _spread(flank, spread, half_width, grid, slices, length, rows, out, taken):  # type: ignore[no-untyped-def]
    space, laid = piece_space(flank.nodes), np.zeros(grid.nodes.shape[1])
    rolls = flank.profile.shape[0]
    for i in slices:
        for k in range(rolls):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                forget_row(space.reach.row)
            # between two loaded positions a slice may lie beyond an end of the other body's face
            if spread.rate[k, i] == 0.0 or not np.isfinite(flank.separation[0, k, i]):
                continue
            gap = slice_gap(flank, k, i)
            pieces = pieces_of(gap, half_width, spread, k, i, space)
            first, end, total, beyond = lay_footprint(
                flank, spread, grid, gap, k, i, length[k, i], pieces, space, laid
            )
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
    """Density on the nodes of the driven flank from kept footprints times factors, (roll, face).

    Returns
    -------
    density : (face, profile) array
        Zero in slices that are not evaluated.
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
    spread: Spread,
    slices: IntArray,
    taken: FloatArray | None = None,
    rows: FootprintRows | None = None,
) -> FloatArray:
    """Density on the nodes of the flank from the amounts of all footprints, summed over roll positions.

    Parameters
    ----------
    lines, grid, removed, half_width
        As in `footprints`.
    spread : Spread
    slices : int array
        Slices to evaluate; the others stay zero.
    taken : (2,) array, changed
        The whole amount is added to the first element, its part beyond the ends of the nodes, on the rounding of an
        edge, to the second [unit of `spread.rate` times mm times that of its factor].
    rows : FootprintRows, changed, optional
        Every footprint is added to its row.

    Returns
    -------
    (face, profile) array
    """
    out, rows = np.zeros(grid.profile.shape), rows or no_rows(spread.rate.shape)
    flank, nodes, by_slice = gap_of_flanks(lines, removed), Nodes(grid.profile, grid.split), np.zeros((len(out), 2))
    in_loose_shares(
        lambda share: _spread(flank, spread, half_width, nodes, share, lines.length, rows, out, by_slice), slices
    )
    if taken is not None:
        taken += by_slice.sum(axis=0)
    return out

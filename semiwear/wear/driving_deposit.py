"""Deposit on both flanks: the footprints of the driven flank, mapped to the driving flank as well."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.fine_row import forget_row
from semiwear.contact.footprint import look_within
from semiwear.contact.gap import gap_of_flanks, slice_gap
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.driving_flank import DrivingFlank, station_of
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.removed import Removed
from semiwear.threads import in_shares
from semiwear.wear.between_rolls import lay_pieces, node_width, shifts_of, step_of
from semiwear.wear.deposit import (
    Nodes,
    Spread,
    factor_at,
    factor_in,
    lay_footprint,
    over_widths,
    piece_space,
    pieces_of,
)
from semiwear.wear.footprint_rows import FootprintRows, lay_down, no_rows, take_up


class _Driving(NamedTuple):
    """Where contact lines lie on the driving flank, (roll, face), and the nodes of its stations.

    Attributes
    ----------
    profile, slope, face : arrays [mm], [1], [mm]
        Profile coordinate at the fresh line, its derivative by that of the driven flank, and face coordinate.
    stations : (stations,) array [mm]
        Face coordinates.
    nodes : (points,) array [mm]
        Profile nodes, the same at every station.
    split : int
    """

    profile: FloatArray
    slope: FloatArray
    face: FloatArray
    stations: FloatArray
    nodes: FloatArray
    split: int


@inner_njit(cache=True, error_model="numpy")
def _add_to_stations(driving, k, i, laid, first, end, times, out):  # type: ignore[no-untyped-def]
    """Add a multiple of a slice's footprint to the stations that it meets; returns the part that they receive."""
    stations = driving.stations.shape[0]
    step, taken = driving.stations[1] - driving.stations[0], 0.0
    station, weight = station_of(driving.face[k, i], driving.stations[0], step, stations)
    for side in range(2):
        # nothing is deposited beyond the width of the last station
        share = max(1.0 - abs(weight - side), 0.0)
        if share > 0.0:
            lay_down(laid, first, end, share * times, out[station + side])
            taken += share
    return taken


@inner_njit(cache=True, error_model="numpy")
def _add_to_driving(spread, driving, places, gap, k, i, length, pieces, space, memory, rows, out, taken):  # type: ignore[no-untyped-def]
    """Add a footprint to the stations of the driving flank that it meets, to `taken`, (2,), and to its row.

    `places`, (3, roll, face), are the profile coordinates of the footprints' centres and of both borders [mm].
    """
    mass, middle, shift = space.mass, space.middle, space.shift
    (place, amount, moves), laid = memory
    stations, rate = driving.stations.shape[0], spread.rate[:, i]
    step = driving.stations[1] - driving.stations[0]
    below, above = max(i - 1, 0), min(i + 1, stations - 1)
    # number of driven slices within the width of a station
    wide = abs(driving.face[k, above] - driving.face[k, below]) / ((above - below) * step)
    alike = shifts_of(
        middle, space.ends, space.at_edge, pieces, gap.low, gap.high, gap.nodes[1] - gap.nodes[0],
        step_of(places[0, :, i], rate, k), step_of(places[1, :, i], rate, k),
        step_of(places[2, :, i], rate, k), shift,
    )  # fmt: skip
    scale, factor = rate[k] * wide * abs(driving.slope[k, i]) / gap.per_mm, factor_in(spread, k, i)
    rising, total = driving.slope[k, i] > 0.0, 0.0
    for c in range(pieces):
        at = c if rising else pieces - 1 - c
        place[at] = driving.profile[k, i] + driving.slope[k, i] * (middle[c] - gap.at)
        amount[at] = scale * mass[c] * factor_at(factor, middle[c])
        moves[at] = shift[c]
        total += amount[at]
    first, end, beyond = lay_pieces(driving.nodes, driving.split, place, moves, amount, pieces, alike, laid)
    met = _add_to_stations(driving, k, i, laid, first, end, 1.0, out)
    whole = rate[k] * length / scale  # amount of a unit of the deposit
    beyond = total - met * (total - beyond)
    take_up(laid, first, end, whole * total, whole * beyond, rows, rows.row[k, i], taken)


@njit(cache=True, error_model="numpy", nogil=True)
def _spread(flank, windows, spread, half_width, slices, driving, places, grid, length, rows, out, own, taken):  # type: ignore[no-untyped-def]
    space = piece_space(flank.nodes)
    most, within = space.mass.size, space.reach.within
    memory = (np.empty(most), np.empty(most), np.empty(most)), np.zeros(driving.nodes.size)
    laid, (theirs, ours) = np.zeros(grid.nodes.shape[1]), rows
    for i in slices:
        for k in range(flank.profile.shape[0]):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                forget_row(space.reach.row)
            if spread.rate[k, i] == 0.0 or not np.isfinite(flank.separation[0, k, i]):
                continue
            gap = slice_gap(flank, k, i)
            within[0], within[1] = look_within(windows[k, i], gap.nodes.shape[0])
            pieces, wide = pieces_of(gap, half_width, spread, k, i, space), length[k, i]
            _add_to_driving(spread, driving, places, gap, k, i, wide, pieces, space, memory, theirs, out, taken[0])
            first, end, total, beyond = lay_footprint(flank, spread, grid, gap, k, i, wide, pieces, space, laid)
            lay_down(laid, first, end, 1.0, own[i])
            take_up(laid, first, end, total, beyond, ours, ours.row[k, i], taken[1])
        over_widths(grid.nodes[i], own[i])


@njit(cache=True, error_model="numpy")
def _add_rows(rows, times, driving, slices, out, taken):  # type: ignore[no-untyped-def]
    for i in slices:
        for k in range(times.shape[0]):
            row = rows.row[k, i]
            if row >= 0 and times[k, i] > 0.0:
                ends = rows.ends[row]
                _add_to_stations(driving, k, i, rows.amount[row], ends[0], ends[1], times[k, i], out)
                taken += times[k, i] * rows.taken[row]


def sum_of_driving_rows(
    rows: FootprintRows, times: FloatArray, lines: ContactLines, driving: DrivingFlank, slices: IntArray
) -> tuple[FloatArray, FloatArray]:
    """As `deposit.sum_of_rows`, on the nodes of the driving flank.

    Returns
    -------
    density : (face, profile) array
        Valid at stations all of whose slices are summed.
    taken : (2,) array
    """
    met, out, taken = _met(lines, driving), np.zeros(driving.grid.profile.shape), np.zeros(2)
    _add_rows(rows, times, met, slices, out, taken)
    return out / _widths(met), taken


def spread_over_both_flanks(
    lines: ContactLines,
    grid: FlankGrid,
    driving: DrivingFlank,
    removed: Removed,
    half_width: float,
    spread: Spread,
    slices: IntArray,
    taken: FloatArray | None = None,
    rows: tuple[FootprintRows, FootprintRows] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Densities on the nodes of both flanks from the amounts of all footprints, summed over roll positions.

    Parameters are as in `deposit.spread_over_flank`, with the driving flank after the grid; `taken`, (2, 2), and
    `rows` are of the driving and of the driven flank.

    Returns
    -------
    driving, driven : (face, profile) arrays
        The first is valid at stations all of whose slices are evaluated.
    """
    places = np.stack([lines.on_driving(place) for place in (spread.place, lines.low, lines.high)])
    met, windows = _met(lines, driving), removed.known
    flank, nodes, own = gap_of_flanks(lines, removed), Nodes(grid.profile, grid.split), np.zeros(grid.profile.shape)
    kept = rows or (no_rows(spread.rate.shape), no_rows(spread.rate.shape))

    def deposited(share: IntArray) -> tuple[FloatArray, FloatArray]:
        out, part = np.zeros(driving.grid.profile.shape), np.zeros((2, 2))
        _spread(flank, windows, spread, half_width, share, met, places, nodes, lines.length, kept, out, own, part)
        return out, part

    out = np.zeros(driving.grid.profile.shape)
    for amount, part in in_shares(deposited, slices):  # a station between two shares of slices gets wear from both
        out += amount
        if taken is not None:
            taken += part
    return out / _widths(met), own


def _met(lines: ContactLines, driving: DrivingFlank) -> _Driving:
    own, grid = (lines.driving_profile, lines.driving_slope, lines.driving_face), driving.grid
    return _Driving(*own, grid.face, grid.profile[0], int(grid.split[0]))


def _widths(met: _Driving) -> FloatArray:
    """Width of the interval around every node of a station, (points,) [mm]."""
    return np.array([node_width(met.nodes, p) for p in range(met.nodes.size)])

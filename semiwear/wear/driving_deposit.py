"""Deposit on both flanks: of the driving one by the same footprints, seen from the other body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.fine_row import forget_row
from semiwear.contact.footprint_windows import look_within
from semiwear.contact.gap import gap_of_flanks, slice_gap
from semiwear.kernel_cache import ZERO, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.driving_flank import DrivingFlank, station_of
from semiwear.meshing.flank_grid import FlankGrid, locate
from semiwear.meshing.removed import Removed
from semiwear.threads import in_shares
from semiwear.wear.between_rolls import lay, lay_points, lies_within, node_width, shifts_of, step_of
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

__all__ = ["spread_over_both_flanks"]


class _Driving(NamedTuple):
    """Where contact lines lie on the driving flank, (roll, face), and the nodes of its stations.

    Attributes
    ----------
    profile, slope, face : arrays [mm], [1], [mm]
        Profile coordinate at the fresh line, its change by the driven flank's, and face coordinate.
    places : (3, roll, face) array [mm]
        Profile coordinate of the footprints' centres and of both borders.
    stations : (stations,) array [mm]
    nodes : (points,) array [mm]
        Of every station.
    split : int
    """

    profile: FloatArray
    slope: FloatArray
    face: FloatArray
    places: FloatArray
    stations: FloatArray
    nodes: FloatArray
    split: int


@njit(cache=True, error_model="numpy")
def _lay_apart(driving, place, shift, rising, part, pieces, into):  # type: ignore[no-untyped-def]
    """Lay stretches that move apart; shifts are in the order of the driven flank. Returns what is laid."""
    laid = 0.0
    for c in range(pieces):
        at = c if rising else pieces - 1 - c
        laid += lay(driving.nodes, driving.split, place[at], shift[c], part[at], into)
    return laid


@njit(cache=True, error_model="numpy")
def _lay_on_driving(what, driving, gap, k, i, length, pieces, space, memory, out, taken):  # type: ignore[no-untyped-def]
    """Add a footprint to the stations of the driving flank that it meets, and to what is taken, (2,)."""
    mass, middle, shift = space.mass, space.middle, space.shift
    (place, amount, part), once = memory
    stations, places, rate = driving.stations.shape[0], driving.places, what.rate[:, i]
    step = driving.stations[1] - driving.stations[0]
    below, above = max(i - 1, 0), min(i + 1, stations - 1)
    # as many driven slices meet a station as lie in its width
    wide = abs(driving.face[k, above] - driving.face[k, below]) / ((above - below) * step)
    station, weight = station_of(driving.face[k, i], driving.stations[0], step, stations)
    alike = shifts_of(
        middle, space.ends, space.at_edge, pieces, gap.low, gap.high, gap.nodes[1] - gap.nodes[0],
        step_of(places[0, :, i], rate, k), step_of(places[1, :, i], rate, k),
        step_of(places[2, :, i], rate, k), shift,
    )  # fmt: skip
    scale, factor = rate[k] * wide * abs(driving.slope[k, i]) / gap.per_mm, factor_in(what, k, i)
    rising, total, laid = driving.slope[k, i] > 0.0, 0.0, 0.0
    for c in range(pieces):
        at = c if rising else pieces - 1 - c
        place[at] = driving.profile[k, i] + driving.slope[k, i] * (middle[c] - gap.at)
        amount[at] = scale * mass[c] * factor_at(factor, middle[c])
        total += amount[at]
    together = alike and lies_within(driving.nodes, place, pieces, shift[0])
    first = last = ZERO
    if together:
        reach = abs(shift[0])
        first = locate(driving.nodes, driving.split, place[0] - reach)[0]
        last = locate(driving.nodes, driving.split, place[pieces - 1] + reach)[0] + 2
        once[first:last] = 0.0
        lay_points(driving.nodes, driving.split, place, amount, pieces, reach, once)
    for side in range(2):
        # nothing is kept beyond the width of the last station
        share = max(1.0 - abs(weight - side), 0.0)
        if share == 0.0:
            continue
        into = out[station + side]
        if together:
            for p in range(first, last):
                into[p] += share * once[p]
            laid += share * total
        else:
            for c in range(pieces):
                part[c] = share * amount[c]
            laid += _lay_apart(driving, place, shift, rising, part, pieces, into)
    whole = rate[k] * length / scale  # what a unit laid stands for
    taken[0] += whole * total
    taken[1] += whole * (total - laid)


@njit(cache=True, error_model="numpy", nogil=True)
def _spread(flank, windows, what, half_width, slices, driving, grid, length, out, own, taken):  # type: ignore[no-untyped-def]
    space = piece_space(flank.nodes)
    memory, within = (np.empty((3, space.mass.size)), np.empty(driving.nodes.size)), space.reach.within
    for i in slices:
        for k in range(flank.profile.shape[0]):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                forget_row(space.reach.row)
            if what.rate[k, i] == 0.0 or not np.isfinite(flank.separation[0, k, i]):
                continue
            gap = slice_gap(flank, k, i)
            within[0], within[1] = look_within(windows[k, i], gap.nodes.shape[0])
            pieces = pieces_of(gap, half_width, what, k, i, space)
            _lay_on_driving(what, driving, gap, k, i, length[k, i], pieces, space, memory, out, taken[0])
            lay_footprint(flank, what, grid, gap, k, i, length[k, i], pieces, space, own[i], taken[1])
        over_widths(grid.nodes[i], own[i])


def spread_over_both_flanks(
    lines: ContactLines,
    grid: FlankGrid,
    driving: DrivingFlank,
    removed: Removed,
    half_width: float,
    what: Spread,
    slices: IntArray,
    taken: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Densities on the nodes of both flanks of what each line spreads over its footprint, summed over rolls.

    Parameters are as in `deposit.spread_over_flank`, with the driving flank after the grid, and `taken` (2, 2): of
    the driving and of the driven flank.

    Returns
    -------
    driving, driven : (face, profile) arrays
        The driving one right in stations all of whose slices are done.
    """
    places = np.stack([lines.on_driving(place) for place in (what.place, lines.low, lines.high)])
    met = _Driving(
        lines.driving_profile, lines.driving_slope, lines.driving_face, places, driving.grid.face,
        driving.grid.profile[0], int(driving.grid.split[0]),
    )  # fmt: skip
    windows = removed.windows
    if windows is None:
        windows = np.tile(np.array([0, removed.depth.shape[-1]]), (*what.rate.shape, 1))
    flank, nodes, own = gap_of_flanks(lines, removed), Nodes(grid.profile, grid.split), np.zeros(grid.profile.shape)

    def spread(share: IntArray) -> tuple[FloatArray, FloatArray]:
        out, part = np.zeros(driving.grid.profile.shape), np.zeros((2, 2))
        _spread(flank, windows, what, half_width, share, met, nodes, lines.length, out, own, part)
        return out, part

    out = np.zeros(driving.grid.profile.shape)
    for amount, part in in_shares(spread, slices):  # stations between two shares take from both
        out += amount
        if taken is not None:
            taken += part
    width: FloatArray = np.array([node_width(met.nodes, p) for p in range(met.nodes.size)])
    return out / width, own

"""What a contact spreads over the driving flank: the same footprints, seen from the other body."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.footprint import MOST_NODES
from semiwear.contact.spread import MOST_PIECES, Spread, node_width, pieces_of
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, locate
from semiwear.meshing.partner_flank import PartnerFlank, station_of
from semiwear.meshing.removed import Removed

__all__ = ["spread_over_partner"]

FloatArray = NDArray[np.float64]

_MOST_PARTS = 8  # of a roll step


@njit(cache=True, error_model="numpy")
def _spread(  # type: ignore[no-untyped-def]
    rate, centre, slope, closes, at_profile, profile, low, high, separation, spacing, low_radius, high_radius,
    removed, row, nodes, split, half_width, slices, partner_profile, partner_slope, partner_face, faces, own,
    own_split, out,
):  # fmt: skip
    work, mass, middle = np.empty((4, MOST_NODES)), np.empty(MOST_PIECES), np.empty(MOST_PIECES)
    at_edge = np.empty(MOST_PIECES, dtype=np.int64)
    rolls, stations, last = profile.shape[0], faces.shape[0], own.shape[0] - 1
    step, node = faces[1] - faces[0], 0.25 * (own[last] - own[0]) / last
    for i in slices:
        for k in range(rolls):
            if rate[k, i] == 0.0 or not np.isfinite(separation[0, k, i]):
                continue
            pieces, _ = pieces_of(
                profile[k, i], low[k, i], high[k, i], separation[:, k, i], spacing[k, i], low_radius[k, i],
                high_radius[k, i], removed[row[k], i], nodes[i], split[i], half_width, closes[k, i], work, mass,
                middle, at_edge,
            )  # fmt: skip
            below, above = max(i - 1, 0), min(i + 1, stations - 1)
            # as many driven slices meet a station as lie in its width
            wide = abs(partner_face[k, above] - partner_face[k, below]) / ((above - below) * step)
            station, weight = station_of(partner_face[k, i], faces[0], step, stations)
            per_profile = abs(partner_slope[k, i])
            # the contact moves on within a roll step: an edge's narrow band would leave stripes
            moves = 0.5 * (partner_profile[min(k + 1, rolls - 1), i] - partner_profile[max(k - 1, 0), i])
            spread = min(int(abs(moves) / node) + 1, _MOST_PARTS)
            scale = rate[k, i] * wide * per_profile / (spacing[k, i] * spread)
            for c in range(pieces):
                place = partner_profile[k, i] + partner_slope[k, i] * (middle[c] - profile[k, i])
                away = middle[c] - at_profile[k, i]
                v0 = centre[k, i, 0] + slope[k, i, 0] * away
                v1 = centre[k, i, 1] + slope[k, i, 1] * away
                amount = scale * mass[c] * sqrt(v0 * v0 + v1 * v1)
                for part in range(spread):
                    there = place + moves * ((part + 0.5) / spread - 0.5)
                    # what an edge's rounding bears wears no flank
                    if there < own[0] or there > own[last]:
                        continue
                    cell, x = locate(own, own_split, there)
                    for side in range(2):
                        # nothing is kept beyond the width of the last station
                        share = max(1.0 - abs(weight - side), 0.0)
                        out[station + side, cell] += share * (1.0 - x) * amount
                        out[station + side, cell + 1] += share * x * amount
    for p in range(last + 1):
        width = node_width(own, p)
        for j in range(stations):
            out[j, p] /= width


def spread_over_partner(
    lines: ContactLines,
    grid: FlankGrid,
    partner: PartnerFlank,
    removed: Removed,
    half_width: float,
    places: FloatArray,
    what: Spread,
    slices: NDArray[np.int64],
) -> FloatArray:
    """Density on the nodes of the driving flank of what each line spreads over its footprint, summed over rolls.

    Parameters are as in `spread.spread_over_flank`.

    Parameters
    ----------
    partner : PartnerFlank

    Returns
    -------
    (face, profile) array
        Right in stations all of whose slices are done.
    """
    out = np.zeros(partner.grid.profile.shape)
    _spread(
        what.rate, what.centre, what.slope, what.closes, places, lines.profile, lines.low, lines.high,
        lines.separation, lines.spacing, lines.low_edge_radius, lines.high_edge_radius, removed.depth, removed.row,
        grid.profile, grid.split, half_width, slices, lines.partner_profile, lines.partner_slope, lines.partner_face,
        partner.grid.face, partner.grid.profile[0], partner.grid.split[0], out,
    )  # fmt: skip
    return out

"""What a contact spreads over the driving flank: the same footprints, seen from the other body."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.between_rolls import lay, node_width, shifts_of, step_of
from semiwear.contact.footprint import most_places
from semiwear.contact.spread import Spread, pieces_of
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.partner_flank import PartnerFlank, station_of
from semiwear.meshing.removed import Removed

__all__ = ["spread_over_partner"]

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def _spread(  # type: ignore[no-untyped-def]
    rate, centre, slope, closes, at_profile, partner_places, profile, low, high, separation, spacing, low_radius,
    high_radius, removed, row, nodes, split, half_width, slices, partner_profile, partner_slope, partner_face, faces,
    own, own_split, length, out, taken,
):  # fmt: skip
    most = most_places(nodes)
    work, mass, middle = np.empty((4, most)), np.empty(2 * most), np.empty(2 * most)
    at_edge, shift, slopes = np.empty(2 * most, dtype=np.int64), np.empty(2 * most), np.empty(nodes.shape[1])
    rolls, stations, last = profile.shape[0], faces.shape[0], own.shape[0] - 1
    step = faces[1] - faces[0]
    for i in slices:
        for k in range(rolls):
            if k == 0 or row[k] != row[k - 1]:
                slopes[:] = np.nan
            if rate[k, i] == 0.0 or not np.isfinite(separation[0, k, i]):
                continue
            pieces = pieces_of(
                profile[k, i], low[k, i], high[k, i], separation[:, k, i], spacing[k, i], low_radius[k, i],
                high_radius[k, i], removed[row[k], i], nodes[i], split[i], half_width, closes[k, i], slopes, work,
                mass, middle, at_edge,
            )  # fmt: skip
            below, above = max(i - 1, 0), min(i + 1, stations - 1)
            # as many driven slices meet a station as lie in its width
            wide = abs(partner_face[k, above] - partner_face[k, below]) / ((above - below) * step)
            station, weight = station_of(partner_face[k, i], faces[0], step, stations)
            per_profile = abs(partner_slope[k, i])
            shifts_of(
                middle, at_edge, pieces, low[k, i], high[k, i], nodes[i, 1] - nodes[i, 0],
                step_of(partner_places[0, :, i], rate[:, i], k), step_of(partner_places[1, :, i], rate[:, i], k),
                step_of(partner_places[2, :, i], rate[:, i], k), shift,
            )  # fmt: skip
            scale = rate[k, i] * wide * per_profile / spacing[k, i]
            for c in range(pieces):
                place = partner_profile[k, i] + partner_slope[k, i] * (middle[c] - profile[k, i])
                away = middle[c] - at_profile[k, i]
                v0 = centre[k, i, 0] + slope[k, i, 0] * away
                v1 = centre[k, i, 1] + slope[k, i, 1] * away
                amount = scale * mass[c] * sqrt(v0 * v0 + v1 * v1)
                laid = 0.0
                for side in range(2):
                    # nothing is kept beyond the width of the last station
                    share = max(1.0 - abs(weight - side), 0.0)
                    if share > 0.0:
                        laid += lay(own, own_split, place, shift[c], share * amount, out[station + side])
                whole = rate[k, i] * length[k, i] * mass[c] * sqrt(v0 * v0 + v1 * v1)
                taken[0] += whole
                taken[1] += whole * (1.0 - laid / amount) if amount > 0.0 else 0.0
    for p in range(last + 1):
        width = node_width(own, p)
        for j in range(stations):
            out[j, p] /= width


def spread_over_partner(
    lines: ContactLines,
    partner: PartnerFlank,
    removed: Removed,
    half_width: float,
    places: FloatArray,
    what: Spread,
    slices: NDArray[np.int64],
    taken: FloatArray | None = None,
) -> FloatArray:
    """Density on the nodes of the driving flank of what each line spreads over its footprint, summed over rolls.

    Parameters are as in `spread.spread_over_flank`, with the flank in place of the grid.

    Returns
    -------
    (face, profile) array
        Right in stations all of whose slices are done.
    """
    out = np.zeros(partner.grid.profile.shape)
    partner_places = np.stack(
        [
            lines.partner_profile + lines.partner_slope * (place - lines.profile)
            for place in (places, lines.low, lines.high)
        ]
    )
    _spread(
        what.rate, what.centre, what.slope, what.closes, places, partner_places, lines.profile, lines.low, lines.high,
        lines.separation, lines.spacing, lines.low_edge_radius, lines.high_edge_radius, removed.depth, removed.row,
        removed.grid.profile, removed.grid.split, half_width, slices, lines.partner_profile, lines.partner_slope,
        lines.partner_face, partner.grid.face, partner.grid.profile[0], partner.grid.split[0], lines.length, out,
        np.zeros(2) if taken is None else taken,
    )  # fmt: skip
    return out

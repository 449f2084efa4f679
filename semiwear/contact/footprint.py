"""Footprints: position, gap and curvature of the contact of each slice with a worn flank.

Hertz's semi-ellipse over a parabola g = x^2/(2R) is the square root of (d - g), with d = b^2/(2R). The footprint
of a slice is the same root over the *current* gap, fresh separation plus wear, inside the part of the slice that
both bodies share and on the rounded edges at its ends:

    w(x) = sqrt(d - (g(x) - min g)) / area        where positive

with d such that the fresh gap gives the reference half-width. It narrows on a ridge, widens in a worn valley, is cut
off at an edge, and passes from one valley to another without a jump. Its mean gap is the gap of the slice, its
greatest density gives the curvature of the Hertz contact with the same peak, and its shape distributes the wear.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.fine_row import FineRow, fill_row, fine_row, forget_row, parts_of_cells
from semiwear.contact.gap import (
    ON_EDGES,
    add_arc,
    fresh_curve,
    fresh_gap,
    fresh_on,
    gap_at,
    gap_of_flanks,
    lowest,
    reaches_ends,
    rises_within,
    slice_gap,
    varies_by,
)
from semiwear.errors import ConvergenceError
from semiwear.kernel_cache import ZERO, inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import locate
from semiwear.meshing.removed import Removed
from semiwear.threads import in_loose_shares

_LEAST_BEND = 5e-7  # least curvature of a gap times the half-width: keeps the footprint of a flat gap finite
_FEW = 12  # cells: among so few it does not pay to look for the closed ones
CLOSED = 1.25  # of a footprint's depth above the lowest node: with room for the curvature between nodes
BESIDE = 4  # nodes of a window beyond a footprint, from which slopes at its ends are taken
_SAME = 1e-9  # of a footprint's half-width: an end of the slice within this distance of a node lies at it
_FINE = 0.1  # of a footprint's half-width: longest stretch that counts as straight, to 0.2 % of the gap's rise


OF_PRESSED_EDGES = ("gap", "curvature", "profile", "softer")
"""Arrays of `Footprints` that loads change where edges press."""


@dataclass(frozen=True)
class Footprints:
    """Contact of every slice with a worn flank; arrays are (roll, face) unless said otherwise.

    Attributes
    ----------
    removed : Removed
        Material removed from the flanks.
    profile : array [mm]
        Profile coordinate of the footprint's centre.
    gap : array [mm]
        Separation at the nominal rotation of the Hertz contact that stands for the footprint.
    curvature : array [1/mm]
        Relative curvature, normal to the line, of the Hertz contact with the same peak.
    half_width : array [mm]
        Half-width normal to the line of that contact under the reference load.
    cut : array
        Depth of the footprint at a flank's end that cuts it off over its greatest depth; 0 where none does.
    least : array [mm]
        Least separation at the nominal rotation: where an unloaded slice touches first.
    softer : array [mm/N]
        Compliance of a slice beyond that of the Hertz contact: of a pressed edge that is narrower.
    near : bool array or None
        Slices whose footprints were found; the others keep place and curvature of the fresh flanks. None: all.
    nearer : array [mm] or None
        How much nearer the flanks are over whole slices than `removed` leaves them.
    """

    removed: Removed
    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    half_width: FloatArray
    cut: FloatArray
    least: FloatArray
    softer: FloatArray
    near: BoolArray | None = None
    nearer: FloatArray | None = None

    def nearer_by(self, distance: FloatArray) -> Footprints:
        """The footprints of flanks that are nearer by a distance [mm], (roll, face)."""
        return replace(self, gap=self.gap - distance, least=self.least - distance, nearer=distance)

    @property
    def edge(self) -> BoolArray:
        """Whether the footprint is cut off by an end of either flank, (roll, face)."""
        return self.cut > 0.0

    def every(self, step: int) -> Footprints:
        """The footprints of every `step`-th roll position."""
        by_roll = {
            entry.name: np.ascontiguousarray(getattr(self, entry.name)[::step])
            for entry in fields(self)
            if entry.name != "removed" and getattr(self, entry.name) is not None
        }
        return Footprints(removed=self.removed.every(step), **by_roll)

    def require_followed(self, force: FloatArray, positions: IntArray, per_cycle: int) -> None:
        """Raise an error where slices bear a force, (roll, face), whose footprints were not found.

        Parameters
        ----------
        force : (roll, face) array [N]
        positions : int array
            Mesh positions to check.
        per_cycle : int
            Mesh positions in a cycle.

        Raises
        ------
        ConvergenceError
            Naming the first such mesh position.
        """
        if self.near is None:
            return
        lost = np.flatnonzero(((force > 0.0) & ~self.near).any(axis=1)) % per_cycle
        lost = lost[np.isin(lost, positions)]
        if lost.size > 0:
            raise ConvergenceError(
                f"load sharing stopped at mesh position {lost[0]}/{per_cycle}: load reaches slices that were too far "
                "apart to be followed; take shorter wear steps (more numerics.wear_steps), or check the depth of wear"
            )


class _Found(NamedTuple):
    """Arrays of `Footprints`."""

    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    half_width: FloatArray
    least: FloatArray
    cut: FloatArray


@inner_njit(cache=True, error_model="numpy")
def depth_of(bend, half_width):  # type: ignore[no-untyped-def]
    """Depth d of a footprint: the sagitta of a fresh gap of this bend over the reference half-width."""
    return 0.5 * max(bend * half_width, _LEAST_BEND) * half_width


@inner_njit(cache=True, error_model="numpy", fastmath={"contract"})
def _along_row(curve, at, place, removed, u, g):  # type: ignore[no-untyped-def]
    """Outline where a row of material removed is tabulated."""
    for k in range(place.shape[0]):
        u[k] = place[k]
    for k in range(place.shape[0]):
        g[k] = fresh_on(curve, place[k] - at) + removed[k]


class Reach(NamedTuple):
    """Memory for the outline of the gap that a footprint may reach.

    Attributes
    ----------
    row : FineRow
    u, g : (places,) arrays [mm]
        Profile coordinate and gap.
    within : (2,) int array
        First and last node between which a footprint is looked for: all, unless the caller knows where it lies.
    """

    row: FineRow
    u: FloatArray
    g: FloatArray
    within: IntArray


@njit(cache=True, error_model="numpy")
def reach_space(nodes):  # type: ignore[no-untyped-def]
    """Memory for the footprints of slices of these nodes."""
    row = fine_row(nodes.shape[1])
    most = row.place.shape[0] + ON_EDGES + 1  # one more where an outline is split
    return Reach(row, np.empty(most), np.empty(most), np.array([0, nodes.shape[1] - 1]))


@inner_njit(cache=True, error_model="numpy")
def look_within(window, points):  # type: ignore[no-untyped-def]
    """First and last node between which a footprint is looked for in a window of a slice of `points` nodes."""
    first = window[0] + BESIDE - 1 if window[0] > 0 else ZERO
    return first, (window[1] - BESIDE if window[1] < points else points - 1)


@inner_njit(cache=True, error_model="numpy")
def _above(removed, g, first, cell, highest):  # type: ignore[no-untyped-def]
    """Whether the gap is above a height all over a cell: at its nodes, less the change of material removed."""
    node = first + cell
    return min(g[cell], g[cell + 1]) - abs(removed[node] - removed[node + 1]) > highest


@inner_njit(cache=True, error_model="numpy")
def closed_between(removed, g, first, low, high, highest, from_low, from_high):  # type: ignore[no-untyped-def]
    """Nodes of `g` from `low` up to `high`, without the cells above a height at the chosen ends."""
    while from_low and low < high - 1 and _above(removed, g, first, low, highest):
        low += 1
    while from_high and high > low + 1 and _above(removed, g, first, high - 1, highest):
        high -= 1
    return low, high


@inner_njit(cache=True, error_model="numpy")
def _closed_cells(gap, first, end, depth, u, g):  # type: ignore[no-untyped-def]
    """Of the cells from `first` up to `end`, those between the outermost ones that a footprint can close."""
    nodes, removed, cells = gap.nodes[first : end + 1], gap.removed, end - first
    fresh = fresh_curve(gap.derivatives)
    _along_row(fresh, gap.at, nodes, removed[first : end + 1], u[: cells + 1], g[: cells + 1])
    highest = lowest(g, cells + 1) + CLOSED * depth
    low, high = closed_between(removed, g, first, ZERO, cells, highest, True, True)
    return first + low, first + high


@inner_njit(cache=True, error_model="numpy")
def reached(gap, half_width, space):  # type: ignore[no-untyped-def]
    """Outline of the gap that a footprint may reach, in `space`: depth, number of places and least gap.

    `space` holds no other row of material removed than that of this gap.
    """
    nodes, split, row, u, g = gap.nodes, gap.split, space.row, space.u, space.g
    width, last = half_width / gap.per_mm, nodes.shape[0] - 1
    depth = depth_of(gap.derivatives[2], width)
    reach = np.inf
    if space.within[0] == 0 and space.within[1] == last:
        # a footprint cannot lie where the fresh separation alone exceeds the variation of the flanks' shape
        reach = width + rises_within(varies_by(gap.removed) + depth, gap.derivatives[2])
    start = max(gap.low, min(gap.at - reach, gap.high))
    stop = min(gap.high, max(gap.at + reach, gap.low))
    parts = parts_of_cells(nodes, _FINE * width)
    first, end = locate(nodes, split, start)[0], min(locate(nodes, split, stop)[0] + 1, last)
    first -= first > 0 and nodes[first] > start  # a node just above, by rounding
    first, end = max(first, space.within[0]), min(end, space.within[1])
    at_low, at_high = reaches_ends(gap, space.within[0], space.within[1])
    to_low, to_high = at_low and start <= gap.low, at_high and stop >= gap.high
    if not to_low and not to_high and end - first > _FEW:
        first, end = _closed_cells(gap, first, end, depth, u, g)
    fill_row(row, gap, parts, first, end)
    p, q, count = first * parts, end * parts + 1, ZERO
    if to_low and gap.low_radius > 0.0:
        count = add_arc(gap, -1.0, depth, u, g, count)
    if row.place[p] <= gap.low:
        u[count], g[count] = start, gap_at(gap, start)
        count += 1
        while p < q and row.place[p] <= start + _SAME * width:
            p += 1
    cut = row.place[q - 1] >= gap.high
    while cut and q > p and row.place[q - 1] >= stop - _SAME * width:
        q -= 1
    inner = count + q - p
    _along_row(fresh_curve(gap.derivatives), gap.at, row.place[p:q], row.removed[p:q], u[count:inner], g[count:inner])
    count = inner
    if cut and (count == 0 or stop > u[count - 1]):
        u[count], g[count] = stop, gap_at(gap, stop)
        count += 1
    if to_high and gap.high_radius > 0.0:
        count = add_arc(gap, 1.0, depth, u, g, count)
    return depth, count, lowest(g, count)


@inner_njit(cache=True, error_model="numpy")
def segment(width, t_a, t_b):  # type: ignore[no-untyped-def]
    """Integrals of t = sqrt(depth - g) and of (depth - g) t over a stretch on which g is linear.

    With a = t_a^2 and b = t_b^2 at its ends they are 2/3 (a^1.5 - b^1.5)/(a - b) and 2/5 (a^2.5 - b^2.5)/(a - b) of
    the width, here with the common factor divided out: nothing cancels where g is even.
    """
    total = t_a + t_b
    if total <= 0.0:
        return 0.0, 0.0
    a, b, ab = t_a * t_a, t_b * t_b, t_a * t_b
    per = width / total
    return 2.0 / 3.0 * per * (a + ab + b), 0.4 * per * (a * a + b * b + ab * (a + ab + b))


@inner_njit(cache=True, error_model="numpy")
def centred_segment(u_a, width, t_a, t_b):  # type: ignore[no-untyped-def]
    """Integral of t over a stretch from `u_a` on which g is linear, as in `segment`, and its centroid."""
    even = t_a * t_a + t_b * (t_a + t_b)
    per = width / (5.0 * even * (t_a + t_b))
    middle = u_a + per * (t_b * (t_b * (3.0 * t_b + 6.0 * t_a) + 4.0 * t_a * t_a) + 2.0 * t_a**3)
    return 10.0 / 3.0 * even * even * per, middle


@inner_njit(cache=True, error_model="numpy")
def open_part(u_a, width, a, b):  # type: ignore[no-untyped-def]
    """Start and width of the part of a stretch where depth - g, straight from a to b, is positive."""
    if a < 0.0:
        return u_a + width * a / (a - b), width * b / (b - a)
    if b < 0.0:
        return u_a, width * a / (a - b)
    return u_a, width


@inner_njit(cache=True, error_model="numpy")
def root_of(a):  # type: ignore[no-untyped-def]
    """Square root of depth - g; zero where the gap is not closed."""
    return sqrt(a) if a > 0.0 else 0.0


@inner_njit(cache=True, error_model="numpy")
def _shape(gap, half_width, space):  # type: ignore[no-untyped-def]
    """Depth and least gap of a footprint, its area, moments of gap and place, and the share of depth at a cut end."""
    depth, count, least = reached(gap, half_width, space)
    u, g = space.u, space.g
    area, below, moment = 0.0, 0.0, 0.0
    b = depth - (g[0] - least)
    t_b = root_of(b)
    for c in range(count - 1):
        a, t_a = b, t_b
        b = depth - (g[c + 1] - least)
        t_b = root_of(b)
        if t_a + t_b > 0.0:
            start, width = open_part(u[c], u[c + 1] - u[c], a, b)
            part, open_gap = segment(width, t_a, t_b)
            area += part
            below += open_gap
            moment += part * (start + 0.5 * width)
    # cut off where the gap is still open to the footprint at an end of the slice
    first, last = 0, count - 1
    cut = 0.0
    while first < count and u[first] <= gap.low:
        cut = max(cut, 1.0 - (g[first] - least) / depth)
        first += 1
    while last >= 0 and u[last] >= gap.high:
        cut = max(cut, 1.0 - (g[last] - least) / depth)
        last -= 1
    return depth, least, area, below, moment, cut


@njit(cache=True, error_model="numpy", nogil=True)
def _find(near, flank, windows, half_width, slices, found):  # type: ignore[no-untyped-def]
    space = reach_space(flank.nodes)
    rolls, points, within = near.shape[0], flank.nodes.shape[1], space.within
    for i in slices:
        for k in range(rolls):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                forget_row(space.row)
            gap = slice_gap(flank, k, i)
            width = half_width / gap.per_mm
            found.profile[k, i] = gap.at
            unknown = windows[k, i, 0] == windows[k, i, 1]
            found.gap[k, i] = fresh_gap(0.0, gap.derivatives) if unknown else gap_at(gap, gap.at)
            found.curvature[k, i] = 2.0 * depth_of(gap.derivatives[2], width) / half_width**2
            found.half_width[k, i] = half_width
            found.least[k, i] = found.gap[k, i]
            found.cut[k, i] = 1.0 if gap.at - gap.low < width or gap.high - gap.at < width else 0.0
            if not near[k, i] or unknown:
                continue
            if found.cut[k, i] == 0.0 and varies_by(gap.removed[windows[k, i, 0] : windows[k, i, 1]]) == 0.0:
                continue
            within[0], within[1] = look_within(windows[k, i], points)
            depth, least, area, below, moment, cut = _shape(gap, half_width, space)
            found.least[k, i] = least
            if area <= 0.0:
                # a single point is left of the slice: it touches as the fresh flank would
                found.cut[k, i] = 1.0
                continue
            # Hertz: the mean of (depth - g) is 3/4 of depth, the greatest density sqrt(depth)/area = 2/(pi b)
            found.gap[k, i] = least + (depth - below / area) - 0.25 * depth
            found.half_width[k, i] = 2.0 * area / (pi * sqrt(depth)) * gap.per_mm
            found.curvature[k, i] = 2.0 * depth / found.half_width[k, i] ** 2
            found.profile[k, i] = min(max(moment / area, gap.low), gap.high)
            found.cut[k, i] = cut


def footprints(lines: ContactLines, removed: Removed, half_width: float, near: BoolArray) -> Footprints:
    """Footprints of all contact lines on a worn flank.

    Parameters
    ----------
    lines : ContactLines
        Fresh contact lines.
    removed : Removed
    half_width : float [mm]
        Reference half-width: that of the footprint on a fresh flank.
    near : (roll, face) bool array
        Slices that can carry load; the others, and those without a window of `removed`, count as fresh.
    """
    shape, windows = lines.profile.shape, removed.known
    found = _Found(*np.empty((6, *shape)))
    flank = gap_of_flanks(lines, removed)
    in_loose_shares(lambda slices: _find(near, flank, windows, half_width, slices, found), np.arange(shape[1]))
    return Footprints(removed, **found._asdict(), softer=np.zeros(shape), near=near)

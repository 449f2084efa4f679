"""Where and how a worn flank is touched in each slice: the footprint of a contact line.

Hertz's semi-ellipse over a parabola g = x^2/(2R) is the square root of (d - g), with d = b^2/(2R). The footprint
of a slice is the same root over the *current* gap, fresh separation plus wear, inside the part of the slice that
both bodies share and on the rounded edges at its ends:

    w(x) = sqrt(d - (g(x) - min g)) / area        where positive

with d such that the fresh gap gives the reference half-width. It narrows on a ridge, widens in a worn valley, is cut
off at an edge, and passes from one valley to another without a jump. Its mean gap is what the slice feels, its
greatest density gives the curvature of the Hertz contact that would be as concentrated, and its shape spreads the
wear.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.gap import (
    fresh_gap,
    gap_at,
    gap_of_flanks,
    most_places,
    outline,
    rises_within,
    slice_gap,
)
from semiwear.errors import ConvergenceError
from semiwear.kernel_cache import njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import change_above, locate, slope_at
from semiwear.meshing.removed import Removed

__all__ = [
    "Footprints",
    "clipped",
    "depth_of",
    "footprints",
    "reached",
    "segment",
]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_LEAST_BEND = 5e-7  # of a gap, times the half-width: keeps the footprint of a flat one finite
_FINE = 0.1  # of a footprint's half-width: longest stretch that counts as straight, to 0.2 % of the gap's rise


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
        Separation at the nominal rotation that a Hertz contact in this place would start from.
    curvature : array [1/mm]
        Relative curvature normal to the line of the Hertz contact that is as concentrated.
    half_width : array [mm]
        Half-width normal to the line of that contact under the reference load.
    edge : bool array
        The footprint is cut off by an end of either flank.
    least : array [mm]
        Least separation at the nominal rotation: where an unloaded slice touches first.
    near : bool array or None
        Slices whose footprints were found; the others are given their fresh place and curvature. None: all.
    """

    removed: Removed
    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    half_width: FloatArray
    edge: BoolArray
    least: FloatArray
    near: BoolArray | None = None

    def every(self, step: int) -> Footprints:
        """The footprints of every `step`-th roll position."""
        by_roll = {
            entry.name: np.ascontiguousarray(getattr(self, entry.name)[::step])
            for entry in fields(self)
            if entry.name != "removed" and getattr(self, entry.name) is not None
        }
        return Footprints(removed=self.removed.every(step), **by_roll)

    def require_followed(self, force: FloatArray, rolls: NDArray[np.int64], where: str) -> None:
        """Raise where slices bear a force, (roll, face), that were too far apart to look for their footprints.

        Raises
        ------
        ConvergenceError
            Naming the mesh position `where`.
        """
        if self.near is not None and np.any(force[rolls][~self.near[rolls]] > 0.0):
            raise ConvergenceError(
                f"load sharing stopped at mesh position {where}: load reaches slices that were too far apart to be "
                "followed; take shorter wear steps (more numerics.wear_steps), or check the depth of wear"
            )


class _Found(NamedTuple):
    """Arrays of `Footprints`."""

    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    half_width: FloatArray
    least: FloatArray
    edge: BoolArray


@njit(cache=True, error_model="numpy")
def depth_of(bend, half_width):  # type: ignore[no-untyped-def]
    """Depth d of a footprint: the sagitta of a fresh gap of this bend over the reference half-width."""
    return 0.5 * max(bend * half_width, _LEAST_BEND) * half_width


@njit(cache=True, error_model="numpy")
def _bend_beside(values, cell):  # type: ignore[no-untyped-def]
    """Greatest second difference of values at the two nodes of a cell."""
    last = values.shape[0] - 1
    bend = 0.0
    if cell > 0:
        bend = abs(values[cell - 1] - 2.0 * values[cell] + values[cell + 1])
    if cell + 2 <= last:
        bend = max(bend, abs(values[cell] - 2.0 * values[cell + 1] + values[cell + 2]))
    return bend


@njit(cache=True, error_model="numpy")
def _refine(gap, u, g, count, depth, longest, slopes, fine_u, fine_g):  # type: ignore[no-untyped-def]  # noqa: C901
    """The outline with places between nodes wherever a footprint may lie; returns their number and the least gap.

    `slopes` keeps what is found of `slope_at` for these depths: NaN where it is not known.
    """
    nodes, split, removed = gap.nodes, gap.split, gap.removed
    least = g[0]
    for c in range(1, count):
        least = min(least, g[c])
    fine_u[0], fine_g[0] = u[0], g[0]
    n, cell = 1, -1
    for c in range(count - 1):
        if u[c] >= gap.low and u[c + 1] <= gap.high:
            width = u[c + 1] - u[c]
            # nodes are places of the outline, so that each of its stretches lies in one cell
            if cell < 0:
                cell = locate(nodes, split, 0.5 * (u[c] + u[c + 1]))[0]
            elif cell + 2 < nodes.shape[0] and u[c] >= nodes[cell + 1]:
                cell += 1
            # by so much, and what wear bends, the gap between two places may be less than at both
            above = min(g[c], g[c + 1]) - least - depth - 0.125 * gap.derivatives[2] * width * width
            if above < 0.0 or above < 0.125 * _bend_beside(removed, cell):
                parts = min(int(width / longest) + 1, fine_u.shape[0] - n - (count - c))
                if parts > 1:
                    for node in range(cell, cell + 2):
                        if np.isnan(slopes[node]):
                            slopes[node] = slope_at(removed, nodes, split, node)
                    before, slope = change_above(slopes[cell], nodes, split, cell), slopes[cell + 1]
                    rise, size = removed[cell + 1] - removed[cell], nodes[cell + 1] - nodes[cell]
                    second, third = 3.0 * rise - 2.0 * before - slope, before + slope - 2.0 * rise
                    x, step = (u[c] - nodes[cell]) / size, width / (size * parts)
                    for part in range(1, parts):
                        x += step
                        fine_u[n] = u[c] + part * width / parts
                        lost = removed[cell] + x * (before + x * (second + x * third))  # `cubic`
                        fine_g[n] = fresh_gap(fine_u[n] - gap.at, gap.derivatives) + lost
                        n += 1
        fine_u[n], fine_g[n] = u[c + 1], g[c + 1]
        n += 1
    for c in range(n):
        least = min(least, fine_g[c])
    return n, least


@njit(cache=True, error_model="numpy")
def reached(gap, half_width, slopes, work):  # type: ignore[no-untyped-def]
    """Outline of what a footprint may reach, in work[2] and work[3]: depth, number of places and least gap.

    `slopes` keeps `slope_at` of the nodes, NaN where it is not known; `work` is (4, `most_places`).
    """
    width = half_width / gap.per_mm
    depth = depth_of(gap.derivatives[2], width)
    # a footprint cannot lie where the fresh separation alone exceeds what the flanks' shape varies by
    reach = width + rises_within(gap.removed.max() - gap.removed.min() + depth, gap.derivatives[2])
    count = outline(gap, gap.at - reach, gap.at + reach, depth, work[0], work[1])
    count, least = _refine(gap, work[0], work[1], count, depth, _FINE * width, slopes, work[2], work[3])
    return depth, count, least


@njit(cache=True, error_model="numpy")
def segment(depth, width, t_a, t_b):  # type: ignore[no-untyped-def]
    """Integrals of t = sqrt(depth - g) and of (depth - g) t over a stretch on which g is linear."""
    a, b = t_a * t_a, t_b * t_b
    if abs(a - b) <= 1e-6 * depth:
        t = 0.5 * (t_a + t_b)
        return width * t, width * t * t * t
    per = width / abs(b - a)
    return (
        2.0 / 3.0 * per * abs(t_a * a - t_b * b),
        2.0 / 5.0 * per * abs(t_a * a * a - t_b * b * b),
    )


@njit(cache=True, error_model="numpy")
def clipped(depth, least, u_a, g_a, u_b, g_b):  # type: ignore[no-untyped-def]
    """Part of a stretch with g - least < depth: its ends and the roots t there; empty if width is zero."""
    a, b = depth - (g_a - least), depth - (g_b - least)
    if a <= 0.0 and b <= 0.0:
        return u_a, u_a, 0.0, 0.0
    if a < 0.0:
        return u_b - (u_b - u_a) * b / (b - a), u_b, 0.0, sqrt(b)
    if b < 0.0:
        return u_a, u_a + (u_b - u_a) * a / (a - b), sqrt(a), 0.0
    return u_a, u_b, sqrt(a), sqrt(b)


@njit(cache=True, error_model="numpy")
def _shape(gap, half_width, slopes, work):  # type: ignore[no-untyped-def]
    """Room and least gap of a footprint, its area, moments of gap and place, and whether an end cuts it off."""
    depth, count, least = reached(gap, half_width, slopes, work)
    u, g = work[2], work[3]
    area, below, moment = 0.0, 0.0, 0.0
    for c in range(count - 1):
        if min(g[c], g[c + 1]) - least >= depth:
            continue
        u_a, u_b, t_a, t_b = clipped(depth, least, u[c], g[c], u[c + 1], g[c + 1])
        if u_b > u_a:
            a, b = segment(depth, u_b - u_a, t_a, t_b)
            area += a
            below += b
            moment += a * 0.5 * (u_a + u_b)
    # cut off where the gap is still open to the footprint at an end of the slice
    cut = False
    for c in range(count):
        if (u[c] <= gap.low or u[c] >= gap.high) and g[c] - least < depth:
            cut = True
    return depth, least, area, below, moment, cut


@njit(cache=True, error_model="numpy")
def _find(near, flank, half_width, found):  # type: ignore[no-untyped-def]
    work, slopes = np.empty((4, most_places(flank.nodes))), np.empty(flank.nodes.shape[1])
    rolls, faces = near.shape
    for i in range(faces):
        for k in range(rolls):
            if k == 0 or flank.row[k] != flank.row[k - 1]:
                slopes[:] = np.nan
            gap = slice_gap(flank, k, i)
            width = half_width / gap.per_mm
            found.profile[k, i] = gap.at
            found.gap[k, i] = gap_at(gap, gap.at)
            found.curvature[k, i] = 2.0 * depth_of(gap.derivatives[2], width) / half_width**2
            found.half_width[k, i] = half_width
            found.least[k, i] = found.gap[k, i]
            found.edge[k, i] = gap.at - gap.low < width or gap.high - gap.at < width
            if not near[k, i]:
                continue
            if gap.removed.max() == gap.removed.min() and not found.edge[k, i]:
                continue
            depth, least, area, below, moment, cut = _shape(gap, half_width, slopes, work)
            found.least[k, i] = least
            if area <= 0.0:
                # a single point is left of the slice: it touches as the fresh flank would
                found.edge[k, i] = True
                continue
            # Hertz: the mean of (depth - g) is 3/4 of depth, the greatest density sqrt(depth)/area = 2/(pi b)
            found.gap[k, i] = least + (depth - below / area) - 0.25 * depth
            found.half_width[k, i] = 2.0 * area / (pi * sqrt(depth)) * gap.per_mm
            found.curvature[k, i] = 2.0 * depth / found.half_width[k, i] ** 2
            found.profile[k, i] = min(max(moment / area, gap.low), gap.high)
            found.edge[k, i] = cut


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
        Slices that can carry load; the others keep their fresh place.
    """
    shape = lines.profile.shape
    profile, gap, curvature, width, least = np.empty((5, *shape))
    found = _Found(profile, gap, curvature, width, least, np.empty(shape, dtype=np.bool_))
    _find(near, gap_of_flanks(lines, removed), half_width, found)
    return Footprints(removed, **found._asdict(), near=near)

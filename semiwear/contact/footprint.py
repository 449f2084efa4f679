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

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.errors import ConvergenceError
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import change_above, locate, slope_at, smooth_value
from semiwear.meshing.removed import Removed

__all__ = [
    "Footprints",
    "clipped",
    "depth_of",
    "edge_tangent",
    "footprints",
    "fresh_beyond",
    "fresh_gap",
    "fresh_slope",
    "most_places",
    "outline",
    "reached",
    "rises_within",
    "segment",
]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_LEAST_BEND = 5e-7  # of a gap, times the half-width: keeps the footprint of a flat one finite
_ARC_NODES = 10  # on the part of a rounded edge that a footprint can reach
_FINE = 0.1  # of a footprint's half-width: longest stretch that counts as straight, to 0.2 % of the gap's rise
_BETWEEN = 1000  # places of a footprint between nodes and on edges, at most


@dataclass(frozen=True)
class Footprints:
    """Contact of every slice with a worn flank; arrays are (roll, face) unless said otherwise.

    Attributes
    ----------
    removed : Removed
        What is gone from the flanks.
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


@njit(cache=True, error_model="numpy")
def _convex(away, terms):  # type: ignore[no-untyped-def]
    """Second derivative at the line, at least zero, and how far towards `away` the polynomial stays convex."""
    side = 1.0 if away >= 0.0 else -1.0
    bend, third, fourth = max(terms[2], 0.0), side * terms[3], terms[4]
    # first zero of bend + third t + fourth t^2/2 at t >= 0, if there is one
    rest = third * third - 2.0 * bend * fourth
    if rest < 0.0:
        return bend, away
    if third > 0.0:
        first = -(third + sqrt(rest)) / fourth if fourth < 0.0 else np.inf
    elif sqrt(rest) - third > 0.0:
        first = 2.0 * bend / (sqrt(rest) - third)
    else:
        first = 0.0 if fourth < 0.0 else np.inf
    return bend, away if abs(away) <= first else side * first


@njit(cache=True, error_model="numpy")
def fresh_gap(away, terms):  # type: ignore[no-untyped-def]
    """Fresh separation at a distance in profile coordinates from the line.

    The separation is convex. Its polynomial need not be, far out on one side, and could fall there without end:
    beyond the place where its curvature vanishes the separation goes on straight.
    """
    bend, d = _convex(away, terms)
    slope = terms[1] + d * (bend + d * (0.5 * terms[3] + d * terms[4] / 6.0))
    rise = d * (terms[1] + d * (0.5 * bend + d * (terms[3] / 6.0 + d * terms[4] / 24.0)))
    return terms[0] + rise + (away - d) * slope


@njit(cache=True, error_model="numpy")
def fresh_slope(away, terms):  # type: ignore[no-untyped-def]
    """Derivative of `fresh_gap`."""
    bend, d = _convex(away, terms)
    return terms[1] + d * (bend + d * (0.5 * terms[3] + d * terms[4] / 6.0))


@njit(cache=True, error_model="numpy")
def _wear_at(place, wear, nodes, split):  # type: ignore[no-untyped-def]
    cell, x = locate(nodes, split, place)
    return smooth_value(wear, nodes, split, cell, x)


@njit(cache=True, error_model="numpy")
def _gap_at(place, at, terms, wear, nodes, split):  # type: ignore[no-untyped-def]
    return fresh_gap(place - at, terms) + _wear_at(place, wear, nodes, split)


@njit(cache=True, error_model="numpy")
def edge_tangent(border, direction, per_mm, at, terms):  # type: ignore[no-untyped-def]
    """Fresh separation at a border, and its slope outwards per mm."""
    return fresh_gap(border - at, terms), direction * fresh_slope(border - at, terms) / per_mm


@njit(cache=True, error_model="numpy")
def fresh_beyond(beyond, fresh, slope, radius):  # type: ignore[no-untyped-def]
    """Fresh separation on a rounded edge, so far beyond its border: the flank's tangent falls away along an arc."""
    return fresh + slope * beyond + radius - sqrt(max(radius * radius - beyond * beyond, 0.0))


@njit(cache=True, error_model="numpy")
def _reach_on_edge(height, slope, radius):  # type: ignore[no-untyped-def]
    """How far beyond a border a rounded edge has opened by a height; its radius at most."""
    if height >= radius * (1.0 + slope):
        return radius
    steep, rest = 1.0 + slope * slope, radius - height
    return (sqrt(max(steep * radius * radius - rest * rest, 0.0)) - slope * rest) / steep


@njit(cache=True, error_model="numpy")
def _arc(border, direction, radius, per_mm, room, at, terms, wear, nodes, split, u, g, count):  # type: ignore[no-untyped-def]
    """Append points of a rounded edge to the outline.

    Where the edge is the partner's, the flank goes on beyond it: the rounding presses on the wall of the groove that
    the edge has worn.
    """
    fresh, slope = edge_tangent(border, direction, per_mm, at, terms)
    here = _wear_at(border, wear, nodes, split)
    rises = 0.0
    cell = locate(nodes, split, border)[0]
    p = cell if direction < 0.0 else cell + 1
    while 0 <= p < nodes.shape[0] and abs(nodes[p] - border) * per_mm < radius:
        rises = max(rises, here - wear[p])
        p += 1 if direction > 0.0 else -1
    reach = _reach_on_edge(room + rises, slope, radius)
    for c in range(1, _ARC_NODES + 1):
        x = reach * c / _ARC_NODES
        u[count] = border + direction * x / per_mm
        g[count] = fresh_beyond(x, fresh, slope, radius) + _wear_at(u[count], wear, nodes, split)
        count += 1
    return count


@njit(cache=True, error_model="numpy")
def depth_of(bend, half_width):  # type: ignore[no-untyped-def]
    """Depth d of a footprint: the sagitta of a fresh gap of this bend over the reference half-width."""
    return 0.5 * max(bend * half_width, _LEAST_BEND) * half_width


@njit(cache=True, error_model="numpy")
def rises_within(height, bend):  # type: ignore[no-untyped-def]
    """Distance within which a fresh gap of this bend rises by a height: without end where it is flat."""
    return sqrt(2.0 * height / bend) if bend > 0.0 else np.inf


@njit(cache=True, error_model="numpy")
def most_places(nodes):  # type: ignore[no-untyped-def]
    """What an outline of a slice of these nodes has room in, refined or not."""
    return nodes.shape[1] + _BETWEEN


@njit(cache=True, error_model="numpy")
def outline(  # type: ignore[no-untyped-def]
    start, stop, at, low, high, terms, per_mm, low_radius, high_radius, room, wear, nodes, split, u, g
):
    """Points (profile, gap) of a slice between start and stop, with the arcs of edges there; returns their number."""
    start, stop = max(low, min(start, high)), min(high, max(stop, low))
    count = 0
    if start <= low and low_radius > 0.0:
        count = _arc(low, -1.0, low_radius, per_mm, room, at, terms, wear, nodes, split, u, g, count)
        u[:count] = u[:count][::-1].copy()
        g[:count] = g[:count][::-1].copy()
    p = np.searchsorted(nodes, start)
    if start > low and p > 0 and nodes[p - 1] > low:
        # from a node, where nothing has to be read between
        p -= 1
    else:
        u[count] = start
        g[count] = _gap_at(start, at, terms, wear, nodes, split)
        count += 1
        if p < nodes.shape[0] and nodes[p] <= start:
            p += 1
    while p < nodes.shape[0] and nodes[p] < stop:
        u[count] = nodes[p]
        g[count] = fresh_gap(nodes[p] - at, terms) + wear[p]
        count += 1
        p += 1
    if p < nodes.shape[0] and nodes[p] < high and stop < high:
        u[count] = nodes[p]
        g[count] = fresh_gap(nodes[p] - at, terms) + wear[p]
        count += 1
    elif count == 0 or stop > u[count - 1]:
        u[count] = stop
        g[count] = _gap_at(stop, at, terms, wear, nodes, split)
        count += 1
    if stop >= high and high_radius > 0.0:
        count = _arc(high, 1.0, high_radius, per_mm, room, at, terms, wear, nodes, split, u, g, count)
    return count


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
def _refine(u, g, count, at, low, high, terms, room, longest, wear, nodes, split, slopes, fine_u, fine_g):  # type: ignore[no-untyped-def]
    """The outline with places between nodes wherever a footprint may lie; returns their number and the least gap.

    `slopes` keeps what is found of `slope_at` for these depths: NaN where it is not known.
    """
    least = g[0]
    for c in range(1, count):
        least = min(least, g[c])
    fine_u[0], fine_g[0] = u[0], g[0]
    n, cell = 1, -1
    for c in range(count - 1):
        if u[c] >= low and u[c + 1] <= high:
            width = u[c + 1] - u[c]
            # nodes are places of the outline, so that each of its stretches lies in one cell
            if cell < 0:
                cell = locate(nodes, split, 0.5 * (u[c] + u[c + 1]))[0]
            elif cell + 2 < nodes.shape[0] and u[c] >= nodes[cell + 1]:
                cell += 1
            # by so much, and what wear bends, the gap between two places may be less than at both
            above = min(g[c], g[c + 1]) - least - room - 0.125 * terms[2] * width * width
            if above < 0.0 or above < 0.125 * _bend_beside(wear, cell):
                parts = min(int(width / longest) + 1, fine_u.shape[0] - n - (count - c))
                if parts > 1:
                    for node in range(cell, cell + 2):
                        if np.isnan(slopes[node]):
                            slopes[node] = slope_at(wear, nodes, split, node)
                    before, slope = change_above(slopes[cell], nodes, split, cell), slopes[cell + 1]
                    rise, size = wear[cell + 1] - wear[cell], nodes[cell + 1] - nodes[cell]
                    second, third = 3.0 * rise - 2.0 * before - slope, before + slope - 2.0 * rise
                    x, step = (u[c] - nodes[cell]) / size, width / (size * parts)
                    for part in range(1, parts):
                        x += step
                        fine_u[n] = u[c] + part * width / parts
                        gone = wear[cell] + x * (before + x * (second + x * third))  # `cubic`
                        fine_g[n] = fresh_gap(fine_u[n] - at, terms) + gone
                        n += 1
        fine_u[n], fine_g[n] = u[c + 1], g[c + 1]
        n += 1
    for c in range(n):
        least = min(least, fine_g[c])
    return n, least


@njit(cache=True, error_model="numpy")
def reached(at, low, high, terms, per_mm, low_radius, high_radius, gone, nodes, split, half_width, slopes, work):  # type: ignore[no-untyped-def]
    """Outline of what a footprint may reach, in work[2] and work[3]: room, number of places and least gap."""
    width = half_width / per_mm
    room = depth_of(terms[2], width)
    # a footprint cannot lie where the fresh separation alone exceeds what the flanks' shape varies by
    reach = width + rises_within(gone.max() - gone.min() + room, terms[2])
    count = outline(
        at - reach, at + reach, at, low, high, terms, per_mm, low_radius, high_radius, room, gone, nodes, split,
        work[0], work[1],
    )  # fmt: skip
    count, least = _refine(
        work[0],
        work[1],
        count,
        at,
        low,
        high,
        terms,
        room,
        _FINE * width,
        gone,
        nodes,
        split,
        slopes,
        work[2],
        work[3],
    )
    return room, count, least


@njit(cache=True, error_model="numpy")
def segment(room, width, t_a, t_b):  # type: ignore[no-untyped-def]
    """Integrals of t = sqrt(room - g) and of (room - g) t over a stretch on which g is linear."""
    a, b = t_a * t_a, t_b * t_b
    if abs(a - b) <= 1e-6 * room:
        t = 0.5 * (t_a + t_b)
        return width * t, width * t * t * t
    per = width / abs(b - a)
    return (
        2.0 / 3.0 * per * abs(t_a * a - t_b * b),
        2.0 / 5.0 * per * abs(t_a * a * a - t_b * b * b),
    )


@njit(cache=True, error_model="numpy")
def clipped(room, least, u_a, g_a, u_b, g_b):  # type: ignore[no-untyped-def]
    """Part of a stretch with g - least < room: its ends and the roots t there; empty if width is zero."""
    a, b = room - (g_a - least), room - (g_b - least)
    if a <= 0.0 and b <= 0.0:
        return u_a, u_a, 0.0, 0.0
    if a < 0.0:
        return u_b - (u_b - u_a) * b / (b - a), u_b, 0.0, sqrt(b)
    if b < 0.0:
        return u_a, u_a + (u_b - u_a) * a / (a - b), sqrt(a), 0.0
    return u_a, u_b, sqrt(a), sqrt(b)


@njit(cache=True, error_model="numpy")
def _find(  # type: ignore[no-untyped-def]
    near, profile, low, high, separation, spacing, low_radius, high_radius, removed, row, nodes, split, half_width,
    out_profile, out_gap, out_curvature, out_width, out_edge, out_least,
):  # fmt: skip
    work, slopes = np.empty((4, most_places(nodes))), np.empty(nodes.shape[1])
    u, g = work[2], work[3]
    rolls, faces = profile.shape
    for i in range(faces):
        for k in range(rolls):
            if k == 0 or row[k] != row[k - 1]:
                slopes[:] = np.nan
            at, per_mm = profile[k, i], spacing[k, i]
            terms, gone = separation[:, k, i], removed[row[k], i]
            width = half_width / per_mm
            out_profile[k, i] = at
            out_gap[k, i] = _gap_at(at, at, terms, gone, nodes[i], split[i])
            out_curvature[k, i] = 2.0 * depth_of(terms[2], width) / half_width**2
            out_width[k, i] = half_width
            out_least[k, i] = out_gap[k, i]
            out_edge[k, i] = at - low[k, i] < width or high[k, i] - at < width
            if not near[k, i]:
                continue
            if gone.max() == gone.min() and not out_edge[k, i]:
                continue
            room, count, least = reached(
                at, low[k, i], high[k, i], terms, per_mm, low_radius[k, i], high_radius[k, i], gone, nodes[i],
                split[i], half_width, slopes, work,
            )  # fmt: skip
            out_least[k, i] = least
            area, below, moment = 0.0, 0.0, 0.0
            for c in range(count - 1):
                if min(g[c], g[c + 1]) - least >= room:
                    continue
                u_a, u_b, t_a, t_b = clipped(room, least, u[c], g[c], u[c + 1], g[c + 1])
                if u_b > u_a:
                    a, b = segment(room, u_b - u_a, t_a, t_b)
                    area += a
                    below += b
                    moment += a * 0.5 * (u_a + u_b)
            if area <= 0.0:
                # a single point is left of the slice: it touches as the fresh flank would
                out_edge[k, i] = True
                continue
            # Hertz: the mean of (room - g) is 3/4 of room, the greatest density sqrt(room)/area = 2/(pi b)
            out_gap[k, i] = least + (room - below / area) - 0.25 * room
            out_width[k, i] = 2.0 * area / (pi * sqrt(room)) * per_mm
            out_curvature[k, i] = 2.0 * room / out_width[k, i] ** 2
            out_profile[k, i] = min(max(moment / area, low[k, i]), high[k, i])
            # cut off where the gap is still open to the footprint at an end of the slice
            cut = False
            for c in range(count):
                if (u[c] <= low[k, i] or u[c] >= high[k, i]) and g[c] - least < room:
                    cut = True
            out_edge[k, i] = cut


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
    profile, gap, curvature, width, least = (np.empty(shape) for _ in range(5))
    edge = np.empty(shape, dtype=np.bool_)
    _find(
        near, lines.profile, lines.low, lines.high, lines.separation, lines.spacing,
        lines.low_edge_radius, lines.high_edge_radius, removed.depth, removed.row, removed.grid.profile,
        removed.grid.split, half_width, profile, gap, curvature, width, edge, least,
    )  # fmt: skip
    return Footprints(removed, profile, gap, curvature, width, edge, least, near)

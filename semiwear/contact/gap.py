"""Gap across a slice of a contact line: fresh separation, material removed, and the rounded edges at both ends.

Footprints, plane-strain pressures, the deposit of wear and the cells of patches all read it here.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.kernel_cache import ZERO, inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import cubic, first_from, locate, slopes_of_cell, smooth_value
from semiwear.meshing.removed import Removed

_SAME = 1e-9  # of the height of a slice: a node within this distance of an end lies there, on either side
_ARC_NODES = 10  # on the part of a rounded edge that a footprint can reach
ON_EDGES = 2 * _ARC_NODES + 2  # places of an outline on edges and at borders, at most


class SliceGap(NamedTuple):
    """Gap of one slice at one roll position.

    Attributes
    ----------
    at : float [mm]
        Profile coordinate of the fresh line.
    low, high : float [mm]
        Borders of what both flanks share.
    derivatives : (5,) array
        Fresh separation at the line and its derivatives by the profile coordinate [mm, 1, 1/mm, ...].
    per_mm : float
        Distance across the line per profile coordinate.
    low_radius, high_radius : float [mm]
        Roundings of the edges beyond the borders.
    removed : (points,) array [mm]
        Material removed from both flanks at the nodes.
    nodes : (points,) array [mm]
    split : int
        Node at which the spacing changes.
    """

    at: float
    low: float
    high: float
    derivatives: FloatArray
    per_mm: float
    low_radius: float
    high_radius: float
    removed: FloatArray
    nodes: FloatArray
    split: int


class FlankGap(NamedTuple):
    """Gap of all slices at all roll positions; arrays are (roll, face) unless said otherwise.

    Attributes
    ----------
    profile, low, high, spacing, low_radius, high_radius : arrays
        `SliceGap.at`, borders, `per_mm` and roundings.
    separation : (5, roll, face) array
        `SliceGap.derivatives`.
    removed : (rows, face, points) array [mm]
    row : (roll,) int array
        Row of `removed` that each roll position meets.
    nodes : (face, points) array [mm]
    split : (face,) int array
    """

    profile: FloatArray
    low: FloatArray
    high: FloatArray
    separation: FloatArray
    spacing: FloatArray
    low_radius: FloatArray
    high_radius: FloatArray
    removed: FloatArray
    row: IntArray
    nodes: FloatArray
    split: IntArray


def gap_of_flanks(lines: ContactLines, removed: Removed) -> FlankGap:
    """Gap of contact lines on flanks from which material is removed."""
    gap = FlankGap(
        lines.profile, lines.low, lines.high, lines.separation, lines.spacing, lines.low_edge_radius,
        lines.high_edge_radius, removed.depth, removed.row, removed.grid.profile, removed.grid.split,
    )  # fmt: skip
    # contiguous and writable: kernels would be compiled again for every other layout
    return FlankGap._make(np.require(array, requirements=("C", "W")) for array in gap)


@njit(cache=True, error_model="numpy")
def slice_gap(gap, k, i):  # type: ignore[no-untyped-def]
    """Gap of slice i at roll position k."""
    return SliceGap(
        gap.profile[k, i], gap.low[k, i], gap.high[k, i], gap.separation[:, k, i], gap.spacing[k, i],
        gap.low_radius[k, i], gap.high_radius[k, i], gap.removed[gap.row[k], i], gap.nodes[i], gap.split[i],
    )  # fmt: skip


class FreshCurve(NamedTuple):
    """Fresh separation across a slice: its polynomial, and how far to either side that stays convex.

    Attributes
    ----------
    least, slope, bend, third, fourth : float [mm, 1, 1/mm, ...]
        Separation at the line and its derivatives by the profile coordinate; `bend` is at least zero.
    below, above : float [mm]
        Limits of the convex stretch, at most and at least zero.
    """

    least: float
    slope: float
    bend: float
    third: float
    fourth: float
    below: float
    above: float


@inner_njit(cache=True, error_model="numpy")
def _convex_within(bend, third, fourth):  # type: ignore[no-untyped-def]
    """First zero of bend + third t + fourth t^2/2 at t >= 0; infinite if there is none."""
    rest = third * third - 2.0 * bend * fourth
    if rest < 0.0:
        return np.inf
    if third > 0.0:
        return -(third + sqrt(rest)) / fourth if fourth < 0.0 else np.inf
    if sqrt(rest) - third > 0.0:
        return 2.0 * bend / (sqrt(rest) - third)
    return 0.0 if fourth < 0.0 else np.inf


@inner_njit(cache=True, error_model="numpy")
def fresh_curve(derivatives):  # type: ignore[no-untyped-def]
    """Fresh separation across a slice from its value and derivatives at the line."""
    bend, third, fourth = max(derivatives[2], 0.0), derivatives[3], derivatives[4]
    below, above = -_convex_within(bend, -third, fourth), _convex_within(bend, third, fourth)
    return FreshCurve(derivatives[0], derivatives[1], bend, third, fourth, below, above)


@inner_njit(cache=True, error_model="numpy")
def fresh_on(curve, distance):  # type: ignore[no-untyped-def]
    """Fresh separation at a distance in profile coordinates from the line.

    The separation is convex. Its polynomial need not be, far out on one side, and could fall there without limit:
    beyond the point of zero curvature the separation is continued linearly.
    """
    d = min(max(distance, curve.below), curve.above)
    slope = curve.slope + d * (curve.bend + d * (0.5 * curve.third + d * curve.fourth / 6.0))
    rise = d * (curve.slope + d * (0.5 * curve.bend + d * (curve.third / 6.0 + d * curve.fourth / 24.0)))
    return curve.least + rise + (distance - d) * slope


@inner_njit(cache=True, error_model="numpy")
def fresh_gap(distance, derivatives):  # type: ignore[no-untyped-def]
    """Fresh separation at a distance from the line, from its derivatives there: `fresh_on`."""
    return fresh_on(fresh_curve(derivatives), distance)


@inner_njit(cache=True, error_model="numpy")
def fresh_slope(distance, derivatives):  # type: ignore[no-untyped-def]
    """Derivative of `fresh_gap`."""
    curve = fresh_curve(derivatives)
    d = min(max(distance, curve.below), curve.above)
    return curve.slope + d * (curve.bend + d * (0.5 * curve.third + d * curve.fourth / 6.0))


@inner_njit(cache=True, error_model="numpy")
def removed_at(gap, place):  # type: ignore[no-untyped-def]
    """Material removed from both flanks at a profile coordinate."""
    cell, x = locate(gap.nodes, gap.split, place)
    return smooth_value(gap.removed, gap.nodes, gap.split, cell, x)


@inner_njit(cache=True, error_model="numpy")
def gap_at(gap, place):  # type: ignore[no-untyped-def]
    """Gap at a profile coordinate between the borders."""
    return fresh_gap(place - gap.at, gap.derivatives) + removed_at(gap, place)


@inner_njit(cache=True, error_model="numpy")
def _tangent(gap, direction):  # type: ignore[no-untyped-def]
    """Fresh separation at the lower (-1) or upper border, and its slope outwards per mm."""
    border = gap.low if direction < 0.0 else gap.high
    slope = direction * fresh_slope(border - gap.at, gap.derivatives) / gap.per_mm
    return fresh_gap(border - gap.at, gap.derivatives), slope


@inner_njit(cache=True, error_model="numpy")
def _beyond(beyond, fresh, slope, radius):  # type: ignore[no-untyped-def]
    """Fresh separation on a rounded edge beyond its border, where the flank's tangent turns off along an arc."""
    return fresh + slope * beyond + radius - sqrt(max(radius * radius - beyond * beyond, 0.0))


@inner_njit(cache=True, error_model="numpy")
def fresh_at(gap, place):  # type: ignore[no-untyped-def]
    """Fresh separation at a place between the borders or on a rounded edge; infinite beyond the edge itself."""
    if gap.low <= place <= gap.high:
        return fresh_gap(place - gap.at, gap.derivatives)
    direction = -1.0 if place < gap.low else 1.0
    border, radius = (gap.low, gap.low_radius) if direction < 0.0 else (gap.high, gap.high_radius)
    beyond = direction * (place - border) * gap.per_mm
    if beyond >= radius:
        return np.inf
    fresh, slope = _tangent(gap, direction)
    return _beyond(beyond, fresh, slope, radius)


@inner_njit(cache=True, error_model="numpy")
def _reach_on_edge(height, slope, radius):  # type: ignore[no-untyped-def]
    """How far beyond a border a rounded edge has opened by a height; its radius at most."""
    if height >= radius * (1.0 + slope):
        return radius
    steep, rest = 1.0 + slope * slope, radius - height
    return (sqrt(max(steep * radius * radius - rest * rest, 0.0)) - slope * rest) / steep


@inner_njit(cache=True, error_model="numpy")
def add_arc(gap, direction, depth, u, g, count):  # type: ignore[no-untyped-def]
    """Append points of a rounded edge to the outline, in the order of their profile coordinates.

    Where the edge is the other body's, the flank continues beyond it: the rounding presses on the wall of the groove
    that the edge has worn.
    """
    border, radius = (gap.low, gap.low_radius) if direction < 0.0 else (gap.high, gap.high_radius)
    nodes, per_mm = gap.nodes, gap.per_mm
    fresh, slope = _tangent(gap, direction)
    here = removed_at(gap, border)
    rises = 0.0
    cell = locate(nodes, gap.split, border)[0]
    p = cell if direction < 0.0 else cell + 1
    while 0 <= p < nodes.shape[0] and abs(nodes[p] - border) * per_mm < radius:
        rises = max(rises, here - gap.removed[p])
        p += 1 if direction > 0.0 else -1
    reach = _reach_on_edge(depth + rises, slope, radius)
    known, start, end, slope_a, slope_b = -1, 0.0, 0.0, 0.0, 0.0
    for n in range(_ARC_NODES):
        # outwards from an upper border, inwards to a lower one
        x = reach * (n + 1 if direction > 0.0 else _ARC_NODES - n) / _ARC_NODES
        place = border + direction * x / per_mm
        cell, inside = locate(nodes, gap.split, place)
        if cell != known:
            known, start, end = cell, gap.removed[cell], gap.removed[cell + 1]
            slope_a, slope_b = slopes_of_cell(gap.removed, nodes, gap.split, cell)
        u[count] = place
        g[count] = _beyond(x, fresh, slope, radius) + cubic(start, end, slope_a, slope_b, inside)
        count += 1
    return count


@inner_njit(cache=True, error_model="numpy")
def reaches_ends(gap, first, last):  # type: ignore[no-untyped-def]
    """Whether nodes between two of them reach the lower and the upper end of a slice, with its rounding."""
    low, high = gap.low - gap.low_radius / gap.per_mm, gap.high + gap.high_radius / gap.per_mm
    return first == 0 or gap.nodes[first] <= low, last == gap.nodes.shape[0] - 1 or gap.nodes[last] >= high


@inner_njit(cache=True, error_model="numpy")
def rises_within(height, bend):  # type: ignore[no-untyped-def]
    """Distance within which a fresh gap of this bend rises by a height: infinite where it is flat."""
    return sqrt(2.0 * height / bend) if bend > 0.0 else np.inf


@inner_njit(cache=True, error_model="numpy")
def most_places(nodes):  # type: ignore[no-untyped-def]
    """Size of arrays for the outline of a slice of these nodes."""
    return nodes.shape[1] + ON_EDGES


@inner_njit(cache=True, error_model="numpy")
def _at_nodes(gap, curve, first, end, u, g, count):  # type: ignore[no-untyped-def]
    """Append nodes to the outline."""
    nodes, removed, at = gap.nodes, gap.removed, gap.at
    for p in range(first, end):
        u[count + p - first] = nodes[p]
        g[count + p - first] = fresh_on(curve, nodes[p] - at) + removed[p]
    return count + end - first


@inner_njit(cache=True, error_model="numpy", fastmath=True)
def lowest(values, count):  # type: ignore[no-untyped-def]
    """Least of the first finite values."""
    least = values[0]
    for c in range(1, count):
        least = min(least, values[c])
    return least


@inner_njit(cache=True, error_model="numpy", fastmath=True)
def varies_by(values):  # type: ignore[no-untyped-def]
    """Greatest less least of finite values."""
    least = greatest = values[0]
    for value in values:
        least = min(least, value)
        greatest = max(greatest, value)
    return greatest - least


@inner_njit(cache=True, error_model="numpy")
def outline(gap, start, stop, depth, u, g):  # type: ignore[no-untyped-def]
    """Points (profile, gap) of a slice between start and stop, with the arcs of edges there; returns their number."""
    low, high, nodes = gap.low, gap.high, gap.nodes
    start, stop, same = max(low, min(start, high)), min(high, max(stop, low)), _SAME * (high - low)
    count = ZERO
    if start <= low and gap.low_radius > 0.0:
        count = add_arc(gap, -1.0, depth, u, g, count)
    p = first_from(nodes, start)
    if start > low and p > 0 and nodes[p - 1] > low + same:
        # from a node, which needs no interpolation
        p -= 1
    else:
        u[count] = start
        g[count] = gap_at(gap, start)
        count += 1
        if p < nodes.shape[0] and nodes[p] <= start:
            p += 1
    curve = fresh_curve(gap.derivatives)
    end = max(first_from(nodes, stop), p)
    if end < nodes.shape[0] and nodes[end] < high - same and stop < high:
        # to a node, for the same reason
        count = _at_nodes(gap, curve, p, end + 1, u, g, count)
    else:
        count = _at_nodes(gap, curve, p, end, u, g, count)
        if count == 0 or stop > u[count - 1]:
            u[count] = stop
            g[count] = gap_at(gap, stop)
            count += 1
    if stop >= high and gap.high_radius > 0.0:
        count = add_arc(gap, 1.0, depth, u, g, count)
    return count

"""How a slice shares its load between an edge that presses and the valley beyond the ridge in between.

Two Hertz contacts in one half-plane, far enough from each other: each closes its own gap, and each lowers the other's
ground by Flamant's logarithm (Johnson 1985, eq. 2.25). With b_j^2 = 4 q_j/(pi E* kappa_j) and their distance s

    g_2 - g_1 = 1/(pi E*) [q_1 (2 ln(s/b_1) + 1) - q_2 (2 ln(s/b_2) + 1)],   q_1 + q_2 = q.

The gap that decides is some five times what either contact closes by itself.
"""

from __future__ import annotations

from math import log, pi, sqrt

from semiwear.arrays import FloatArray
from semiwear.contact.footprint import CLOSED, open_part, root_of, segment
from semiwear.kernel_cache import njit

__all__ = ["closed_alone", "highest_that_bears", "share_of_edge"]

_HALVINGS = 12
_FAR = 8.0  # times what a Hertz contact closes by itself: then only the nearer one touches
_LEAST = 1e-9  # of a load, what a contact that just lifts off bears


def closed_alone(line_load: FloatArray, modulus: float) -> FloatArray:
    """Gap that a Hertz contact under a line load [N/mm] closes, 2 q/(pi E*) [mm]."""
    return 2.0 / (pi * modulus) * line_load


@njit(cache=True, error_model="numpy")
def highest_that_bears(least, depth, closes):  # type: ignore[no-untyped-def]
    """Gap beyond which nothing bears beside an edge or a valley at the least gap.

    One that shares their load may lie by what decides higher, and its own footprint reaches up from there.
    """
    return least + CLOSED * depth + (1.0 + _FAR) * closes


@njit(cache=True, error_model="numpy")
def _curvature(u, g, count, bottom, depth, per_mm):  # type: ignore[no-untyped-def]
    """Curvature of the parabola that has the same footprint of some depth as the gap around a point."""
    least = g[bottom]
    area = 0.0
    for step in (1, -1):
        c, end = bottom, count - 1 if step > 0 else 0
        while c != end and g[c] - least < depth:
            a, b = depth - (g[c] - least), depth - (g[c + step] - least)
            _, width = open_part(u[c], abs(u[c + step] - u[c]), a, b)
            area += segment(width, root_of(a), root_of(b))[0]
            c += step
    return 0.5 * (pi * depth / max(area * per_mm, _LEAST * depth * sqrt(depth))) ** 2


@njit(cache=True, error_model="numpy")
def _closed(share, curvature, closes, distance):  # type: ignore[no-untyped-def]
    """Gap that a contact with a share of the load closes, the other one as datum."""
    share = max(share, _LEAST)
    half_width = sqrt(2.0 * closes * share / curvature)
    return 0.5 * closes * share * (2.0 * log(distance / half_width) + 1.0)


@njit(cache=True, error_model="numpy")
def _share_under(higher, curvature, other, closes, distance):  # type: ignore[no-untyped-def]
    """Share of a load that the contact of the first curvature bears where the other one's ground is so much higher."""
    below, above = 0.0, 1.0
    short = higher - (_closed(0.0, curvature, closes, distance) - _closed(1.0, other, closes, distance))
    over = _closed(1.0, curvature, closes, distance) - _closed(0.0, other, closes, distance) - higher
    if short <= 0.0:
        return 0.0
    if over <= 0.0:
        return 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (below + above)
        differ = _closed(share, curvature, closes, distance) - _closed(1.0 - share, other, closes, distance)
        if differ < higher:
            below, short = share, higher - differ
        else:
            above, over = share, differ - higher
    # straight in between: a share in steps would make a jump of a rounding error
    return below + short / (short + over) * (above - below)


@njit(cache=True, error_model="numpy")
def _turning_place(u, g, count, c):  # type: ignore[no-untyped-def]
    """Place where the gap turns about a point: by the parabola through it and the points beside it.

    It moves on evenly where the next point becomes the highest or the lowest one.
    """
    if c == 0 or c == count - 1:
        return u[c]
    before, after = u[c] - u[c - 1], u[c + 1] - u[c]
    rises = (g[c] - g[c - 1]) / before
    bend = ((g[c + 1] - g[c]) / after - rises) / (before + after)
    away = -0.5 * (rises / bend + before) if bend != 0.0 else 0.0
    return u[c] + min(max(away, -0.5 * before), 0.5 * after)


@njit(cache=True, error_model="numpy")
def share_of_edge(u, g, count, low, high, per_mm, depth, closes):  # type: ignore[no-untyped-def]
    """Share of a slice's load that an edge bears.

    Parameters
    ----------
    u, g : arrays [mm]
        Outline of the slice: profile coordinate and gap.
    count : int
        Points of it.
    low, high : float [mm]
        Ends of the slice; beyond them lies the rounding of an edge.
    per_mm : float
        Distance across the line per profile coordinate.
    depth : float [mm]
        Of the footprint.
    closes : float [mm]
        Gap that a Hertz contact under the line load closes, 2 q/(pi E*).

    Returns
    -------
    edge : int
        -1 for the lower, 1 for the upper end; 0 where no edge presses.
    ridge : float [mm]
        Profile coordinate of the ridge between the edge and the valley.
    share : float
        Of the load, that the edge bears.
    apart : float
        0 where edge and valley are one contact, 1 where the ridge between them is higher than what is closed.
    """
    if count < 3 or closes <= 0.0:
        return 0, 0.0, 0.0, 0.0
    highest = highest_that_bears(g[:count].min(), depth, closes)
    for edge in (-1, 1):
        # from the edge into the slice
        first, step = (0, 1) if edge < 0 else (count - 1, -1)
        if (low - u[first] if edge < 0 else u[first] - high) <= 0.0:
            continue
        foot, c = first, first
        while 0 <= c < count and (u[c] <= low if edge < 0 else u[c] >= high):
            if g[c] < g[foot]:
                foot = c
            c += step
        if g[foot] > highest:
            continue
        # the valley is where the gap has fallen most from the ridge before it
        valley, ridge, top, fall, c = -1, foot, foot, 0.0, foot
        while 0 <= c < count:
            if g[c] > g[top]:
                top = c
            falls = min(g[top], highest) - min(g[c], highest)
            if (u[c] > low if edge < 0 else u[c] < high) and falls > fall:
                valley, ridge, fall = c, top, falls
            c += step
        if valley < 0 or ridge == foot:
            continue
        height = g[ridge] - max(g[foot], g[valley])
        if height <= 0.0:
            continue
        higher, at = g[valley] - g[foot], _turning_place(u, g, count, ridge)
        if abs(higher) > _FAR * closes:
            return edge, at, 1.0 if higher > 0.0 else 0.0, min(height / closes, 1.0)
        distance = abs(_turning_place(u, g, count, valley) - _turning_place(u, g, count, foot)) * per_mm
        curvature = _curvature(u, g, count, foot, min(closes, g[ridge] - g[foot]), per_mm)
        other = _curvature(u, g, count, valley, min(closes, g[ridge] - g[valley]), per_mm)
        return edge, at, _share_under(higher, curvature, other, closes, distance), min(height / closes, 1.0)
    return 0, 0.0, 0.0, 0.0

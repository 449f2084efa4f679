"""How a slice shares its load between an edge that presses and the valley beyond the ridge in between.

Two Hertz contacts in one half-plane, far enough from each other: each closes its own gap, and each lowers the other's
ground by Flamant's logarithm (Johnson 1985, eq. 2.25). With b_j^2 = 4 q_j/(pi E* kappa_j) and their distance s

    g_2 - g_1 = 1/(pi E*) [q_1 (2 ln(s/b_1) + 1) - q_2 (2 ln(s/b_2) + 1)],   q_1 + q_2 = q.

The gap that decides is some five times what either contact closes by itself.

While flanks wear in cycles, shares found from the gap alone swing to and fro where a cycle takes more off an edge
than twice what contact closes, which is a micrometre or less. They foresee the middle of the cycle to come: with the
shares s' and 1 - s' in the one before and the wear w_1 and w_2 under all of the load, the gap that decides is

    g_2 - g_1 + [w_2 (1 - s) - w_1 s]/2 - a [w_2 (1 - s') - w_1 s']/2.

a = 1 would leave out what goes on evenly, and let shares swing by inertia; a = 0 would run ahead of the wear.
"""

from __future__ import annotations

from math import log, pi, sqrt

from semiwear.arrays import FloatArray
from semiwear.contact.footprint import CLOSED, open_part, root_of, segment
from semiwear.contact.gap import lowest
from semiwear.kernel_cache import inner_njit

__all__ = ["closed_alone", "highest_that_bears", "share_of_edge"]

_STEADY = 0.75  # a: fitted to the main job with both flanks worn, where some shares swing with 0.5 and with 1
_HALVINGS = 12
_FAR = 8.0  # times what a Hertz contact closes by itself: then only the nearer one touches
_SMALL = 1e-3  # of a load: what less of it wears says little of what all of it would
_LEAST = 1e-9  # of a load, what a contact that just lifts off bears


def closed_alone(line_load: FloatArray, modulus: float) -> FloatArray:
    """Gap that a Hertz contact under a line load [N/mm] closes, 2 q/(pi E*) [mm]."""
    return 2.0 / (pi * modulus) * line_load


@inner_njit(cache=True, error_model="numpy")
def highest_that_bears(least, depth, closes):  # type: ignore[no-untyped-def]
    """Gap beyond which nothing bears beside an edge or a valley at the least gap.

    One that shares their load may lie by what decides higher, and its own footprint reaches up from there.
    """
    return least + CLOSED * depth + (1.0 + _FAR) * closes


@inner_njit(cache=True, error_model="numpy")
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


@inner_njit(cache=True, error_model="numpy")
def _closed(share, curvature, closes, distance):  # type: ignore[no-untyped-def]
    """Gap that a contact with a share of the load closes, the other one as datum."""
    share = max(share, _LEAST)
    half_width = sqrt(2.0 * closes * share / curvature)
    return 0.5 * closes * share * (2.0 * log(distance / half_width) + 1.0)


@inner_njit(cache=True, error_model="numpy")
def _share_under(higher, curvature, other, closes, distance, wears):  # type: ignore[no-untyped-def]
    """Share of a load that the contact of the first curvature bears where the other one's ground is so much higher.

    With all of the load `wears` is closed more than with none, besides what contact closes.
    """
    below, above = 0.0, 1.0
    short = higher - (_closed(0.0, curvature, closes, distance) - _closed(1.0, other, closes, distance))
    over = wears + _closed(1.0, curvature, closes, distance) - _closed(0.0, other, closes, distance) - higher
    if short <= 0.0:
        return 0.0
    if over <= 0.0:
        return 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (below + above)
        differ = _closed(share, curvature, closes, distance) - _closed(1.0 - share, other, closes, distance)
        differ += wears * share
        if differ < higher:
            below, short = share, higher - differ
        else:
            above, over = share, differ - higher
    # straight in between: a share in steps would make a jump of a rounding error
    return below + short / (short + over) * (above - below)


@inner_njit(cache=True, error_model="numpy")
def _foreseen(foot, valley, before, most):  # type: ignore[no-untyped-def]
    """Change of the gap that decides until the middle of a cycle, where an edge bears nothing; less it where all."""
    known = before[3]
    if known == 0.0:
        return 0.0, 0.0
    off_edge = min(max(foot - before[1], 0.0) / max(before[0], _SMALL), most)
    off_valley = min(max(valley - before[2], 0.0) / max(1.0 - before[0], _SMALL), most)
    both = off_edge + off_valley
    steady = off_valley - both * before[0]
    return 0.5 * known * (off_valley - _STEADY * steady), 0.5 * known * both


@inner_njit(cache=True, error_model="numpy")
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


@inner_njit(cache=True, error_model="numpy")
def _foot(u, g, count, border, edge):  # type: ignore[no-untyped-def]
    """Lowest point of the outline beyond a border, on the rounding of the lower (-1) or upper edge; -1 for none."""
    c, step = (0, 1) if edge < 0 else (count - 1, -1)
    if (border - u[c]) * step <= 0.0:
        return -1
    foot = c
    while 0 <= c < count and (border - u[c]) * step >= 0.0:
        if g[c] < g[foot]:
            foot = c
        c += step
    return foot


@inner_njit(cache=True, error_model="numpy")
def _ridge_and_valley(u, g, count, border, edge, foot, highest):  # type: ignore[no-untyped-def]
    """Points of the outline inside a border: where the gap has fallen most from the ridge before it; -1 for none."""
    step = 1 if edge < 0 else -1
    valley, ridge, top, fall, c = -1, foot, foot, 0.0, foot
    while 0 <= c < count:
        if g[c] > g[top]:
            top = c
        falls = min(g[top], highest) - min(g[c], highest)
        if (border - u[c]) * step < 0.0 and falls > fall:
            valley, ridge, fall = c, top, falls
        c += step
    return ridge, valley if ridge != foot else -1


@inner_njit(cache=True, error_model="numpy")
def share_of_edge(u, g, count, low, high, per_mm, depth, closes, before, most):  # type: ignore[no-untyped-def]
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
    before : (4,) array, changed
        Share of the edge, gap at its lowest point and gap of the valley [mm] in the cycle before, and how far they
        count: 0 where no edge pressed, 1 where edge and valley were two contacts.
    most : float [mm]
        Wear of a cycle at most.

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
    if count < 3 or closes <= 0.0 or (u[0] >= low and u[count - 1] <= high):
        before[3] = 0.0
        return 0, 0.0, 0.0, 0.0
    highest = highest_that_bears(lowest(g, count), depth, closes)
    for edge in (-1, 1):
        border = low if edge < 0 else high
        foot = _foot(u, g, count, border, edge)
        if foot < 0 or g[foot] > highest:
            continue
        ridge, valley = _ridge_and_valley(u, g, count, border, edge, foot, highest)
        if valley < 0:
            continue
        height = g[ridge] - max(g[foot], g[valley])
        if height <= 0.0:
            continue
        higher, at = g[valley] - g[foot], _turning_place(u, g, count, ridge)
        change, wears = _foreseen(g[foot], g[valley], before, most)
        higher += change
        before[1], before[2] = g[foot], g[valley]
        apart = min(height / closes, 1.0)
        before[3] = min(apart, (highest - g[foot]) / closes)  # an edge comes to press by and by
        if higher < -_FAR * closes or higher > _FAR * closes + wears:
            before[0] = 1.0 if higher > 0.0 else 0.0
            return edge, at, before[0], apart
        distance = abs(_turning_place(u, g, count, valley) - _turning_place(u, g, count, foot)) * per_mm
        curvature = _curvature(u, g, count, foot, min(closes, g[ridge] - g[foot]), per_mm)
        other = _curvature(u, g, count, valley, min(closes, g[ridge] - g[valley]), per_mm)
        before[0] = _share_under(higher, curvature, other, closes, distance, wears)
        return edge, at, before[0], apart
    before[3] = 0.0
    return 0, 0.0, 0.0, 0.0

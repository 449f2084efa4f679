"""Load sharing of a slice between an edge in contact and the valley beyond the ridge in between.

Two Hertz contacts in one half-plane, far enough from each other: each closes its own gap, and each lowers the surface
at the other by Flamant's logarithm (Johnson 1985, eq. 2.25). With b_j^2 = 4 q_j/(pi E* kappa_j) and their distance s

    g_2 - g_1 = 1/(pi E*) [q_1 (2 ln(s/b_1) + 1) - q_2 (2 ln(s/b_2) + 1)],   q_1 + q_2 = q.

Differences g_2 - g_1 up to some five times what either contact closes by itself matter. Position and curvature of a
contact are those of its whole footprint: that of the edge ends at the highest ridge between it and the valley, where
that of the valley begins. Between two ridges of nearly equal height the gap belongs to both, and of two valleys of
nearly equal depth both count, so that a rounding error does not choose one of them.

While flanks wear in cycles, shares found from the gap alone oscillate if a cycle removes more from an edge than twice
what contact closes, which is a micrometre or less. They are found for the middle of the coming cycle: with the shares
s' and 1 - s' in the one before and the wear w_1 and w_2 under all of the load, the gap difference is

    g_2 - g_1 + [w_2 (1 - s) - w_1 s]/2 - a [w_2 (1 - s') - w_1 s']/2.

a = 1 would leave out steady wear, and let shares oscillate; a = 0 would overestimate the wear.
"""

from __future__ import annotations

from math import inf, log, pi

from semiwear.arrays import FloatArray
from semiwear.contact.footprint import CLOSED, centred_segment, open_part, root_of
from semiwear.contact.gap import lowest
from semiwear.kernel_cache import inner_njit

_STEADY = 0.75  # a: fitted to the main job with both flanks worn, where some shares oscillate with 0.5 and with 1
_HALVINGS = 12
_FAR = 8.0  # times what a Hertz contact closes by itself: beyond, only the nearer one touches
_SMALL = 1e-3  # of a load: wear under less of it is no measure of the wear under all of it
_EVEN = 0.2  # of what contact closes, or of a lower ridge: two ridges or valleys that differ by less both count
_LEAST = 1e-9  # of a load, on a contact that just lifts off


def closed_alone(line_load: FloatArray, modulus: float) -> FloatArray:
    """Gap that a Hertz contact under a line load [N/mm] closes, 2 q/(pi E*) [mm]."""
    return 2.0 / (pi * modulus) * line_load


@inner_njit(cache=True, error_model="numpy")
def highest_that_bears(least, depth, closes):  # type: ignore[no-untyped-def]
    """Greatest gap that can carry load beside an edge or a valley at the least gap.

    A contact that shares their load may lie higher by `_FAR`, and its own footprint reaches up from there.
    """
    return least + CLOSED * depth + (1.0 + _FAR) * closes


@inner_njit(cache=True, error_model="numpy")
def part_of(side, c):  # type: ignore[no-untyped-def]
    """Fraction of the stretch from a point of the outline to the next that belongs to the edge, or to the valley."""
    return 0.5 * (side[c] + side[c + 1])


@inner_njit(cache=True, error_model="numpy")
def lowest_of(side, g, count, lift):  # type: ignore[no-untyped-def]
    """Least gap of an edge, or of a valley; points that belong to both are raised by up to `lift`."""
    least = inf
    for c in range(count):
        if side[c] > 0.0:
            least = min(least, g[c] + (1.0 - side[c]) * lift)
    return least


@inner_njit(cache=True, error_model="numpy")
def _contact(u, g, count, side, least, depth, per_mm):  # type: ignore[no-untyped-def]
    """Curvature of the parabola with the same footprint of some depth as an edge or a valley, and its middle."""
    area, moment = 0.0, 0.0
    for c in range(count - 1):
        part, a, b = part_of(side, c), depth - (g[c] - least), depth - (g[c + 1] - least)
        if part > 0.0 and (a > 0.0 or b > 0.0):
            begin, width = open_part(u[c], u[c + 1] - u[c], a, b)
            mass, middle = centred_segment(begin, width, root_of(a), root_of(b))
            area += part * mass
            moment += part * mass * middle
    return 0.5 * (pi * depth / (area * per_mm)) ** 2, moment / area


@inner_njit(cache=True, error_model="numpy")
def _closed(share, far, closes):  # type: ignore[no-untyped-def]
    """Gap closed by a contact with a share of the load, relative to the other contact.

    `far` is 2 ln(s/b) with all of the load. Where contacts are not far from each other the formula would let a
    greater share close less.
    """
    share = max(share, _LEAST)
    return 0.5 * closes * share * (max(far - log(share), 0.0) + 1.0)


@inner_njit(cache=True, error_model="numpy")
def _share_under(higher, curvature, other, closes, distance, wears):  # type: ignore[no-untyped-def]
    """Share of a load on the contact of the first curvature, whose gap is less than the other's by `higher`.

    Under all of the load, wear adds `wears` to what the contact closes.
    """
    per = distance * distance / (2.0 * closes)
    far, other_far = log(per * curvature), log(per * other)
    below, above = 0.0, 1.0
    short = higher - (_closed(0.0, far, closes) - _closed(1.0, other_far, closes))
    over = wears + _closed(1.0, far, closes) - _closed(0.0, other_far, closes) - higher
    if short <= 0.0:
        return 0.0
    if over <= 0.0:
        return 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (below + above)
        differ = _closed(share, far, closes) - _closed(1.0 - share, other_far, closes) + wears * share
        if differ < higher:
            below, short = share, higher - differ
        else:
            above, over = share, differ - higher
    # linear in between: a share in steps would turn a rounding error into a jump
    return below + short / (short + over) * (above - below)


@inner_njit(cache=True, error_model="numpy")
def _foreseen(foot, valley, before, most):  # type: ignore[no-untyped-def]
    """Change of the gap difference up to mid-cycle with an unloaded edge, and its decrease with all load on it."""
    known = before[3]
    if known == 0.0:
        return 0.0, 0.0
    off_edge = min(max(foot - before[1], 0.0) / max(before[0], _SMALL), most)
    off_valley = min(max(valley - before[2], 0.0) / max(1.0 - before[0], _SMALL), most)
    both = off_edge + off_valley
    steady = off_valley - both * before[0]
    return 0.5 * known * (off_valley - _STEADY * steady), 0.5 * known * both


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
def _valley(u, g, count, border, edge, foot, highest, top):  # type: ignore[no-untyped-def]
    """Point inside a border to which the gap falls most from the ridge between it and the foot; -1 for none.

    `top` receives the height of the ridge before every point.
    """
    step = 1 if edge < 0 else -1
    valley, most, ridge, c = -1, 0.0, g[foot], foot
    while 0 <= c < count:
        ridge = max(ridge, g[c])
        top[c] = ridge
        falls = min(ridge, highest) - min(g[c], highest)
        if (border - u[c]) * step < 0.0 and falls > most:
            valley, most = c, falls
        c += step
    return valley


@inner_njit(cache=True, error_model="numpy")
def _other_valley(u, g, count, border, edge, foot, highest, closes, top, valley):  # type: ignore[no-untyped-def]
    """Point to which the gap falls by nearly as much beyond another ridge, and its weight: at most a half."""
    most, other, counts = min(top[valley], highest) - min(g[valley], highest), -1, 0.0
    even = _EVEN * min(most, closes)
    for step in (-1, 1):
        ridge, c = g[valley], valley
        while 0 <= c < count and (border - u[c]) * edge > 0.0:
            ridge = max(ridge, g[c])
            falls = min(top[c], highest) - min(g[c], highest)
            divided = min(1.0 - (min(top[valley], top[c]) - ridge) / even, 1.0)
            part = divided * max(0.5 - 0.5 * (most - falls) / even, 0.0)
            if part > counts:
                other, counts = c, part
            c += step
    return other, counts


@inner_njit(cache=True, error_model="numpy")
def _parted(u, g, count, border, edge, foot, highest, closes, side):  # type: ignore[no-untyped-def]
    """Height of the ridge between an edge and the valley to which the gap falls most; 0 where there is none.

    Of two valleys to which it falls by nearly as much both count.
    """
    top = side[1]
    valley = _valley(u, g, count, border, edge, foot, highest, top)
    if valley < 0:
        return 0.0
    other, counts = _other_valley(u, g, count, border, edge, foot, highest, closes, top, valley)
    height, beyond = top[valley] - max(g[foot], g[valley]), 0.0
    if other >= 0:
        beyond = top[other] - max(g[foot], g[other])
        if height <= 0.0:
            # before the first ridge all is one contact
            valley, other, height, beyond, counts = other, valley, beyond, height, 1.0 - counts
    if height <= 0.0:
        return 0.0
    _divide(g, count, edge, foot, valley, _EVEN * min(height, closes), side[0])
    if beyond > 0.0:
        _divide(g, count, edge, foot, other, _EVEN * min(beyond, closes), side[1])
        for c in range(count):
            side[0, c] += counts * (side[1, c] - side[0, c])
    return height + counts * (beyond - height)


@inner_njit(cache=True, error_model="numpy")
def _divide(g, count, edge, foot, valley, even, side):  # type: ignore[no-untyped-def]
    """Fraction by which each point of the outline belongs to the edge, from the ridges towards foot and valley.

    The higher ridge divides. Points between two ridges that differ by less than `even` belong to both, so that
    nothing jumps when another ridge becomes the highest one.
    """
    step = 1 if edge < 0 else -1
    for c in range(count):
        side[c] = 1.0 if (c - foot) * step <= 0 else 0.0
    ridge = g[foot]
    for c in range(foot, valley, step):
        ridge = max(ridge, g[c])
        side[c] = ridge
    ridge = g[valley]
    for c in range(valley - step, foot, -step):
        ridge = max(ridge, g[c])
        side[c] = min(max(0.5 + 0.5 * (ridge - side[c]) / even, 0.0), 1.0)
    side[foot] = 1.0


@inner_njit(cache=True, error_model="numpy")
def share_of_edge(u, g, count, low, high, per_mm, depth, closes, before, most, side):  # type: ignore[no-untyped-def]
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
        Share of the edge, gap at its lowest point and gap of the valley [mm] in the cycle before, and their weight:
        0 where no edge was in contact, 1 where edge and valley were two contacts.
    most : float [mm]
        Greatest wear of a cycle.
    side : (2, points) array, changed
        Fractions by which each outline point belongs to the edge and to the valley; set if an edge is pressed.

    Returns
    -------
    edge : int
        -1 for the lower, 1 for the upper end; 0 where no edge presses.
    share : float
        Of the load, that the edge bears.
    apart : float
        0 where edge and valley are one contact, 1 where the ridge between them is higher than the gap that is closed.
    """
    if count < 3 or closes <= 0.0 or (u[0] >= low and u[count - 1] <= high):
        before[3] = 0.0
        return 0, 0.0, 0.0
    lift = highest_that_bears(0.0, depth, closes)
    highest = lowest(g, count) + lift
    for edge in (-1, 1):
        border = low if edge < 0 else high
        foot = _foot(u, g, count, border, edge)
        if foot < 0 or g[foot] > highest:
            continue
        height = _parted(u, g, count, border, edge, foot, highest, closes, side)
        if height <= 0.0:
            continue
        for c in range(count):
            side[1, c] = 1.0 - side[0, c]
        bottom, valley = lowest_of(side[0], g, count, lift), lowest_of(side[1], g, count, lift)
        change, wears = _foreseen(bottom, valley, before, most)
        higher = valley - bottom + change
        before[1], before[2] = bottom, valley
        apart = min(height / closes, 1.0)
        before[3] = min(apart, (highest - g[foot]) / closes)  # an edge comes into contact gradually
        if higher < -_FAR * closes or higher > _FAR * closes + wears:
            before[0] = 1.0 if higher > 0.0 else 0.0
            return edge, before[0], apart
        ridge = height + max(valley, g[foot])
        own, at = _contact(u, g, count, side[0], bottom, min(closes, ridge - bottom), per_mm)
        other, beyond = _contact(u, g, count, side[1], valley, min(closes, ridge - valley), per_mm)
        before[0] = _share_under(higher, own, other, closes, abs(beyond - at) * per_mm, wears)
        return edge, before[0], apart
    before[3] = 0.0
    return 0, 0.0, 0.0

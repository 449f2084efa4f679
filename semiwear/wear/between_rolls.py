"""Deposit of footprints between roll positions, on a flank's nodes, even where it should be.

A footprint stands for the step from half of one roll position to half of the next one, over which it moves on. Laid
evenly along that step it wears what it should to second order, but a ripple somewhat shorter than the step would be
worn deeper, since the transform of an even density is negative there. Laid as a triangle, two steps wide, no ripple
is, but all wear is smoothed. In between lies a trapezoid as wide as 1 + f steps, even over 1 - f of them: its
transform, sinc(l) sinc(f l) of steps l to a wavelength, is negative for wavelengths from f steps to one alone, and
smooths by f^2 of what the triangle does. Where nodes are too far apart to hold such ripples, f is as little as
a half.
"""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import ZERO, inner_njit
from semiwear.meshing.flank_grid import locate

__all__ = [
    "VALLEY",
    "lay",
    "lay_pieces",
    "lay_points",
    "lies_within",
    "node_width",
    "shifts_of",
    "span_of",
    "step_of",
]

VALLEY = 2  # stretches that lie beyond the ridge from a pressed edge, as `at_edge` marks them
_LEAST_STEP = 1e-6  # of a flank's height
_SHORT_STEP = 0.05  # of a cell: below it the differences of `lay_points` would lose digits
_ROUNDING = 1e-9  # of a stretch: it lies on the nodes where no more of it is missing there
_FADES = 0.5  # least f; half of the cells to a step where that is more, and 1 at most


@inner_njit(cache=True, error_model="numpy")
def step_of(place, rate, k):  # type: ignore[no-untyped-def]
    """How far a place moves in the step about a roll position."""
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    return (place[after] - place[before]) / max(after - before, 1)


@inner_njit(cache=True, error_model="numpy")
def _lay_straight(nodes, split, a, b, at_a, at_b, out):  # type: ignore[no-untyped-def]
    """Add a density that is straight from one place up to another one; returns how much of it lies on the nodes."""
    last = nodes.shape[0] - 1
    start, stop = max(a, nodes[0]), min(b, nodes[last])
    laid = 0.0
    if stop <= start:
        return laid
    slope = (at_b - at_a) / (b - a)
    cell, _ = locate(nodes, split, start)
    while cell < last and nodes[cell] < stop:
        begin, end = max(start, nodes[cell]), min(stop, nodes[cell + 1])
        width = nodes[cell + 1] - nodes[cell]
        first, second = at_a + slope * (begin - a), at_a + slope * (end - a)
        x, y = (begin - nodes[cell]) / width, (end - nodes[cell]) / width
        # exact for the product of two straight lines
        upper = (end - begin) / 6.0 * (first * x + (first + second) * (x + y) + second * y)
        out[cell] += 0.5 * (end - begin) * (first + second) - upper
        out[cell + 1] += upper
        laid += 0.5 * (end - begin) * (first + second)
        cell += 1
    return laid


@inner_njit(cache=True, error_model="numpy")
def span_of(nodes, step):  # type: ignore[no-untyped-def]
    """How far to either side of a place an amount is laid evenly, and how far in all, from a step either way."""
    last = nodes.shape[0] - 1
    step = max(abs(step), _LEAST_STEP * (nodes[last] - nodes[0]))
    cell = min(nodes[1] - nodes[0], nodes[last] - nodes[last - 1])
    fades = min(max(0.5 * step / cell, _FADES), 1.0)
    return 0.5 * (1.0 - fades) * step, 0.5 * (1.0 + fades) * step


@inner_njit(cache=True, error_model="numpy")
def _up_to(x, even, reach):  # type: ignore[no-untyped-def]
    """Amount of a trapezoid about zero up to a place, and the integral of that; both times (reach^2 - even^2)."""
    a, b = max(x + reach, 0.0), max(x + even, 0.0)
    c, d = max(x - even, 0.0), max(x - reach, 0.0)
    return 0.5 * (a * a - b * b - c * c + d * d), (a * a * a - b * b * b - c * c * c + d * d * d) / 6.0


@inner_njit(cache=True, error_model="numpy")
def lay(nodes, split, middle, step, amount, out):  # type: ignore[no-untyped-def]
    """Add to nodes an amount that is even about a place and fades out on either side.

    What lies beyond the last node wears no flank: the amount on the nodes is returned.
    """
    last = nodes.shape[0] - 1
    even, reach = span_of(nodes, step)
    if middle + reach <= nodes[0] or middle - reach >= nodes[last]:
        return 0.0
    p, _ = locate(nodes, split, middle - reach)
    height = amount / (reach + even)
    if reach < _SHORT_STEP * (nodes[p + 1] - nodes[p]):
        laid = _lay_straight(nodes, split, middle - reach, middle - even, 0.0, height, out)
        laid += _lay_straight(nodes, split, middle - even, middle + even, height, height, out)
        return laid + _lay_straight(nodes, split, middle + even, middle + reach, height, 0.0, out)
    # as in `lay_points`, with the amount below the first node taken off and no more than up to the last one
    steep = height / (reach - even)
    x = nodes[p] - middle
    first, before = _up_to(x, even, reach)
    first, before = steep * first, steep * before
    slope = first
    while p < last and x < reach:
        width = nodes[p + 1] - nodes[p]
        x += width
        value = steep * _up_to(x, even, reach)[1]
        after = (value - before) / width
        out[p] += max(after - slope, 0.0)
        before, slope, p = value, after, p + 1
    whole = steep * _up_to(x, even, reach)[0] if x < reach else amount
    out[p] += max(whole - slope, 0.0)
    return whole - first


@inner_njit(cache=True, error_model="numpy")
def lies_within(nodes, middle, count, step):  # type: ignore[no-untyped-def]
    """Whether amounts at rising places that fade out over a step lie on the nodes, as `lay_points` needs it."""
    last, reach = nodes.shape[0] - 1, span_of(nodes, step)[1]
    if count == 0 or reach < _SHORT_STEP * max(nodes[1] - nodes[0], nodes[last] - nodes[last - 1]):
        return False
    return middle[0] - reach > nodes[0] and middle[count - 1] + reach < nodes[last]


@inner_njit(cache=True, error_model="numpy")
def lay_points(nodes, split, middle, amount, count, step, out):  # type: ignore[no-untyped-def]
    """Add to nodes amounts at rising places that all move by one step, as `lay` does one by one.

    An amount m at u, even up to e and faded out at r, has the density m [(x-u+r)+ - (x-u+e)+ - (x-u-e)+ + (x-u-r)+]
    /(r^2 - e^2); a node takes the integral of its product with the hat function of the node, which is the second
    difference over the nodes of the density's double integral: that of the cubes over 6 (r^2 - e^2). Beyond u+r that
    is m (x-u), so that all amounts which have faded out come in by their sum and their moment. Returns the first node
    that takes something, and the one behind the last.
    """
    even, reach = span_of(nodes, step)
    origin, end = middle[0], middle[count - 1] + reach
    p = start = locate(nodes, split, middle[0] - reach)[0]
    first, total, moment = 0, 0.0, 0.0
    scale, before, slope = 1.0 / (6.0 * (reach + even) * (reach - even)), 0.0, 0.0
    while nodes[p] < end:
        x = nodes[p + 1]
        while first < count and middle[first] <= x - reach:
            total += amount[first]
            moment += amount[first] * (middle[first] - origin)
            first += 1
        value, c = total * (x - origin) - moment, first
        while c < count and middle[c] < x + reach:
            away = x - middle[c]
            rises, risen, falls = away + reach, max(away + even, 0.0), max(away - even, 0.0)
            value += scale * amount[c] * (rises * rises * rises - risen * risen * risen - falls * falls * falls)
            c += 1
        after = (value - before) / (x - nodes[p])
        out[p] += max(after - slope, 0.0)
        before, slope, p = value, after, p + 1
    out[p] += max(total - slope, 0.0)
    return start, p + 1


@inner_njit(cache=True, error_model="numpy")
def lay_pieces(nodes, split, middle, shift, amount, pieces, alike, out):  # type: ignore[no-untyped-def]
    """Add the stretches of a footprint to nodes, each faded out over its own step.

    `alike`: places rise, and all stretches move by one step. Returns the first node that takes something, the one
    behind the last, and what lies beyond the nodes.
    """
    if pieces == 0:
        return ZERO, ZERO, 0.0
    if alike and lies_within(nodes, middle, pieces, shift[0]):
        first, end = lay_points(nodes, split, middle, amount, pieces, shift[0], out)
        return first, end, 0.0
    lowest, highest, beyond = np.inf, -np.inf, 0.0
    for c in range(pieces):
        reach = span_of(nodes, shift[c])[1]
        lowest, highest = min(lowest, middle[c] - reach), max(highest, middle[c] + reach)
        missing = amount[c] - lay(nodes, split, middle[c], shift[c], amount[c], out)
        beyond += missing if missing > _ROUNDING * amount[c] else 0.0
    return locate(nodes, split, lowest)[0], locate(nodes, split, highest)[0] + 2, beyond


@inner_njit(cache=True, error_model="numpy")
def _share_held(distance, slack):  # type: ignore[no-untyped-def]
    """Part in which an end of the slice that is so near holds a footprint: all of one that it cuts off."""
    return min(max(1.0 - distance / slack, 0.0), 1.0)


@inner_njit(cache=True, error_model="numpy")
def shifts_of(middle, ends, at_edge, pieces, low, high, slack, moves, low_moves, high_moves, shift):  # type: ignore[no-untyped-def]
    """How far every stretch of a footprint moves in a roll step, from how far its centre and the slice's ends do.

    A footprint that an end of the slice cuts off stays at that end and is drawn out: nothing of it passes over the
    border. It comes to be held over a slack, and its own ends count, not the places of its last stretches: wear would
    jump as a stretch is added that weighs nothing. Returns whether all of them are one stretch that moves as a whole.
    """
    plain = pieces > 0 and at_edge[0] == 0 and at_edge[pieces - 1] == 0  # no edge presses, and places rise
    if plain and ends[0, 0] > low + slack and ends[pieces - 1, 1] < high - slack:
        shift[:pieces] = moves
        return True
    alike = pieces > 0 and at_edge[0] == at_edge[pieces - 1]
    for whole in (0, VALLEY):  # the valley by itself goes over into the whole footprint
        first, last = np.inf, -np.inf
        for c in range(pieces):
            if at_edge[c] == whole:
                first, last = min(first, ends[c, 0]), max(last, ends[c, 1])
        at_low, at_high = _share_held(first - low, slack), _share_held(high - last, slack)
        alike &= at_low == 0.0 and at_high == 0.0
        to_low, to_high = at_low * (low_moves - moves), at_high * (high_moves - moves)
        for c in range(pieces):
            if at_edge[c] == whole:
                shift[c] = moves + to_high * (1.0 - max(high - middle[c], 0.0) / max(high - first, slack))
                shift[c] += to_low * (1.0 - max(middle[c] - low, 0.0) / max(last - low, slack))
    for c in range(pieces):
        if at_edge[c] == -1:
            shift[c] = low_moves
            alike = False
        elif at_edge[c] == 1:
            shift[c] = high_moves
            alike = False
    return alike


@inner_njit(cache=True, error_model="numpy")
def node_width(nodes, p):  # type: ignore[no-untyped-def]
    """Width that a node stands for: half of the cells on either side."""
    left = nodes[p] - nodes[p - 1] if p > 0 else 0.0
    right = nodes[p + 1] - nodes[p] if p < nodes.shape[0] - 1 else 0.0
    return 0.5 * (left + right)

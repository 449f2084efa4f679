"""Deposit of footprints between roll positions, on a flank's nodes, even where it should be."""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import ZERO, njit
from semiwear.meshing.flank_grid import locate

__all__ = ["VALLEY", "lay", "lay_pieces", "lay_points", "lies_within", "node_width", "shifts_of", "step_of"]

VALLEY = 2  # stretches that lie beyond the ridge from a pressed edge, as `at_edge` marks them
_LEAST_STEP = 1e-6  # of a flank's height
_SHORT_STEP = 0.05  # of a cell: below it the differences of `lay_points` would lose digits


@njit(cache=True, error_model="numpy")
def step_of(place, rate, k):  # type: ignore[no-untyped-def]
    """How far a place moves in the step about a roll position."""
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    return (place[after] - place[before]) / max(after - before, 1)


@njit(cache=True, error_model="numpy")
def _lay_ramp(nodes, split, foot, top, height, out):  # type: ignore[no-untyped-def]
    """Add a density that rises straight from nothing at `foot` to `height` at `top`, on either side of it.

    Returns how much of it lies on the nodes.
    """
    last = nodes.shape[0] - 1
    start, stop = max(min(foot, top), nodes[0]), min(max(foot, top), nodes[last])
    laid = 0.0
    if stop <= start:
        return laid
    steep = height / (top - foot)
    cell, _ = locate(nodes, split, start)
    while cell < last and nodes[cell] < stop:
        begin, end = max(start, nodes[cell]), min(stop, nodes[cell + 1])
        width = nodes[cell + 1] - nodes[cell]
        a, b = steep * (begin - foot), steep * (end - foot)
        x, y = (begin - nodes[cell]) / width, (end - nodes[cell]) / width
        # exact for the product of two straight lines
        upper = (end - begin) / 6.0 * (a * x + (a + b) * (x + y) + b * y)
        out[cell] += 0.5 * (end - begin) * (a + b) - upper
        out[cell + 1] += upper
        laid += 0.5 * (end - begin) * (a + b)
        cell += 1
    return laid


@njit(cache=True, error_model="numpy")
def _reach_of(nodes, step):  # type: ignore[no-untyped-def]
    """How far an amount is laid to either side of its place."""
    return max(abs(step), _LEAST_STEP * (nodes[nodes.shape[0] - 1] - nodes[0]))


@njit(cache=True, error_model="numpy")
def lay(nodes, split, middle, step, amount, out):  # type: ignore[no-untyped-def]
    """Add to nodes an amount that fades out over a step to either side of a place.

    Footprints a roll step apart would leave ripples of that wavelength, so what they wear is straight in between.
    Laid evenly along a step, with its transform below zero, it would wear ripples in a flank deeper that are
    somewhat shorter than the step. What lies beyond the last node wears no flank: the amount on the nodes is
    returned.
    """
    last = nodes.shape[0] - 1
    reach = _reach_of(nodes, step)
    if middle + reach <= nodes[0] or middle - reach >= nodes[last]:
        return 0.0
    p, _ = locate(nodes, split, middle - reach)
    if reach < _SHORT_STEP * (nodes[p + 1] - nodes[p]):
        height = amount / reach
        below = _lay_ramp(nodes, split, middle - reach, middle, height, out)
        return below + _lay_ramp(nodes, split, middle + reach, middle, height, out)
    # as in `lay_points`, with the amount below the first node taken off and no more than up to the last one
    scale = amount / (reach * reach)
    x = nodes[p] - middle
    first = 0.5 * scale * (max(x + reach, 0.0) ** 2 - 2.0 * max(x, 0.0) ** 2)
    before = scale / 6.0 * (max(x + reach, 0.0) ** 3 - 2.0 * max(x, 0.0) ** 3)
    slope = first
    while p < last and x < reach:
        width = nodes[p + 1] - nodes[p]
        x += width
        rest = max(x - reach, 0.0)
        value = scale / 6.0 * (max(x + reach, 0.0) ** 3 - 2.0 * max(x, 0.0) ** 3 + rest * rest * rest)
        after = (value - before) / width
        out[p] += max(after - slope, 0.0)
        before, slope, p = value, after, p + 1
    whole = amount
    if x < reach:
        whole = 0.5 * scale * (max(x + reach, 0.0) ** 2 - 2.0 * max(x, 0.0) ** 2)
    out[p] += max(whole - slope, 0.0)
    return whole - first


@njit(cache=True, error_model="numpy")
def lies_within(nodes, middle, count, step):  # type: ignore[no-untyped-def]
    """Whether amounts at rising places that fade out over a step lie on the nodes, as `lay_points` needs it."""
    last, reach = nodes.shape[0] - 1, abs(step)
    if count == 0 or reach < _SHORT_STEP * max(nodes[1] - nodes[0], nodes[last] - nodes[last - 1]):
        return False
    return middle[0] - reach > nodes[0] and middle[count - 1] + reach < nodes[last]


@njit(cache=True, error_model="numpy")
def lay_points(nodes, split, middle, amount, count, step, out):  # type: ignore[no-untyped-def]
    """Add to nodes amounts at rising places that all fade out over one step, as `lay` does one by one.

    An amount m at u has the density m [(x-u+s)+ - 2 (x-u)+ + (x-u-s)+]/s^2; a node takes the integral of its product
    with the hat function of the node, which is the second difference over the nodes of the density's double integral
    G(x) = m [(x-u+s)+^3 - 2 (x-u)+^3 + (x-u-s)+^3]/(6 s^2). Beyond u+s that is m (x-u), so that all amounts which
    have faded out come in by their sum and their moment. Returns the first node that takes something, and the one
    behind the last.
    """
    origin, end = middle[0], middle[count - 1] + step
    p = start = locate(nodes, split, middle[0] - step)[0]
    first, total, moment = 0, 0.0, 0.0
    scale, before, slope = 1.0 / (6.0 * step * step), 0.0, 0.0
    while nodes[p] < end:
        x = nodes[p + 1]
        while first < count and middle[first] <= x - step:
            total += amount[first]
            moment += amount[first] * (middle[first] - origin)
            first += 1
        value, c = total * (x - origin) - moment, first
        while c < count and middle[c] < x + step:
            away = x - middle[c]
            rises, falls = away + step, max(away, 0.0)
            value += scale * amount[c] * (rises * rises * rises - 2.0 * falls * falls * falls)
            c += 1
        after = (value - before) / (x - nodes[p])
        out[p] += max(after - slope, 0.0)
        before, slope, p = value, after, p + 1
    out[p] += max(total - slope, 0.0)
    return start, p + 1


@njit(cache=True, error_model="numpy")
def lay_pieces(nodes, split, middle, shift, amount, pieces, alike, out):  # type: ignore[no-untyped-def]
    """Add the stretches of a footprint to nodes, each faded out over its own step.

    `alike`: places rise, and all stretches move by one step. Returns the first node that takes something, the one
    behind the last, and what lies beyond the nodes.
    """
    if pieces == 0:
        return ZERO, ZERO, 0.0
    if alike and lies_within(nodes, middle, pieces, shift[0]):
        first, end = lay_points(nodes, split, middle, amount, pieces, abs(shift[0]), out)
        return first, end, 0.0
    lowest, highest, beyond = np.inf, -np.inf, 0.0
    for c in range(pieces):
        reach = _reach_of(nodes, shift[c])
        lowest, highest = min(lowest, middle[c] - reach), max(highest, middle[c] + reach)
        beyond += amount[c] - lay(nodes, split, middle[c], shift[c], amount[c], out)
    return locate(nodes, split, lowest)[0], locate(nodes, split, highest)[0] + 2, beyond


@njit(cache=True, error_model="numpy")
def _share_held(distance, slack):  # type: ignore[no-untyped-def]
    """Part in which an end of the slice that is so near holds a footprint: all of one that it cuts off."""
    return min(max(1.0 - distance / slack, 0.0), 1.0)


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def node_width(nodes, p):  # type: ignore[no-untyped-def]
    """Width that a node stands for: half of the cells on either side."""
    left = nodes[p] - nodes[p - 1] if p > 0 else 0.0
    right = nodes[p + 1] - nodes[p] if p < nodes.shape[0] - 1 else 0.0
    return 0.5 * (left + right)

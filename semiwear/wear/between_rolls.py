"""Deposit of footprints between roll positions on the nodes of a flank.

A footprint represents the interval around its roll position, over which it moves by one step. Spread evenly along
that step, its wear is right to second order, but a ripple somewhat shorter than the step would grow, since the
Fourier transform of an even density is negative there. Spread as a triangle two steps wide, no ripple grows, but all
wear is smoothed. A trapezoid 1 + f steps wide and even over 1 - f steps is a compromise: its transform sinc(l) sinc(f
l), for l steps to a wavelength, is negative only for wavelengths from f steps to one, and it smooths f^2 times as
much as the triangle. Where nodes are too far apart to resolve such ripples, f is as small as a half.
"""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import ZERO, inner_njit
from semiwear.meshing.flank_grid import locate

VALLEY = 2  # mark in `at_edge` of stretches beyond the ridge from a pressed edge
_LEAST_STEP = 1e-6  # of a flank's height
_SHORT_STEP = 0.05  # of a cell: below it the differences of `lay_points` would lose digits
_ROUNDING = 1e-9  # of a stretch: up to this part beyond the nodes is rounding
_FADES = 0.5  # least f; otherwise half the number of cells in a step, at most 1


@inner_njit(cache=True, error_model="numpy")
def step_of(place, rate, k):  # type: ignore[no-untyped-def]
    """Distance that a profile coordinate moves in the step around a roll position."""
    before, after = max(k - 1, 0), min(k + 1, place.shape[0] - 1)
    before, after = (before if rate[before] != 0.0 else k), (after if rate[after] != 0.0 else k)
    return (place[after] - place[before]) / max(after - before, 1)


@inner_njit(cache=True, error_model="numpy")
def _lay_straight(nodes, split, a, b, at_a, at_b, out):  # type: ignore[no-untyped-def]
    """Add a linear density between two profile coordinates; returns its amount on the nodes."""
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
        # exact for the product of two linear functions
        upper = (end - begin) / 6.0 * (first * x + (first + second) * (x + y) + second * y)
        out[cell] += 0.5 * (end - begin) * (first + second) - upper
        out[cell + 1] += upper
        laid += 0.5 * (end - begin) * (first + second)
        cell += 1
    return laid


@inner_njit(cache=True, error_model="numpy")
def span_of(nodes, step):  # type: ignore[no-untyped-def]
    """Half-widths of the even part and of the whole of a trapezoid, from a step of either sign."""
    last = nodes.shape[0] - 1
    step = max(abs(step), _LEAST_STEP * (nodes[last] - nodes[0]))
    cell = min(nodes[1] - nodes[0], nodes[last] - nodes[last - 1])
    fades = min(max(0.5 * step / cell, _FADES), 1.0)
    return 0.5 * (1.0 - fades) * step, 0.5 * (1.0 + fades) * step


@inner_njit(cache=True, error_model="numpy")
def _up_to(x, even, reach):  # type: ignore[no-untyped-def]
    """Integral of a trapezoid around zero up to x, and its double integral; both times (reach^2 - even^2)."""
    a, b = max(x + reach, 0.0), max(x + even, 0.0)
    c, d = max(x - even, 0.0), max(x - reach, 0.0)
    return 0.5 * (a * a - b * b - c * c + d * d), (a * a * a - b * b * b - c * c * c + d * d * d) / 6.0


@inner_njit(cache=True, error_model="numpy")
def lay(nodes, split, middle, step, amount, out):  # type: ignore[no-untyped-def]
    """Add an amount to the nodes, spread as a trapezoid around `middle`; returns the amount on the nodes."""
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
    # as in `lay_points`, without the amounts below the first and above the last node
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
    """Whether trapezoids around increasing places all lie on the nodes, as required by `lay_points`."""
    last, reach = nodes.shape[0] - 1, span_of(nodes, step)[1]
    if count == 0 or reach < _SHORT_STEP * max(nodes[1] - nodes[0], nodes[last] - nodes[last - 1]):
        return False
    return middle[0] - reach > nodes[0] and middle[count - 1] + reach < nodes[last]


@inner_njit(cache=True, error_model="numpy")
def lay_points(nodes, split, middle, amount, count, step, out):  # type: ignore[no-untyped-def]
    """Add amounts at increasing places that all move by the same step, as repeated calls of `lay` would.

    An amount m at u, even up to e and zero from r on, has the density m [(x-u+r)+ - (x-u+e)+ - (x-u-e)+ + (x-u-r)+]
    /(r^2 - e^2). A node receives the integral of this density times its hat function, which is the second difference
    over the nodes of the density's double integral, the same expression in cubes over 6 (r^2 - e^2). Beyond u+r the
    double integral is m (x-u), so that all earlier amounts enter by their sum and moment. Returns the first node with
    a deposit and the one behind the last.
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
            distance = x - middle[c]
            rises, risen, falls = distance + reach, max(distance + even, 0.0), max(distance - even, 0.0)
            value += scale * amount[c] * (rises * rises * rises - risen * risen * risen - falls * falls * falls)
            c += 1
        after = (value - before) / (x - nodes[p])
        out[p] += max(after - slope, 0.0)
        before, slope, p = value, after, p + 1
    out[p] += max(total - slope, 0.0)
    return start, p + 1


@inner_njit(cache=True, error_model="numpy")
def lay_pieces(nodes, split, middle, shift, amount, pieces, alike, out):  # type: ignore[no-untyped-def]
    """Add the stretches of a footprint to the nodes, each spread over its own step.

    `alike`: places increase, and all stretches move by the same step. Returns the first node with a deposit, the one
    behind the last, and the amount beyond the nodes.
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
    """Degree from 0 to 1 to which an end of the slice at some distance holds a footprint back: 1 if cut off."""
    return min(max(1.0 - distance / slack, 0.0), 1.0)


@inner_njit(cache=True, error_model="numpy")
def shifts_of(middle, ends, at_edge, pieces, low, high, slack, moves, low_moves, high_moves, shift):  # type: ignore[no-untyped-def]
    """Distance that every stretch of a footprint moves in a roll step, from those of its centre and the slice's ends.

    A footprint cut off by an end of the slice stays at that end and is stretched: nothing of it crosses the border.
    The transition takes place over `slack`. It depends on the ends of the footprint, not on the centroids of its
    stretches, since wear would jump where a stretch without weight is added. Returns whether all stretches move
    alike.
    """
    plain = pieces > 0 and at_edge[0] == 0 and at_edge[pieces - 1] == 0  # no pressed edge, and places increase
    if plain and ends[0, 0] > low + slack and ends[pieces - 1, 1] < high - slack:
        shift[:pieces] = moves
        return True
    alike = pieces > 0 and at_edge[0] == at_edge[pieces - 1]
    for whole in (0, VALLEY):  # a separate valley merges continuously into the whole footprint
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
    """Width of the interval around a node: half of the cells on either side."""
    left = nodes[p] - nodes[p - 1] if p > 0 else 0.0
    right = nodes[p + 1] - nodes[p] if p < nodes.shape[0] - 1 else 0.0
    return 0.5 * (left + right)

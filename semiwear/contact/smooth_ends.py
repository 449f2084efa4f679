"""Ends of a contact on cells as continuous functions of the load, for results that are differentiated."""

from __future__ import annotations

from math import pi

from semiwear.contact.plane_strain import respond
from semiwear.kernel_cache import inner_njit


@inner_njit(cache=True, error_model="numpy")
def _rate(influence, active, force, a, x, y, points, none):  # type: ignore[no-untyped-def]
    """Derivative of the approach by the load with these cells in contact; `none` where it is undefined."""
    m = 0
    for i in range(active.shape[0]):
        if active[i]:
            points[m] = i
            m += 1
    if m == 0 or not respond(force, influence, points[:m], a, x, y):
        return none
    return 1.0 / y[:m].sum()


@inner_njit(cache=True, error_model="numpy")
def _weights(gap, influence, approach, force, end, beyond, inside):  # type: ignore[no-untyped-def]
    """Weights of a stretch without the cell at its end, unchanged, and with the next cell, if there is one."""
    if not inside:
        return 0.0, 1.0, 0.0
    part = 0.0
    if force[end] > 0.0:
        slack = gap[beyond] - approach
        for k in range(gap.shape[0]):
            slack += influence[beyond, k] * force[k]
        part = pi * force[end] / (pi * force[end] + max(slack, 0.0))
    return 0.5 * (1.0 - part), 0.5, 0.5 * part


@inner_njit(cache=True, error_model="numpy")
def _with_ends(active, first, last, low, high):  # type: ignore[no-untyped-def]
    """Change the ends of a stretch: 0 without its end cell, 1 unchanged, 2 with the next one."""
    active[first] = low > 0
    if high == 0:
        active[last] = False
    if low == 2:
        active[first - 1] = True
    if high == 2:
        active[last + 1] = True


@inner_njit(cache=True, error_model="numpy")
def smooth_rate(gap, influence, approach, rate, active, force, a, x, y, points, on, cells):  # type: ignore[no-untyped-def]
    """Derivative of the approach by the load, continuous where cells come into contact.

    Contact does not end where a cell does. A cell that has just come into contact bears no load; when its neighbour
    is about to, it is wholly in contact. In between, the fraction of the cell that is in contact grows from 0 to 1,
    and the rate goes from the mean of those without and with the cell to the mean of those with it and with the
    next. Both ends of a stretch are treated together, since a corner may press with a single cell. At an
    end the pressure c sqrt(d) and the slope pi c sqrt(d) of the gap differ by pi, which weighs force against gap. On
    a parabola it leaves 2e-4 of steps of 1.4e-2 in the half-width.
    """
    n, smooth, first, pressed = gap.shape[0], rate, 0, 0
    for i in range(n):
        on[i] = active[i]
        pressed += on[i]
    if pressed < 2:
        return rate
    for last in range(n):
        start, stop = last // cells * cells, (last // cells + 1) * cells  # of the band
        if on[last] and (last == start or not on[last - 1]):
            first = last
        if not on[last] or (last + 1 < stop and on[last + 1]):
            continue
        lows = _weights(gap, influence, approach, force, first, first - 1, first > start)
        highs = _weights(gap, influence, approach, force, last, last + 1, last + 1 < stop)
        for low in range(3):
            for high in range(3):
                weight = lows[low] * highs[high]
                if weight > 0.0 and (low != 1 or high != 1):
                    _with_ends(active, first, last, low, high)
                    smooth += weight * (_rate(influence, active, force, a, x, y, points, rate) - rate)
                    for i in range(max(first - 1, 0), min(last + 2, n)):
                        active[i] = on[i]
    return smooth

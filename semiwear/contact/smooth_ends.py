"""Where a pressed stretch of cells ends, continuously in the load: for results that are differentiated."""

from __future__ import annotations

from math import pi

from semiwear.contact.plane_strain import respond
from semiwear.kernel_cache import njit

__all__ = ["smooth_rate"]


@njit(cache=True, error_model="numpy")
def _rate(influence, active, force, a, x, y, points):  # type: ignore[no-untyped-def]
    """Change of the approach by the load while these cells are pressed."""
    m = 0
    for i in range(active.shape[0]):
        if active[i]:
            points[m] = i
            m += 1
    respond(force, influence, points[:m], a, x, y)
    return 1.0 / y[:m].sum()


@njit(cache=True, error_model="numpy")
def smooth_rate(gap, influence, approach, rate, active, force, a, x, y, points, cells):  # type: ignore[no-untyped-def]
    """Change of the approach by the load, continuous where cells come to be pressed.

    Contact does not end where a cell does. A cell that has just come to be pressed bears nothing, one next to which
    another is about to be still bears its load at no gap: between the two the share of the cell that is in contact
    grows from 0 to 1, and the rate goes from the mean of those without and with the cell to the mean of those with
    it and with the next. A cell by itself has two ends, and so grows from nothing. At an end the pressure c sqrt(d)
    and the slope pi c sqrt(d) of the gap differ by pi, which weighs force against gap. On a parabola it leaves 2e-4
    of steps of 1.4e-2 in the half-width.
    """
    n, smooth = gap.shape[0], rate
    on = active.copy()
    if on.sum() < 2:
        return rate
    for i in range(n):
        if not on[i]:
            continue
        for step in (-1, 1):
            j = i + step
            if j < 0 or j >= n or on[j] or i // cells != j // cells:  # not where another band begins
                continue
            slack = gap[j] - approach
            for k in range(n):
                slack += influence[j, k] * force[k]
            share = pi * force[i] / (pi * force[i] + max(slack, 0.0)) if force[i] > 0.0 else 0.0
            active[j] = True
            more = _rate(influence, active, force, a, x, y, points)
            active[j], active[i] = False, False
            less = _rate(influence, active, force, a, x, y, points)
            active[i] = True
            smooth += 0.5 * (share * (more - rate) + (1.0 - share) * (less - rate))
    return smooth

"""Pressure across a slice of a line contact, exact for any gap: the elastic half-plane under a known line load.

A worn flank is no parabola. Where its gap changes within the contact, at the ridge that remains along the pitch line
above all, Hertz's pressure for some mean curvature misses the peak. Here each loaded slice is solved by itself in
plane strain: p >= 0 on narrow cells, gap + u - approach >= 0 and their product zero, with Flamant's logarithmic
influence (Johnson 1985, eq. 2.25) and the line load that the load sharing found.
"""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.footprint import LEAST_BEND, MOST_NODES, Footprints, fresh_gap, outline
from semiwear.contact.teeth_solver import SlicePressures
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, locate, smooth_value

__all__ = ["solve_slices"]

FloatArray = NDArray[np.float64]

_CELLS = 32  # across what may touch: Hertz's peak within 0.3 %
_ROOM = 1.6  # of the gap that closes in a Hertz contact: what is looked at
_WIDER = 1.6  # when that was too little
_ATTEMPTS = 8
_SETS = 60


def _flamant() -> FloatArray:
    """Influence -(ln s) of a cell of unit width at whole distances, up to a constant that keeps it definite."""
    s = np.arange(_CELLS, dtype=float)
    high, low = s + 0.5, np.abs(s - 0.5)
    whole = high * np.log(high) - np.where(s > 0, 1.0, -1.0) * low * np.log(low) - 1.0
    return log(2.0 * _CELLS) - whole


_INFLUENCE = _flamant()


@njit(cache=True, error_model="numpy")
def _plane_contact(gap, load, influence, active, pressure, a, x, y, on):  # type: ignore[no-untyped-def]
    """Pressures of cells of unit width under a load; returns the approach, NaN if unsettled, in units of the gaps."""
    n = gap.shape[0]
    for _ in range(_SETS):
        m = 0
        for i in range(n):
            if active[i]:
                on[m] = i
                m += 1
        for i in range(m):
            for j in range(i + 1):
                value = influence[on[i] - on[j]]
                for k in range(j):
                    value -= a[i, k] * a[j, k]
                a[i, j] = sqrt(max(value, 1e-300)) if i == j else value / a[j, j]
            first, second = gap[on[i]], 1.0
            for k in range(i):
                first -= a[i, k] * x[k]
                second -= a[i, k] * y[k]
            x[i], y[i] = first / a[i, i], second / a[i, i]
        top, bottom = load, 0.0
        for i in range(m - 1, -1, -1):
            for k in range(i + 1, m):
                x[i] -= a[k, i] * x[k]
                y[i] -= a[k, i] * y[k]
            x[i] /= a[i, i]
            y[i] /= a[i, i]
            top += x[i]
            bottom += y[i]
        approach = top / bottom
        pressure[:] = 0.0
        changed = False
        for i in range(m):
            value = approach * y[i] - x[i]
            if value < 0.0:
                active[on[i]] = False
                changed = True
            else:
                pressure[on[i]] = value
        if changed:
            continue
        for i in range(n):
            if not active[i]:
                slack = gap[i] - approach
                for k in range(m):
                    slack += influence[abs(i - on[k])] * pressure[on[k]]
                if slack < -1e-9 * abs(approach):
                    active[i] = True
                    changed = True
        if not changed:
            return approach
    return np.nan


@njit(cache=True, error_model="numpy")
def _solve(  # type: ignore[no-untyped-def]
    line_load, curvature, profile, low, high, separation, spacing, low_radius, high_radius, removed, row, nodes,
    split, modulus, margin, influence, out_inner, out_place, out_border, out_gap,
):  # fmt: skip
    cells = influence.shape[0]
    gap, pressure = np.empty(cells), np.empty(cells)
    a, x, y = np.empty((cells, cells)), np.empty(cells), np.empty(cells)
    on, active = np.empty(cells, dtype=np.int64), np.empty(cells, dtype=np.bool_)
    u, g = np.empty(MOST_NODES), np.empty(MOST_NODES)
    rolls, faces = line_load.shape
    for i in range(faces):
        for k in range(rolls):
            q, at, per_mm, terms = line_load[k, i], profile[k, i], spacing[k, i], separation[:, k, i]
            if q <= 0.0:
                continue
            gone = removed[row[k], i]
            spread = gone.max() - gone.min()
            # a Hertz contact closes gaps up to b^2/(2R) = 2 q/(pi E*)
            closes = 2.0 * q / (pi * modulus)
            room = _ROOM * closes
            for _ in range(_ATTEMPTS):
                reach = sqrt(2.0 * (spread + room) / max(terms[2], LEAST_BEND))
                count = outline(
                    at - reach, at + reach, at, low[k, i], high[k, i], terms, per_mm, low_radius[k, i],
                    high_radius[k, i], room, gone, nodes[i], split[i], u, g,
                )  # fmt: skip
                least = g[:count].min()
                first, last = 0, count - 1
                while first < count - 2 and g[first + 1] - least > room:
                    first += 1
                while last > 1 and g[last - 1] - least > room:
                    last -= 1
                start, width = u[first], (u[last] - u[first]) / cells
                if width <= 0.0:
                    break
                # displacement of a cell: 2 p width / (pi E*) times the influence
                unit = 2.0 * width * per_mm / (pi * modulus)
                for c in range(cells):
                    place = start + (c + 0.5) * width
                    if low[k, i] <= place <= high[k, i]:
                        cell, x_cell = locate(nodes[i], split[i], place)
                        gap[c] = fresh_gap(place - at, terms) + smooth_value(gone, cell, x_cell) - least
                    else:
                        gap[c] = np.interp(place, u[:count], g[:count]) - least
                    active[c] = gap[c] < closes
                    gap[c] /= unit
                if not active.any():
                    active[np.argmin(gap)] = True
                approach = _plane_contact(gap, q / (width * per_mm), influence, active, pressure, a, x, y, on)
                cut = (pressure[0] > 0.0 and start > low[k, i]) or (
                    pressure[cells - 1] > 0.0 and u[last] < high[k, i]
                )
                if not (np.isnan(approach) or cut):
                    break
                room *= _WIDER
            if width <= 0.0:
                continue
            if not np.isnan(approach):
                # the same approach as Hertz's with the half-width that goes with the curvature
                b = sqrt(4.0 * q / (pi * modulus * curvature[k, i]))
                out_gap[k, i] = least + unit * approach - closes * (log(cells * width * per_mm / b * 4.0) + 0.5)
            for c in range(cells):
                place = start + (c + 0.5) * width
                if min(place - low[k, i], high[k, i] - place) * per_mm < margin:
                    out_border[k, i] = max(out_border[k, i], pressure[c])
                elif pressure[c] > out_inner[k, i]:
                    out_inner[k, i], out_place[k, i] = pressure[c], place


def solve_slices(
    lines: ContactLines, grid: FlankGrid, worn: Footprints, line_load: FloatArray, modulus: float, margin: float
) -> tuple[SlicePressures, FloatArray]:
    """Greatest pressures of every loaded slice, and the gap that Hertz's law has to start from.

    Parameters
    ----------
    lines : ContactLines
    grid : FlankGrid
    worn : Footprints
    line_load : (roll, face) array [N/mm]
    modulus : float [MPa]
        Effective modulus E*.
    margin : float [mm]
        Distance across the line from an end of the slice, within which pressure is at the border.

    Returns
    -------
    pressures : SlicePressures
    gap : (roll, face) array [mm]
        With the curvature of the footprint, a Hertz contact over this gap has the approach of the slice; that of the
        footprint where nothing is loaded.
    """
    inner, border = np.zeros(line_load.shape), np.zeros(line_load.shape)
    place, gap = lines.profile.copy(), worn.gap.copy()
    _solve(
        line_load, worn.curvature, lines.profile, lines.low, lines.high, lines.separation, lines.spacing,
        lines.low_edge_radius, lines.high_edge_radius, worn.removed.depth, worn.removed.row, grid.profile,
        grid.split, modulus, margin, _INFLUENCE, inner, place, border, gap,
    )  # fmt: skip
    return SlicePressures(inner, place, border), gap

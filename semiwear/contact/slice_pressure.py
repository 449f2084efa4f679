"""Pressure across a slice of a line contact, exact for any gap: the elastic half-plane under a known line load.

A worn flank is no parabola. Where its gap changes within the contact, at the ridge that remains along the pitch line
above all, Hertz's pressure for some mean curvature misses the peak. Here each loaded slice is solved by itself in
plane strain: p >= 0 on narrow cells, gap + u - approach >= 0 and their product zero, with Flamant's logarithmic
influence (Johnson 1985, eq. 2.25) and the line load that the load sharing found. Where an edge presses on the wall of
the groove that it has worn, the valley beyond may bear as well: every such band has cells of its own.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.footprint import (
    Footprints,
    edge_tangent,
    fresh_beyond,
    fresh_gap,
    most_places,
    outline,
    rises_within,
)
from semiwear.contact.loads import SlicePressures
from semiwear.errors import ConvergenceError
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import locate, smooth_value

__all__ = ["solve_slices"]

FloatArray = NDArray[np.float64]

# across each of one, two or three bands that may touch; with the most, Hertz's peak within 0.3 %
_CELLS = (32, 24, 16)
_ROOM = 1.6  # of the gap that closes in a Hertz contact: what is looked at
_WIDER = 1.6  # when that was too little
_FAR = 8.0  # times the gap that closes in a Hertz contact: nothing farther touches
_BEYOND = 1.1  # of the gap of a place that turned out to be pressed
_ATTEMPTS = 8
_SETS = 60
_MOST = max(n * cells for n, cells in enumerate(_CELLS, 1))


def _flamant() -> FloatArray:
    """Influence -(ln s) of a cell of unit width at whole distances, up to a constant that keeps it definite."""
    s = np.arange(_CELLS[0], dtype=float)
    high, low = s + 0.5, np.abs(s - 0.5)
    whole = high * np.log(high) - np.where(s > 0, 1.0, -1.0) * low * np.log(low) - 1.0
    return np.asarray(log(2.0 * _CELLS[0]) - whole)


_INFLUENCE = _flamant()


@njit(cache=True, error_model="numpy")
def _mean_log(distance, width):  # type: ignore[no-untyped-def]
    """Mean of the logarithm of the distance from a place to a cell of some width."""
    high, low = distance + 0.5 * width, distance - 0.5 * width
    total = high * log(high) - width
    if low != 0.0:
        total -= low * log(abs(low))
    return total / width


@njit(cache=True, error_model="numpy")
def _influences(x, width, n, bands, span, even, out):  # type: ignore[no-untyped-def]
    """Deflection of cells under unit loads on cells, -(ln s) up to a constant that keeps it definite; symmetric."""
    if bands == 1:
        for i in range(n):
            for j in range(n):
                out[i, j] = even[abs(i - j)]
        return
    constant = log(2.0 * span)
    for i in range(n):
        for j in range(i + 1):
            away = abs(x[i] - x[j])
            out[i, j] = constant - 0.5 * (_mean_log(away, width[i]) + _mean_log(away, width[j]))
            out[j, i] = out[i, j]


@njit(cache=True, error_model="numpy")
def _plane_contact(gap, load, influence, active, force, a, x, y, on):  # type: ignore[no-untyped-def]
    """Forces on cells under a load; returns the approach and its derivative, NaN if unsettled."""
    n = gap.shape[0]
    for _ in range(_SETS):
        m = 0
        for i in range(n):
            if active[i]:
                on[m] = i
                m += 1
        for i in range(m):
            for j in range(i + 1):
                value = influence[on[i], on[j]]
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
        force[:] = 0.0
        changed = False
        for i in range(m):
            value = approach * y[i] - x[i]
            if value < 0.0:
                active[on[i]] = False
                changed = True
            else:
                force[on[i]] = value
        if changed:
            continue
        for i in range(n):
            if not active[i]:
                slack = gap[i] - approach
                for k in range(m):
                    slack += influence[i, on[k]] * force[on[k]]
                if slack < -1e-9 * abs(approach):
                    active[i] = True
                    changed = True
        if not changed:
            return approach, 1.0 / bottom
    return np.nan, np.nan


@njit(cache=True, error_model="numpy")
def _bands(u, g, count, least, room, first, last):  # type: ignore[no-untyped-def]
    """First and last points of the stretches whose gap is within `room` of the least; returns their number."""
    bands = 0
    c = 0
    while c < count:
        if not g[c] - least <= room:  # no number belongs to no band
            c += 1
            continue
        start = max(c - 1, 0)
        while c < count and g[c] - least <= room:
            c += 1
        stop = min(c, count - 1)
        if bands > 0 and start <= last[bands - 1]:
            last[bands - 1] = stop
            continue
        if bands == len(_CELLS):
            # the nearest become one
            nearest, apart = bands, u[start] - u[last[bands - 1]]
            for k in range(1, bands):
                if u[first[k]] - u[last[k - 1]] < apart:
                    nearest, apart = k, u[first[k]] - u[last[k - 1]]
            if nearest == bands:
                last[bands - 1] = stop
                continue
            last[nearest - 1] = last[nearest]
            for k in range(nearest, bands - 1):
                first[k], last[k] = first[k + 1], last[k + 1]
            bands -= 1
        first[bands], last[bands] = start, stop
        bands += 1
    return bands


@njit(cache=True, error_model="numpy")
def _pressed_beyond(u, g, count, least, bands, first, last, x, width, force, n, per_mm, span, approach, load, unit):  # type: ignore[no-untyped-def]
    """Greatest gap above the least of places outside all bands that the flanks would penetrate; zero if none."""
    constant, farthest = log(2.0 * span), 0.0
    band = 0
    for c in range(count):
        while band < bands and c > last[band]:
            band += 1
        if band < bands and c >= first[band]:
            continue
        opening = (g[c] - least) / unit
        if opening > _FAR * load:
            continue
        slack = opening - approach
        for k in range(n):
            if force[k] > 0.0:
                slack += force[k] * (constant - _mean_log(abs(u[c] * per_mm - x[k]), width[k]))
        if slack < 0.0:
            farthest = max(farthest, g[c] - least)
    return farthest


@njit(cache=True, error_model="numpy")
def _cells(  # type: ignore[no-untyped-def]
    u, bands, first, last, at, low, high, terms, per_mm, low_radius, high_radius, gone, nodes, split,
    place, width, gap,
):  # fmt: skip
    """Middles and widths of the cells of all bands [mm], and the gaps there; returns their number."""
    n, cells = 0, _CELLS[bands - 1]
    fresh_low, slope_low = edge_tangent(low, -1.0, per_mm, at, terms)
    fresh_high, slope_high = edge_tangent(high, 1.0, per_mm, at, terms)
    for band in range(bands):
        start, step = u[first[band]], (u[last[band]] - u[first[band]]) / cells
        for c in range(cells):
            at_cell = start + (c + 0.5) * step
            if at_cell < low:
                fresh = fresh_beyond((low - at_cell) * per_mm, fresh_low, slope_low, low_radius)
            elif at_cell > high:
                fresh = fresh_beyond((at_cell - high) * per_mm, fresh_high, slope_high, high_radius)
            else:
                fresh = fresh_gap(at_cell - at, terms)
            cell, x = locate(nodes, split, at_cell)
            gap[n] = fresh + smooth_value(gone, nodes, split, cell, x)
            place[n], width[n] = at_cell * per_mm, step * per_mm
            n += 1
    return n


@njit(cache=True, error_model="numpy")
def _cut_off(u, bands, first, last, force, low, high):  # type: ignore[no-untyped-def]
    """Whether pressure ends where cells end; at the end of a flank that is no edge it has to."""
    cells = _CELLS[bands - 1]
    for band in range(bands):
        if force[band * cells] > 0.0 and u[first[band]] != low:
            return True
        if force[(band + 1) * cells - 1] > 0.0 and u[last[band]] != high:
            return True
    return False


@njit(cache=True, error_model="numpy")
def _solve(  # type: ignore[no-untyped-def]
    line_load, profile, low, high, separation, spacing, low_radius, high_radius, removed, row, nodes, split, modulus,
    margin, even, out_inner, out_place, out_border, out_gap, out_curvature, out_centre,
):  # fmt: skip
    gap, force = np.empty(_MOST), np.empty(_MOST)
    place, width = np.empty(_MOST), np.empty(_MOST)
    influence, a = np.empty((_MOST, _MOST)), np.empty((_MOST, _MOST))
    x, y = np.empty(_MOST), np.empty(_MOST)
    on, active = np.empty(_MOST, dtype=np.int64), np.empty(_MOST, dtype=np.bool_)
    u, g = np.empty(most_places(nodes)), np.empty(most_places(nodes))
    first, last = np.empty(len(_CELLS), dtype=np.int64), np.empty(len(_CELLS), dtype=np.int64)
    unit = 2.0 / (pi * modulus)  # of deflection by line load
    rolls, faces = line_load.shape
    unsettled = 0
    for i in range(faces):
        for k in range(rolls):
            q, at, per_mm, terms = line_load[k, i], profile[k, i], spacing[k, i], separation[:, k, i]
            if q <= 0.0:
                continue
            gone = removed[row[k], i]
            spread = gone.max() - gone.min()
            # a Hertz contact closes gaps up to b^2/(2R) = 2 q/(pi E*)
            closes = unit * q
            room = _ROOM * closes
            for _ in range(_ATTEMPTS):
                reach = rises_within(spread + room, terms[2])
                count = outline(
                    at - reach, at + reach, at, low[k, i], high[k, i], terms, per_mm, low_radius[k, i],
                    high_radius[k, i], room, gone, nodes[i], split[i], u, g,
                )  # fmt: skip
                least = g[:count].min()
                bands = _bands(u, g, count, least, room, first, last)
                n = _cells(
                    u, bands, first, last, at, low[k, i], high[k, i], terms, per_mm, low_radius[k, i],
                    high_radius[k, i], gone, nodes[i], split[i], place, width, gap,
                )  # fmt: skip
                for c in range(n):
                    gap[c] -= least
                    active[c] = gap[c] < closes
                    gap[c] /= unit
                span = (u[last[bands - 1]] - u[first[0]]) * per_mm
                if span <= 0.0:
                    break
                if not active[:n].any():
                    active[np.argmin(gap[:n])] = True
                _influences(place, width, n, bands, span, even, influence)
                approach, rate = _plane_contact(gap[:n], q, influence, active, force, a, x, y, on)
                if np.isnan(approach) or _cut_off(u, bands, first, last, force, low[k, i], high[k, i]):
                    room *= _WIDER
                    continue
                beyond = _pressed_beyond(
                    u, g, count, least, bands, first, last, place, width, force, n, per_mm, span, approach, q, unit
                )
                if beyond == 0.0:
                    break
                room = max(room, _BEYOND * beyond)
            if span <= 0.0:
                continue
            moment = 0.0
            for c in range(n):
                moment += force[c] * place[c]
            if np.isnan(approach):
                unsettled += 1
            else:
                # one band would be as stiff whose half-width is twice the logarithmic capacity of what touches
                b = 4.0 * span * exp(-rate)
                out_curvature[k, i] = 2.0 * closes / (b * b)
                out_gap[k, i] = least + unit * approach - closes * (log(4.0 * span / b) + 0.5)
                out_centre[k, i] = min(max(moment / (q * per_mm), low[k, i]), high[k, i])
            for c in range(n):
                pressure, at_cell = force[c] / width[c], place[c] / per_mm
                if min(at_cell - low[k, i], high[k, i] - at_cell) * per_mm < margin:
                    out_border[k, i] = max(out_border[k, i], pressure)
                elif pressure > out_inner[k, i]:
                    out_inner[k, i], out_place[k, i] = pressure, at_cell
    return unsettled


def solve_slices(
    lines: ContactLines, worn: Footprints, line_load: FloatArray, modulus: float, margin: float
) -> tuple[SlicePressures, Footprints]:
    """Greatest pressures of every loaded slice, and the Hertz contacts that are as soft and as far away.

    Parameters
    ----------
    lines : ContactLines
    worn : Footprints
    line_load : (roll, face) array [N/mm]
    modulus : float [MPa]
        Effective modulus E*.
    margin : float [mm]
        Distance across the line from an end of the slice, within which pressure is at the border.

    Returns
    -------
    pressures : SlicePressures
    touched : Footprints
        `worn` with the gap and the curvature of Hertz contacts that have the approach of these slices under their
        loads, and the same change of it by the load; and where the force lies.
    """
    inner, border, removed = np.zeros(line_load.shape), np.zeros(line_load.shape), worn.removed
    place, gap, curvature, centre = lines.profile.copy(), worn.gap.copy(), worn.curvature.copy(), worn.profile.copy()
    unsettled = _solve(
        line_load, lines.profile, lines.low, lines.high, lines.separation, lines.spacing, lines.low_edge_radius,
        lines.high_edge_radius, removed.depth, removed.row, removed.grid.profile, removed.grid.split, modulus, margin,
        _INFLUENCE, inner, place, border, gap, curvature, centre,
    )  # fmt: skip
    if unsettled:
        raise ConvergenceError(
            f"the pressure across {unsettled} of {int((line_load > 0.0).sum())} loaded slices does not settle; "
            "change numerics.profile_points, or take shorter wear steps (more numerics.wear_steps)"
        )
    touched = replace(worn, gap=gap, curvature=curvature, profile=centre)
    return SlicePressures(inner, place, border), touched

"""Pressure across a slice of a line contact, exact for any gap: the elastic half-plane under a known line load.

The gap of a worn flank is no parabola. Where it changes within the contact, at the ridge along the pitch line
above all, Hertz's pressure for a mean curvature misses the peak. Here each loaded slice is solved by itself on
narrow cells in plane strain (`plane_strain`), with its line load from load sharing. Where an edge presses
on the wall of the groove that it has worn, the valley beyond may bear load, too: every such band has its own cells.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, pi
from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.footprint import Footprints
from semiwear.contact.gap import (
    fresh_at,
    fresh_curve,
    fresh_on,
    gap_of_flanks,
    lowest,
    most_places,
    outline,
    rises_within,
    slice_gap,
    varies_by,
)
from semiwear.contact.loads import SlicePressures
from semiwear.contact.plane_strain import Cells, even_cells, influences, mean_log, plane_contact
from semiwear.contact.smooth_ends import smooth_rate
from semiwear.errors import ConvergenceError
from semiwear.kernel_cache import ZERO, inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import cubic, locate, slopes_of_cell
from semiwear.threads import in_loose_shares

# across each of one, two or three bands that may touch; with the most, Hertz's peak within 0.3 %
_CELLS = (32, 24, 16)
_ROOM = 1.6  # of the gap that closes in a Hertz contact: range of gaps considered
_WIDER = 1.6  # factor if that was too little
_FAR = 8.0  # times the gap that closes in a Hertz contact: nothing farther touches
_BEYOND = 1.1  # of the gap of a point that turned out to be in contact
_ATTEMPTS = 8
_MOST = max(n * cells for n, cells in enumerate(_CELLS, 1))


_EVEN = even_cells(_CELLS[0])


@inner_njit(cache=True, error_model="numpy")
def _bands(u, g, count, least, depth, first, last):  # type: ignore[no-untyped-def]
    """First and last points of the stretches whose gap is within `depth` of the least; returns their number."""
    bands = 0
    c = 0
    while c < count:
        if not g[c] - least <= depth:  # NaN belongs to no band
            c += 1
            continue
        start = max(c - 1, 0)
        while c < count and g[c] - least <= depth:
            c += 1
        stop = min(c, count - 1)
        if bands > 0 and start <= last[bands - 1]:
            last[bands - 1] = stop
            continue
        if bands == len(_CELLS):
            # the nearest two are joined
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


@inner_njit(cache=True, error_model="numpy")
def _ends_of_bands(work, bands, least, depth, smooth):  # type: ignore[no-untyped-def]
    """Ends of bands [mm]: at points of the outline, or where the gap is `depth` between two of them."""
    u, g = work.u, work.g
    for band in range(bands):
        first, last = work.first[band], work.last[band]
        work.begin[band], work.end[band] = u[first], u[last]
        if smooth is None:
            continue
        over, under = g[first] - least - depth, depth - (g[first + 1] - least)
        if over > 0.0 and under >= 0.0:
            work.begin[band] += over / (over + under) * (u[first + 1] - u[first])
        over, under = g[last] - least - depth, depth - (g[last - 1] - least)
        if over > 0.0 and under >= 0.0:
            work.end[band] -= over / (over + under) * (u[last] - u[last - 1])


@inner_njit(cache=True, error_model="numpy")
def _pressed_beyond(work, count, least, bands, n, per_mm, span, approach, load, unit):  # type: ignore[no-untyped-def]
    """Greatest gap, above the least, at which the flanks would penetrate outside all bands; zero if none."""
    constant, farthest = log(2.0 * span), 0.0
    band = 0
    for c in range(count):
        while band < bands and c > work.last[band]:
            band += 1
        if band < bands and c >= work.first[band]:
            continue
        opening = (work.g[c] - least) / unit
        if opening > _FAR * load:
            continue
        slack, x = opening - approach, work.u[c] * per_mm
        farthest_cell = max(abs(x - work.place[0]) + work.width[0], abs(x - work.place[n - 1]) + work.width[n - 1])
        if slack + load * (constant - log(farthest_cell)) > 0.0:  # even if all force lay at the farthest cell
            continue
        for k in range(n):
            if work.force[k] > 0.0:
                slack += work.force[k] * (constant - mean_log(abs(x - work.place[k]), work.width[k]))
        if slack < 0.0:
            farthest = max(farthest, work.g[c] - least)
    return farthest


@inner_njit(cache=True, error_model="numpy")
def _cells(gap, bands, begin, end, place, width, opening):  # type: ignore[no-untyped-def]
    """Middles and widths of the cells of all bands [mm], and the gaps there; returns their number."""
    n, cells, curve, removed = 0, _CELLS[bands - 1], fresh_curve(gap.derivatives), gap.removed
    known, slope_a, slope_b = -1, 0.0, 0.0
    for band in range(bands):
        start, step = begin[band], (end[band] - begin[band]) / cells
        for c in range(cells):
            at_cell = start + (c + 0.5) * step
            inside = gap.low <= at_cell <= gap.high
            fresh = fresh_on(curve, at_cell - gap.at) if inside else fresh_at(gap, at_cell)
            node, part = locate(gap.nodes, gap.split, at_cell)
            if node != known:
                known = node
                slope_a, slope_b = slopes_of_cell(removed, gap.nodes, gap.split, node)
            opening[n] = fresh + cubic(removed[node], removed[node + 1], slope_a, slope_b, part)
            place[n], width[n] = at_cell * gap.per_mm, step * gap.per_mm
            n += 1
    return n


@inner_njit(cache=True, error_model="numpy")
def _cut_off(bands, begin, end, force, low, high):  # type: ignore[no-untyped-def]
    """Whether the pressure is cut off where cells end, other than at the ends of the slice."""
    cells = _CELLS[bands - 1]
    for band in range(bands):
        if force[band * cells] > 0.0 and begin[band] != low:
            return True
        if force[(band + 1) * cells - 1] > 0.0 and end[band] != high:
            return True
    return False


@inner_njit(cache=True, error_model="numpy")
def _open(work, n, least, closes, unit):  # type: ignore[no-untyped-def]
    """Gaps of cells above the least one, in units of deflection; those that a Hertz contact closes become active."""
    nearest, touches = ZERO, False
    for c in range(n):
        work.gap[c] -= least
        work.active[c] = work.gap[c] < closes
        touches |= work.active[c]
        work.gap[c] /= unit
        if work.gap[c] < work.gap[nearest]:
            nearest = np.int64(c)
    if n > 0 and not touches:
        work.active[nearest] = True


class _Found(NamedTuple):
    """Pressures and Hertz contacts of every slice, (roll, face), as `solve_slices` finds them."""

    inner: FloatArray
    place: FloatArray
    border: FloatArray
    gap: FloatArray
    curvature: FloatArray
    centre: FloatArray


class _Work(NamedTuple):
    """Memory for one slice: cells, their influence and factor, outline, and bands."""

    gap: FloatArray
    force: FloatArray
    place: FloatArray
    width: FloatArray
    influence: FloatArray
    factor: FloatArray
    x: FloatArray
    y: FloatArray
    on: IntArray
    active: BoolArray
    pressed: BoolArray
    u: FloatArray
    g: FloatArray
    first: IntArray
    last: IntArray
    begin: FloatArray
    end: FloatArray


def _work_space(places: int) -> _Work:
    gap, force, place, width, x, y = np.empty((6, _MOST))
    influence, factor = np.empty((2, _MOST, _MOST))
    u, g = np.empty((2, places))
    on, (active, pressed) = np.empty(_MOST, dtype=np.int64), np.empty((2, _MOST), dtype=np.bool_)
    first, last = np.empty((2, len(_CELLS)), dtype=np.int64)
    begin, end = np.empty((2, len(_CELLS)))
    return _Work(
        gap, force, place, width, influence, factor, x, y, on, active, pressed, u, g, first, last, begin, end
    )


@inner_njit(cache=True, error_model="numpy")
def _settle(gap, load, unit, even, smooth, work):  # type: ignore[no-untyped-def]
    """Forces on cells of a slice: how many, least gap, span, approach and its derivative (NaN if unsettled)."""
    spread, closes = varies_by(gap.removed), unit * load
    # a Hertz contact closes gaps up to b^2/(2R) = 2 q/(pi E*)
    depth, n, least, span, approach, rate = _ROOM * closes, 0, 0.0, 0.0, np.nan, np.nan
    for _ in range(_ATTEMPTS):
        reach = rises_within(spread + depth, gap.derivatives[2])
        count = outline(gap, gap.at - reach, gap.at + reach, depth, work.u, work.g)
        least = lowest(work.g, count)
        bands = _bands(work.u, work.g, count, least, depth, work.first, work.last)
        _ends_of_bands(work, bands, least, depth, smooth)
        n = _cells(gap, bands, work.begin, work.end, work.place, work.width, work.gap)
        _open(work, n, least, closes, unit)
        span = (work.end[bands - 1] - work.begin[0]) * gap.per_mm
        if span <= 0.0:
            break
        cells = even
        if bands > 1:
            influences(work.place, work.width, n, _CELLS[bands - 1], span, work.influence)
            cells = Cells(work.influence, even.factor[:0], even.response[:0])
        approach, rate = plane_contact(
            work.gap[:n], load, cells, work.active, work.force, work.factor, work.x, work.y, work.on
        )
        if np.isnan(approach) or _cut_off(bands, work.begin, work.end, work.force, gap.low, gap.high):
            depth *= _WIDER
            continue
        beyond = _pressed_beyond(work, count, least, bands, n, gap.per_mm, span, approach, load, unit)
        if beyond == 0.0:
            if smooth is not None:
                rate = smooth_rate(
                    work.gap[:n], cells.influence, approach, rate, work.active[:n], work.force[:n], work.factor,
                    work.x, work.y, work.on, work.pressed, _CELLS[bands - 1],
                )  # fmt: skip
            break
        depth = max(depth, _BEYOND * beyond)
    return n, least, span, approach, rate


@njit(cache=True, error_model="numpy", nogil=True)
def _solve(line_load, flank, modulus, margin, even, smooth, slices, work, found):  # type: ignore[no-untyped-def]
    unit = 2.0 / (pi * modulus)  # of deflection by line load
    rolls = line_load.shape[0]
    unsettled = 0
    for i in slices:
        for k in range(rolls):
            q = line_load[k, i]
            if q <= 0.0:
                continue
            gap = slice_gap(flank, k, i)
            n, least, span, approach, rate = _settle(gap, q, unit, even, smooth, work)
            if span <= 0.0:
                continue
            moment = 0.0
            for c in range(n):
                moment += work.force[c] * work.place[c]
            if np.isnan(approach):
                unsettled += 1
            else:
                # as stiff as one band whose half-width is twice the logarithmic capacity of the contact
                b, closes = 4.0 * span * exp(-rate), unit * q
                found.curvature[k, i] = 2.0 * closes / (b * b)
                found.gap[k, i] = least + unit * approach - closes * (log(4.0 * span / b) + 0.5)
                found.centre[k, i] = min(max(moment / (q * gap.per_mm), gap.low), gap.high)
            for c in range(n):
                pressure, at_cell = work.force[c] / work.width[c], work.place[c] / gap.per_mm
                if min(at_cell - gap.low, gap.high - at_cell) * gap.per_mm < margin:
                    found.border[k, i] = max(found.border[k, i], pressure)
                elif pressure > found.inner[k, i]:
                    found.inner[k, i], found.place[k, i] = pressure, at_cell
    return unsettled


def solve_slices(
    lines: ContactLines,
    worn: Footprints,
    line_load: FloatArray,
    modulus: float,
    margin: float,
    *,
    smooth: bool = False,
) -> tuple[SlicePressures, Footprints]:
    """Greatest pressures of every loaded slice, and the equivalent Hertz contacts.

    Parameters
    ----------
    lines : ContactLines
    worn : Footprints
    line_load : (roll, face) array [N/mm]
    modulus : float [MPa]
        Effective modulus E*.
    margin : float [mm]
        Distance across the line from an end of the slice within which pressure counts as border.
    smooth : bool
        Whether gap and curvature of `touched` are continuous functions of the load: they change in steps of a cell
        otherwise.

    Returns
    -------
    pressures : SlicePressures
    touched : Footprints
        `worn` with the gap and the curvature of Hertz contacts that have the same approach as these slices under
        their loads, and the same stiffness, at the centre of the force.
    """
    found = _Found(
        inner=np.zeros(line_load.shape),
        place=lines.profile.copy(),
        border=np.zeros(line_load.shape),
        gap=worn.gap.copy(),
        curvature=worn.curvature.copy(),
        centre=worn.profile.copy(),
    )
    flank = gap_of_flanks(lines, worn.removed)
    places = most_places(flank.nodes)

    ends = True if smooth else None  # None is a type of its own: the branch that it skips is not compiled

    def solve(slices: IntArray) -> int:
        return int(_solve(line_load, flank, modulus, margin, _EVEN, ends, slices, _work_space(places), found))

    unsettled = sum(in_loose_shares(solve, np.arange(line_load.shape[1])))
    if unsettled:
        raise ConvergenceError(
            f"the pressure across {unsettled} of {int((line_load > 0.0).sum())} loaded slices does not settle; "
            "change numerics.profile_points, or take shorter wear steps (more numerics.wear_steps)"
        )
    touched = replace(worn, gap=found.gap, curvature=found.curvature, profile=found.centre)
    return SlicePressures(found.inner, found.place, found.border), touched

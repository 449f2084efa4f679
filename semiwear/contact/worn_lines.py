"""Where a worn flank is touched: the valley of fresh separation plus wear, slice by slice."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid, locate

__all__ = ["WornLines", "worn_lines"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Gauss points and weights of the semi-elliptic pressure (Chebyshev polynomials of the second kind)
_ORDER = 7
_POINTS = np.array([cos(pi * k / (_ORDER + 1)) for k in range(1, _ORDER + 1)])
_WEIGHTS = np.array([2.0 / (_ORDER + 1) * sin(pi * k / (_ORDER + 1)) ** 2 for k in range(1, _ORDER + 1)])

# Wear cannot make a contact flatter than this part of the fresh curvature: a flatter one would be more than twice
# as wide as the smoothing, and over such a width the curvature of the worn flank averages out.
_LEAST_CURVATURE = 0.25

_AT_BORDER = 1e-9  # mm
_EDGE_SLOPE = 1e-12  # outward fall of the gap at a border that makes it an edge contact
_FLATTEST = 1e-9  # 1/mm; keeps Hertz finite where geometry itself is conformal


@dataclass(frozen=True)
class WornLines:
    """Contact lines on a worn flank; arrays are (roll, face).

    Attributes
    ----------
    profile : array [mm]
        Profile coordinate of the valley, held inside the slice.
    gap : array [mm]
        Separation at the nominal rotation, with wear and rounded edges.
    curvature : array [1/mm]
        Relative curvature normal to the line.
    edge : bool array
        The slice touches at a rounded edge of either body.
    locus : array [mm]
        Profile coordinate of the valley, carried on over the arc of a rounded edge: its speed is the speed
        with which contact sweeps over the material.
    free : array [mm]
        Where the valley would lie if the slice had no ends, to first order.
    """

    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    edge: BoolArray
    locus: FloatArray
    free: FloatArray


@njit(cache=True)
def _smoothed(wear, nodes, split, place, width):  # type: ignore[no-untyped-def]
    total = 0.0
    first, last = nodes[0], nodes[-1]
    for q in range(_ORDER):
        at = place + width * _POINTS[q]
        # beyond the ends the flank is mirrored: nothing is known there, and an even wear must stay even
        if at < first:
            at = 2.0 * first - at
        elif at > last:
            at = 2.0 * last - at
        cell, x = locate(nodes, split, at)
        total += _WEIGHTS[q] * ((1.0 - x) * wear[cell] + x * wear[cell + 1])
    return total


@njit(cache=True)
def _smooth_flank(wear, nodes, split, width, level, slope, bend):  # type: ignore[no-untyped-def]
    """Wear averaged over a contact of half-width `width`, and its derivatives over half that distance."""
    for i in range(wear.shape[0]):
        h = 0.5 * width[i]
        for p in range(wear.shape[1]):
            u = nodes[i, p]
            left = _smoothed(wear[i], nodes[i], split[i], u - h, width[i])
            middle = _smoothed(wear[i], nodes[i], split[i], u, width[i])
            right = _smoothed(wear[i], nodes[i], split[i], u + h, width[i])
            level[i, p] = middle
            slope[i, p] = (right - left) / (2.0 * h)
            bend[i, p] = (left - 2.0 * middle + right) / (h * h)


@njit(cache=True)
def _read(values, nodes, split, place):  # type: ignore[no-untyped-def]
    cell, x = locate(nodes, split, place)
    return (1.0 - x) * values[cell] + x * values[cell + 1]


@njit(cache=True)
def _valley(at, low, high, cubic, level, slope, nodes, split, width, spread):  # type: ignore[no-untyped-def]
    """Place of the least smoothed gap in one slice, inside [low, high]."""
    g1, g2, g3 = cubic[1], cubic[2], cubic[3]
    # the valley cannot lie where the fresh separation alone exceeds what the wear varies by
    reach = 1.5 * (2.0 * spread / max(g2, 1e-4)) ** 0.5 + width
    start, stop = max(low, at - reach), min(high, at + reach)
    count = int((stop - start) / (0.5 * width)) + 3
    step = (stop - start) / (count - 1)
    best, least = at, 1e300
    for c in range(count):
        u = start + step * c
        d = u - at
        f = d * (g1 + d * (0.5 * g2 + d * g3 / 6.0)) + _read(level, nodes, split, u)
        if f < least:
            best, least = u, f
    left, right = max(best - step, start), min(best + step, stop)
    d = left - at
    if g1 + d * (g2 + 0.5 * d * g3) + _read(slope, nodes, split, left) >= 0.0:
        return left
    d = right - at
    if g1 + d * (g2 + 0.5 * d * g3) + _read(slope, nodes, split, right) <= 0.0:
        return right
    for _ in range(40):
        u = 0.5 * (left + right)
        d = u - at
        if g1 + d * (g2 + 0.5 * d * g3) + _read(slope, nodes, split, u) < 0.0:
            left = u
        else:
            right = u
    return 0.5 * (left + right)


@njit(cache=True)
def _search(  # type: ignore[no-untyped-def]
    needed, profile, low, high, separation, spacing, low_radius, high_radius,
    wear, level, slope, bend, nodes, split, width,
    out_profile, out_gap, out_curvature, out_edge, out_locus, out_free,
):  # fmt: skip
    rolls, faces = profile.shape
    for i in range(faces):
        spread = wear[i].max() - wear[i].min()
        for k in range(rolls):
            at, per_mm = profile[k, i], spacing[k, i]
            cubic = separation[:, k, i]
            place, height, worn_slope, worn_bend = at, wear[i, 0], 0.0, 0.0
            if needed[k, i] and spread > 0.0:
                place = _valley(
                    at, low[k, i], high[k, i], cubic, level[i], slope[i], nodes[i], split[i], width[i], spread
                )
                height = _read(level[i], nodes[i], split[i], place)
                worn_slope = _read(slope[i], nodes[i], split[i], place)
                worn_bend = _read(bend[i], nodes[i], split[i], place)
            d = place - at
            fresh_bend = cubic[2] + d * cubic[3]
            gap = cubic[0] + d * (cubic[1] + d * (0.5 * cubic[2] + d * cubic[3] / 6.0))
            # a parabola's mean under the pressure lies bend b^2/8 above its vertex
            gap += height - worn_bend * width[i] ** 2 / 8.0
            curvature = max(fresh_bend + worn_bend, _LEAST_CURVATURE * fresh_bend) / per_mm**2
            gradient = (cubic[1] + d * (cubic[2] + 0.5 * d * cubic[3]) + worn_slope) / per_mm
            outward, radius, direction = 0.0, 0.0, 0.0
            if place >= high[k, i] - _AT_BORDER:
                outward, radius, direction = -gradient, high_radius[k, i], 1.0
            elif place <= low[k, i] + _AT_BORDER:
                outward, radius, direction = gradient, low_radius[k, i], -1.0
            out_edge[k, i] = outward > _EDGE_SLOPE
            out_locus[k, i] = place
            out_free[k, i] = place
            if out_edge[k, i]:
                # on an arc of this radius the least gap lies where the arc's slope equals the flank's
                gap -= 0.5 * radius * outward * outward
                if radius > 0.0:
                    curvature += 1.0 / radius
                out_free[k, i] += direction * outward * per_mm / max(fresh_bend, 1e-4)
                out_locus[k, i] += direction * radius * outward / per_mm
            out_profile[k, i] = place
            out_gap[k, i] = gap
            out_curvature[k, i] = max(curvature, _FLATTEST)


def worn_lines(
    lines: ContactLines, grid: FlankGrid, wear: FloatArray, smoothing: float, needed: BoolArray
) -> WornLines:
    """Valley of the worn flank for every roll position.

    Parameters
    ----------
    lines : ContactLines
        Fresh contact lines.
    grid : FlankGrid
    wear : (face, profile) array [mm]
        Wear depth on the grid, >= 0.
    smoothing : float [mm]
        Half-width over which a contact feels the worn flank: wear enters averaged with the semi-elliptic
        pressure of a Hertz contact of this half-width (its mean is what the resultant works against).
    needed : (roll, face) bool array
        Slices that can carry load; the others keep their fresh place.
    """
    shape = lines.profile.shape
    profile, gap, curvature, locus, free = (np.empty(shape) for _ in range(5))
    edge = np.empty(shape, dtype=np.bool_)
    width = smoothing / np.mean(lines.spacing, axis=0)
    level, slope, bend = (np.zeros(wear.shape) for _ in range(3))
    if np.any(wear > 0.0):
        _smooth_flank(wear, grid.profile, grid.split, width, level, slope, bend)
    _search(
        needed, lines.profile, lines.low, lines.high, lines.separation, lines.spacing,
        lines.low_edge_radius, lines.high_edge_radius,
        wear, level, slope, bend, grid.profile, grid.split, width,
        profile, gap, curvature, edge, locus, free,
    )  # fmt: skip
    return WornLines(profile, gap, curvature, edge, locus, free)

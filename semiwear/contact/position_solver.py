"""Load sharing at a mesh position: which of its candidates may touch, and the loads on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.line_solver import NearField, Slices, solve_line_loads
from semiwear.contact.problem import picked
from semiwear.contact.rounded_contact import rounded_from
from semiwear.contact.stripe import pairs_among
from semiwear.kernel_cache import ZERO, njit

LEAST_WIDTH = 0.1
"""Least half-width of lightly loaded slices, over the typical one."""
MARGIN = 1.15
"""Over the expected approach: range of gaps within which slices may touch."""
_FIRST = 0.25  # of the slices, the nearest ones, start in contact if no loads are known


class WornSlices(NamedTuple):
    """Worn slices of all roll positions, flat (roll face,) arrays.

    Attributes
    ----------
    gap, profile : arrays [mm]
        Least separation and its profile coordinate.
    curvature : array [1/mm]
    softer : array [mm/N]
        Compliance beyond that of a Hertz contact: wear of a step per force, and `Footprints.softer`.
    """

    gap: FloatArray
    curvature: FloatArray
    profile: FloatArray
    softer: FloatArray


class SharingRules(NamedTuple):
    """Rules of load sharing that hold for all mesh positions.

    Attributes
    ----------
    near : NearField
    usual_half_width : float [mm]
    least_curvature : float [1/mm]
    tolerance : float
        Of half-widths between two solutions.
    max_iterations : int
    """

    near: NearField
    usual_half_width: float
    least_curvature: float
    tolerance: float
    max_iterations: int


@njit(cache=True, error_model="numpy")
def _rising(values):  # type: ignore[no-untyped-def]
    """A few values in rising order, by insertion: numpy's sorting takes seconds to compile."""
    out = values.copy()
    for i in range(1, out.shape[0]):
        value, k = out[i], i
        while k > 0 and out[k - 1] > value:
            out[k] = out[k - 1]
            k -= 1
        out[k] = value
    return out


@njit(cache=True, error_model="numpy")
def _places_of(values, rising):  # type: ignore[no-untyped-def]
    """Number of elements of `rising` that are less than each of `values`, which rise, too."""
    out, k = np.empty(values.shape[0], dtype=np.int64), ZERO
    for i in range(values.shape[0]):
        while k < rising.shape[0] and rising[k] < values[i]:
            k += 1
        out[i] = k
    return out


@njit(cache=True, error_model="numpy")
def _slices_of(found, chosen, worn, rules, all_force, all_width):  # type: ignore[no-untyped-def]
    """Chosen candidates as slices, the rotation at which the first touches, those in contact, and half-widths."""
    n, typical_width = chosen.size, rules.usual_half_width
    force, half_width = all_force.ravel(), all_width.ravel()
    gap, lever, length, arc = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    curvature, moved, width, floor = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    active, loaded, touching = np.empty(n, dtype=np.bool_), False, np.inf
    for i in range(n):
        c = chosen[i]
        at = found.flat[c]
        gap[i], lever[i], length[i], arc[i] = worn.gap[at], found.lever[c], found.length[c], found.arc[c]
        curvature[i] = max(worn.curvature[at], rules.least_curvature)
        moved[i] = min(max(worn.profile[at] - found.profile[c], -found.farthest_move), found.farthest_move)
        active[i], floor[i] = force[at] > 0.0, LEAST_WIDTH * typical_width
        loaded |= active[i]
        touching = min(touching, gap[i] / lever[i])
    # measured from first touch: a displaced pinion may be millimetres away, a light approach nanometres
    for i in range(n):
        gap[i] -= touching * lever[i]
    static = picked(found.static, found.slope, chosen, moved)
    nearest = 0.0 if loaded else _rising(gap)[int(_FIRST * (n - 1))]
    for i in range(n):
        at = found.flat[chosen[i]]
        static[i, i] += worn.softer[at]
        if loaded:
            width[i] = max(half_width[at], floor[i])
        else:
            active[i], width[i] = gap[i] <= nearest, typical_width
    starts = _places_of(found.starts, chosen)
    pairs = found.pairs if n == found.flat.size else pairs_among(found.pairs, chosen, found.flat.size)
    return Slices(static, gap, lever, arc, length, floor, curvature, starts, pairs), touching, active, width


@njit(cache=True, error_model="numpy")
def _put(found, chosen, slices, rotation, load, slack, width, torque, rolls, all_force, all_width):  # type: ignore[no-untyped-def]
    """Errors of the torque and of complementarity; stores loads and half-widths."""
    force, half_width = all_force.ravel(), all_width.ravel()
    for roll in rolls:
        all_force[roll] = 0.0
    balance, product, highest, deepest, approach = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(chosen.size):
        at = found.flat[chosen[i]]
        force[at], half_width[at] = load[i], width[i] if load[i] > 0.0 else 0.0
        balance += slices.lever[i] * load[i]
        # the Hertz pressure is proportional to the root of line load times curvature
        pressure = np.sqrt(load[i] / slices.length[i] * slices.curvature[i])
        highest, product = max(highest, pressure), max(product, pressure * abs(slack[i]))
        deepest = max(deepest, -slack[i])
        approach = max(approach, slices.lever[i] * rotation - slices.gap[i])
    return abs(balance / torque - 1.0), max(product / highest, deepest) / approach


@njit(cache=True, error_model="numpy")
def _chosen(near, every):  # type: ignore[no-untyped-def]
    """Numbers of the near ones, or of all."""
    out, count = np.empty(near.shape[0], dtype=np.int64), ZERO
    for i in range(near.shape[0]):
        if near[i] or every:
            out[count] = i
            count += 1
    return out[:count]


@njit(cache=True, error_model="numpy", nogil=True)
def share_torque(found, worn, torque, rules, rounding, rolls, expected, cap, force, half_width):  # type: ignore[no-untyped-def]
    """Forces on the slices of a mesh position that balance a torque.

    Parameters
    ----------
    found : Candidates
    worn : WornSlices
    torque : float [N mm]
    rules : SharingRules
    rounding : Rounding or None
    rolls : (pairs,) int array
        Roll positions of all pairs.
    expected : float [rad]
        Expected rotation, if loads are known.
    cap : float [mm]
        Separation below which slices may touch if none are known.
    force, half_width : (roll, face) arrays [N], [mm], changed
        Those of the start, then of the solution.

    Returns
    -------
    status : int
        `LineStatus`.
    rotation : float [rad]
    iterations : int
    change : float
        Last relative change of half-widths.
    balance : float
        Relative error of the torque.
    complementarity : float
        As in `TeethLoads`.
    """
    n = found.flat.size
    least, loaded = np.inf, False
    for i in range(n):
        least = min(least, worn.gap[found.flat[i]])
        loaded |= force.ravel()[found.flat[i]] > 0.0
    # only slices nearer than the approach can touch; if the start gives it, few remain
    near, count = np.empty(n, dtype=np.bool_), ZERO
    for i in range(n):
        if loaded:
            near[i] = worn.gap[found.flat[i]] < least + MARGIN * (expected * found.lever[i] - least)
        else:
            near[i] = found.least[i] < cap
        count += near[i]
    every = count == 0
    while True:
        chosen = _chosen(near, every)
        slices, touching, active, width = _slices_of(found, chosen, worn, rules, force, half_width)
        status, rotation, load, slack, iterations, change = solve_line_loads(
            slices, rules.near, torque, rounding, rules.tolerance, rules.max_iterations, active, width
        )
        if status != 0:
            return status, 0.0, iterations, change, 0.0, 0.0
        balance, complementarity = _put(
            found, chosen, slices, rotation, load, slack, width, torque, rolls, force, half_width
        )
        rotation += touching
        missed = False
        for i in range(n):
            if not near[i] and not every:
                missed |= worn.gap[found.flat[i]] - rotation * found.lever[i] < rounded_from(rounding)
        if not missed:
            return status, rotation, iterations, change, balance, complementarity
        every = True

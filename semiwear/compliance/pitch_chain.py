"""Chain of the pitches of a toothed body, joined to a rack with free ends or to a whole ring.

All teeth are equal, so one pitch is condensed onto its two sides in the middle of the tooth spaces
(`condensed_pitch`). Side unknowns are in the axes of their own side, so that neighbours in a ring share them as
neighbours in a rack do.
"""

from __future__ import annotations

from math import floor

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.compliance.condensed_pitch import Condensed
from semiwear.geometry.section import RingRim, ToothSection

DEFLECTION_OFFSETS = (-2, -1, 0, 1, 2)
"""Teeth whose deflection is kept; +1 is the neighbour that faces the loaded flank (x > 0)."""

STRESS_OFFSETS = (-1, 0, 1)
"""Teeth whose fillet stress is kept."""


def join(condensed: Condensed, section: ToothSection, rack_teeth: int) -> tuple[FloatArray, FloatArray]:
    """Join equal pitches and load the flank of the middle one.

    Parameters
    ----------
    condensed : Condensed
        The pitch at n wave numbers.
    section : ToothSection
        By its rim the pitches make a ring, which is whole, or a rack, whose ends are free.
    rack_teeth : int
        Teeth of a rack, an odd number.

    Returns
    -------
    deflection : (n, 5, H, H) array
        Of the teeth at `DEFLECTION_OFFSETS` from the loaded one; zero beyond the ends of a rack.
    stress : (n, 3, F, H) array
        Of the teeth at `STRESS_OFFSETS`, likewise.
    """
    pitch = condensed.stiffness
    count, side = len(pitch), pitch.shape[1] // 2
    teeth = 5 if isinstance(section.rim, RingRim) else min(rack_teeth, 5)
    whole = np.zeros((count, (teeth + 1) * side, (teeth + 1) * side))  # unknowns: sides of the teeth in order
    for tooth in range(teeth):
        whole[:, _sides(tooth, side), _sides(tooth, side)] += pitch
    first, last = slice(None, side), slice(teeth * side, None)
    near, far = slice(None, side), slice(side, None)
    if isinstance(section.rim, RingRim):
        rest = _chain_of(pitch, section.rim.teeth - teeth)
        whole[:, last, last] += rest[:, near, near]
        whole[:, last, first] += rest[:, near, far]
        whole[:, first, last] += rest[:, far, near]
        whole[:, first, first] += rest[:, far, far]
    elif rack_teeth > teeth:
        rest = _chain(pitch, (rack_teeth - teeth) // 2)
        whole[:, last, last] += _without(rest, near, far)
        whole[:, first, first] += _without(rest, far, near)

    middle = teeth // 2
    load = np.zeros((count, whole.shape[1], condensed.side_load.shape[2]))
    load[:, _sides(middle, side)] = condensed.side_load
    moved = np.linalg.solve(whole, load)

    def of_teeth(offsets: tuple[int, ...], rows: FloatArray, own: FloatArray) -> FloatArray:
        values = np.zeros((count, len(offsets), *own.shape[1:]))
        for place, offset in enumerate(offsets):
            if abs(offset) <= middle:
                values[:, place] = rows @ moved[:, _sides(middle + offset, side)]
        values[:, offsets.index(0)] += own
        return values

    deflection = of_teeth(DEFLECTION_OFFSETS, condensed.deflection, condensed.deflection_load)
    return deflection, of_teeth(STRESS_OFFSETS, condensed.stress, condensed.stress_load)


def _sides(tooth: int, side: int) -> slice:
    """Unknowns of both sides of a tooth."""
    return slice(tooth * side, (tooth + 2) * side)


def _without(stiffness: FloatArray, keep: slice, drop: slice) -> FloatArray:
    """Schur complement: stiffness of the kept unknowns with the dropped ones free of load."""
    coupling = stiffness[:, drop, keep]
    carried = np.linalg.solve(stiffness[:, drop, drop], coupling)
    return stiffness[:, keep, keep] - coupling.swapaxes(1, 2) @ carried


def _chain_of(pitch: FloatArray, count: float) -> FloatArray:
    """Stiffness of the outer sides of a chain of pitches, whose number need not be whole.

    Between whole numbers the stiffness is linear: the ring of a virtual spur gear has no whole number of teeth.
    """
    whole = floor(count)
    part = count - whole
    chain = _chain(pitch, whole)
    return chain if part == 0.0 else (1.0 - part) * chain + part * _pair(chain, pitch)


def _chain(pitch: FloatArray, count: int) -> FloatArray:
    """Stiffness (n, 2 s, 2 s) of the outer sides of a chain of pitches, by doubling."""
    if count == 1:
        return pitch
    half = _chain(pitch, count // 2)
    double = _pair(half, half)
    return _pair(double, pitch) if count % 2 else double


def _pair(first: FloatArray, second: FloatArray) -> FloatArray:
    """Stiffness of the outer sides of two chains of pitches that share a side."""
    s = first.shape[1] // 2
    joined = np.zeros((len(first), 3 * s, 3 * s))  # unknowns: outer left, shared, outer right
    joined[:, : 2 * s, : 2 * s] += first
    joined[:, s:, s:] += second
    outer = np.concatenate([np.arange(s), np.arange(2 * s, 3 * s)])
    coupling = joined[:, s : 2 * s, outer]
    kept = joined[:, outer[:, None], outer]
    return kept - coupling.swapaxes(1, 2) @ np.linalg.solve(joined[:, s : 2 * s, s : 2 * s], coupling)

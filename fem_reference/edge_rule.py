r"""Classification of edge pressures: the rule of the result variable `contact_pressure_max_edge`.

The reference length is the half-width b of the Hertz ellipse with the whole torque on one unworn pair at the pitch
point. A pressure counts as at the border

* nearer than 2 b, across the contact line, to the end of the slice on either flank: the tips' roundings, the fillets;
* nearer than 2 b to the roundings at the ends of either flank's face;
* in a slice nearer than 12 b, along the line, to one with a higher pressure at the border than elsewhere:
  a loaded edge relieves its neighbours.

It is the rule of `semiwear.contact.loaded_teeth`, written independently from the geometry here; a test checks that
both agree.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from fem_reference.arrays import BoolArray, FloatArray
from fem_reference.pair_motion import PairMotion
from fem_reference.pairs import module_of, pair_motion
from fem_reference.rigid_lines import RigidLine, effective_modulus

_ACROSS = 2.0  # reference half-widths from an edge
_ALONG = 12.0  # reference half-widths along the line from a slice whose edge presses
_STEP = 0.016  # modules, of the differences that give curvatures
_FLAT = 1e-5  # of the curvature across the line: with less curvature along it, contact is along a line


def reference_half_width(pair: PairMotion) -> float:
    """Minor half-axis of the contact ellipse at the pitch point, whole torque on one unworn, aligned pair [mm].

    Half the width of a line contact over the whole face where contact is along lines.

    Source: Johnson 1985, *Contact Mechanics*, equations 4.26 to 4.32 and 4.43.
    """
    aligned = pair_motion(pair.scene)
    across, along = _principal_curvatures(aligned)
    force = 1e3 * pair.scene.operation.pinion_torque_Nm / aligned.lever

    if along < _FLAT * across:
        low, high = pair.gear_face
        return sqrt(4.0 * force / (pi * (high - low) * effective_modulus(pair.scene) * across))

    # b/a from the ratio of the curvatures; m = 1 - (b/a)^2
    def excess(ratio: float) -> float:
        m = 1.0 - ratio**2
        k, e = ellipk(m), ellipe(m)
        return float((e / ratio**2 - k) / (k - e)) - across / along

    ratio = float(brentq(excess, 1e-6, 1.0 - 1e-6))
    m = 1.0 - ratio**2
    shape = float(ellipk(m) - ellipe(m)) / m
    major = (3.0 * force * shape / (pi * effective_modulus(pair.scene) * along)) ** (1.0 / 3.0)
    return float(ratio * major)


def _principal_curvatures(pair: PairMotion) -> tuple[float, float]:
    """Greater and smaller curvature of the gap at the pitch point [1/mm]."""
    step = _STEP * module_of(pair.scene)
    face, steps = pair.pitch_face, np.array([-1.0, 0.0, 1.0]) * step
    met = pair.meeting(face + steps[:, None], steps[None, :], 0.0)
    tangent = np.stack([met.position[2, 1] - met.position[0, 1], met.position[1, 2] - met.position[1, 0]])
    tangent /= 2.0 * step
    gap = met.gap
    mixed = (gap[2, 2] - gap[2, 0] - gap[0, 2] + gap[0, 0]) / (4.0 * step**2)
    second = [
        (gap[2, 1] - 2.0 * gap[1, 1] + gap[0, 1]) / step**2,
        (gap[1, 2] - 2.0 * gap[1, 1] + gap[1, 0]) / step**2,
    ]
    hessian = np.array([[second[0], mixed], [mixed, second[1]]])
    # in lengths on the flank instead of coordinates
    values = np.linalg.eigvals(np.linalg.solve(tangent @ tangent.T, hessian)).real
    return float(values.max()), float(values.min())


def beside_edges(
    pair: PairMotion,
    half_width: float,
    line: RigidLine,
    face: FloatArray,
    profile: FloatArray,
    pinion_face: FloatArray,
    pinion_profile: FloatArray,
    pressure: FloatArray,
) -> BoolArray:
    """Points whose pressure counts as an edge pressure.

    Parameters
    ----------
    pair : PairMotion
    half_width : float [mm]
        `reference_half_width`.
    line : RigidLine
        Of the pair at the roll position.
    face, profile, pinion_face, pinion_profile, pressure : (k,) arrays [mm], [MPa]
        Points on both flanks; equal `face` means the same slice.
    """
    margin, inset = _ACROSS * half_width, pair.edge_insets(face)
    spacing = np.interp(face, line.face, line.spacing)
    # the pinion's profile coordinate is a length of its own, the gear's one of the shaper
    ends = np.minimum(pair.gear.tip_profile(face) - inset.gear_tip - profile, profile - pair.gear.root_profile)
    pinion_tip = pair.pinion_profile_limits[1]
    across = np.minimum(ends * spacing, pinion_tip - inset.pinion_tip - pinion_profile) < margin
    table = pair.scene.gear_pair
    own = np.minimum(face - pair.gear_face[0], pair.gear_face[1] - face) - table.gear_end_edge_radius_mm
    theirs = np.minimum(pinion_face - pair.pinion_face[0], pair.pinion_face[1] - pinion_face)
    aside = across | (np.minimum(own, theirs - table.pinion_end_edge_radius_mm) < margin)

    stations, slice_of = np.unique(face, return_inverse=True)
    inner, border = np.zeros(len(stations)), np.zeros(len(stations))
    np.maximum.at(inner, slice_of, np.where(across, 0.0, pressure))
    np.maximum.at(border, slice_of, np.where(across, pressure, 0.0))
    place = np.interp(stations, line.face, line.arc)
    pressed = place[border > inner]
    if len(pressed):
        near = np.abs(place[:, None] - pressed).min(axis=1) < _ALONG * half_width
        aside = aside | near[slice_of]
    return np.asarray(aside)

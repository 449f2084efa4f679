"""Free ends of a tooth: correction of its prism.

The cosines of a prism mirror it at its ends: no shear stress there, but no displacement along the tooth either. A
free end has no normal stress instead; a load some 20 mm from it then causes a few per cent more root stress, and
the root stress at the end itself falls by a quarter within a millimetre. An inclined tooth ends in planes normal to
the axis, its prism in planes normal to the tooth: where the loaded flank reaches farther than the other, the corner
is acute and deflects half as much again; at the obtuse corner the tooth is supported.

A stretch of one tooth with the ground around it is computed in three dimensions (`tooth_stretch`), with its own
ends and with mirrored square ones; the difference corrects the prism. Its section is coarse, which lowers all
stresses of the fillet by a tenth: the difference is taken relative to the stress far from any end and applied to the
prism's, which is converged. Square ends add only bending deflection here: their effect on the local deflection under
loads is in `free_edges`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin

import numpy as np
from scipy.interpolate import make_interp_spline

from semiwear.arrays import FloatArray
from semiwear.compliance.cubics import cubic_weights
from semiwear.compliance.pitch_chain import STRESS_OFFSETS
from semiwear.compliance.prism import PrismSection
from semiwear.compliance.root import ROOT_FROM
from semiwear.compliance.section_elements import fillet_shares
from semiwear.compliance.section_outline import load_heights
from semiwear.compliance.tooth_stretch import HEIGHTS, ORDERS, Stretch
from semiwear.geometry.section import RingRim, ToothSection
from semiwear.kept_on_disk import kept_on_disk

_GROUND = 0.67  # depth of the ground below the root, as a share of the tooth's height: a module and a half


@dataclass(frozen=True)
class EndEffect:
    """Additional deflection and stress of the loaded tooth due to free ends, by loads normal to the flank.

    Loads and deflections are expanded along the axis in P polynomials, see `along_width`, at each of H load heights.

    Attributes
    ----------
    deflection : (P H, P H) array [mm/N]
        Of the flank without the local deflection under loads; symmetric.
    stress : (P, F, P H) array [MPa/N]
        Tangential stress of the fillet on the loaded side.
    fillet_share : (F,) array
        Points of the fillet as fractions of its length from the end of the flank.
    """

    deflection: FloatArray
    stress: FloatArray
    fillet_share: FloatArray


@kept_on_disk
def end_effect(
    section: ToothSection,
    prism: PrismSection,
    *,
    width: float,
    slant: float,
    youngs_modulus: float,
    poissons_ratio: float,
    name: str = "tooth section",
) -> EndEffect:
    """Correction of a prism with mirrored ends for the free ends of a tooth.

    Parameters
    ----------
    section : ToothSection
        Normal to the tooth [mm].
    prism : PrismSection
        Of this section, with mirrored ends.
    width : float [mm]
        Between the ends, along the axis.
    slant : float [rad]
        Helix angle, positive when the tooth runs with z in the direction of the load.
    youngs_modulus : float [MPa]
    poissons_ratio : float
    name : str
        Name of the section in error messages.
    """
    stretch = Stretch.of(
        _on_shallow_ground(section),
        width=width,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        along=cos(slant),
        name=name,
    )
    mirrored, square = stretch.influence(mirrored=True), stretch.influence()
    free = square if slant == 0.0 else replace(stretch, lean=sin(slant)).influence()
    share = fillet_shares(stretch.mesh)
    fine, coarse = _peaks(_steady(prism), prism.fillet_share), _peaks(mirrored.stress[0, :, :HEIGHTS], share)
    # a load beside the fillet may cause no peak of stress in either
    finer = np.where((fine > 0.0) & (coarse > 0.0), fine / np.where(coarse > 0.0, coarse, 1.0), 1.0)
    return EndEffect(
        deflection=free.deflection - square.deflection + square.bending - mirrored.bending,
        stress=(free.stress - mirrored.stress) * np.tile(finer, ORDERS),
        fillet_share=share,
    )


def _steady(prism: PrismSection) -> FloatArray:
    """Stress of the loaded tooth's fillet by an even line load at each height of the stretch: (F, H) array."""
    weights, _ = cubic_weights(load_heights(HEIGHTS), load_heights(prism.load_profile.size))
    steady: FloatArray = prism.stress[0, STRESS_OFFSETS.index(0)] @ weights.T
    return steady


def _peaks(stress: FloatArray, share: FloatArray) -> FloatArray:
    """Greatest stress of the root by loads at each height."""
    between = make_interp_spline(share, stress, k=3)
    peaks: FloatArray = between(np.linspace(ROOT_FROM, 1.0, 101)).max(axis=0)
    return peaks


def _on_shallow_ground(section: ToothSection) -> ToothSection:
    """The section held at a small depth below its root, or at its own held face if that is nearer."""
    rim, root = section.rim, section.fillet[-1]
    if isinstance(rim, RingRim):
        low = float(np.hypot(*root))
        return replace(section, rim=replace(rim, bore_radius=max(rim.bore_radius, low - depth_of_ground(section))))
    low = float(root[1])
    return replace(section, rim=replace(rim, back_height=max(rim.back_height, low - depth_of_ground(section))))


def depth_of_ground(section: ToothSection) -> float:
    """Depth below the root at which the ground of the stretch is held [mm], unless the wheel is held above it."""
    tip, root = section.flank[0], section.fillet[-1]
    if isinstance(section.rim, RingRim):
        return _GROUND * float(np.hypot(*tip) - np.hypot(*root))
    return _GROUND * float(tip[1] - root[1])

"""The wheel under inclined teeth, in place of the ring of their virtual spur gear.

A tooth's prism stands on the ring of the virtual spur gear. The deflection of that ring under the forces and couples
on the feet of its teeth is subtracted, and the deflection of the true wheel under the same loads along the true helix
is added: both from elastic annuli (`annulus.py`) under feet of one chord, so that the local deflection at a foot
cancels, and without a helix angle both cancel. The difference is that of the wheel: its torsion, its shear and
tilting under the axial force, its width and radius, and the helix of the teeth around it.

With the loads of a foot, spread along the axis as polynomial s, b_m(s) in harmonic m of the angle, and g_m the
flexibility of the annulus,

    C(s, s', o) = sum over m of Re [exp(2 pi i m o/z) b_m(s)^H g_m b_m(s')],     o teeth between the two feet.

The wheel's strain at the root of a tooth is read in the same way: the stress of the loaded cylinder normal to the
tooth, averaged over its foot. Of the tooth's own loads only the far field counts, of deflection and stress: their
effect on the ground beside the tooth, slanted ends included, is in the stretch of tooth and ground (`tooth_ends`), so
that an annulus held where that ground is held, with the same elements above, is subtracted. An axial force bends a
solid wheel like a disc; at the ends of a narrow face that is a tenth of the root stress, of either sign.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, hypot, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.annulus import Annulus
from semiwear.compliance.polynomials import along_width
from semiwear.compliance.quadratic import quadratic_weights
from semiwear.geometry.inclined_foot import FootRing

OFFSETS = np.arange(-4, 5)
"""Teeth between the observed and the loaded one, counted towards where the load pushes."""


POLYNOMIALS = 6
"""Orders in which loads are expanded along the axis: shorter waves are local to a foot."""

_FOOT_POINTS = 5  # across a foot
_LEAST_HARMONICS = 24
_LEAST_ELEMENTS = 12
_CHUNK = 64  # harmonics summed at a time


class RingInfluence(NamedTuple):
    """Deflection and stress by loads on the feet of a ring's teeth, for each of `OFFSETS`.

    Loads are spread along the axis as P polynomials, see `along_width`: [polynomial, (radial, tangential, axial,
    couple)].

    Attributes
    ----------
    compliance : (9, 4 P, 4 P) array
        Motion of a foot, spread in the same way; [mm/N], [mm/(N mm)] and [rad/(N mm)]. Of the loaded tooth itself
        without the effect of the ground nearby.
    stress : (9, P, 4 P) array [MPa/N], [MPa/(N mm)]
        Stress of the ring's surface normal to the tooth, averaged over its foot and expanded in polynomials. Of the
        loaded tooth itself without the effect of the ground nearby.
    """

    compliance: FloatArray
    stress: FloatArray


def ring_influence(
    ring: FootRing, youngs_modulus: float, poissons_ratio: float, elements: int, ground: float
) -> RingInfluence:
    """Deflection and stress of a ring under loads on the feet of its teeth.

    Parameters
    ----------
    ring : FootRing
    youngs_modulus : float [MPa]
    poissons_ratio : float
    elements : int
        Along the axis, see `elements_along`.
    ground : float [mm]
        Depth of the ground that belongs to the stretch of tooth.
    """
    depth = min(ground / abs(ring.held_radius - ring.foot_radius), 1.0)
    between = ring.foot_radius + depth * (ring.held_radius - ring.foot_radius)
    annulus = Annulus(
        ring.held_radius, ring.foot_radius, ring.width, youngs_modulus, poissons_ratio, elements, between
    )
    # waves shorter than a foot average out; the last counts in part, so that the result is continuous in the radius
    shortest = max(2.0 * pi * ring.foot_radius / ring.chord, _LEAST_HARMONICS)
    harmonics = ceil(shortest)
    whole = annulus.flexibility(harmonics)
    near = whole if depth == 1.0 else replace(annulus, held=between).flexibility(harmonics)
    compliance = np.zeros((OFFSETS.size, 4 * POLYNOMIALS, 4 * POLYNOMIALS))
    stress = np.zeros((OFFSETS.size, POLYNOMIALS, 4 * POLYNOMIALS))
    own = np.flatnonzero(OFFSETS == 0)[0]
    for first in range(0, harmonics + 1, _CHUNK):
        m = np.arange(first, min(first + _CHUNK, harmonics + 1))
        load = _foot_loads(ring, annulus.stations, m)
        moved = whole[m] @ load
        turned = np.exp(2j * pi / ring.teeth * np.multiply.outer(OFFSETS, m))
        turned *= np.clip(shortest - m + 1.0, 0.0, 1.0)
        held = near[m] @ load
        compliance += np.tensordot(turned, load.conj().swapaxes(1, 2) @ moved, axes=1).real
        compliance[own] -= np.tensordot(turned[own], load.conj().swapaxes(1, 2) @ held, axes=1).real
        gauge = _gauges(ring, annulus.stations, m, youngs_modulus, poissons_ratio).conj().swapaxes(1, 2)
        stress += np.tensordot(turned, gauge @ moved, axes=1).real
        stress[own] -= np.tensordot(turned[own], gauge @ held, axes=1).real
    return RingInfluence(compliance, stress)


def elements_along(ring: FootRing) -> int:
    """Elements along the axis that follow a load around the ring: half a foot each, twelve at least."""
    return max(ceil(2.0 * ring.width / ring.chord), _LEAST_ELEMENTS)


class _Foot(NamedTuple):
    """Points of the foot of the tooth whose middle is at each position along the axis; it is normal to the tooth."""

    angle: FloatArray  # (places, points) [rad]
    height: FloatArray  # along the axis [mm]
    across: FloatArray  # (points,) [mm]
    share: FloatArray  # (points,)
    spread: FloatArray  # (places, P) polynomials, times the weight of each place


def _foot(ring: FootRing, z: FloatArray) -> _Foot:
    at, weight = np.polynomial.legendre.leggauss(_FOOT_POINTS)
    across, share = 0.5 * ring.chord * at, 0.5 * weight
    at, weight = np.polynomial.legendre.leggauss(2 * z.size)
    along, spread = 0.5 * ring.width * at, 0.5 * weight[:, None] * along_width(0.5 * at, POLYNOMIALS)
    cosine = 1.0 / hypot(1.0, ring.slope)
    angle = (ring.slope * along[:, None] + cosine * across) / ring.foot_radius
    height = np.clip(along[:, None] - ring.slope * cosine * across, z[0], z[-1])
    return _Foot(angle, height, across, share, spread)


def _foot_loads(ring: FootRing, z: FloatArray, harmonics: IntArray) -> NDArray[np.complex128]:
    """Harmonics of loads on feet, expanded along the axis: (m, 3 S, 4 P) array, see the module."""
    foot = _foot(ring, z)
    on_stations = quadratic_weights(z, foot.height.ravel()).T.reshape(z.size, *foot.height.shape)
    phase = np.exp(-1j * harmonics[:, None, None] * foot.angle)
    couple = 12.0 / ring.chord**2 * foot.across * foot.share
    even, turning = (
        np.einsum("nsk,msk,k,sp->mnp", on_stations, phase, by, foot.spread, optimize=True)
        for by in (foot.share, couple)
    )
    loads = np.zeros((harmonics.size, z.size, 3, POLYNOMIALS, 4), dtype=complex)
    loads[:, :, 0, :, 0] = loads[:, :, 2, :, 2] = even
    loads[:, :, 1, :, 1] = 1j * even  # a tangential load turns sines into cosines
    loads[:, :, 0, :, 3] = turning
    return loads.reshape(harmonics.size, 3 * z.size, 4 * POLYNOMIALS)


def _gauges(
    ring: FootRing, z: FloatArray, harmonics: IntArray, youngs_modulus: float, poissons_ratio: float
) -> NDArray[np.complex128]:
    """Readings of the stress normal to a tooth from the loaded cylinder's harmonics: (m, 3 S, P) array.

    The surface is free, so that its stress follows from two strains, as `fem_reference.root_stress` reads a fillet.
    """
    foot, radius, slope = _foot(ring, z), ring.foot_radius, ring.slope
    smooth = make_interp_spline(z, np.eye(z.size), k=3)
    phase = np.exp(-1j * harmonics[:, None, None] * foot.angle)
    value, by_z = (
        np.einsum("skn,msk,k,sp->mnp", smooth(foot.height, nu=order), phase, foot.share, foot.spread, optimize=True)
        for order in (0, 1)
    )
    m = harmonics[:, None, None]
    hoop, axial, shear = (np.zeros((harmonics.size, z.size, 3, POLYNOMIALS), dtype=np.complex128) for _ in range(3))
    hoop[:, :, 0], hoop[:, :, 1] = value / radius, m * value / radius
    axial[:, :, 2] = by_z
    shear[:, :, 1], shear[:, :, 2] = 1j * by_z, -1j * m * value / radius
    both = hoop + axial
    across = (hoop + slope**2 * axial - slope * shear) / (1.0 + slope**2)
    stress: NDArray[np.complex128] = across + poissons_ratio * (both - across)
    stress *= youngs_modulus / (1.0 - poissons_ratio**2)
    return stress.reshape(harmonics.size, 3 * z.size, POLYNOMIALS)

"""The wheel under inclined teeth, in place of the ring of their virtual spur gear.

A tooth's prism stands on the ring of the virtual spur gear. What that ring yields to the forces and couples on the
feet of its teeth is taken off, and what the true wheel yields to the same loads along the true helix is put on: both
from elastic annuli (`annulus.py`) under feet of one chord, so that what is local to a foot cancels, and all of it
without a helix angle. What remains is the wheel's own: its torsion, its shear and tilting under the axial force, its
width and radius, the teeth's way around it.

With the loads of a foot, spread along the axis as polynomial s, b_m(s) in harmonic m of the angle, and g_m the
flexibility of the annulus,

    C(s, s', o) = sum over m of Re [exp(2 pi i m o/z) b_m(s)^H g_m b_m(s')],     o teeth between the two feet.
"""

from __future__ import annotations

from math import ceil, hypot, pi

import numpy as np
from numpy.typing import NDArray

from semiwear.compliance.annulus import Annulus
from semiwear.compliance.polynomials import along_width
from semiwear.compliance.quadratic import quadratic_weights
from semiwear.geometry.inclined_foot import FootRing

__all__ = ["OFFSETS", "POLYNOMIALS", "elements_along", "ring_compliance"]

FloatArray = NDArray[np.float64]

OFFSETS = np.arange(-4, 5)
"""Teeth between the observed and the loaded one, counted towards where the load pushes."""


POLYNOMIALS = 6
"""Orders in which loads are spread along the axis: what is shorter is local to a foot."""

_FOOT_POINTS = 5  # across a foot
_LEAST_HARMONICS = 24
_LEAST_ELEMENTS = 12
_CHUNK = 64  # harmonics summed at a time


def ring_compliance(ring: FootRing, youngs_modulus: float, poissons_ratio: float, elements: int) -> FloatArray:
    """Deflection of a ring under loads on the feet of its teeth.

    Parameters
    ----------
    ring : FootRing
    youngs_modulus : float [MPa]
    poissons_ratio : float
    elements : int
        Along the axis, see `elements_along`.

    Returns
    -------
    (9, 4 P, 4 P) array
        For each of `OFFSETS`: motion of a foot by loads on a foot, both spread along the axis as `along_width` says,
        [polynomial, (radial, tangential, axial, couple)]; [mm/N], [mm/(N mm)] and [rad/(N mm)].
    """
    annulus = Annulus(ring.held_radius, ring.foot_radius, ring.width, youngs_modulus, poissons_ratio, elements)
    # waves shorter than a foot are evened out on it; the last counts in part, so that nothing jumps with the radius
    shortest = max(2.0 * pi * ring.foot_radius / ring.chord, _LEAST_HARMONICS)
    harmonics = ceil(shortest)
    flexibility = annulus.flexibility(harmonics)
    table = np.zeros((OFFSETS.size, 4 * POLYNOMIALS, 4 * POLYNOMIALS))
    for first in range(0, harmonics + 1, _CHUNK):
        m = np.arange(first, min(first + _CHUNK, harmonics + 1))
        load = _foot_loads(ring, annulus.stations, m)
        own = load.conj().swapaxes(1, 2) @ (flexibility[m] @ load)
        turned = np.exp(2j * pi / ring.teeth * np.multiply.outer(OFFSETS, m))
        table += np.tensordot(turned * np.clip(shortest - m + 1.0, 0.0, 1.0), own, axes=1).real
    return table


def elements_along(ring: FootRing) -> int:
    """Elements along the axis that follow a load around the ring: half a foot each, twelve at least."""
    return max(ceil(2.0 * ring.width / ring.chord), _LEAST_ELEMENTS)


def _foot_loads(ring: FootRing, z: FloatArray, harmonics: NDArray[np.int64]) -> NDArray[np.complex128]:
    """Harmonics of loads on feet, spread along the axis: (m, 3 S, 4 P) array, see the module."""
    at, weight = np.polynomial.legendre.leggauss(_FOOT_POINTS)
    across, share = 0.5 * ring.chord * at, 0.5 * weight
    at, weight = np.polynomial.legendre.leggauss(2 * z.size)
    along, spread = 0.5 * ring.width * at, 0.5 * weight[:, None] * along_width(0.5 * at, POLYNOMIALS)
    cosine = 1.0 / hypot(1.0, ring.slope)
    # points of the foot of the tooth whose middle is at each place: the foot stands normal to the tooth
    angle = (ring.slope * along[:, None] + cosine * across) / ring.foot_radius
    height = np.clip(along[:, None] - ring.slope * cosine * across, z[0], z[-1])
    on_stations = quadratic_weights(z, height.ravel()).T.reshape(z.size, *height.shape)
    phase = np.exp(-1j * harmonics[:, None, None] * angle)
    couple = 12.0 / ring.chord**2 * across * share
    even, turning = (
        np.einsum("nsk,msk,k,sp->mnp", on_stations, phase, by, spread, optimize=True) for by in (share, couple)
    )
    loads = np.zeros((harmonics.size, z.size, 3, POLYNOMIALS, 4), dtype=complex)
    loads[:, :, 0, :, 0] = loads[:, :, 2, :, 2] = even
    loads[:, :, 1, :, 1] = 1j * even  # a tangential load turns sines into cosines
    loads[:, :, 0, :, 3] = turning
    return loads.reshape(harmonics.size, 3 * z.size, 4 * POLYNOMIALS)

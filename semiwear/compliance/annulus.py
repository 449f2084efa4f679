"""An elastic annulus of finite width: held on one cylinder, loaded on the other, its end faces free.

Harmonic m of the angle about the axis, with unit loads along r, theta and z at a station of the loaded cylinder:

    u_r = U(r, z) cos(m theta),   u_theta = V(r, z) sin(m theta),   u_z = W(r, z) cos(m theta)

whose strains are (B0 + m B1) q, so that every harmonic is one sparse plane problem, K0 + m K1 + m^2 K2.

Source: O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 2, 5th ed. 2000, ch. 9 (axisymmetric solids
under non-axisymmetric loads).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.sparse import coo_matrix, csc_matrix, eye_array, kron
from skfem import Basis, ElementQuad2, MeshQuad

from semiwear.arrays import FloatArray
from semiwear.compliance.condensation import factors_of, halves
from semiwear.compliance.section_elements import elasticity, unknowns_of

_THROUGH = 6  # elements through the wall
_ABOVE, _BELOW = 4, 4  # elements from the loaded cylinder to the intermediate one, and from there to the held one
_TOWARDS_LOAD = 1.5  # exponent by which elements grow away from the loaded cylinder, in the logarithm of the radius
_EXACT, _BETWEEN = 6, 10  # harmonics solved individually, and interpolation nodes from there to the last


@dataclass(frozen=True)
class Annulus:
    """A ring about its axis.

    Attributes
    ----------
    held, loaded : float [mm]
        Radii of the fixed cylinder and of the loaded one; either may be the greater.
    width : float [mm]
    youngs_modulus [MPa], poissons_ratio [1] : float
    elements : int
        Along the axis.
    between : float, optional [mm]
        Radius of an intermediate element boundary: an annulus that is held there has the same elements above it.
    """

    held: float
    loaded: float
    width: float
    youngs_modulus: float
    poissons_ratio: float
    elements: int = 12
    between: float | None = None

    @property
    def stations(self) -> FloatArray:
        """Nodes of the loaded cylinder along the axis, from the middle of the width: (S,) array [mm].

        Corner and middle nodes of quadratic elements in turn.
        """
        corners = self._corners()
        return np.sort(np.concatenate([corners, 0.5 * (corners[1:] + corners[:-1])]))

    def flexibility(self, harmonics: int) -> FloatArray:
        """Displacement of the loaded cylinder by unit forces on it, for m = 0 to `harmonics`.

        Parameters
        ----------
        harmonics : int
            Six at least. Above m = 5 the flexibility is smooth in m and interpolated between a few.

        Returns
        -------
        (harmonics + 1, 3 S, 3 S) array [mm/N]
            Amplitudes (U, V, W) at every station for forces in these directions at every station. A force F at
            theta = 0 along r moves the ring along r by the sum over m of F U_m cos(m theta).
        """
        orders = np.arange(harmonics + 1, dtype=float)
        beyond = np.geomspace(_EXACT - 1, max(harmonics, _EXACT), _BETWEEN)
        solved = np.concatenate([orders[: _EXACT - 1], beyond])
        found = np.zeros((harmonics + 1, 3 * self.stations.size, 3 * self.stations.size))
        for layers in self._halves():
            values = layers.flexibility(solved)
            # for short waves the flexibility is that of a half-space, inverse to m
            spline = make_interp_spline(np.log(solved[2:]), values[2:] * (1.0 + solved[2:])[:, None, None], k=3)
            further = spline(np.log(orders[_EXACT:])) / (1.0 + orders[_EXACT:])[:, None, None]
            found += layers.shapes @ np.concatenate([values[:_EXACT], further])[: harmonics + 1] @ layers.shapes.T
        return found

    def _corners(self) -> FloatArray:
        """Ends of the elements along the axis: the mean of even spacing and spacing refined towards the ends."""
        even = np.linspace(-1.0, 1.0, self.elements + 1)
        return 0.25 * self.width * (even + np.sin(0.5 * pi * even))

    def _wall(self) -> FloatArray:
        """Radii of the element boundaries through the wall, from the loaded cylinder on."""
        if self.between is None:
            return _growing(self.loaded, self.held, _THROUGH)
        above = _growing(self.loaded, self.between, _ABOVE)
        if self.between == self.held:
            return above
        return np.concatenate([above, np.geomspace(self.between, self.held, _BELOW + 1)[1:]])

    def _halves(self) -> Iterator[_Layers]:
        """Fields that are symmetric about the middle of the width, and antisymmetric ones."""
        mesh = MeshQuad.init_tensor(np.sort(self._wall()), self._corners())
        basis = Basis(mesh, ElementQuad2(), intorder=4)
        radius, along = basis.doflocs
        # cylinders of nodes from the held one to the loaded one, the nodes of each along the axis
        ends = np.sort(abs(self._wall() - self.held))
        cylinder = np.rint(2.0 * np.interp(abs(radius - self.held), ends, np.arange(ends.size)))
        ordered = unknowns_of(np.lexsort((along, cylinder)))
        matrices = [k[ordered][:, ordered] for k in _matrices(basis, self.youngs_modulus, self.poissons_ratio)]
        cylinders = 2 * ends.size - 1
        for sign in (1.0, -1.0):
            shapes = _shapes(radius.size // cylinders, sign)
            n = shapes.shape[1]
            everywhere = kron(eye_array(cylinders), shapes, format="csr")
            of_shapes = [everywhere.T @ (k @ everywhere) for k in matrices]
            layers = [slice((layer + 1) * n, (layer + 3) * n) for layer in range(0, cylinders - 1, 2)]
            own = [[k[layer, layer].toarray() for k in of_shapes] for layer in layers]
            below = [[k[layer, layer.start - n : layer.start].toarray() for k in of_shapes] for layer in layers[1:]]
            yield _Layers(shapes, np.array(own), np.array(below).reshape(-1, len(matrices), 2 * n, n))


def _shapes(nodes: int, sign: float) -> FloatArray:
    """Orthonormal fields along the axis whose U and V are even (`sign` 1) or odd (-1) in z, and W the opposite.

    Returns
    -------
    (3 nodes, n) array
        Of an odd number of nodes.
    """
    half = nodes // 2
    pair, middle = np.eye(half, nodes) / sqrt(2.0), np.eye(1, nodes, half)
    even, odd = np.vstack([pair + pair[:, ::-1], middle]), pair - pair[:, ::-1]
    parts = (even, even, odd) if sign > 0.0 else (odd, odd, even)
    return np.vstack([np.kron(part, unit) for part, unit in zip(parts, np.eye(3), strict=True)]).T


def _growing(first: float, last: float, count: int) -> FloatArray:
    return np.asarray(first * (last / first) ** ((np.arange(count + 1) / count) ** _TOWARDS_LOAD))


@dataclass(frozen=True)
class _Layers:
    """Stiffness of the layers of elements, in fields along the axis.

    A layer has two cylinders of nodes with n fields each, one through its middle and one on its upper face. Layer
    by layer from the held cylinder on they are condensed to the stiffness of the upper one.

    Attributes
    ----------
    shapes : (3 S, n) array
        The fields at the nodes of a cylinder, orthonormal.
    own : (layers, 3, 2 n, 2 n) array
        K0, K1, K2 of each layer's two cylinders.
    below : (layers - 1, 3, 2 n, n) array
        Coupling of a layer's two cylinders to the upper one of the layer beneath.
    """

    shapes: FloatArray
    own: FloatArray
    below: FloatArray

    def flexibility(self, orders: FloatArray) -> FloatArray:
        """Of the loaded cylinder at harmonics, which need not be integers: (orders, n, n) array."""
        # the integral over the circumference of cos^2 or sin^2
        powers = np.where(orders > 0.0, pi, 2.0 * pi)[:, None] * orders[:, None] ** np.arange(3)
        n = self.own.shape[-1] // 2
        condensed = np.tensordot(powers, self.own[0], 1)
        for k, layer in enumerate(self.own):
            if k:
                coupling = np.tensordot(powers, self.below[k - 1], 1).swapaxes(1, 2)
                condensed = np.tensordot(powers, layer, 1) - _condensed_part(condensed, coupling)
            condensed = condensed[:, n:, n:] - _condensed_part(condensed[:, :n, :n], condensed[:, :n, n:])
        return np.linalg.inv(condensed)


def _condensed_part(stiffness: FloatArray, coupling: FloatArray) -> FloatArray:
    """Stiffness removed by static condensation of the coupled unknowns: C^T K^-1 C, (orders, n, n) arrays."""
    half = halves(factors_of(stiffness), coupling)
    return half.swapaxes(1, 2) @ half


def _matrices(basis: Basis, youngs_modulus: float, poissons_ratio: float) -> tuple[csc_matrix, ...]:
    """K0, K1, K2 of unknowns 3 node + (U, V, W), without the integral over the angle."""
    radius = np.asarray(basis.global_coordinates())[0]
    elements, places = radius.shape
    value = np.stack([np.broadcast_to(np.asarray(f[0]), radius.shape) for f in basis.basis], axis=-1)
    slope = np.stack([f[0].grad for f in basis.basis], axis=-1)
    by_radius, along_r, along_z = value / radius[..., None], slope[0], slope[1]
    # strains rr, theta theta, zz, r theta, theta z, r z (engineering shear)
    steady = np.zeros((elements, places, 6, 9, 3))
    steady[:, :, 0, :, 0] = along_r
    steady[:, :, 1, :, 0] = by_radius
    steady[:, :, 2, :, 2] = along_z
    steady[:, :, 3, :, 1] = along_r - by_radius
    steady[:, :, 4, :, 1] = steady[:, :, 5, :, 0] = along_z
    steady[:, :, 5, :, 2] = along_r
    turning = np.zeros_like(steady)
    turning[:, :, 1, :, 1] = by_radius
    turning[:, :, 3, :, 0] = turning[:, :, 4, :, 2] = -by_radius
    b0, b1 = (b.reshape(elements, places, 6, 27) for b in (steady, turning))
    weighted = (basis.dx * radius)[..., None, None] * elasticity(youngs_modulus, poissons_ratio)
    unknowns = unknowns_of(basis.element_dofs.T.ravel()).reshape(elements, 27)
    at = np.repeat(unknowns, 27, axis=1).ravel(), np.tile(unknowns, (1, 27)).ravel()

    def assembled(left: FloatArray, right: FloatArray) -> csc_matrix:
        entries = np.einsum("eqsi,eqst,eqtj->eij", left, weighted, right, optimize=True)
        return coo_matrix((entries.ravel(), at), shape=(3 * basis.N, 3 * basis.N)).tocsc()

    mixed = assembled(b0, b1)
    return assembled(b0, b0), mixed + mixed.T, assembled(b1, b1)

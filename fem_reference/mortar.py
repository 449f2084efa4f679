r"""Dual-mortar coupling of two quadrilateral surface grids that do not match.

The contact pressure is :math:`\sum_j p_j \psi_j` with functions dual to the bilinear :math:`\phi_j` of the slave
surface: over the part :math:`S_e` of each slave element that lies opposite the master,

.. math:: \int_{S_e} \psi_j \phi_k \, dA = \delta_{jk} \int_{S_e} \phi_k \, dA ,

so that the weight matrix :math:`D_{jk} = \int \psi_j \phi_k \, dA` is diagonal and each slave node is coupled to the
master by :math:`P = D^{-1} M`, :math:`M_{jl} = \int \psi_j \phi_l^{master} \, dA`. Because the functions are dual on
the covered part, not on the whole element, P reproduces linear fields and its rows sum to 1 also where one
surface overhangs the other (Cichosz and Bischoff 2011).

The gap of a slave node is :math:`\gamma_j + n_j \cdot (P u^{master} - u^{slave})_j`, with n_j outward from the slave;
its work-conjugate is the force :math:`F_j = p_j D_{jj}`, which presses the slave along -n_j and, spread by P, the
master along +n_j.

A node beyond the other surface's border, with a vanishing covered area, would carry the force that closes
a gap extrapolated beyond the surface: a finite force on no area. Its dual function is added to that of its neighbour,
which keeps their sum and thereby constant pressure.

Sources: Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989, doi:10.1137/S0036142999350929 (dual functions); Popp,
Gitterle, Gee, Wall, Int. J. Numer. Meth. Eng. 83 (2010) 1428, doi:10.1002/nme.2866 (segments in the plane of the
slave element); Cichosz, Bischoff, Comput. Meth. Appl. Mech. Eng. 200 (2011) 1317 (borders).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags_array

from fem_reference.arrays import BoolArray, FloatArray, IntArray
from fem_reference.segments import bilinear, clip, integration_points, local_coordinates, signed_area
from fem_reference.surface import Surface, sphere_of
from semiwear.errors import SceneError

Field = Callable[[FloatArray], FloatArray] | FloatArray | float
"""A quantity on the slave surface: a function of (q, 3) positions, a value per node of the body, or a constant."""

SLIVER = 1e-4
"""Covered fraction of a slave element below which the bilinear functions replace the dual ones, which would come
from a nearly singular matrix. The force is transmitted exactly, its moment within this fraction of an element's."""

LEAST_COVER = 0.02
"""Covered fraction of the facets about a node below which a neighbour carries its load. Values from 0.001 to 0.05
give the same result; above, edges lose nodes that carry load."""

POOLED_COVER = 0.5
"""Covered fraction below which a node's pressure is that of its and its neighbour's force and area together: the load
of an edge is finite on any area, so that a pressure is only defined on areas of the size of an element."""

FACING = -0.1
"""Greatest product of the unit normals of two facets that count as opposite."""


@dataclass(frozen=True)
class Mortar:
    """Coupling of a slave and a master surface.

    Attributes
    ----------
    nodes : (k,) int array
        Slave nodes that lie opposite the master.
    shares : (k, n_slave) sparse array
        Distribution of each force on the slave's nodes: on `nodes`, and in small part on those that they represent;
        its rows sum to 1.
    weight : (k,) array [mm2]
        D: force over pressure.
    normals : (k, 3) array
        Outward from the slave.
    sampling : (k, q) sparse array
        Averages over integration points with the dual functions; its rows sum to 1.
    points : (q, 3) array [mm]
        Integration points on the slave surface.
    transfer : (k, n_master) sparse array
        P, from the nodes of the master body.
    distance : (k,) array [mm]
        Gap between the two meshes, along the normals.
    covered : (k,) array
        Fraction of the facets about the node that lies opposite the master; the least of the nodes it represents.
    beside : (k,) int array
        For each node itself, or the neighbour with which its pressure is averaged.
    """

    nodes: IntArray
    shares: csr_matrix
    weight: FloatArray
    normals: FloatArray
    sampling: csr_matrix
    points: FloatArray
    transfer: csr_matrix
    distance: FloatArray
    covered: FloatArray
    beside: IntArray

    def pressure(self, force: FloatArray) -> FloatArray:
        """Pressure at the nodes under forces (k,) [MPa]."""
        extra = (self.beside != np.arange(len(self.nodes))).astype(float)
        return np.asarray((force + extra * force[self.beside]) / (self.weight + extra * self.weight[self.beside]))

    def average(self, field: Field) -> FloatArray:
        """A quantity averaged at the slave nodes, (k,).

        Parameters
        ----------
        field : function, array or float
            Values at the nodes of the slave body are taken as they are, which is the average of their interpolant:
            best for a gap, since the nodes lie on the flank and the facets between them do not. A function of
            position is averaged with the dual functions. On a gap of curvature k the two differ by k h^2/12, h the
            size of a facet: this moves the approach, hardly the pressure.
        """
        if callable(field):
            return np.asarray(
                self.sampling @ np.broadcast_to(np.asarray(field(self.points), dtype=float), len(self.points))
            )
        values = np.asarray(field, dtype=float)
        return np.full(len(self.nodes), values[()]) if values.ndim == 0 else values[self.nodes]

    def unit_loads(self) -> tuple[csr_matrix, csr_matrix]:
        """Loads on the unknowns of slave and master for unit forces F, (3 n, k) each.

        Transposed they give the opening of the gap by displacements, n . (P u_master - u_slave).
        """
        return _along(self.shares, -self.normals), _along(self.transfer, self.normals)


def couple(
    slave: Surface, master: Surface, *, normals: FloatArray | None = None, reach: float | None = None
) -> Mortar:
    """Couple two surfaces.

    Parameters
    ----------
    slave : Surface
        Carries the pressure: the deformable and finer one.
    master : Surface
    normals : (n_slave, 3) array, optional
        Unit normals at all nodes of the slave body, outward: those of the flank if they are known, for they are
        better than the average over facets, which is the default.
    reach : float, optional [mm]
        Greatest distance of facets that are tried, along the normal; default half the extent of the slave surface.
    """
    slave_row, master_row = _neighbours(slave, master, reach)
    frame = _frames(slave)
    slave_flat = _flatten(slave.points[slave.quads], slave.centres, frame)[slave_row]
    master_flat = _flatten(master.points[master.quads[master_row]], slave.centres[slave_row], frame[slave_row])
    # seen from the slave, the master turns clockwise
    owner, point, area = integration_points(*clip(master_flat[:, ::-1], slave_flat))
    if not len(owner):
        raise SceneError.of(
            "surfaces", "no overlap", "a master surface opposite the slave surface",
            "turn the facets outward, raise `reach` or choose facets that face each other",
        )  # fmt: skip
    on_slave = bilinear(local_coordinates(slave_flat[owner], point))
    on_master = bilinear(local_coordinates(master_flat[owner], point))
    element, other = slave_row[owner], master_row[owner]
    dual = _dual_functions(slave, element, on_slave, area)

    slave_shape = _interpolation(slave.quads[element], on_slave, len(slave.points))
    master_shape = _interpolation(master.quads[other], on_master, len(master.points))
    dual_shape = _interpolation(slave.quads[element], dual, len(slave.points))
    share = slave_shape.T @ area
    # nodes with negligible covered area are left out
    known = np.flatnonzero(share > 1e-9 * share.max())
    whole = _whole_share(slave)
    covered = share[known] / whole[known]
    keeper = _keepers(slave, known, share[known], covered < LEAST_COVER)
    kept, row = np.unique(keeper, return_inverse=True)
    nodes = known[kept]
    belongs = csr_matrix((np.ones(len(known)), (row, np.arange(len(known)))))
    weight = belongs @ share[known]
    dual_sums = dual_shape[:, known] @ belongs.T
    sampling = csr_matrix(diags_array(1.0 / weight) @ (dual_sums.T @ diags_array(area)))
    transfer = csr_matrix(sampling @ master_shape)
    points = slave_shape @ slave.points
    unit = (slave.node_normals if normals is None else np.asarray(normals, dtype=float))[nodes]
    least = np.ones(len(nodes))
    np.minimum.at(least, row, covered)
    return Mortar(
        nodes=nodes,
        shares=csr_matrix((share[known] / weight[row], (row, known)), shape=(len(nodes), len(slave.points))),
        weight=weight,
        normals=unit,
        sampling=sampling,
        points=points,
        transfer=transfer,
        distance=np.einsum("jk,jk->j", unit, transfer @ master.points - sampling @ points),
        covered=least,
        beside=_keepers(slave, nodes, weight, weight < POOLED_COVER * whole[nodes]),
    )


def _keepers(slave: Surface, nodes: IntArray, weight: FloatArray, small: BoolArray) -> IntArray:
    """Index of the node that represents each node: itself, or for a node of small area a neighbour of larger area."""
    row_of = np.full(len(slave.points), -1, dtype=np.int64)
    row_of[nodes] = np.arange(len(nodes))
    keeper = np.arange(len(nodes))
    beside = slave.neighbours
    for k in np.flatnonzero(small):
        start, end = beside.indptr[nodes[k]], beside.indptr[nodes[k] + 1]
        near = row_of[beside.indices[start:end]]
        near = near[near >= 0]
        # towards more weight only, so that no chain closes
        if len(near) and weight[near].max() > weight[k]:
            keeper[k] = near[np.argmax(weight[near])]
    while (keeper[keeper] != keeper).any():
        keeper = keeper[keeper]
    return keeper


def _along(spread: csr_matrix, direction: FloatArray) -> csr_matrix:
    """Loads (3 n, k) that act in shares `spread` (k, n) along the directions (k, 3)."""
    parts = spread.tocoo()
    rows = (3 * parts.col[:, None] + np.arange(3)).ravel()
    values = (parts.data[:, None] * direction[parts.row]).ravel()
    shape = (3 * spread.shape[1], spread.shape[0])
    return csr_matrix((values, (rows, np.repeat(parts.row, 3))), shape=shape)


def _neighbours(slave: Surface, master: Surface, reach: float | None) -> tuple[IntArray, IntArray]:
    """Pairs of facets that face each other and may overlap: their circles do, seen along the slave's normal."""
    if reach is None:
        corners = slave.points[slave.nodes]
        reach = 0.5 * float(np.linalg.norm(np.ptp(corners, axis=0)))
    normal = slave.area_vectors / np.linalg.norm(slave.area_vectors, axis=1)[:, None]
    facing = master.area_vectors / np.linalg.norm(master.area_vectors, axis=1)[:, None]
    radius, other_radius = sphere_of(slave), sphere_of(master)
    found = []
    for start in range(0, len(normal), 64):
        block = slice(start, start + 64)
        offset = master.centres[None] - slave.centres[block, None]
        height = np.einsum("smk,sk->sm", offset, normal[block])
        across = np.einsum("smk,smk->sm", offset, offset) - height**2
        near = (across < (radius[block, None] + other_radius) ** 2) & (np.abs(height) < reach + other_radius)
        near &= normal[block] @ facing.T < FACING
        rows = np.argwhere(near)
        rows[:, 0] += start
        found.append(rows)
    pairs = np.concatenate(found)
    return pairs[:, 0], pairs[:, 1]


def _frames(surface: Surface) -> FloatArray:
    """Two unit vectors in the plane of each facet, (f, 2, 3), right-handed with its outward normal."""
    corner = surface.points[surface.quads]
    normal = surface.area_vectors / np.linalg.norm(surface.area_vectors, axis=1)[:, None]
    first = corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3]
    first -= np.einsum("fk,fk->f", first, normal)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first)], axis=1)


def _flatten(corner: FloatArray, centre: FloatArray, frame: FloatArray) -> FloatArray:
    """Corners (f, 4, 3) projected onto the planes through the centres, (f, 4, 2)."""
    return np.asarray(np.einsum("fak,fik->fai", corner - centre[:, None], frame))


def _dual_functions(slave: Surface, element: IntArray, shape: FloatArray, area: FloatArray) -> FloatArray:
    """Dual functions at the integration points, (q, 4), dual on the covered part of each element."""
    count = len(slave.quads)
    mass = np.zeros((count, 4, 4))
    np.add.at(mass, element, area[:, None, None] * shape[:, :, None] * shape[:, None, :])
    share = mass.sum(axis=2)
    whole = np.linalg.norm(slave.area_vectors, axis=1)
    good = share.sum(axis=1) > SLIVER * whole
    coefficients = np.repeat(np.eye(4)[None], count, axis=0)
    coefficients[good] = share[good][:, :, None] * np.linalg.inv(mass[good])
    return np.asarray(np.einsum("qab,qb->qa", coefficients[element], shape))


def _interpolation(quads: IntArray, shape: FloatArray, size: int) -> csr_matrix:
    """Sparse (q, size) array that interpolates values at the nodes of a body."""
    row = np.repeat(np.arange(len(quads)), 4)
    return csr_matrix((shape.ravel(), (row, quads.ravel())), shape=(len(quads), size))


def _whole_share(slave: Surface) -> FloatArray:
    """Integral of each node's bilinear function over all its facets, in their planes, (n_slave,) [mm2]."""
    flat = _flatten(slave.points[slave.quads], slave.centres, _frames(slave))
    polygon = np.concatenate([flat, np.repeat(flat[:, 3:], 4, axis=1)], axis=1)
    owner, point, area = integration_points(polygon, np.full(len(flat), 4))
    shape = bilinear(local_coordinates(flat[owner], point))
    assert abs(area.sum() / signed_area(flat).sum() - 1.0) < 1e-9
    return np.asarray(_interpolation(slave.quads[owner], shape, len(slave.points)).T @ area)

"""A contact surface: quadrilaterals on the skin of a body, with the names of its real edges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import skfem
from scipy.sparse import csr_matrix

from fem_reference.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Surface:
    """Quadrilaterals of a body, counter-clockwise when seen from outside.

    Attributes
    ----------
    body : str or None
        Key of the body; None is rigid and does not move.
    points : (n, 3) array [mm]
        All nodes of the body.
    quads : (f, 4) int array
        Rows of `points`.
    edges : mapping of name to int array
        Nodes on real edges of the body, such as ``{"tip": ..., "end face": ...}``: contact there is edge contact.
        At a border of the surface without a name the mesh of candidates ends but the body continues.
    symmetry : int array
        Nodes on planes of symmetry, where the model ends but the contact does not.
    """

    body: str | None
    points: FloatArray
    quads: IntArray
    edges: Mapping[str, IntArray] = field(default_factory=dict)
    symmetry: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @cached_property
    def nodes(self) -> IntArray:
        """Nodes of the surface, sorted."""
        return np.unique(self.quads)

    @cached_property
    def centres(self) -> FloatArray:
        """Middle of each quadrilateral [mm]."""
        return np.asarray(self.points[self.quads].mean(axis=1))

    @cached_property
    def area_vectors(self) -> FloatArray:
        """Half the cross product of the diagonals: area [mm2] times outward normal of each quadrilateral."""
        corner = self.points[self.quads]
        return 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])

    @cached_property
    def node_normals(self) -> FloatArray:
        """Unit normals at all nodes of the body, averaged over the facets by area; zero away from the surface."""
        total = np.zeros_like(self.points)
        for corner in self.quads.T:
            np.add.at(total, corner, self.area_vectors)
        length = np.linalg.norm(total, axis=1)
        return total / np.where(length > 0.0, length, 1.0)[:, None]

    @cached_property
    def neighbours(self) -> csr_matrix:
        """(n, n) matrix with an entry for each side of a quadrilateral, both ways: in how many it is a side."""
        start, end = self.quads.ravel(), np.roll(self.quads, -1, axis=1).ravel()
        one = np.ones(2 * start.size)
        size = len(self.points)
        return csr_matrix((one, (np.r_[start, end], np.r_[end, start])), shape=(size, size))

    @cached_property
    def border(self) -> dict[str, IntArray]:
        """Nodes of the real edges by name, and as ``"candidates"`` those on other sides of one quadrilateral only."""
        named = {name: np.intersect1d(nodes, self.nodes) for name, nodes in self.edges.items()}
        sides = self.neighbours.tocoo()
        ends = np.stack([sides.row, sides.col], axis=1)[sides.data == 1].astype(np.int64)
        for known in (*named.values(), self.symmetry):
            ends = ends[~np.isin(ends, known).all(axis=1)]
        return named | {"candidates": np.unique(ends)}


def sphere_of(surface: Surface) -> FloatArray:
    """Greatest distance of a corner from the middle of each quadrilateral [mm]."""
    offsets = surface.points[surface.quads] - surface.centres[:, None]
    return np.asarray(np.linalg.norm(offsets, axis=2).max(axis=1))


def outward_quads(mesh: skfem.MeshHex, facets: IntArray) -> IntArray:
    """Corner nodes of boundary facets of a hexahedral mesh, counter-clockwise when seen from outside.

    On trilinear elements ("hex8i") these are all the nodes of the skin; on quadratic ones the contact would miss
    the nodes between.

    Parameters
    ----------
    mesh : skfem.MeshHex
    facets : (f,) int array
        Boundary facets, for instance ``mesh.facets_satisfying(..., boundaries_only=True)``.
    """
    quads = mesh.facets[:4, facets].T.astype(np.int64)
    corner = mesh.p.T[quads]
    inside = mesh.p[:, mesh.t[:8, mesh.f2t[0, facets]]].mean(axis=1).T
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    inward = np.einsum("fk,fk->f", normal, corner.mean(axis=1) - inside) < 0.0
    quads[inward] = quads[inward][:, ::-1]
    return np.asarray(quads)

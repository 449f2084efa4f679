"""A worn gear mesh: flank nodes moved along their normals, the inside of the teeth smoothed after them.

What Abaqus does with UMESHMOTION and an arbitrary Lagrangian-Eulerian step: the surface takes the wear, the nodes
below follow so that elements keep their shape. Here the inside moves by the mean of its neighbours (Laplace on the
mesh's edges), which leaves the first element below the surface its share of the depth. All other flanks, fillets and
the held face stay; tip lands and end faces follow.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags_array
from skfem import MeshHex

from fem_reference.hexahedra import check_jacobians
from fem_reference.solvers import factorise
from fem_reference.tooth_mesh import LOADED, ToothMesh
from fem_reference.wear import WearDepth

__all__ = ["moved_flanks"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def moved_flanks(mesh: ToothMesh, wear: WearDepth, teeth: Iterable[int]) -> ToothMesh:
    """The gear's mesh with some loaded flanks worn.

    Parameters
    ----------
    mesh : ToothMesh
        Of trilinear elements.
    wear : WearDepth
    teeth : iterable of int
        Whose loaded flanks are worn.

    Raises
    ------
    MeshError
        Where the wear folds an element.
    """
    if mesh.element != "hex8i":
        raise ValueError(f"only meshes of trilinear elements move, not {mesh.element}")
    count = mesh.mesh.nvertices
    given, known = np.zeros((count, 3)), np.zeros(count, dtype=bool)
    for (tooth, side), flank in mesh.flanks.items():
        known[mesh.fillets[tooth, side].nodes] = True
        known[flank.nodes] = True
    known[mesh.held] = True
    flanks = dict(mesh.flanks)
    for tooth in teeth:
        flank = mesh.flanks[tooth, LOADED]
        depth = wear.depth(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
        moved = -depth[..., None] * flank.normals
        given[flank.nodes] = moved
        flanks[tooth, LOADED] = replace(flank, points=flank.points + moved)
    points = mesh.mesh.p.T + _smoothed(mesh.mesh, given, known)
    worn = MeshHex(np.ascontiguousarray(points.T), mesh.mesh.t)
    check_jacobians(worn, name=f"worn {mesh.name}")
    return replace(mesh, mesh=worn, flanks=flanks)


def _smoothed(mesh: MeshHex, given: FloatArray, known: NDArray[np.bool_]) -> FloatArray:
    """Displacements (n, 3) that are the mean of their neighbours' wherever they are not known."""
    start, end = mesh.edges
    both = np.concatenate([start, end]), np.concatenate([end, start])
    count = len(given)
    beside = csr_matrix((np.ones(len(both[0])), both), shape=(count, count))
    laplace = csr_matrix(diags_array(np.asarray(beside.sum(axis=1)).ravel()) - beside)
    free = np.flatnonzero(~known)
    result = given.copy()
    result[free] = factorise(csc_matrix(laplace[free][:, free])).solve(-(laplace[free] @ given))
    return result

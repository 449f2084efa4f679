"""A worn mesh: flank nodes moved along their normals, with smoothing of the mesh inside the teeth.

As in Abaqus with UMESHMOTION and an arbitrary Lagrangian-Eulerian step, the surface nodes move by the wear depth and
the nodes below follow so that elements keep their shape. Here inner nodes move by the mean of their neighbours,
weighted by proximity (Laplace on the mesh's edges), so that the first element
below the surface takes only its part of the depth.
All other flanks, fillets and the held face stay; tip lands and end faces follow.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags_array
from skfem import ElementHex1, ElementHex2, MeshHex
from skfem.assembly import Dofs

from fem_reference.arrays import BoolArray, FloatArray
from fem_reference.hexahedra import check_jacobians
from fem_reference.solvers import factorise
from fem_reference.tooth_mesh import LOADED, OPPOSITE, ToothMesh
from fem_reference.wear import WearDepth


def moved_flanks(mesh: ToothMesh, wear: WearDepth, teeth: Iterable[int], *, borders_stay: bool = False) -> ToothMesh:
    """A body's mesh with some loaded flanks worn.

    Parameters
    ----------
    mesh : ToothMesh
        Of trilinear or 20-node elements.
    wear : WearDepth
        Of the body's flank.
    teeth : iterable of int
        Whose loaded flanks are worn.
    borders_stay : bool
        Whether nodes on the border of a flank slide along the tip land and the end faces, which then stay where they
        are; else they move along the normal, and draw the tip land with them.

    Raises
    ------
    MeshError
        Where the wear folds an element.
    """
    if mesh.element == "hex27":
        raise ValueError("meshes of 27-node elements are not moved; take hex8i or hex20")
    corners = mesh.mesh.nvertices
    count = mesh.mesh.doflocs.shape[1]
    given, known, worn = np.zeros((count, 3)), np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    grids = [grid.nodes for grid in mesh.flanks.values()] + [grid.nodes for grid in mesh.fillets.values()]
    for nodes in grids:
        known[nodes[nodes >= 0]] = True
    known[mesh.held] = True
    flanks = dict(mesh.flanks)
    for tooth in teeth:
        flank = mesh.flanks[tooth, LOADED]
        depth = wear.depth(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
        moved = -depth[..., None] * flank.normals
        if borders_stay:
            moved = _along_borders(flank.points, mesh.flanks[tooth, OPPOSITE].points, flank.normals, depth)
        there = flank.nodes >= 0
        given[flank.nodes[there]], worn[flank.nodes[there]] = moved[there], True
        flanks[tooth, LOADED] = replace(flank, points=flank.points + moved)
    motion = _smoothed(mesh.mesh, given[:corners], known[:corners])
    if count > corners:
        motion = np.where(worn[:, None], given, _between(mesh.mesh, motion))
    kind = type(mesh.mesh)
    moved_mesh = kind(np.ascontiguousarray((mesh.mesh.doflocs.T + motion).T), mesh.mesh.t)
    check_jacobians(moved_mesh, name=f"worn {mesh.name}")
    return replace(mesh, mesh=moved_mesh, flanks=flanks)


def _along_borders(points: FloatArray, opposite: FloatArray, normals: FloatArray, depth: FloatArray) -> FloatArray:
    """Least motions (profile, face, 3) with the depth along the normals that stay in tip land and end faces."""
    along, up = np.gradient(points, axis=1), np.gradient(points, axis=0)
    through = opposite - points
    held = np.zeros((*depth.shape, 2, 3))  # normals of the surfaces that a node stays in
    held[-1, :, 0] = np.cross(through[-1], along[-1])
    for column in (0, -1):
        held[:, column, 1] = np.cross(through[:, column], up[:, column])
    # the second perpendicular to the first, then the flank's normal to both
    free = normals
    first, second = (_unit(held[..., k, :]) for k in range(2))
    second = _unit(second - np.sum(second * first, axis=-1, keepdims=True) * first)
    for one in (first, second):
        free = free - np.sum(free * one, axis=-1, keepdims=True) * one
    return np.asarray(-depth[..., None] * free / np.sum(free * normals, axis=-1, keepdims=True))


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors of unit length; zero ones stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _between(mesh: MeshHex, motion: FloatArray) -> FloatArray:
    """Motion of all nodes of a curved mesh, trilinear between the corners' (n, 3)."""
    element = ElementHex2()
    nodes = Dofs(mesh, element).element_dofs.T
    places = np.asarray(element.doflocs, dtype=float).T
    weights = np.array([ElementHex1().lbasis(places, a)[0] for a in range(8)])
    result = np.empty((mesh.doflocs.shape[1], 3))
    result[nodes] = np.einsum("ap,mai->mpi", weights, motion[mesh.t.T])
    return result


def _smoothed(mesh: MeshHex, given: FloatArray, known: BoolArray) -> FloatArray:
    """Displacements (n, 3) that are the mean of their neighbours' wherever they are not known."""
    start, end = mesh.edges
    both = np.concatenate([start, end]), np.concatenate([end, start])
    count = len(given)
    # a node close below the surface follows it, since elements there are thin
    weight = 1.0 / np.linalg.norm(mesh.p[:, start] - mesh.p[:, end], axis=0)
    beside = csr_matrix((np.tile(weight, 2), both), shape=(count, count))
    laplace = csr_matrix(diags_array(np.asarray(beside.sum(axis=1)).ravel()) - beside)
    free = np.flatnonzero(~known)
    result = given.copy()
    result[free] = factorise(csc_matrix(laplace[free][:, free])).solve(-(laplace[free] @ given))
    return result

"""A body of a scene as a mesh with worn flanks, under contact forces: as a solid to look at, and as an input deck."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fem_reference.abaqus import write_inp
from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ElasticBody
from fem_reference.hexahedra import MeshError
from fem_reference.moved_nodes import moved_flanks
from fem_reference.pairs import body_mesh
from fem_reference.root_load import carried
from fem_reference.tooth_mesh import LOADED, Divisions, ToothMesh
from fem_reference.wear import FlankWear, WearDepth
from semiwear.scene import Scene

__all__ = ["FlankLoad", "FlankWear", "MeshError", "WornBody", "worn_body"]


@dataclass(frozen=True)
class FlankLoad:
    """Normal forces on the loaded flank of a tooth.

    Attributes
    ----------
    tooth : int
        As in `ToothMesh.teeth`.
    face, profile : (k,) arrays [mm]
        Points of action.
    force : (k,) array [N]
        Into the material.
    """

    tooth: int
    face: FloatArray
    profile: FloatArray
    force: FloatArray


@dataclass(frozen=True)
class WornBody:
    """The mesh of a worn body.

    Attributes
    ----------
    mesh : ToothMesh
    body : ElasticBody
    """

    mesh: ToothMesh
    body: ElasticBody

    def nodal_depth(self, wear: WearDepth) -> FloatArray:
        """A wear depth at all nodes, (n,) [mm]: that of the loaded flanks, zero elsewhere."""
        depth = np.zeros(len(self.body.points))
        for (_, side), flank in self.mesh.flanks.items():
            there = flank.nodes >= 0
            if side == LOADED:
                own = wear.depth(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
                depth[flank.nodes[there]] = own[there]
        return depth

    def skin(self) -> IntArray:
        """Corners of the outer faces, anticlockwise as seen from outside: (m, 4) vertices."""
        mesh = self.mesh.mesh
        facets = mesh.boundary_facets()
        corners = mesh.facets[:, facets].T
        places, inside = mesh.doflocs.T[corners], mesh.doflocs.T[mesh.t[:, mesh.f2t[0, facets]]].mean(axis=0)
        # a facet's vertices may be numbered in any order: about its middle, in the plane of its diagonals
        middle = places.mean(axis=1)
        out = middle - inside
        first = places[:, 0] - middle
        second = np.cross(out, first)
        arms = places - middle[:, None]
        angle = np.arctan2(
            np.einsum("fai,fi->fa", arms, second), np.einsum("fai,fi->fa", arms, first) * _norm(out)[:, None]
        )
        return np.take_along_axis(corners, np.argsort(angle, axis=1), axis=1)

    def forces(self, loads: Sequence[FlankLoad]) -> FloatArray:
        """Nodal forces (n, 3) of normal forces on loaded flanks [N], by the shape functions of 8-node facets.

        Raises
        ------
        ValueError
            For a load on a tooth that is not in the mesh, or elements without mid-side nodes.
        """
        if self.body.element != "hex20":
            raise ValueError(f"forces act on 20-node elements, not on {self.body.element}")
        count = len(self.body.points)
        force = np.zeros((count, 3))
        for load in loads:
            if load.tooth not in self.mesh.teeth:
                raise ValueError(f"tooth {load.tooth} bears load, the mesh has {self.mesh.teeth}: mesh more teeth")
            flank = self.mesh.flanks[load.tooth, LOADED]
            shares = carried(flank, load.face, load.profile, count)
            there = flank.nodes >= 0
            normals = np.zeros((count, 3))
            normals[flank.nodes[there]] = flank.normals[there]
            normal = shares @ normals
            force += shares.T @ (-load.force[:, None] * normal / _norm(normal)[:, None])
        return force

    def write(self, path: str | os.PathLike[str], loads: Sequence[FlankLoad], title: str = "semiwear") -> Path:
        """Write an input deck: held at its bore or back face, under forces; node sets FLANK and FILLET of tooth 0."""
        name = self.mesh.name.upper()
        sets = {"HELD": (name, self.mesh.held)}
        for what, grid in (("FLANK", self.mesh.flanks[0, LOADED]), ("FILLET", self.mesh.fillets[0, LOADED])):
            sets[what] = (name, grid.nodes[grid.nodes >= 0])
        return write_inp(
            path, {name: self.body}, node_sets=sets, boundary=[("HELD", 1, 3, 0.0)],
            forces={name: self.forces(loads)}, reactions=["HELD"], title=title,
        )  # fmt: skip


def worn_body(
    scene: Scene,
    body: str,
    wear: WearDepth,
    *,
    element: str = "hex20",
    teeth: int | None = 5,
    divisions: Divisions | None = None,
) -> WornBody:
    """A body's mesh with all loaded flanks equally worn.

    Parameters
    ----------
    scene : Scene
        With a face gear pair or a cylindrical one.
    body : str
        ``"pinion"`` or ``"gear"``.
    wear : WearDepth
    element : str
        ``"hex20"`` (forces need it) or ``"hex8i"``.
    teeth : int or None
        Teeth of the sector, tooth 0 in its middle; None is the whole ring of a cylindrical gear.
    divisions : Divisions, optional
        Elements of tooth 0; its neighbours are coarse.

    Raises
    ------
    SceneError
        For flanks given as points, which are not meshed.
    MeshError
        Where a tooth cannot be meshed, or the wear folds an element.
    """
    mesh = body_mesh(scene, body, element=element, teeth=teeth, divisions=divisions)
    mesh = moved_flanks(mesh, wear, mesh.teeth, borders_stay=True)
    return WornBody(mesh, ElasticBody.of(mesh.mesh, element, getattr(scene.material, body)))


def _norm(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))

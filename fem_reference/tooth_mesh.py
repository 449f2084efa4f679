"""Teeth on their rim as structured hexahedra, with the node sets that contact, root stress and supports need.

Every pitch has the four blocks of `pitch_blocks`; all teeth are joined node by node into one mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from skfem import MeshHex

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ELEMENTS
from fem_reference.hexahedra import Lattice, join_blocks, with_middles
from fem_reference.pitch_blocks import Divisions, Pattern, Refinement, ToothSurface, depth_corners, face_corners
from fem_reference.ring import RestOfRing

__all__ = ["LOADED", "OPPOSITE", "Divisions", "FilletGrid", "FlankGrid", "Refinement", "ToothMesh", "mesh_teeth"]

LOADED, OPPOSITE = 0, 1
"""The two sides of a tooth."""


@dataclass(frozen=True)
class FlankGrid:
    """Nodes of a flank, profile growing to the tip.

    Attributes
    ----------
    nodes : (profile, face) array
        Displacement nodes; -1 at the middles of faces, where a 20-node element has none.
    profile : (profile, face) array [mm]
        Profile coordinate of the nodes.
    face : (face,) array [mm]
        Gear radius, or place along the pinion axis.
    points, normals : (profile, face, 3) arrays [mm], [1]
        Places, and unit normals out of the material.
    """

    nodes: IntArray
    profile: FloatArray
    face: FloatArray
    points: FloatArray
    normals: FloatArray


@dataclass(frozen=True)
class FilletGrid:
    """Nodes of a fillet, from the end of the flank to the root.

    Attributes
    ----------
    nodes : (arc, face) array
        Displacement nodes; -1 where a 20-node element has none.
    arc : (arc, face) array [mm]
        Length along the fillet from the end of the flank.
    face : (face,) array [mm]
    points : (arc, face, 3) array [mm]
    """

    nodes: IntArray
    arc: FloatArray
    face: FloatArray
    points: FloatArray

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit tangents (arc, face, 3) down the fillet in the section, by splines through the points."""
        columns = [CubicSpline(a, p)(a, 1) for a, p in zip(self.arc.T, self.points.swapaxes(0, 1), strict=True)]
        tangents = np.stack(columns, axis=1)
        return np.asarray(tangents / np.linalg.norm(tangents, axis=2, keepdims=True))


@dataclass(frozen=True)
class ToothMesh:
    """The mesh of a body with the node sets that contact, root stress and supports need.

    Attributes
    ----------
    name : str
        ``"gear"`` or ``"pinion"``.
    element : str
        The element of the node numbers.
    mesh : skfem.MeshHex or skfem.MeshHex2
    held : array of int
        Displacement nodes of the back face or bore.
    teeth : tuple of int
        Teeth in the mesh; tooth j is the j-th neighbour of tooth 0 on the side that its loaded flank faces.
    flanks : dict from (tooth, side) to FlankGrid
    fillets : dict from (tooth, side) to FilletGrid
    middles : dict from tooth to (n, face) array
        Displacement nodes of the tooth's middle surface, from the tip to the held face; -1 where there is none.
    rest : RestOfRing, optional
        Teeth that are not in the mesh and close it to a ring; without them the cut planes are free.
    inclined : bool
        Whether teeth may be inclined to the sections of the mesh, so that root stress is read normal to the tooth.
    """

    name: str
    element: str
    mesh: MeshHex
    held: IntArray
    teeth: tuple[int, ...]
    flanks: dict[tuple[int, int], FlankGrid]
    fillets: dict[tuple[int, int], FilletGrid]
    middles: dict[int, IntArray]
    rest: RestOfRing | None = None
    inclined: bool = False


def mesh_teeth(
    surface: ToothSurface,
    teeth: Iterable[int],
    element: str,
    refinements: Mapping[int, Refinement],
    divisions: Divisions,
    detailed: tuple[int, ...],
    missing: int = 0,
    turn: FloatArray | None = None,
) -> ToothMesh:
    """Mesh some teeth of a body; see `face_gear_mesh` and `pinion_mesh`.

    With `missing` teeth, which close them to a ring, and the rotation `turn` from one tooth to the next, the mesh has
    a `ToothMesh.rest`.
    """
    teeth = tuple(teeth)
    if strange := [tooth for tooth in refinements if tooth not in teeth]:
        raise ValueError(f"{surface.name}: refinement of teeth {strange}, which are not in the mesh")
    if not teeth:
        raise ValueError(f"{surface.name}: a mesh needs one tooth at least")
    if element not in ELEMENTS:
        raise ValueError(f"element must be one of {', '.join(ELEMENTS)}, not {element!r}")
    face = with_middles(face_corners(surface, refinements.values(), divisions.face_size))
    depth = with_middles(depth_corners(surface, face, divisions))
    blocks: list[FloatArray] = []
    pitches = []
    patterns: dict[object, Pattern] = {}
    for tooth in teeth:
        refinement = refinements.get(tooth)
        own = divisions if refinement or tooth in detailed else divisions.coarse
        key = refinement if refinement else own
        if key not in patterns:
            patterns[key] = Pattern.of(surface, face, depth, own, refinement)
        pattern = patterns[key]
        pitches.append(pattern)
        blocks += _in_space(surface, pattern, face, tooth)
    joined = join_blocks(blocks, name=surface.name)
    lattice = Lattice.of(joined, element, name=surface.name)

    step = 2 if element == "hex8i" else 1
    flanks: dict[tuple[int, int], FlankGrid] = {}
    fillets: dict[tuple[int, int], FilletGrid] = {}
    middles = {}
    held = []
    for k, (tooth, pattern) in enumerate(zip(teeth, pitches, strict=True)):
        ids = joined.ids[4 * k : 4 * k + 4]
        held += [ids_of_block[-1] for ids_of_block in ids[1:]]
        down_the_middle = np.concatenate([ids[0][:, pattern.centre], ids[1][1:, pattern.centre]])
        middles[tooth] = lattice.number[::step, down_the_middle[::step]].T
        for side in (LOADED, OPPOSITE):
            edge, land = ids[0][:, -side], ids[2 + side][0]
            up = edge[: pattern.flank_points][::-1][::step]
            flanks[tooth, side] = FlankGrid(
                nodes=lattice.number[::step, up].T,
                profile=pattern.profile[side][::-1][::step, ::step],
                face=face[::step],
                points=joined.points[::step, up].swapaxes(0, 1),
                normals=_normals(surface, pattern, face, tooth, side)[::-1][::step, ::step],
            )
            down = np.concatenate([edge[pattern.flank_points - 1 :], land[1 : pattern.fillet_points + 1]])
            fillets[tooth, side] = _fillet_grid(lattice.number, joined.points, down, face, step)
    rest = None
    if missing and turn is not None:
        pattern = Pattern.of(surface, face, depth, divisions.coarse, None)
        pitch = join_blocks(_in_space(surface, pattern, face, teeth[-1] + 1), name=surface.name)
        alike = Lattice.of(pitch, element, name=surface.name)
        rest = RestOfRing(
            alike.mesh,
            element,
            missing,
            turn,
            held=_nodes(alike, *(pitch.ids[k][-1] for k in (1, 2, 3))),
            low=_cut_plane(alike, pitch.ids[2 + OPPOSITE]),
            high=_cut_plane(alike, pitch.ids[2 + LOADED]),
            last=_cut_plane(lattice, joined.ids[4 * (len(teeth) - 1) + 2 + LOADED]),
            first=_cut_plane(lattice, joined.ids[2 + OPPOSITE]),
        )
    return ToothMesh(
        surface.name, element, lattice.mesh, _nodes(lattice, *held), teeth, flanks, fillets, middles, rest
    )


def _in_space(surface: ToothSurface, pattern: Pattern, face: FloatArray, tooth: int) -> list[FloatArray]:
    """The blocks of a tooth as points (levels, rows, columns, 3)."""
    return [
        np.stack([surface.to_space(section, r, tooth) for section, r in zip(block, face, strict=True)])
        for block in pattern.blocks
    ]


# --- node sets ---------------------------------------------------------------------------------------------


def _nodes(lattice: Lattice, *ids: IntArray) -> IntArray:
    """All displacement nodes at points of the plane."""
    found = np.unique(lattice.number[:, np.unique(np.concatenate(ids))])
    return found[found >= 0]


def _cut_plane(lattice: Lattice, space: IntArray) -> IntArray:
    """Displacement nodes in the middle of a tooth space, face station by face station, from the root down."""
    found = lattice.number[:, space[:, -1]].ravel()
    return found[found >= 0]


def _normals(surface: ToothSurface, pattern: Pattern, face: FloatArray, tooth: int, side: int) -> FloatArray:
    """Outward unit normals (rows, levels, 3) of a flank, from the tip down."""
    columns = []
    for k, r in enumerate(face):
        section, normal = surface.flank(pattern.profile[side][:, k], float(r))
        mirror = 1.0 if side == LOADED else -1.0
        frame = surface.directions(mirror * section[:, 0], float(r), tooth)
        columns.append(np.einsum("na,nai->ni", normal * (mirror, 1.0, 1.0), frame))
    return np.stack(columns, axis=1)


def _fillet_grid(number: IntArray, points: FloatArray, ids: IntArray, face: FloatArray, step: int) -> FilletGrid:
    """The fillet's nodes with arc length through its lattice points."""
    places = points[:, ids].swapaxes(0, 1)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=2)
    arc = np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])
    pick = np.s_[::step, ::step]
    return FilletGrid(nodes=number[:, ids].T[pick], arc=arc[pick], face=face[::step], points=places[pick])

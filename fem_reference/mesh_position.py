"""One mesh position in finite elements: meshes that follow the contact lines, contact of all pairs, root stress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from skfem import MeshHex

from fem_reference.condensation import SupportedBody
from fem_reference.contact import ContactPair, ContactSolution, PairContact, condense
from fem_reference.elasticity import ElasticBody
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.kinematics import Pose
from fem_reference.pinion_mesh import pinion_mesh
from fem_reference.rigid_lines import Forecast, RigidFlank, RigidLine, forecast
from fem_reference.root_load import BODIES, RootStress
from fem_reference.surface import Surface
from fem_reference.tooth_mesh import LOADED, Divisions, FlankGrid, Refinement, ToothMesh
from semiwear.scene import Material, Scene

__all__ = ["MeshSettings", "PairResult", "PositionResult", "WearToCome", "effective_modulus", "solve_position"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

WearToCome = Callable[[RigidLine], FloatArray]
"""Depth that a unit line load wears off at the stations of a line [mm per N/mm]."""

_MASTER = 1.4  # the pinion's candidates reach this much farther than the gear's
_LEAST_WIDTH = 0.4  # of the widest pair's half-width: what hardly loaded pairs are meshed for
_APART = 1.0  # mm: the gap where nothing lies opposite
_REACH = 2.0  # mm, of facets that are tried against each other


@dataclass(frozen=True)
class MeshSettings:
    """Resolution of the contact meshes.

    Attributes
    ----------
    elements_per_half_width : float
        Elements across the expected contact half-width.
    element_length : float
        Length of elements along the line [mm].
    gear_teeth, pinion_teeth : int
        Teeth in the meshes; the bore and the back face are held, the cut planes free.
    growth : float
        Growth of elements outside the patch, mm for each mm.
    patch : float
        Half the refined width over the forecast half-width.
    """

    elements_per_half_width: float = 3.0
    element_length: float = 2.0
    gear_teeth: int = 5
    pinion_teeth: int = 9
    growth: float = 0.5
    patch: float = 1.5


@dataclass(frozen=True)
class PairResult:
    """What one tooth pair carries; arrays have one entry per slave node of the gear.

    Attributes
    ----------
    contact : PairContact
    line : RigidLine
    face, profile : arrays [mm]
        Places of the nodes on the gear's flank.
    force_vector : (k, 3) array [N]
        Pressing the pinion, fixed frame; the gear feels its opposite.
    pinion_face, pinion_profile : arrays [mm]
        Where the nodes meet the pinion.
    """

    contact: PairContact
    line: RigidLine
    face: FloatArray
    profile: FloatArray
    force_vector: FloatArray
    pinion_face: FloatArray
    pinion_profile: FloatArray


@dataclass(frozen=True)
class PositionResult:
    """A solved mesh position.

    Attributes
    ----------
    pairs : dict from pair to PairResult
    solution : ContactSolution
    forecast : Forecast
    root_stress : dict from (body, pair) to float [MPa]
    seconds : dict
    """

    pairs: dict[int, PairResult]
    solution: ContactSolution
    forecast: Forecast
    root_stress: dict[tuple[str, int], float]
    seconds: dict[str, float] = field(default_factory=dict)


def solve_position(
    flank: RigidFlank,
    mesh_position: float,
    torque: float,
    settings: MeshSettings,
    roots: RootStress | None = None,
    wear_to_come: WearToCome | None = None,
) -> PositionResult:
    """Contact of all tooth pairs at a mesh position.

    Parameters
    ----------
    flank : RigidFlank
        Pair, placement and wear.
    mesh_position : float
    torque : float [N mm]
    settings : MeshSettings
    roots : RootStress, optional
        Leave out to do without root stress.
    wear_to_come : function, optional
        Wear that a line load causes in the step to come, which is itself a gap: an implicit wear step.
    """
    pair = flank.pair
    scene = pair.scene
    started = perf_counter()
    lines = flank.lines(mesh_position)
    expected = forecast(lines, -(len(lines) // 2), torque / pair.pinion.base_radius, effective_modulus(scene))
    refined = _refinements(expected, settings)
    poses = {"gear": pair.gear_pose(mesh_position), "pinion": pair.pinion_pose(mesh_position)}
    divisions = Divisions.of_module(scene.gear_pair.module_mm)
    divisions = replace(divisions, depth=4, face_size=2.0 * settings.element_length)
    meshes = {
        "gear": face_gear_mesh(
            scene, teeth=settings.gear_teeth, divisions=divisions, detailed=(), refinements=refined["gear"]
        ),
        "pinion": pinion_mesh(
            scene, teeth=settings.pinion_teeth, divisions=divisions, detailed=(), refinements=refined["pinion"]
        ),
    }
    meshed = perf_counter()
    bodies = {name: _elastic(meshes[name], poses[name], getattr(scene.material, name)) for name in BODIES}
    supported = {name: SupportedBody(bodies[name].stiffness, bodies[name].dofs(meshes[name].held)) for name in BODIES}
    contacts, places = [], []
    for j in expected.lines:
        contact, place = _contact_pair(flank, expected, j, settings.patch, meshes, bodies, poses)
        contacts.append(contact)
        places.append(place)
    assembled = perf_counter()
    condensed = condense(supported, contacts)
    if wear_to_come is not None:
        blocks = [
            _wear_compliance(wear_to_come(line), line, place[0][mortar.nodes])
            for line, place, mortar in zip(expected.lines.values(), places, condensed.mortars, strict=True)
        ]
        condensed = replace(condensed, compliance=condensed.compliance + block_diag(*blocks))
    solution = condensed.solve(torque)
    pairs = {}
    for j, contact, found, (face, profile) in zip(expected.lines, contacts, solution.pairs, places, strict=True):
        face, profile = face[found.nodes], profile[found.nodes]
        met = pair.meeting(face, profile, mesh_position + j)
        assert contact.normals is not None
        vector = found.force[:, None] * contact.normals[found.nodes]
        line = expected.lines[j]
        pairs[j] = PairResult(found, line, face, profile, vector, met.pinion_face, met.pinion_profile)
    solved = perf_counter()
    stress = {} if roots is None else roots.of(pairs, poses)
    seconds = {
        "mesh": meshed - started,
        "stiffness and factor": assembled - meshed,
        "contact": solved - assembled,
        "root stress": perf_counter() - solved,
    }
    return PositionResult(pairs, solution, expected, stress, seconds)


def _wear_compliance(depth: FloatArray, line: RigidLine, face: FloatArray) -> FloatArray:
    """Gap that forces at nodes open by the wear they cause: alike for all nodes across the line (k, k) [mm/N]."""
    columns, where = np.unique(face, return_inverse=True)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line.position, axis=0), axis=1))])
    place = np.interp(columns, line.face, along)
    middles = np.concatenate([place[:1], 0.5 * (place[1:] + place[:-1]), place[-1:]])
    per_force = np.interp(columns, line.face, depth) / np.diff(middles)
    return np.where(where[:, None] == where, per_force[where][:, None], 0.0)


def effective_modulus(scene: Scene) -> float:
    """E* of both materials [MPa] (Johnson 1985, equation 4.5)."""

    def softness(material: Material) -> float:
        return (1.0 - material.poissons_ratio**2) / material.youngs_modulus_MPa

    return 1.0 / (softness(scene.material.pinion) + softness(scene.material.gear))


def _elastic(mesh: ToothMesh, pose: Pose, material: Material) -> ElasticBody:
    """The body in the fixed frame."""
    return ElasticBody(
        MeshHex(np.ascontiguousarray(pose.points(mesh.mesh.p.T).T), mesh.mesh.t),
        element=mesh.element,
        youngs_modulus=material.youngs_modulus_MPa,
        poissons_ratio=material.poissons_ratio,
    )


# --- meshes that follow the lines ----------------------------------------------------------------------------


def _half_range(expected: Forecast, pair: int, patch: float) -> float:
    """Half the width of the patch of a pair [mm]."""
    widest = max(float(width.max()) for width in expected.half_width.values())
    return patch * max(float(expected.half_width[pair].max()), _LEAST_WIDTH * widest)


def _refinements(expected: Forecast, settings: MeshSettings) -> dict[str, dict[int, Refinement]]:
    """Refined patches of all loaded teeth of both bodies: pair j is pinion tooth j on gear tooth -j."""
    result: dict[str, dict[int, Refinement]] = {name: {} for name in BODIES}
    for j, line in expected.lines.items():
        half = _half_range(expected, j, settings.patch)
        near = line.gap - expected.least < 1.5 * expected.approach
        tables = {"gear": (-j, line.face, line.profile), "pinion": (j, line.pinion_face, line.pinion_profile)}
        for name, (tooth, face, profile) in tables.items():
            result[name][tooth] = Refinement(
                profile_middle=_curve(face, profile),
                profile_half_range=half,
                face_range=(float(face[near].min()) - 1.0, float(face[near].max()) + 1.0),
                element_size_profile=half / settings.patch / settings.elements_per_half_width,
                element_size_face=settings.element_length,
                growth=settings.growth,
            )
    return result


def _curve(face: FloatArray, profile: FloatArray) -> Callable[[FloatArray], FloatArray]:
    return lambda wanted: np.interp(wanted, face, profile)


def _contact_pair(
    flank: RigidFlank,
    expected: Forecast,
    j: int,
    patch: float,
    meshes: dict[str, ToothMesh],
    bodies: dict[str, ElasticBody],
    poses: dict[str, Pose],
) -> tuple[ContactPair, tuple[FloatArray, FloatArray]]:
    """Candidates of a pair with their exact gap; also face and profile coordinates at all nodes of the gear."""
    pair, line, half = flank.pair, expected.lines[j], _half_range(expected, j, patch)
    gear, pinion = meshes["gear"].flanks[-j, LOADED], meshes["pinion"].flanks[j, LOADED]
    face = np.broadcast_to(gear.face, gear.profile.shape)
    met = pair.meeting(face, gear.profile, line.roll)
    gap = met.gap + flank.wear.depth(face, gear.profile) + pair.rounding(face, gear.profile, met)
    gap = np.where(np.isfinite(gap), np.minimum(gap, _APART), _APART)
    place = np.abs(gear.profile - np.interp(gear.face, line.face, line.profile))
    near = (place < half) & (gap - expected.least < 2.2 * expected.approach)
    other = np.abs(pinion.profile - np.interp(pinion.face, line.pinion_face, line.pinion_profile)) < _MASTER * half

    count = len(bodies["gear"].points)
    at_nodes = {name: np.full(count, fill) for name, fill in (("gap", _APART), ("face", 0.0), ("profile", 0.0))}
    normals = np.zeros((count, 3))
    for name, values in (("gap", gap), ("face", face), ("profile", gear.profile)):
        at_nodes[name][gear.nodes] = values
    normals[gear.nodes] = poses["gear"].vectors(gear.normals)
    contact = ContactPair(
        slave=_surface("gear", bodies["gear"].points, gear, near, poses["gear"]),
        master=_surface("pinion", bodies["pinion"].points, pinion, other, poses["pinion"]),
        gap=at_nodes["gap"],
        lever=pair.pinion.base_radius,
        normals=normals,
        reach=_REACH,
        name=f"pair {j:+d}",
    )
    return contact, (at_nodes["face"], at_nodes["profile"])


def _surface(name: str, points: FloatArray, grid: FlankGrid, chosen: NDArray[np.bool_], pose: Pose) -> Surface:
    """Facets of a flank with a chosen node, counter-clockwise from outside, and the flank's real edges."""
    n = grid.nodes
    quads = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1)
    wanted = chosen[:-1, :-1] | chosen[1:, :-1] | chosen[1:, 1:] | chosen[:-1, 1:]
    corner = points[quads[0, 0]]
    outward = np.cross(corner[2] - corner[0], corner[3] - corner[1]) @ pose.vectors(grid.normals[0, 0])
    quads = quads[wanted]
    edges = {"tip": n[-1], "inner end": n[:, 0], "outer end": n[:, -1], "fillet": n[0]}
    return Surface(name, points, quads if outward > 0.0 else quads[:, ::-1], edges)

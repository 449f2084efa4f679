"""One mesh position in finite elements: meshes that follow the contact lines, contact of all pairs, root stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from skfem import MeshHex

from fem_reference.arrays import BoolArray, FloatArray
from fem_reference.condensation import SupportedBody
from fem_reference.contact import CondensedContact, ContactSolution, PairContact, condense
from fem_reference.elasticity import ElasticBody
from fem_reference.line_meshes import Candidates, MeshSettings, candidates, line_meshes
from fem_reference.pair_motion import Pose
from fem_reference.rigid_lines import Forecast, RigidFlank, RigidLine, effective_modulus, forecast
from fem_reference.root_load import BODIES, RootStress
from fem_reference.tooth_mesh import ToothMesh
from semiwear.scene import Material

__all__ = ["MeshSettings", "MeshedPosition", "PairResult", "PositionResult"]


@dataclass(frozen=True)
class PairResult:
    """Contact of one tooth pair; arrays have one entry per slave node of the gear.

    Attributes
    ----------
    contact : PairContact
    line : RigidLine
    face, profile : arrays [mm]
        Coordinates of the nodes on the gear's flank.
    force_vector : (k, 3) array [N]
        On the pinion, fixed frame; the opposite force acts on the gear.
    pinion_face, pinion_profile : arrays [mm]
        Corresponding points of the pinion.
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


@dataclass(frozen=True)
class MeshedPosition:
    """Both bodies meshed around the contact lines of a mesh position, condensed onto their contact candidates.

    Solutions for other wear with nearly the same lines, or another torque, cost a hundredth of this.

    Attributes
    ----------
    flank : RigidFlank
        For which it was meshed.
    settings : MeshSettings
    expected : Forecast
    poses : dict of body to Pose
    candidates : dict of pair to Candidates
    condensed : CondensedContact
    seconds : dict
    """

    flank: RigidFlank
    settings: MeshSettings
    expected: Forecast
    poses: Mapping[str, Pose]
    candidates: Mapping[int, Candidates]
    condensed: CondensedContact
    seconds: Mapping[str, float]

    @classmethod
    def of(cls, flank: RigidFlank, mesh_position: float, torque: float, settings: MeshSettings) -> MeshedPosition:
        """Mesh and condense, with patches for a torque [N mm]; `flank` has pair, placement and wear."""
        pair, scene = flank.pair, flank.pair.scene
        started = perf_counter()
        lines = flank.lines(mesh_position)
        expected = forecast(lines, -(len(lines) // 2), torque / pair.lever, effective_modulus(scene))
        poses = {"gear": pair.gear_pose(mesh_position), "pinion": pair.pinion_pose(mesh_position)}
        meshes = line_meshes(flank, mesh_position, expected, settings)
        meshed = perf_counter()
        bodies = {name: _elastic(meshes[name], poses[name], getattr(scene.material, name)) for name in BODIES}
        supported = {
            name: SupportedBody.of(meshes[name], body, poses[name].rotation) for name, body in bodies.items()
        }
        every = {j: candidates(flank, expected, j, settings, meshes, bodies, poses) for j in expected.lines}
        # a pair that is expected to touch may have no node near enough
        found = {j: one for j, one in every.items() if len(one.contact.slave.quads) and len(one.contact.master.quads)}
        assembled = perf_counter()
        condensed = condense(supported, [one.contact for one in found.values()])
        # stiffnesses take much room, and only displacements would need them
        condensed = replace(condensed, bodies={}, unit_loads={})
        seconds = {
            "mesh": meshed - started,
            "stiffness": assembled - meshed,
            "condensation": perf_counter() - assembled,
            "contact": 0.0,
        }
        return cls(flank, settings, expected, poses, found, condensed, seconds)

    def solve(
        self,
        torque: float,
        roots: RootStress | None = None,
        flank: RigidFlank | None = None,
        start: list[BoolArray] | None = None,
    ) -> PositionResult:
        """Contact with the wear of `flank` (that of the mesh unless given), started from active sets."""
        worn, started = flank or self.flank, perf_counter()
        gaps = [one.gap(worn) for one in self.candidates.values()]
        solution = self.condensed.solve(torque, gaps=gaps, start=start)
        pairs = {}
        for (j, one), found, mortar in zip(
            self.candidates.items(), solution.pairs, self.condensed.mortars, strict=True
        ):
            at = found.nodes
            pairs[j] = PairResult(
                contact=found,
                line=self.expected.lines[j],
                face=one.face[at],
                profile=one.profile[at],
                force_vector=found.force[:, None] * mortar.normals,
                pinion_face=one.pinion_face[at],
                pinion_profile=one.pinion_profile[at],
            )
        solved = perf_counter()
        stress = {} if roots is None else roots.of(pairs, self.poses)
        # meshes that serve several wear states count once
        seconds = dict(self.seconds) if flank is None else dict.fromkeys(self.seconds, 0.0)
        seconds["contact"] += solved - started
        seconds["root stress"] = perf_counter() - solved
        return PositionResult(pairs, solution, self.expected, stress, seconds)


def _elastic(mesh: ToothMesh, pose: Pose, material: Material) -> ElasticBody:
    """The body in the fixed frame."""
    placed = MeshHex(np.ascontiguousarray(pose.points(mesh.mesh.p.T).T), mesh.mesh.t)
    return ElasticBody.of(placed, mesh.element, material)

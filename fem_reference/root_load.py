"""Root stress under the forces of a contact solution, on meshes that do not change with the roll position."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix

from fem_reference.arrays import FloatArray
from fem_reference.condensation import SupportedBody
from fem_reference.elasticity import ElasticBody
from fem_reference.pair_motion import Pose
from fem_reference.pairs import body_mesh, module_of, pair_motion
from fem_reference.root_stress import fillet_stress
from fem_reference.tooth_mesh import LOADED, Divisions, FlankGrid, ToothMesh
from semiwear.errors import ConvergenceError
from semiwear.scene import CylindricalPair, Scene

if TYPE_CHECKING:
    from fem_reference.mesh_position import PairResult

BODIES = ("pinion", "gear")

_EXPLICIT = 4  # teeth on either side that may carry load


@dataclass(frozen=True)
class RootStress:
    """Root stress on meshes of 20-node elements that do not change with the roll position.

    The contact forces act at the same points as in the contact solution. Every loaded pair is solved in turn on
    the middle tooth, with the loads of the others on its neighbours: it alone is meshed finely, far from the cut
    planes.

    Attributes
    ----------
    scene : Scene
    gear_teeth, pinion_teeth : int
        Five and seven teeth of a face gear pair give the stress of twice as many to 0.1 and 0.3 %. None is every
        tooth (of cylindrical gears): those farther than `_EXPLICIT` from the observed one carry no load.
    fillet, across, flank : int
        Elements along the fillet, across half the tooth and along the flank. The first two should match: twelve
        along the fillet with four across cause an error of 4 % of the stress where the mesh's blocks meet.
    towards_fillet : float
        Exponent of the growth of the flank's elements from the fillet to the tip. A load within the lowest element
        falsifies the fillet stress up to about an element's length from the flank's end, which must stay above the
        root (`root_stress.ROOT_FROM`).
    face_size : float
        Greatest length of an element along the face, in modules.

    Rings may be thick: elements below the root of cylindrical gears start with the size of the fillet's. Five instead
    of nine below 45 mm of steel raise root stress by 3 to 7 %.
    """

    scene: Scene
    gear_teeth: int | None = 5
    pinion_teeth: int | None = 9
    fillet: int = 8
    across: int = 6
    flank: int = 10
    towards_fillet: float = 1.8
    face_size: float = 0.5

    @cached_property
    def meshes(self) -> dict[str, ToothMesh]:
        """Both meshes, in their own frames."""
        counts = {"gear": self.gear_teeth, "pinion": self.pinion_teeth}
        return {
            name: body_mesh(
                self.scene, name, element="hex20", teeth=teeth, divisions=self._divisions, explicit=_EXPLICIT
            )
            for name, teeth in counts.items()
        }

    @property
    def _divisions(self) -> Divisions:
        module = module_of(self.scene)
        return Divisions(
            self.flank,
            self.fillet,
            land=1,
            across=self.across,
            depth=5,
            face_size=self.face_size * module,
            towards_fillet=self.towards_fillet,
            deeper=isinstance(self.scene.gear_pair, CylindricalPair),
        )

    @cached_property
    def systems(self) -> dict[str, tuple[ElasticBody, SupportedBody]]:
        """Elasticity of each body, and the body held."""
        systems = {}
        for name, mesh in self.meshes.items():
            body = ElasticBody.of(mesh.mesh, "hex20", getattr(self.scene.material, name))
            systems[name] = body, SupportedBody.of(mesh, body)
        return systems

    def of(self, pairs: Mapping[int, PairResult], poses: Mapping[str, Pose]) -> dict[tuple[str, int], float]:
        """Greatest tangential stress of the root of every loaded tooth, loaded side [MPa]."""
        result = {}
        for name in BODIES:
            body, supported = self.systems[name]
            mesh = self.meshes[name]
            forces = np.stack([self.forces(name, observed, pairs, poses[name]) for observed in pairs], axis=1)
            for j, moved in zip(pairs, supported.displacement(forces).T, strict=True):
                result[name, j] = fillet_stress(body, mesh, moved).greatest
        return result

    def forces(self, name: str, observed: int, pairs: Mapping[int, PairResult], pose: Pose) -> FloatArray:
        """Nodal forces (3 n,) of all pairs on a body turned so that the observed pair's tooth is tooth 0 [N]."""
        body, _ = self.systems[name]
        mesh, motion = self.meshes[name], pair_motion(self.scene)
        force = np.zeros((len(body.points), 3))
        for j, found in pairs.items():
            # pair j is pinion tooth j on gear tooth -j
            tooth = j - observed if name == "pinion" else observed - j
            if tooth not in mesh.teeth:
                if mesh.rest is not None and found.contact.load > 0.0:
                    raise ConvergenceError(f"root stress: tooth {tooth} of the {name} bears load outside the mesh")
                continue
            at = (found.pinion_face, found.pinion_profile) if name == "pinion" else (found.face, found.profile)
            sign = 1.0 if name == "pinion" else -1.0
            vector = found.force_vector @ pose.rotation @ motion.turned_to_zero(name, observed).T
            force += sign * (carried(mesh.flanks[tooth, LOADED], *at, len(body.points)).T @ vector)
        return force.ravel()


def carried(grid: FlankGrid, face: FloatArray, profile: FloatArray, nodes: int) -> csr_matrix:
    """Weights (k, nodes) with which forces at points of a flank act on the nodes of its 8-node facets."""
    column = np.clip(np.searchsorted(grid.face[::2], face) - 1, 0, (len(grid.face) - 1) // 2 - 1)
    left, right = grid.face[2 * column], grid.face[2 * column + 2]
    across = np.clip(2.0 * (face - left) / (right - left) - 1.0, -1.0, 1.0)
    share = 0.5 * (1.0 + across)[:, None]
    stations = (1.0 - share) * grid.profile[::2, 2 * column].T + share * grid.profile[::2, 2 * column + 2].T
    rows = stations.shape[1] - 1
    row = np.clip((stations < profile[:, None]).sum(axis=1) - 1, 0, rows - 1)
    k = np.arange(len(face))
    along = np.clip(2.0 * (profile - stations[k, row]) / (stations[k, row + 1] - stations[k, row]) - 1.0, -1.0, 1.0)
    entries, values = [], []
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            if a == 0 and b == 0:
                continue
            if a and b:  # corner of the serendipity element
                value = 0.25 * (1.0 + a * along) * (1.0 + b * across) * (a * along + b * across - 1.0)
            elif b:
                value = 0.5 * (1.0 - along**2) * (1.0 + b * across)
            else:
                value = 0.5 * (1.0 + a * along) * (1.0 - across**2)
            entries.append(grid.nodes[2 * row + 1 + a, 2 * column + 1 + b])
            values.append(value)
    columns = np.stack(entries, axis=1)
    return csr_matrix(
        (np.stack(values, axis=1).ravel(), (np.repeat(k, 8), columns.ravel())), shape=(len(face), nodes)
    )

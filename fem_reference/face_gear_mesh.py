"""Surface and mesh of the face gear: teeth side by side on a stretch of rim that is held at its back face.

The mesh lies in the gear frame of `FaceGearTooth` (gear axis y, teeth to +y): the loaded flank of tooth 0 is the
one that `FaceGearTooth.points` describes. Face stations are cylinders about the gear axis; on each the section
coordinates are the arc from the middle of the tooth, positive to the loaded side, and y.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from fem_reference.arrays import FloatArray
from fem_reference.hexahedra import MeshError
from fem_reference.kinematics import PairKinematics
from fem_reference.tooth_mesh import Divisions, Refinement, ToothMesh, mesh_teeth
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.scene import Scene


@dataclass(frozen=True)
class FaceGearSurface:
    """The face gear as `mesh_teeth` sees it (a `ToothSurface`)."""

    tooth: FaceGearTooth
    face_limits: tuple[float, float]
    name: str = "gear"

    @cached_property
    def _undercut_radius(self) -> float:
        return self.tooth.undercut_radius()

    def half_pitch(self, face: float) -> float:
        """Half a pitch on the cylinder [mm]."""
        return pi * face / self.tooth.gear_teeth

    @property
    def foot(self) -> float:
        """Section height of the held back face [mm]."""
        return -self.tooth.shaper_pitch_radius - self.tooth.shaper_addendum - self.tooth.rim_thickness

    def profile_limits(self, face: float) -> tuple[float, float]:
        """Profile coordinate of the lower end of the flank and of the tip [mm]."""
        tip = float(self.tooth.tip_profile(np.array([face]))[0])
        if self.tooth.half_thickness(face, self.tooth.gear_addendum) <= 0.0:
            raise MeshError(
                f"gear: the tooth is pointed at radius {face:.4g} mm; lower gear_pair.gear_outer_radius_mm"
            )
        if face < self._undercut_radius:
            raise MeshError(
                f"gear: the tooth is undercut at radius {face:.4g} mm; raise gear_pair.gear_inner_radius_mm"
            )
        return self.tooth.root_profile, tip

    def flank(self, profile: FloatArray, face: float) -> tuple[FloatArray, FloatArray]:
        """Section points (n, 2) of the loaded flank and normals (n, 3): along the arc, the height, the radius."""
        points, normals = self.tooth.points(np.full(len(profile), face), profile)
        angle = np.arctan2(points[:, 0], points[:, 2])
        section = np.column_stack([face * (angle + pi / self.tooth.gear_teeth), points[:, 1]])
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = normals.T
        return section, np.column_stack([x * c - z * s, y, x * s + z * c])

    def fillet(self, face: float) -> FloatArray:
        """Section points (k, 2) of the fillet, from the end of the flank to the root."""
        points = self.tooth.fillet(face, 161)
        angle = np.arctan2(points[:, 0], points[:, 2])
        return np.column_stack([face * (angle + pi / self.tooth.gear_teeth), points[:, 1]])

    def to_space(self, section: FloatArray, face: float, tooth: int) -> FloatArray:
        """Points (..., 3) of section points (..., 2) of a tooth [mm]."""
        angle = section[..., 0] / face + (2 * tooth - 1) * pi / self.tooth.gear_teeth
        return np.stack([face * np.sin(angle), section[..., 1], face * np.cos(angle)], axis=-1)

    def directions(self, across: FloatArray, face: float, tooth: int) -> FloatArray:
        """Unit vectors (..., 3, 3) along the arc, the height and the radius at section coordinates `across`."""
        angle = across / face + (2 * tooth - 1) * pi / self.tooth.gear_teeth
        c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        rows = [np.stack([c, o, -s], axis=-1), np.stack([o, o + 1.0, o], axis=-1), np.stack([s, o, c], axis=-1)]
        return np.stack(rows, axis=-2)


def face_gear_mesh(
    scene: Scene,
    *,
    element: str = "hex8i",
    teeth: int = 5,
    refinements: Mapping[int, Refinement] | None = None,
    divisions: Divisions | None = None,
    detailed: tuple[int, ...] = (0,),
) -> ToothMesh:
    """Mesh a stretch of the face gear.

    Parameters
    ----------
    scene : Scene
    element : str
        ``"hex8i"``, ``"hex20"`` or ``"hex27"``.
    teeth : int
        Teeth of the stretch, tooth 0 in its middle; an even number puts one more on the loaded side.
    refinements : mapping from tooth to Refinement, optional
        Refined patches on loaded flanks; tooth j is the j-th neighbour on the side that the loaded flank faces.
    divisions : Divisions, optional
        Elements of the detailed teeth.
    detailed : tuple of int
        Teeth that are meshed with `divisions` (those with a refinement are anyway); the others are coarse.

    Raises
    ------
    MeshError
        Where the tooth is pointed or undercut, or an element is folded.
    """
    motion = PairKinematics(scene)
    surface = FaceGearSurface(motion.gear, motion.gear_face)
    first = -((teeth - 1) // 2)
    divisions = divisions or Divisions.of_module(motion.gear.module)
    return mesh_teeth(surface, range(first, first + teeth), element, refinements or {}, divisions, detailed)

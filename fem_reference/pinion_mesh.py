"""Surface and mesh of the spur pinion: its whole ring, held at the bore.

The mesh lies in the pinion's own frame (axis z, tooth 0 centred on -y): the loaded flank of tooth 0 is the one on its
-x side that `InvoluteTooth` describes. Face stations are planes of constant z, measured as in the fixed frame. The
section coordinates are the angle from the middle of the tooth, positive to the loaded side, times the pitch radius,
and the radius.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import numpy as np

from fem_reference.arrays import FloatArray
from fem_reference.hexahedra import MeshError
from fem_reference.kinematics import PairKinematics
from fem_reference.tooth_mesh import Divisions, Refinement, ToothMesh, mesh_teeth
from semiwear.geometry.involute import InvoluteTooth
from semiwear.scene import Scene


@dataclass(frozen=True)
class PinionSurface:
    """The pinion as a `ToothSurface` for `mesh_teeth`."""

    tooth: InvoluteTooth
    face_limits: tuple[float, float]
    name: str = "pinion"

    def half_pitch(self, face: float) -> float:
        """Half a pitch on the pitch circle [mm]."""
        return pi * self.tooth.pitch_radius / self.tooth.teeth

    @property
    def foot(self) -> float:
        """Radius of the held bore [mm]."""
        return self.tooth.bore_radius

    def profile_limits(self, face: float) -> tuple[float, float]:
        """Profile coordinate of the lower end of the involute and of the tip [mm]."""
        tooth = self.tooth
        if tooth.tip_half_thickness <= 0.0:
            raise MeshError("pinion: the tooth is pointed at its tip circle; lower gear_pair.pinion_addendum_mm")
        if tooth.form_roll_angle <= 0.0:
            raise MeshError("pinion: the rack undercuts the tooth; lower gear_pair.rack_addendum_mm or add teeth")
        low, high = tooth.profile_from_roll(np.array([tooth.form_roll_angle, tooth.tip_roll_angle]))
        return float(low), float(high)

    def flank(self, profile: FloatArray, face: float) -> tuple[FloatArray, FloatArray]:
        """Section points (n, 2) of the loaded flank and normals (n, 3): along the arc, the radius, the axis."""
        roll = self.tooth.roll_from_profile(profile)
        angle = -self.tooth.polar_angle(roll)
        radius = self.tooth.base_radius * np.sqrt(1.0 + roll**2)
        # the normal is tangent to the base circle, at atan(roll) to the arc and pointing outwards
        normal = np.column_stack([np.ones_like(roll), roll, np.zeros_like(roll)]) / np.sqrt(1.0 + roll**2)[:, None]
        return np.column_stack([angle * self.tooth.pitch_radius, radius]), normal

    def fillet(self, face: float) -> FloatArray:
        """Section points (k, 2) of the fillet, from the end of the involute to the root circle."""
        x, y = self.tooth.fillet(161).T
        return np.column_stack([np.arctan2(x, y) * self.tooth.pitch_radius, np.hypot(x, y)])

    def to_space(self, section: FloatArray, face: float, tooth: int) -> FloatArray:
        """Points (..., 3) of section points (..., 2) of a tooth [mm]."""
        angle = self._polar(section[..., 0], tooth)
        radius = section[..., 1]
        return np.stack([radius * np.sin(angle), -radius * np.cos(angle), np.full_like(angle, face)], axis=-1)

    def directions(self, across: FloatArray, face: float, tooth: int) -> FloatArray:
        """Unit vectors (..., 3, 3) along the arc, the radius and the axis at section coordinates `across`."""
        angle = self._polar(across, tooth)
        c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        rows = [np.stack([-c, -s, o], axis=-1), np.stack([s, -c, o], axis=-1), np.stack([o, o, o + 1.0], axis=-1)]
        return np.stack(rows, axis=-2)

    def _polar(self, across: FloatArray, tooth: int) -> FloatArray:
        """Polar angle from -y towards +x [rad]."""
        return -across / self.tooth.pitch_radius - 2.0 * pi * tooth / self.tooth.teeth


def pinion_mesh(
    scene: Scene,
    *,
    element: str = "hex8i",
    teeth: int | None = None,
    refinements: Mapping[int, Refinement] | None = None,
    divisions: Divisions | None = None,
    detailed: tuple[int, ...] = (0,),
) -> ToothMesh:
    """Mesh the pinion.

    Parameters
    ----------
    scene : Scene
    element : str
        ``"hex8i"``, ``"hex20"`` or ``"hex27"``.
    teeth : int, optional
        Number of teeth of a sector with free cut planes instead of the whole ring, for fast trials.
    refinements, divisions, detailed
        As for `face_gear_mesh`.

    Raises
    ------
    MeshError
        Where the tooth is pointed or undercut, or an element is folded.
    """
    motion = PairKinematics(scene)
    surface = PinionSurface(motion.pinion, motion.pinion_face)
    whole = motion.pinion_teeth
    count = whole if teeth is None else min(teeth, whole)
    first = -((count - 1) // 2)
    divisions = divisions or Divisions.of_module(motion.pinion.module)
    return mesh_teeth(surface, range(first, first + count), element, refinements or {}, divisions, detailed)

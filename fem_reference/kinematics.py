r"""A face gear pair in motion: position of both bodies at a roll position, gap and sliding of their true flanks.

Written from `semiwear.geometry` alone, without the core's `semiwear.meshing`, so that an error in either is detected.
Frames and signs are those of docs/frame.svg:

* gear and pinion have frames of their own, in which their meshes lie (`face_gear_mesh`, `pinion_mesh`);
* in the fixed frame the gear is turned by its angle about y, the pinion by its own about z, moved down by the
  difference of the pitch radii of shaper and pinion, then displaced as a rigid body by the `Placement`;
* `roll` counts base pitches: the pinion turns by -2 pi/N1 for each, and tooth pair j (pinion tooth j, gear tooth -j)
  stands at roll position r as pair 0 does at r + j.

The distance of a point to the pinion's involute along its normal is the difference of two lengths of string unwound
from the base circle, r_b (rotation - rotation at which the involute passes through the point); exact (Litvin and
Fuentes 2004, *Gear Geometry and Applied Theory*, chapters 10 and 18).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import pi, radians

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fem_reference.arrays import FloatArray
from fem_reference.face_gear_scene import face_gear_pair
from fem_reference.pair_motion import ARCSEC, EdgeInsets, FlankMeeting, PairMotion, Pose, displacement
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth
from semiwear.scene import Placement, Scene


@dataclass(frozen=True)
class PairKinematics:
    """Face gear pair in motion (a `PairMotion`).

    Attributes
    ----------
    scene : Scene
        With a face gear pair at 90 degrees.
    placement : Placement
        Rigid displacement of the pinion.
    """

    scene: Scene
    placement: Placement = field(default_factory=Placement)

    @cached_property
    def gear(self) -> FaceGearTooth:
        """Tooth space of the gear."""
        table = face_gear_pair(self.scene)
        return FaceGearTooth(
            shaper_teeth=table.shaper_teeth,
            gear_teeth=table.gear_teeth,
            module=table.module_mm,
            pressure_angle=radians(table.pressure_angle_deg),
            gear_addendum=table.gear_addendum_mm,
            shaper_addendum=table.shaper_addendum_mm,
            shaper_tip_radius=table.shaper_tip_radius_mm,
            rim_thickness=table.gear_rim_thickness_mm,
        )

    @cached_property
    def pinion(self) -> InvoluteTooth:
        """Tooth of the pinion."""
        table = face_gear_pair(self.scene)
        return InvoluteTooth(
            teeth=table.pinion_teeth,
            module=table.module_mm,
            pressure_angle=radians(table.pressure_angle_deg),
            addendum=table.pinion_addendum_mm,
            rack_addendum=table.rack_addendum_mm,
            rack_tip_radius=table.rack_tip_radius_mm,
            bore_radius=table.pinion_bore_radius_mm,
        )

    @property
    def pinion_teeth(self) -> int:
        """Number of the pinion's teeth."""
        return int(self.pinion.teeth)

    @property
    def lever(self) -> float:
        """Base radius of the pinion [mm]."""
        return self.pinion.base_radius

    @property
    def pitch_face(self) -> float:
        """Gear radius of the pitch point [mm]."""
        return self.gear.pitch_radius

    @property
    def ratio(self) -> float:
        """Gear rotation per pinion rotation."""
        return self.pinion.teeth / self.gear.gear_teeth

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the line of action [arcsec/mm]."""
        return self.ratio / self.pinion.base_radius * ARCSEC

    def pitch_height(self, face: FloatArray) -> FloatArray:
        """Height of the pitch cone above the gear's pitch plane at gear radii [mm]."""
        return self.pinion.pitch_radius * (1.0 - face / self.gear.pitch_radius)

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate of the pitch cone at gear radii [mm]."""
        return self.gear.profile_from_height(face, self.pitch_height(face))

    def flank_grid(self, face: FloatArray, radius: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Face and profile coordinates of gear radii and heights (P, F) [mm]: radii are the face coordinate."""
        return radius[0], self.gear.profile_from_height(radius, height)

    @property
    def gear_face(self) -> tuple[float, float]:
        """Inner and outer radius of the gear's teeth [mm]."""
        return face_gear_pair(self.scene).gear_inner_radius_mm, face_gear_pair(self.scene).gear_outer_radius_mm

    @property
    def pinion_face(self) -> tuple[float, float]:
        """Ends of the pinion's teeth along its axis [mm]."""
        table = face_gear_pair(self.scene)
        half = 0.5 * table.pinion_face_width_mm
        return table.pinion_centre_mm - half, table.pinion_centre_mm + half

    @property
    def pinion_profile_limits(self) -> tuple[float, float]:
        """Profile coordinates at which the pinion's involute begins and at which its tip circle cuts it [mm]."""
        tooth = self.pinion
        low, high = tooth.profile_from_roll(np.array([max(tooth.form_roll_angle, 0.0), tooth.tip_roll_angle]))
        return float(low), float(high)

    # --- poses -----------------------------------------------------------------------------------------------

    def pinion_angle(self, roll: ArrayLike) -> FloatArray:
        """Rotation of the pinion about +z at which the pair is conjugate [rad]."""
        return pi / self.pinion.teeth * (0.5 - 2.0 * np.asarray(roll, float))

    def gear_pose(self, roll: float) -> Pose:
        """The gear at a roll position."""
        angle = self.ratio * float(self.pinion_angle(roll))
        return Pose(Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix(), np.zeros(3))

    def pinion_pose(self, roll: float) -> Pose:
        """The pinion at a roll position, displaced by the placement."""
        about_axis = Rotation.from_rotvec([0.0, 0.0, float(self.pinion_angle(roll))]).as_matrix()
        turn, shift = self._displacement
        return Pose(turn @ about_axis, turn @ self._pinion_centre + shift)

    @property
    def _pinion_centre(self) -> FloatArray:
        """A point of the aligned pinion's axis [mm]."""
        return np.array([0.0, self.pinion.pitch_radius - self.gear.shaper_pitch_radius, 0.0])

    @cached_property
    def _displacement(self) -> tuple[FloatArray, FloatArray]:
        """Turn and shift by the placement: x -> turn x + shift; about y first, both axes through the pitch point."""
        return displacement(self.placement, np.array([0.0, -self.gear.shaper_pitch_radius, self.gear.pitch_radius]))

    def turned_to_zero(self, body: str, pair: int) -> FloatArray:
        """Rotation (3, 3) of a body in its own frame that brings the tooth of a pair to tooth 0."""
        about = np.array([0.0, 0.0, 1.0]) if body == "pinion" else np.array([0.0, 1.0, 0.0])
        teeth = self.pinion.teeth if body == "pinion" else self.gear.gear_teeth
        return np.asarray(Rotation.from_rotvec(2.0 * pi * pair / teeth * about).as_matrix())

    # --- flanks ----------------------------------------------------------------------------------------------

    def meeting(self, face: ArrayLike, profile: ArrayLike, roll: float) -> FlankMeeting:
        """Meeting points of gear flank points of pair 0 at a roll position.

        Parameters
        ----------
        face, profile : arrays that broadcast [mm]
            Gear radius and profile coordinate.
        roll : float
            Roll position of the pair.
        """
        return self.met_by(*self.gear.points(np.asarray(face, float), np.asarray(profile, float)), roll)

    def met_by(self, points: FloatArray, normals: FloatArray, roll: float) -> FlankMeeting:
        """Meeting points of points (..., 3) of the gear's tooth 0, on the fresh flank or a worn one.

        Parameters
        ----------
        points, normals : (..., 3) arrays [mm], [1]
            In the gear's own frame.
        roll : float
        """
        gear, pinion = self.gear_pose(roll), self.pinion_pose(roll)
        position = gear.points(points)
        gap, met_profile, met_face = self.distance(pinion.back(position))
        return FlankMeeting(gap, position, gear.vectors(normals), met_profile, met_face)

    def distance(self, in_pinion: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Distance of points (..., 3) to the loaded flank of pinion tooth 0, all in the pinion's own frame [mm].

        Returns
        -------
        gap, profile, face : arrays [mm]
            Positive gap outside the tooth; profile coordinate and axial place of the foot, at the points' radius.
        """
        x, y, z = np.moveaxis(in_pinion, -1, 0)
        base = self.pinion.base_radius
        unwound = np.sqrt(np.maximum(x**2 + y**2 - base**2, 0.0)) / base
        gap = -base * (np.arctan2(x, -y) - self.pinion.polar_angle(unwound))
        return gap, self.pinion.profile_from_roll(unwound), z

    def edge_insets(self, face: ArrayLike) -> EdgeInsets:
        """Distance from the nominal tips at which their roundings begin, at gear radii [mm]."""
        table = face_gear_pair(self.scene)
        tip = self.gear.tip_profile(np.asarray(face, float))
        gear_turn = 0.5 * pi - self.gear.generation_angle(np.asarray(face, float), tip)
        pinion_turn = 0.5 * pi - float(np.arctan(self.pinion.tip_roll_angle))
        return EdgeInsets(
            gear_tip=table.gear_tip_edge_radius_mm * np.tan(0.5 * gear_turn),
            pinion_tip=table.pinion_tip_edge_radius_mm * float(np.tan(0.5 * pinion_turn)),
        )

    # --- speeds ----------------------------------------------------------------------------------------------

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion minus that of the gear at fixed-frame points [mm per radian of the pinion]."""
        turn, shift = self._displacement
        centre = turn @ self._pinion_centre + shift
        pinion = np.cross(turn @ np.array([0.0, 0.0, -1.0]), position - centre)
        return pinion - np.cross(np.array([0.0, -self.ratio, 0.0]), position)


def face_gear_motion(pair: PairMotion) -> PairKinematics:
    """The pair, which must be that of a face gear.

    Raises
    ------
    SceneError
        For another kind.
    """
    if not isinstance(pair, PairKinematics):
        face_gear_pair(pair.scene)
        raise TypeError(f"not a face gear in motion: {type(pair).__name__}")
    return pair

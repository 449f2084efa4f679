r"""Where both bodies of a face gear pair stand at a roll position, and how their true flanks part and slide there.

Written from `semiwear.geometry` alone, without the core's `semiwear.meshing`, so that a mistake in either shows.
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
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fem_reference.face_gear_scene import face_gear_pair
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth
from semiwear.scene import Placement, Scene

__all__ = ["EdgeInsets", "FlankMeeting", "PairKinematics", "Pose"]

FloatArray = NDArray[np.float64]

_ARCSEC = 180.0 * 3600.0 / pi


@dataclass(frozen=True)
class Pose:
    """A rigid motion from a body's own frame into the fixed frame: turn, then shift.

    Attributes
    ----------
    rotation : (3, 3) array
    shift : (3,) array [mm]
    """

    rotation: FloatArray
    shift: FloatArray

    def points(self, own: FloatArray) -> FloatArray:
        """Fixed-frame places of points (..., 3) [mm]."""
        return own @ self.rotation.T + self.shift

    def vectors(self, own: FloatArray) -> FloatArray:
        """Fixed-frame components of vectors (..., 3)."""
        return own @ self.rotation.T

    def back(self, fixed: FloatArray) -> FloatArray:
        """Own-frame places of fixed-frame points (..., 3) [mm]."""
        return (fixed - self.shift) @ self.rotation


@dataclass(frozen=True)
class FlankMeeting:
    """Gear flank points and what they find on the pinion's involute.

    Attributes
    ----------
    gap : array [mm]
        Distance along the pinion's normal, positive when apart.
    position, normal : (..., 3) arrays [mm], [1]
        The gear's points in the fixed frame, and its normals out of the material.
    pinion_profile, pinion_face : arrays [mm]
        Profile coordinate of the involute that is met, and place along the pinion's axis.
    """

    gap: FloatArray
    position: FloatArray
    normal: FloatArray
    pinion_profile: FloatArray
    pinion_face: FloatArray


@dataclass(frozen=True)
class EdgeInsets:
    """Distances from nominal tip edges to where their roundings begin.

    Attributes
    ----------
    gear_tip : array [mm]
    pinion_tip : float [mm]
    """

    gear_tip: FloatArray
    pinion_tip: float


@dataclass(frozen=True)
class PairKinematics:
    """Face gear pair in motion.

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
    def ratio(self) -> float:
        """Gear rotation per pinion rotation."""
        return self.pinion.teeth / self.gear.gear_teeth

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the line of action [arcsec/mm]."""
        return self.ratio / self.pinion.base_radius * _ARCSEC

    def pitch_height(self, face: FloatArray) -> FloatArray:
        """Height of the pitch cone above the gear's pitch plane at gear radii [mm]."""
        return self.pinion.pitch_radius * (1.0 - face / self.gear.pitch_radius)

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
        """The pinion at a roll position, displaced as the placement says."""
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
        place = self.placement
        about_y = Rotation.from_rotvec([0.0, 1e-3 * place.pinion_slope_mrad, 0.0])
        about_x = Rotation.from_rotvec([1e-3 * place.shaft_angle_error_mrad, 0.0, 0.0])
        turn = (about_x * about_y).as_matrix()
        pitch_point = np.array([0.0, -self.gear.shaper_pitch_radius, self.gear.pitch_radius])
        moved = np.array([place.offset_mm, place.axial_gear_mm, place.axial_pinion_mm])
        return turn, pitch_point - turn @ pitch_point + moved

    # --- flanks ----------------------------------------------------------------------------------------------

    def meeting(self, face: ArrayLike, profile: ArrayLike, roll: float) -> FlankMeeting:
        """What gear flank points of pair 0 meet at a roll position.

        Parameters
        ----------
        face, profile : arrays that broadcast [mm]
            Gear radius and profile coordinate.
        roll : float
            Roll position of the pair.
        """
        return self.met_by(*self.gear.points(np.asarray(face, float), np.asarray(profile, float)), roll)

    def met_by(self, points: FloatArray, normals: FloatArray, roll: float) -> FlankMeeting:
        """What points (..., 3) of the gear's tooth 0 meet, wherever they lie: on the fresh flank or a worn one.

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
        """How far before the nominal tips their roundings begin, at gear radii [mm]."""
        table = face_gear_pair(self.scene)
        tip = self.gear.tip_profile(np.asarray(face, float))
        gear_turn = 0.5 * pi - self.gear.generation_angle(np.asarray(face, float), tip)
        pinion_turn = 0.5 * pi - float(np.arctan(self.pinion.tip_roll_angle))
        return EdgeInsets(
            gear_tip=table.gear_tip_edge_radius_mm * np.tan(0.5 * gear_turn),
            pinion_tip=table.pinion_tip_edge_radius_mm * float(np.tan(0.5 * pinion_turn)),
        )

    def rounding(self, face: ArrayLike, profile: ArrayLike, met: FlankMeeting) -> FloatArray:
        """Gap that the rounded edges of both bodies add [mm]; infinite beyond the nominal edges.

        An edge of radius rho that turns by t begins rho tan(t/2) before the nominal edge and falls off as its arc.
        """
        table = face_gear_pair(self.scene)
        face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        inset, gear_end, pinion_end = (
            self.edge_insets(face), table.gear_end_edge_radius_mm, table.pinion_end_edge_radius_mm,
        )  # fmt: skip
        edges = (
            (self.gear.tip_profile(face) - profile, table.gear_tip_edge_radius_mm, inset.gear_tip),
            (self.pinion_profile_limits[1] - met.pinion_profile, table.pinion_tip_edge_radius_mm, inset.pinion_tip),
            (face - self.gear_face[0], gear_end, gear_end),
            (self.gear_face[1] - face, gear_end, gear_end),
            (met.pinion_face - self.pinion_face[0], pinion_end, pinion_end),
            (self.pinion_face[1] - met.pinion_face, pinion_end, pinion_end),
        )
        added = np.zeros(face.shape)
        for distance, radius, begins in edges:
            into = begins - distance
            arc = radius - np.sqrt(np.maximum(radius**2 - np.clip(into, 0.0, radius) ** 2, 0.0))
            added += np.where(distance < -1e-9, np.inf, arc)
        return added

    # --- speeds ----------------------------------------------------------------------------------------------

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion less that of the gear at fixed-frame points [mm per radian of the pinion]."""
        turn, shift = self._displacement
        centre = turn @ self._pinion_centre + shift
        pinion = np.cross(turn @ np.array([0.0, 0.0, -1.0]), position - centre)
        return pinion - np.cross(np.array([0.0, -self.ratio, 0.0]), position)

    def line_speed(self, before: FloatArray, after: FloatArray, rolls: float) -> FloatArray:
        """Speed of a contact line over a flank, normal to the line [mm per radian of the pinion].

        Parameters
        ----------
        before, after : (face, 3) arrays [mm]
            The line in the body's own frame at two roll positions, by the same stations.
        rolls : float
            Roll positions between them.
        """
        moved = (after - before) / rolls * self.pinion.teeth / (2.0 * pi)
        along = np.gradient(0.5 * (before + after), axis=0)
        along /= np.linalg.norm(along, axis=-1)[:, None]
        return np.linalg.norm(moved - np.sum(moved * along, -1)[:, None] * along, axis=-1)

r"""A cylindrical pair in motion: position of both bodies at a roll position, gap and sliding of their flanks.

Written from `semiwear.geometry` alone, without the core's `semiwear.meshing`. Fixed frame: the origin on the pinion's
axis in the middle of the gear's face, z along both axes, the pitch point at (0, -r_w1, 0), the gear's axis at
(0, -a, 0), a negative for an internal gear. At roll 0 the flanks of pair 0 pass through the pitch point; each roll
position turns the pinion by -2 pi/z_1 about z and the gear, by its ratio, the other way or, inside, the same way. On
the coast flank the pair is its own mirror at x = 0, and its hand the other one.

The distance of a point to the pinion's involute helicoid along its normal is r_b cos(beta_b) times the rotation at
which the two would touch (Litvin and Fuentes 2004, *Gear Geometry and Applied Theory*, chapter 16; ISO 21771:2007).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import atan, cos, pi, radians, tan

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fem_reference.arrays import FloatArray
from fem_reference.involute_flank import InvoluteFlank
from fem_reference.pair_motion import ARCSEC, EdgeInsets, FlankMeeting, Pose, displacement
from semiwear.errors import SceneError
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.scene import CylindricalPair, Placement, Scene


@dataclass(frozen=True)
class CylindricalMotion:
    """Cylindrical pair in motion (a `PairMotion`).

    Attributes
    ----------
    scene : Scene
        With a cylindrical pair.
    placement : Placement
        Rigid displacement of the pinion.
    """

    scene: Scene
    placement: Placement = field(default_factory=Placement)

    @property
    def table(self) -> CylindricalPair:
        """The scene's table ``[gear_pair]``.

        Raises
        ------
        SceneError
            For another kind of gear pair.
        """
        pair = self.scene.gear_pair
        if not isinstance(pair, CylindricalPair):
            raise SceneError.of("gear_pair.type", pair.type, '"cylindrical"')
        return pair

    @cached_property
    def pinion(self) -> InvoluteFlank:
        """Loaded flank of the pinion."""
        table = self.table
        reference = 0.5 * table.normal_module_mm * table.pinion_teeth / cos(radians(table.helix_angle_deg))
        root = reference + table.pinion_profile_shift * table.normal_module_mm - table.pinion_rack_addendum_mm
        return self._flank("pinion", root - table.pinion_bore_radius_mm)

    @cached_property
    def gear(self) -> InvoluteFlank:
        """Loaded flank of the gear."""
        return self._flank("gear", self.table.gear_rim_thickness_mm)

    def _flank(self, name: str, rim_thickness: float) -> InvoluteFlank:
        table, internal = self.table, name == "gear" and self.table.internal
        tooth = CylindricalTooth(
            teeth=abs(getattr(table, f"{name}_teeth")),
            internal=internal,
            normal_module=table.normal_module_mm,
            normal_pressure_angle=radians(table.pressure_angle_deg),
            helix_angle=radians(table.helix_angle_deg),
            profile_shift=getattr(table, f"{name}_profile_shift"),
            tip_radius=0.5 * getattr(table, f"{name}_tip_diameter_mm"),
            rack_addendum=getattr(table, f"{name}_rack_addendum_mm"),
            rack_tip_radius=getattr(table, f"{name}_rack_tip_radius_mm"),
            rim_thickness=rim_thickness,
        )
        right = (table.hand == "right") == (self.scene.operation.loaded_flank == "drive")
        # a right-handed helix turns with growing z; the hands of two external gears differ
        turn = (1.0 if right else -1.0) * (-1.0 if name == "gear" and not internal else 1.0)
        twist = turn * tan(tooth.helix_angle) / tooth.reference_radius
        return InvoluteFlank(tooth, tooth.base_radius / cos(table.working_pressure_angle), twist)

    @property
    def pinion_teeth(self) -> int:
        """Number of the pinion's teeth."""
        return int(self.pinion.tooth.teeth)

    @property
    def ratio(self) -> float:
        """Gear rotation per pinion rotation, without its sign."""
        return self.pinion.tooth.teeth / self.gear.tooth.teeth

    @property
    def lever(self) -> float:
        """r_b1 cos(beta_b) [mm]."""
        return self.pinion.tooth.base_radius * cos(self.pinion.tooth.base_helix_angle)

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the normal [arcsec/mm]."""
        return self.ratio / self.lever * ARCSEC

    @property
    def gear_face(self) -> tuple[float, float]:
        """Ends of the gear's face, from its middle [mm]."""
        half = 0.5 * self.table.gear_face_width_mm
        return -half, half

    @property
    def pinion_face(self) -> tuple[float, float]:
        """Ends of the pinion's face, from the middle of the gear's [mm]."""
        half, middle = 0.5 * self.table.pinion_face_width_mm, self.table.face_offset_mm
        return middle - half, middle + half

    @property
    def pitch_face(self) -> float:
        """The middle of the gear's face [mm]."""
        return 0.0

    @property
    def pinion_profile_limits(self) -> tuple[float, float]:
        """Profile coordinates at which the pinion's involute begins and at which its tip circle cuts it [mm]."""
        return self.pinion.root_profile, float(self.pinion.tip_profile(np.array(0.0)))

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Zero: profile coordinates count from the working pitch circle [mm]."""
        return np.zeros(np.shape(face))

    def flank_grid(self, face: FloatArray, radius: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Face and profile coordinates of radii about the gear's axis (P, F) [mm]."""
        tooth = self.gear.tooth
        roll = np.sqrt(np.maximum((radius / tooth.base_radius) ** 2 - 1.0, 0.0))
        return face, self.gear.profile_from_roll(roll)

    # --- poses -----------------------------------------------------------------------------------------------

    def gear_pose(self, roll: float) -> Pose:
        """The gear at a roll position."""
        tooth = self.gear.tooth
        centre = np.array([0.0, -self.pinion.working_radius - tooth.side * self.gear.working_radius, 0.0])
        # its flank meets the line between the axes at roll 0; an external gear's tooth 0 points to the pinion
        turn = -self._at_pitch(self.gear) + tooth.side * 2.0 * pi / tooth.teeth * roll
        if not tooth.internal:
            turn += pi
        return Pose(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix(), centre)

    def pinion_pose(self, roll: float) -> Pose:
        """The pinion at a roll position, displaced by the placement."""
        turn = -self._at_pitch(self.pinion) - 2.0 * pi / self.pinion_teeth * roll
        moved, shift = self._displacement
        return Pose(moved @ Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix(), shift)

    @staticmethod
    def _at_pitch(flank: InvoluteFlank) -> float:
        """Polar angle of tooth 0's flank on the working pitch circle at z = 0, own frame [rad]."""
        return float(flank.polar_angle(np.array(flank.working_roll), np.array(0.0)))

    @cached_property
    def _displacement(self) -> tuple[FloatArray, FloatArray]:
        return displacement(self.placement, np.array([0.0, -self.pinion.working_radius, 0.0]))

    def turned_to_zero(self, body: str, pair: int) -> FloatArray:
        """Rotation (3, 3) of a body in its own frame that brings the tooth of a pair to tooth 0."""
        flank, tooth = (self.pinion, pair) if body == "pinion" else (self.gear, -pair)
        angle = -flank.facing * 2.0 * pi * tooth / flank.tooth.teeth
        return np.asarray(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix())

    # --- flanks ----------------------------------------------------------------------------------------------

    def meeting(self, face: ArrayLike, profile: ArrayLike, roll: float) -> FlankMeeting:
        """Meeting points of flank points of gear tooth 0 at a roll position."""
        return self.met_by(*self.gear.points(np.asarray(face, float), np.asarray(profile, float)), roll)

    def met_by(self, points: FloatArray, normals: FloatArray, roll: float) -> FlankMeeting:
        """Meeting points of points (..., 3) of gear tooth 0, given in the gear's own frame."""
        gear, tooth = self.gear_pose(roll), self.pinion.tooth
        position = gear.points(points)
        x, y, z = np.moveaxis(self.pinion_pose(roll).back(position), -1, 0)
        unwound = np.sqrt(np.maximum(x**2 + y**2 - tooth.base_radius**2, 0.0)) / tooth.base_radius
        gap = -self.lever * (np.arctan2(x, -y) - self.pinion.polar_angle(unwound, z))
        return FlankMeeting(gap, position, gear.vectors(normals), self.pinion.profile_from_roll(unwound), z)

    def edge_insets(self, face: ArrayLike) -> EdgeInsets:
        """Distance from the nominal tips at which their roundings begin [mm]."""
        table = self.table
        pinion, gear = (tan(0.25 * pi - 0.5 * atan(f.tooth.tip_roll_angle)) for f in (self.pinion, self.gear))
        return EdgeInsets(
            gear_tip=np.full(np.shape(face), table.gear_tip_edge_radius_mm * gear),
            pinion_tip=table.pinion_tip_edge_radius_mm * pinion,
        )

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion minus that of the gear at fixed-frame points [mm per radian of the pinion]."""
        turn, shift = self._displacement
        pinion = np.cross(turn @ np.array([0.0, 0.0, -1.0]), position - shift)
        centre = self.gear_pose(0.0).shift
        gear = np.cross(np.array([0.0, 0.0, self.gear.tooth.side * self.ratio]), position - centre)
        return pinion - gear

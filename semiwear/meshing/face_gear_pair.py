"""The face-gear pair: a spur involute pinion that drives a shaped face gear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, radians

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth
from semiwear.meshing.flank_pair import ARCSEC, DRIVING, EXACT_STEPS, Borders, Meeting, PrismBody, displacement
from semiwear.meshing.own_flanks import driving_involute
from semiwear.scene import FaceGearPair as FaceGearTable
from semiwear.scene import Placement

_GEAR_SECTIONS = 9  # with seven, root stress near the inner end, where undercut shapes the fillet, varies by 5 %


def _edge_inset(edge_radius: float, turn: float | FloatArray) -> FloatArray:
    """Distance from a nominal edge to where its rounding begins, for an outline that turns by `turn` [rad]."""
    return edge_radius * np.tan(0.5 * np.asarray(turn))


@dataclass(frozen=True)
class FaceGearMesh:
    """A face-gear tooth and an involute pinion tooth in mesh (a `FlankPair`).

    Attributes
    ----------
    table : FaceGearPair
        The scene's table.
    placement : Placement
        Rigid displacement of the pinion from its nominal place.
    """

    table: FaceGearTable
    placement: Placement

    @cached_property
    def gear(self) -> FaceGearTooth:
        """The gear's tooth."""
        t = self.table
        return FaceGearTooth(
            shaper_teeth=t.shaper_teeth,
            gear_teeth=t.gear_teeth,
            module=t.module_mm,
            pressure_angle=radians(t.pressure_angle_deg),
            gear_addendum=t.gear_addendum_mm,
            shaper_addendum=t.shaper_addendum_mm,
            shaper_tip_radius=t.shaper_tip_radius_mm,
            rim_thickness=t.gear_rim_thickness_mm,
        )

    @cached_property
    def pinion(self) -> InvoluteTooth:
        """The pinion's tooth."""
        t = self.table
        return InvoluteTooth(
            teeth=t.pinion_teeth,
            module=t.module_mm,
            pressure_angle=radians(t.pressure_angle_deg),
            addendum=t.pinion_addendum_mm,
            rack_addendum=t.rack_addendum_mm,
            rack_tip_radius=t.rack_tip_radius_mm,
            bore_radius=t.pinion_bore_radius_mm,
        )

    @property
    def difference_steps(self) -> tuple[float, float]:
        """Steps for flanks given by formulas."""
        return EXACT_STEPS

    @property
    def face_limits(self) -> tuple[float, float]:
        """Inner and outer gear radius [mm]."""
        return self.table.gear_inner_radius_mm, self.table.gear_outer_radius_mm

    @property
    def base_pitch(self) -> float:
        """Base pitch of the pinion [mm]."""
        return self.pinion.base_pitch

    @cached_property
    def base_profiles(self) -> tuple[float, float]:
        """Profile coordinates of the base circles of the pinion and of the shaper that generates the gear [mm]."""
        return float(self.pinion.profile_from_roll(np.zeros(()))), float(self.gear.profile_from_roll(0.0))

    @property
    def roll_per_time(self) -> float:
        """Pinion teeth per radian."""
        return self.table.pinion_teeth / (2.0 * pi)

    @property
    def transmission_ratio(self) -> float:
        """Gear rotation per pinion rotation, N1/N2."""
        return self.table.pinion_teeth / self.table.gear_teeth

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the pinion's reference circle."""
        return self.table.normal_per_arc

    @property
    def driving_meshes(self) -> float:
        """N2/N1: a pinion tooth meshes more often than a gear tooth."""
        return self.table.gear_teeth / self.table.pinion_teeth

    @property
    def pitch_point(self) -> FloatArray:
        """Pitch point on the line between the axes, at the pitch radii [mm]."""
        return np.array([0.0, -self.gear.shaper_pitch_radius, self.gear.pitch_radius])

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the line of action [arcsec/mm]."""
        return self.transmission_ratio / self.pinion.base_radius * ARCSEC

    @cached_property
    def _axis_offset(self) -> float:
        return self.gear.shaper_pitch_radius - self.pinion.pitch_radius

    @cached_property
    def _pinion_frame(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rotation and shift of the displaced pinion, and the pitch point about which it is turned."""
        return *displacement(self.placement), self.pitch_point

    def _nominal_rotation(self, roll: FloatArray) -> FloatArray:
        """Pinion rotation at which the pair nominally meets at a roll position [rad]."""
        return 0.5 * pi / self.table.pinion_teeth - 2.0 * pi / self.table.pinion_teeth * np.asarray(roll)

    def _tip_turn_driven(self, face: FloatArray) -> FloatArray:
        """Angle between the gear's flank and its tip plane [rad]: 90 degrees less the flank's inclination."""
        tip = self.gear.tip_profile(face)
        return 0.5 * pi - self.gear.generation_angle(face, tip)

    def borders(self, face: FloatArray, *, sharp: bool = False) -> Borders:
        """Limits of both flanks at gear radii `face` [mm]."""
        t, pinion = self.table, self.pinion
        face = np.asarray(face, float)
        keep = 0.0 if sharp else 1.0
        tip_turn = self._tip_turn_driven(face)
        tip_inset = keep * _edge_inset(t.gear_tip_edge_radius_mm, tip_turn)
        # the pinion's flank leaves its tip circle under 90 degrees less the pressure angle there
        driving_turn = 0.5 * pi - np.arctan(pinion.tip_roll_angle)
        driving_inset = keep * float(_edge_inset(t.pinion_tip_edge_radius_mm, driving_turn))
        half_width = 0.5 * t.pinion_face_width_mm
        return Borders(
            root=np.full(face.shape, self.gear.root_profile),
            tip=self.gear.tip_profile(face) - tip_inset,
            driving_root=float(pinion.profile_from_roll(np.array(max(pinion.form_roll_angle, 0.0)))),
            driving_tip=float(pinion.profile_from_roll(np.array(pinion.tip_roll_angle))) - driving_inset,
            face=self.face_limits,
            driving_face=(t.pinion_centre_mm - half_width, t.pinion_centre_mm + half_width),
            tip_turn=tip_turn,
            driving_tip_turn=float(driving_turn),
            tip_edge_radius=t.gear_tip_edge_radius_mm,
            end_edge_radius=t.gear_end_edge_radius_mm,
            driving_tip_edge_radius=t.pinion_tip_edge_radius_mm,
            driving_end_edge_radius=t.pinion_end_edge_radius_mm,
        )

    def meeting(self, face: FloatArray, profile: FloatArray, roll: FloatArray) -> Meeting:
        """Separation along the pinion's involute normal, exact (design, section 4)."""
        points, normals = self.gear.points(face, profile)
        nominal = self._nominal_rotation(roll)
        turn = nominal * self.transmission_ratio
        c, s = np.cos(turn), np.sin(turn)

        def rotate(v: FloatArray) -> FloatArray:
            x, y, z = v[..., 0], v[..., 1], v[..., 2]
            return np.stack(np.broadcast_arrays(x * c + z * s, y + 0.0 * c, z * c - x * s), axis=-1)

        position = rotate(points)
        rotation, shift, pitch_point = self._pinion_frame
        local = (position - shift - pitch_point) @ rotation + pitch_point
        across, down = local[..., 0], -(local[..., 1] + self._axis_offset)
        roll_angle = np.sqrt(np.maximum((across**2 + down**2) / self.pinion.base_radius**2 - 1.0, 0.0))
        touching = np.arctan2(across, down) - self.pinion.polar_angle(roll_angle)
        return Meeting(
            separation=self.pinion.base_radius * (nominal - touching),
            position=position,
            normal=rotate(normals),
            driving_profile=self.pinion.profile_from_roll(roll_angle),
            driving_face=local[..., 2],
        )

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion minus that of the gear [mm per radian of pinion rotation]."""
        rotation, shift, pitch_point = self._pinion_frame
        axis = rotation @ np.array([0.0, 0.0, -1.0])
        centre = rotation @ (np.array([0.0, -self._axis_offset, 0.0]) - pitch_point) + pitch_point + shift
        return np.cross(axis, position - centre) - self.driven_velocity(position)

    def driven_velocity(self, position: FloatArray) -> FloatArray:
        """Velocity of the gear [mm per radian of pinion rotation]: it turns about -y."""
        zero = np.zeros(position.shape[:-1])
        return self.transmission_ratio * np.stack([-position[..., 2], zero, position[..., 0]], axis=-1)

    def lever_arm(self, position: FloatArray) -> FloatArray:
        """Base radius of the pinion, the same at every contact point [mm]."""
        return np.full(position.shape[:-1], self.pinion.base_radius)

    def flank_place(self, body: int, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Height above the pitch plane (pitch circle), and radius about the body's own axis [mm]."""
        face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        if body == DRIVING:
            roll = self.pinion.roll_from_profile(profile)
            radius = self.pinion.base_radius * np.sqrt(1.0 + roll**2)
            return radius - self.pinion.pitch_radius, radius
        return self.gear.height(face, profile), face

    def profile_at(self, face: FloatArray, height: FloatArray) -> FloatArray:
        """Profile coordinate of the gear's flank at a height above the pitch plane [mm]."""
        return self.gear.profile_from_height(face, height)

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate where the gear's flank crosses the pitch cone of the pair [mm]."""
        # the cone's height above the pitch plane falls linearly with the distance from the gear axis
        height = self.pinion.pitch_radius * (1.0 - np.asarray(face) / self.gear.pitch_radius)
        return self.gear.profile_from_height(face, height)

    def driving_points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals of the pinion's involute in its own frame."""
        pinion = self.pinion
        return driving_involute(self, face, pinion.roll_from_profile(profile), pinion.base_radius, pinion.flank_phase)

    def prism_body(self, body: int) -> PrismBody:
        """One section of the pinion; nine of the gear, whose section changes with radius."""
        if body == DRIVING:
            low, high = self.borders(np.array([self.gear.pitch_radius])).driving_face
            return PrismBody(high - low, low, (0.5 * (low + high),), (self.pinion.section(),))
        low, high = self.face_limits
        faces = tuple(float(face) for face in np.linspace(low, high, _GEAR_SECTIONS))
        return PrismBody(high - low, low, faces, tuple(self.gear.section(face) for face in faces))

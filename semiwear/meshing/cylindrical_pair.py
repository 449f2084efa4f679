r"""The cylindrical pair: a spur or helical involute pinion that drives an external or internal gear.

Fixed frame, laid out as that of the face gear (docs/frame.svg): the origin lies on the pinion's axis in the middle
of the gear's face width, z along both axes, -y from the pinion towards the pitch point (0, -r_w1, 0). The gear's
axis is at (0, -a, 0); a is negative for an internal gear (ISO 21771). The teeth run towards -x through the pitch
point and the line of action is x = l cos(alpha_wt), y = -r_w1 + l sin(alpha_wt), with l = -p_bt roll at z = 0: a
pair enters at the gear's tip. On a helical pair l grows by z tan(beta_b) for a right-hand pinion.

Polar angles count from the direction of the pitch point as seen from either axis, positive towards +x. With
inv(alpha_wt) - (theta - atan theta) for the external gear's flank (its opposite for the pinion's and an internal
gear's), theta the roll angle, the flanks pass the pitch point at roll 0. `Placement` moves the pinion: offset along
+x, out of the plane of the axes; axial_gear along +y, which opens an external pair; axial_pinion along z; the shaft
angle error about +x inclines the axes in their common plane, the slope about +y sets them askew.

The separation is exact: a point at radius rho and polar angle phi in the pinion's frame touches it at the rotation

    psi_touch = phi - (theta_1 - atan theta_1) + inv(alpha_wt) - h z tan(beta_b)/r_b1,   h = 1 right, -1 left hand,

and the normal distance is r_b1 cos(beta_b) (psi - psi_touch), since an involute helicoid that is turned is its own
parallel surface (Litvin and Fuentes 2004, ch. 16; ISO 21771:2007).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, radians, sqrt, tan

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.geometry.inclined_foot import InclinedFoot
from semiwear.geometry.involute import involute_function
from semiwear.meshing.flank_pair import ARCSEC, DRIVING, EXACT_STEPS, Borders, Meeting, PrismBody, displacement
from semiwear.meshing.own_flanks import driving_involute
from semiwear.scene import CylindricalPair as CylindricalTable
from semiwear.scene import Placement


@dataclass(frozen=True)
class _Flank:
    """A tooth with its working pitch cylinder, and the profile coordinate on its flank.

    The profile coordinate [mm] is the transverse arc length of the involute from the working pitch cylinder,
    positive towards the tip.
    """

    tooth: CylindricalTooth
    working_radius: float

    @cached_property
    def _pitch_square(self) -> float:
        return (self.working_radius / self.tooth.base_radius) ** 2 - 1.0

    def profile_from_roll(self, roll: FloatArray | float) -> FloatArray:
        """Profile coordinate at a roll angle [mm]."""
        tooth = self.tooth
        return tooth.side * 0.5 * tooth.base_radius * (np.asarray(roll) ** 2 - self._pitch_square)

    def roll_from_profile(self, profile: FloatArray) -> FloatArray:
        """Roll angle at a profile coordinate [rad]; 0 beyond the base cylinder."""
        tooth = self.tooth
        squared = tooth.side * 2.0 * np.asarray(profile) / tooth.base_radius + self._pitch_square
        return np.sqrt(np.maximum(squared, 0.0))

    def radius(self, profile: FloatArray) -> FloatArray:
        """Radius about the body's axis at a profile coordinate [mm]."""
        return self.tooth.base_radius * np.sqrt(1.0 + self.roll_from_profile(profile) ** 2)

    @property
    def ends(self) -> tuple[float, float]:
        """Profile coordinate where the fillet begins, and on the tip cylinder [mm]."""
        tooth = self.tooth
        root = max(tooth.form_roll_angle, 0.0)
        return float(self.profile_from_roll(root)), float(self.profile_from_roll(tooth.tip_roll_angle))

    @property
    def tip_turn(self) -> float:
        """Angle by which the outline turns at the tip: 90 degrees less the pressure angle there [rad]."""
        return 0.5 * pi - float(np.arctan(self.tooth.tip_roll_angle))

    def body(self, width: float, start: float, sense: int) -> PrismBody:
        """The tooth's section along its whole width; `sense` as of `InclinedFoot`."""
        root, tip = self.ends
        profile = np.linspace(tip, root, 161)
        section = self.tooth.section(profile, self.radius(profile))
        length = width / cos(self.tooth.helix_angle)
        foot = InclinedFoot(self.tooth, width, sense) if self.tooth.helix_angle > 0.0 else None
        return PrismBody(width, start, (start + 0.5 * width,), (section,), length, foot)


@dataclass(frozen=True)
class CylindricalMesh:
    """A pinion tooth and a gear tooth with parallel axes in mesh (a `FlankPair`).

    Attributes
    ----------
    table : CylindricalPair
        The scene's table.
    placement : Placement
        Rigid displacement of the pinion from its nominal place.
    """

    table: CylindricalTable
    placement: Placement

    @cached_property
    def pinion(self) -> CylindricalTooth:
        """The pinion's tooth."""
        t = self.table
        root = 0.5 * t.normal_module_mm * t.pinion_teeth / cos(radians(t.helix_angle_deg))
        root += t.pinion_profile_shift * t.normal_module_mm - t.pinion_rack_addendum_mm
        return self._tooth("pinion", False, root - t.pinion_bore_radius_mm)

    @cached_property
    def gear(self) -> CylindricalTooth:
        """The gear's tooth."""
        return self._tooth("gear", self.table.internal, self.table.gear_rim_thickness_mm)

    def _tooth(self, body: str, internal: bool, rim_thickness: float) -> CylindricalTooth:
        t = self.table
        return CylindricalTooth(
            teeth=abs(getattr(t, f"{body}_teeth")),
            internal=internal,
            normal_module=t.normal_module_mm,
            normal_pressure_angle=radians(t.pressure_angle_deg),
            helix_angle=radians(t.helix_angle_deg),
            profile_shift=getattr(t, f"{body}_profile_shift"),
            tip_radius=0.5 * getattr(t, f"{body}_tip_diameter_mm"),
            rack_addendum=getattr(t, f"{body}_rack_addendum_mm"),
            rack_tip_radius=getattr(t, f"{body}_rack_tip_radius_mm"),
            rim_thickness=rim_thickness,
        )

    @cached_property
    def _flanks(self) -> tuple[_Flank, _Flank]:
        """Of the pinion and of the gear."""
        cosine = cos(self.table.working_pressure_angle)
        return tuple(_Flank(tooth, tooth.base_radius / cosine) for tooth in (self.pinion, self.gear))  # type: ignore[return-value]

    @cached_property
    def _helix(self) -> float:
        """Shift of the pinion's flank along the line of action per mm of z."""
        hand = 1.0 if self.table.hand == "right" else -1.0
        return hand * tan(self.pinion.base_helix_angle)

    @property
    def working_radii(self) -> tuple[float, float]:
        """Radii of the working pitch cylinders of pinion and gear [mm]."""
        pinion, gear = self._flanks
        return pinion.working_radius, gear.working_radius

    @property
    def path_limits(self) -> tuple[float, float]:
        """Ends of the path of contact, l at the gear's and at the pinion's tip [mm]."""
        pinion, gear = self._flanks
        first = gear.tooth.path_to(gear.tooth.tip_radius, gear.working_radius)
        return first, -pinion.tooth.path_to(pinion.tooth.tip_radius, pinion.working_radius)

    @property
    def transverse_contact_ratio(self) -> float:
        """Length of the path of contact over the transverse base pitch (ISO 21771, 5.5)."""
        first, last = self.path_limits
        return (first - last) / self.base_pitch

    @property
    def overlap_ratio(self) -> float:
        """Base helix over the common face width, over the transverse base pitch (ISO 21771, 5.5)."""
        low, high = self.face_limits
        other_low, other_high = self._driving_face
        return abs(self._helix) * (min(high, other_high) - max(low, other_low)) / self.base_pitch

    @property
    def difference_steps(self) -> tuple[float, float]:
        """Steps for flanks given by formulas."""
        return EXACT_STEPS

    @property
    def face_limits(self) -> tuple[float, float]:
        """Ends of the gear's face, from its middle [mm]."""
        half = 0.5 * self.table.gear_face_width_mm
        return -half, half

    @property
    def _driving_face(self) -> tuple[float, float]:
        half, middle = 0.5 * self.table.pinion_face_width_mm, self.table.face_offset_mm
        return middle - half, middle + half

    @property
    def base_pitch(self) -> float:
        """Transverse base pitch [mm]."""
        return 2.0 * pi * self.pinion.base_radius / self.pinion.teeth

    @cached_property
    def base_profiles(self) -> tuple[float, float]:
        """Profile coordinates of the base cylinders of pinion and gear [mm]."""
        pinion, gear = self._flanks
        return float(pinion.profile_from_roll(0.0)), float(gear.profile_from_roll(0.0))

    @property
    def roll_per_time(self) -> float:
        """Pinion teeth per radian."""
        return self.pinion.teeth / (2.0 * pi)

    @property
    def transmission_ratio(self) -> float:
        """Gear rotation per pinion rotation, without its sign."""
        return self.pinion.teeth / self.gear.teeth

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the pinion's reference circle."""
        return self.table.normal_per_arc

    @property
    def driving_meshes(self) -> float:
        """A pinion tooth meshes more often than a gear tooth."""
        return self.gear.teeth / self.pinion.teeth

    @cached_property
    def pitch_point(self) -> FloatArray:
        """Pitch point on the line between the axes, in the middle of the gear's face [mm]."""
        return np.array([0.0, -self.working_radii[0], 0.0])

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the normal [arcsec/mm]."""
        return self.transmission_ratio / self._lever * ARCSEC

    @property
    def _lever(self) -> float:
        return self.pinion.base_radius * cos(self.pinion.base_helix_angle)

    @cached_property
    def _gear_centre(self) -> FloatArray:
        return np.asarray(self.pitch_point + np.array([0.0, -self.gear.side * self.working_radii[1], 0.0]))

    @cached_property
    def _pinion_frame(self) -> tuple[FloatArray, FloatArray]:
        """Rotation about the pitch point and shift of the displaced pinion."""
        return displacement(self.placement)

    def borders(self, face: FloatArray, *, sharp: bool = False) -> Borders:
        """Limits of both flanks at distances `face` from the middle of the gear's face [mm]."""
        t = self.table
        face = np.asarray(face, float)
        keep = 0.0 if sharp else 1.0
        pinion, gear = self._flanks
        pinion_root, pinion_tip = pinion.ends
        gear_root, gear_tip = gear.ends
        gear_inset = keep * t.gear_tip_edge_radius_mm * tan(0.5 * gear.tip_turn)
        pinion_inset = keep * t.pinion_tip_edge_radius_mm * tan(0.5 * pinion.tip_turn)
        return Borders(
            root=np.full(face.shape, gear_root),
            tip=np.full(face.shape, gear_tip - gear_inset),
            driving_root=pinion_root,
            driving_tip=pinion_tip - pinion_inset,
            face=self.face_limits,
            driving_face=self._driving_face,
            tip_turn=np.full(face.shape, gear.tip_turn),
            driving_tip_turn=pinion.tip_turn,
            tip_edge_radius=t.gear_tip_edge_radius_mm,
            end_edge_radius=t.gear_end_edge_radius_mm,
            driving_tip_edge_radius=t.pinion_tip_edge_radius_mm,
            driving_end_edge_radius=t.pinion_end_edge_radius_mm,
        )

    def meeting(self, face: FloatArray, profile: FloatArray, roll: FloatArray) -> Meeting:
        """Separation along the pinion's involute normal, exact."""
        face, profile, roll = np.broadcast_arrays(*(np.asarray(a, float) for a in (face, profile, roll)))
        pinion, gear = self._flanks
        phase = involute_function(self.table.working_pressure_angle)
        side, base = gear.tooth.side, gear.tooth.base_radius
        theta = gear.roll_from_profile(profile)
        turn = -2.0 * pi / gear.tooth.teeth * roll + self._helix / base * face
        normal_angle = side * (phase - theta) + turn  # of the tangent from the base circle
        polar = normal_angle + side * np.arctan(theta)
        radius = base * np.sqrt(1.0 + theta**2)
        centre = self._gear_centre
        position = np.stack([radius * np.sin(polar), centre[1] + side * radius * np.cos(polar), face], axis=-1)
        along = 1.0 / sqrt(1.0 + self._helix**2)
        normal = along * np.stack(
            [np.cos(normal_angle), -side * np.sin(normal_angle), np.full(face.shape, -self._helix)], axis=-1
        )
        rotation, shift = self._pinion_frame
        local = (position - shift - self.pitch_point) @ rotation + self.pitch_point
        across, down, height = local[..., 0], -local[..., 1], local[..., 2]
        own_base = pinion.tooth.base_radius
        own = np.sqrt(np.maximum((across**2 + down**2) / own_base**2 - 1.0, 0.0))
        touching = np.arctan2(across, down) - own + np.arctan(own) + phase - self._helix / own_base * height
        nominal = -2.0 * pi / pinion.tooth.teeth * roll
        return Meeting(
            separation=self._lever * (nominal - touching),
            position=position,
            normal=normal,
            driving_profile=pinion.profile_from_roll(own),
            driving_face=height,
        )

    def driving_points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals of the pinion's involute helicoid in its own frame."""
        pinion, _ = self._flanks
        phase = -involute_function(self.table.working_pressure_angle)
        roll = pinion.roll_from_profile(profile)
        return driving_involute(self, face, roll, pinion.tooth.base_radius, phase, self._helix)

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion minus that of the gear [mm per radian of pinion rotation]."""
        rotation, shift = self._pinion_frame
        axis = rotation @ np.array([0.0, 0.0, -1.0])
        centre = rotation @ -self.pitch_point + self.pitch_point + shift
        return np.cross(axis, position - centre) - self.driven_velocity(position)

    def driven_velocity(self, position: FloatArray) -> FloatArray:
        """Velocity of the gear [mm per radian of pinion rotation]: an external one turns about +z."""
        speed = self.gear.side * self.transmission_ratio
        arm = position - self._gear_centre
        return speed * np.stack([-arm[..., 1], arm[..., 0], np.zeros(position.shape[:-1])], axis=-1)

    def lever_arm(self, position: FloatArray) -> FloatArray:
        """Lever arm r_b1 cos(beta_b), the same at every contact point [mm]."""
        return np.full(position.shape[:-1], self._lever)

    def flank_place(self, body: int, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Height above the working pitch cylinder, towards the tip, and radius about the body's own axis [mm]."""
        flank = self._flanks[body]
        _, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        radius = flank.radius(profile)
        return flank.tooth.side * (radius - flank.working_radius), radius

    def profile_at(self, face: FloatArray, height: FloatArray) -> FloatArray:
        """Profile coordinate of the gear's flank at a height above its working pitch cylinder [mm]."""
        gear = self._flanks[1]
        radius = gear.working_radius + gear.tooth.side * np.asarray(height, float) + 0.0 * np.asarray(face, float)
        return gear.profile_from_roll(np.sqrt(np.maximum((radius / gear.tooth.base_radius) ** 2 - 1.0, 0.0)))

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Zero: the profile coordinate counts from the working pitch cylinder [mm]."""
        return np.zeros(np.shape(face))

    def prism_body(self, body: int) -> PrismBody:
        """One section, normal to the teeth, over the whole width."""
        low, high = self._driving_face if body == DRIVING else self.face_limits
        # a right-hand pinion's teeth go with z towards +x, where the gear pushes them back to; the gear's the same
        # way, but the pinion pushes them towards -x
        sense = 1 if (self.table.hand == "right") == (body == DRIVING) else -1
        return self._flanks[body].body(high - low, low, sense)

"""Spur and helical involute teeth, external and internal, with profile shift (ISO 21771:2007).

Lengths and angles are those of the transverse section unless a name says normal. Numbers of teeth, radii and the
tooth thickness are positive; quantities reversed on an internal gear carry its sign `side`. A positive
profile shift moves the tooth towards its tip and makes it thicker, internal as external.

The section that carries the load stands normal to the teeth: the virtual spur gear with z/(cos^2 beta_b cos beta)
teeth, which need not be whole (ISO 6336-3:2019, 6.2). For spur teeth it is the transverse section itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, pi, sin, sqrt, tan

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.involute import InvoluteTooth, half_tooth_angle, involute_function
from semiwear.geometry.section import RackRim, ToothSection


@dataclass(frozen=True)
class CylindricalTooth:
    """One tooth of a cylindrical involute gear.

    Attributes
    ----------
    teeth : float
        Number of teeth, positive; that of a virtual spur gear need not be whole.
    internal : bool
        Whether the teeth point to the axis.
    normal_module : float
        Normal module [mm].
    normal_pressure_angle, helix_angle : float
        Normal pressure angle and helix angle at the reference cylinder, not negative [rad].
    profile_shift : float
        Profile shift coefficient x [1].
    tip_radius : float
        Radius of the tip cylinder [mm].
    rack_addendum : float
        Dedendum of the tooth without profile shift: reference line to crest of the generating rack [mm].
    rack_tip_radius : float
        Radius that rounds the rack's crest; of an internal tooth, radius of the arc that is its fillet [mm].
    rim_thickness : float
        Material between the root cylinder and the cylinder that is held [mm].
    """

    teeth: float
    internal: bool
    normal_module: float
    normal_pressure_angle: float
    helix_angle: float
    profile_shift: float
    tip_radius: float
    rack_addendum: float
    rack_tip_radius: float
    rim_thickness: float

    @property
    def side(self) -> int:
        """+1 for external teeth, which point away from the axis, -1 for internal ones."""
        return -1 if self.internal else 1

    @property
    def pressure_angle(self) -> float:
        """Transverse pressure angle: tan(alpha_t) = tan(alpha_n)/cos(beta) [rad]."""
        return atan(tan(self.normal_pressure_angle) / cos(self.helix_angle))

    @property
    def base_helix_angle(self) -> float:
        """Helix angle at the base cylinder: tan(beta_b) = tan(beta) cos(alpha_t) [rad]."""
        return atan(tan(self.helix_angle) * cos(self.pressure_angle))

    @property
    def reference_radius(self) -> float:
        """Radius of the reference cylinder, m_n z/(2 cos(beta)) [mm]."""
        return 0.5 * self.normal_module * self.teeth / cos(self.helix_angle)

    @property
    def base_radius(self) -> float:
        """Radius of the base cylinder [mm]."""
        return self.reference_radius * cos(self.pressure_angle)

    @property
    def root_radius(self) -> float:
        """Radius of the root cylinder [mm]."""
        return self.reference_radius - self.side * (self.rack_addendum - self._shift)

    @property
    def _shift(self) -> float:
        return self.profile_shift * self.normal_module

    @property
    def virtual_teeth(self) -> float:
        """Teeth of the virtual spur gear in the normal section, z_n = z/(cos^2 beta_b cos beta)."""
        return self.teeth / (cos(self.base_helix_angle) ** 2 * cos(self.helix_angle))

    @property
    def half_thickness_angle(self) -> float:
        """Half the angle that the tooth takes on the reference circle, psi (ISO 21771, 4.4) [rad]."""
        return (0.5 * pi + 2.0 * self.profile_shift * tan(self.normal_pressure_angle)) / self.teeth

    def roll_at(self, radius: float) -> float:
        """Roll angle of the flank on a cylinder, 0 within the base cylinder [rad]."""
        return sqrt(max((radius / self.base_radius) ** 2 - 1.0, 0.0))

    @property
    def tip_roll_angle(self) -> float:
        """Roll angle at the tip cylinder [rad]."""
        return self.roll_at(self.tip_radius)

    @property
    def form_roll_angle(self) -> float:
        """Roll angle where the involute ends and the fillet begins [rad]; negative when the rack undercuts.

        On external teeth the deepest point that the rack's straight flank generates; on internal ones the point where
        the arc that also touches the root circle is tangent to the involute.
        """
        if self.internal:
            centre = self.root_radius - self.rack_tip_radius
            return (sqrt(max(centre**2 - self.base_radius**2, 0.0)) + self.rack_tip_radius) / self.base_radius
        alpha = self.pressure_angle
        return tan(alpha) - self.straight_depth / sin(alpha) / self.base_radius

    @property
    def straight_depth(self) -> float:
        """Reference circle to the end of the rack's straight flank [mm]."""
        rounded = self.rack_tip_radius * (1.0 - sin(self.normal_pressure_angle))
        return self.rack_addendum - self._shift - rounded

    def half_thickness(self, radius: float) -> float:
        """Half the tooth thickness on a cylinder, as an arc [mm]; negative beyond a pointed tip."""
        return radius * float(self.half_angle(np.array(self.roll_at(radius))))

    def half_angle(self, roll: FloatArray) -> FloatArray:
        """Half the angle that the tooth takes at roll angles [rad]."""
        return half_tooth_angle(roll, self.pressure_angle, self.half_thickness_angle, self.side)

    @property
    def root_land_half_angle(self) -> float:
        """Half the angle of the root land of an internal tooth space [rad]; negative if its arc is too large."""
        roll = self.roll_at(self.root_radius - self.rack_tip_radius)
        space = pi / self.teeth - self.half_thickness_angle + involute_function(self.pressure_angle)
        return space - self.rack_tip_radius / self.base_radius - roll + atan(roll)

    def transverse_outline(self) -> FloatArray:
        """Half the outline of a tooth in the transverse section, from the tip to the middle of the tooth space.

        The flank is exact; the fillet of a helical tooth is that of a transverse rack whose crest is round.

        Returns
        -------
        (n, 2) array
            Radius [mm] and angle from the middle of the tooth [rad].
        """
        if self.internal:
            drawn = self._internal_section()
            radius = self.reference_radius - np.concatenate([drawn.flank[:, 1], drawn.fillet[1:, 1]])
            angle = np.concatenate([drawn.flank[:, 0], drawn.fillet[1:, 0]]) / radius
        else:
            module = self.normal_module / cos(self.helix_angle)
            drawn = InvoluteTooth(
                teeth=self.teeth,
                module=module,
                pressure_angle=self.pressure_angle,
                addendum=self.tip_radius - self.reference_radius,
                rack_addendum=self.rack_addendum,
                rack_tip_radius=self.rack_tip_radius,
                bore_radius=self.root_radius - self.rim_thickness,
                profile_shift=self._shift,
            ).section()
            x, y = np.concatenate([drawn.flank, drawn.fillet[1:]]).T
            radius, angle = np.hypot(x, y), np.arctan2(x, y)
        return np.column_stack([np.append(radius, self.root_radius), np.append(angle, pi / self.teeth)])

    # ---- the section normal to the teeth

    def section(self, profile_of_radius: FloatArray, radii: FloatArray) -> ToothSection:
        """Section of the tooth normal to the teeth, with fillet and rim.

        Parameters
        ----------
        profile_of_radius, radii : (n,) arrays
            Profile coordinate [mm] of the flank pair on cylinders [mm], from the tip to the end of the flank.
        """
        normal = self.normal_section()
        height = radii - self.reference_radius
        if isinstance(normal, InvoluteTooth):
            drawn = normal.section()
            there = np.hypot(drawn.flank[:, 0], drawn.flank[:, 1]) - normal.pitch_radius
        else:
            drawn = normal._internal_section()
            there = -drawn.flank[:, 1]
        order = np.argsort(height)
        # both sections have the same heights except at the end of the flank, beyond which the profile is continued
        slope = np.gradient(profile_of_radius[order], height[order])
        low, high = height[order[0]], height[order[-1]]
        profile = np.interp(there, height[order], profile_of_radius[order])
        profile = profile + slope[0] * np.minimum(there - low, 0.0) + slope[-1] * np.maximum(there - high, 0.0)
        return ToothSection(drawn.flank, profile, drawn.fillet, drawn.rim)

    def normal_section(self) -> InvoluteTooth | CylindricalTooth:
        """The virtual spur tooth: same module, profile shift and heights."""
        teeth = self.virtual_teeth
        reference = 0.5 * self.normal_module * teeth
        tip_height = self.side * (self.tip_radius - self.reference_radius)
        if self.internal:
            return CylindricalTooth(
                teeth, True, self.normal_module, self.normal_pressure_angle, 0.0, self.profile_shift,
                reference - tip_height, self.rack_addendum, self.rack_tip_radius, self.rim_thickness,
            )  # fmt: skip
        root = reference - self.rack_addendum + self._shift
        return InvoluteTooth(
            teeth=teeth,
            module=self.normal_module,
            pressure_angle=self.normal_pressure_angle,
            addendum=tip_height,
            rack_addendum=self.rack_addendum,
            rack_tip_radius=self.rack_tip_radius,
            bore_radius=root - self.rim_thickness,
            profile_shift=self._shift,
        )

    def _internal_section(self) -> ToothSection:
        """Internal spur tooth developed about its root cylinder: arcs across, y from the reference circle to the tip.

        The held outer cylinder becomes the held back face of a rack.
        """
        roll = np.linspace(self.tip_roll_angle, self.form_roll_angle, 81)
        radius = self.base_radius * np.sqrt(1.0 + roll**2)
        angle = self.half_angle(roll)
        rounding = self.rack_tip_radius
        centre_radius, centre_angle = self.root_radius - rounding, pi / self.teeth - self.root_land_half_angle
        # from the point of tangency outwards: the arc's normal turns from the flank's to the radial direction
        first = 0.5 * pi - atan(self.roll_at(centre_radius))
        turn = np.linspace(first, 0.0, 41)
        out = centre_radius + rounding * np.cos(turn)
        across = -rounding * np.sin(turn)
        fillet_radius = np.hypot(out, across)
        fillet_angle = centre_angle + np.arctan2(across, out)
        outline = [
            np.column_stack([r * a, self.reference_radius - r])
            for r, a in ((radius, angle), (fillet_radius, fillet_angle))
        ]
        outline[1][0] = outline[0][-1]
        back = self.reference_radius - self.root_radius - self.rim_thickness
        rim = RackRim(2.0 * pi * self.root_radius / self.teeth, back)
        return ToothSection(outline[0], radius, outline[1], rim)

    def path_to(self, radius: float, working_radius: float) -> float:
        """Distance along the line of action from the pitch point to the flank on a cylinder [mm].

        Positive towards this gear's tip.

        Parameters
        ----------
        radius, working_radius : float [mm]
            Of the cylinder, and of the working pitch cylinder.
        """
        return self.side * self.base_radius * (self.roll_at(radius) - self.roll_at(working_radius))

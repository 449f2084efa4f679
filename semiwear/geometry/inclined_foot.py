"""Foot of a helical tooth on its wheel: the ring under the teeth, and the forces of a flank load on the foot.

The tooth itself is computed in its normal section, on the ring of the virtual spur gear (`CylindricalTooth`). That
ring is not the wheel: its radius is larger by 1/cos^2(beta), without axial force and torsion of the true
width. Both rings are described by the same quantities, so that one may replace the other: radius, width, teeth, the
foot's chord and slope, and the force and couple on the foot of a unit load normal to the flank.

Directions are those of the tooth: radially outwards, tangential in the direction of the load, and axial.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, hypot, pi, sin, tan

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.geometry.involute import half_tooth_angle


@dataclass(frozen=True)
class FootRing:
    """A ring under teeth.

    Attributes
    ----------
    held_radius, foot_radius : float [mm]
        Of the cylinder that is held and of the root cylinder.
    width : float [mm]
    teeth : float
        Teeth to the circumference.
    chord : float [mm]
        Of a tooth's foot, normal to the tooth.
    slope : float
        Tangent of the helix angle on the root cylinder, positive if the teeth incline with +z in the direction of
        the load.
    """

    held_radius: float
    foot_radius: float
    width: float
    teeth: float
    chord: float
    slope: float


@dataclass(frozen=True)
class InclinedFoot:
    """The foot of a helical tooth.

    Attributes
    ----------
    tooth : CylindricalTooth
    width : float [mm]
        Of the wheel, along its axis.
    sense : int
        +1 if the teeth incline with +z in the direction of the load, -1 if against it.
    """

    tooth: CylindricalTooth
    width: float
    sense: int

    @property
    def slant(self) -> float:
        """Signed helix angle at the reference cylinder [rad]."""
        return self.sense * self.tooth.helix_angle

    @property
    def crowding(self) -> float:
        """Length of the tooth on the reference cylinder over that on the root cylinder.

        The same forces act on a shorter tooth where the helix is less inclined.
        """
        return cos(atan(self.wheel.slope)) / cos(self.tooth.helix_angle)

    @property
    def wheel(self) -> FootRing:
        """The ring of the actual wheel."""
        tooth = self.tooth
        slope = self.sense * tan(tooth.helix_angle) * tooth.root_radius / tooth.reference_radius
        return self._ring(tooth.root_radius, self.width, tooth.teeth, slope)

    @property
    def virtual(self) -> FootRing:
        """The ring of the virtual spur gear."""
        tooth = self.tooth
        radius = self._virtual_radius + tooth.root_radius - tooth.reference_radius
        return self._ring(radius, self.width / cos(tooth.helix_angle), tooth.virtual_teeth, 0.0)

    def _ring(self, radius: float, width: float, teeth: float, slope: float) -> FootRing:
        tooth = self.tooth
        held = radius - tooth.side * tooth.rim_thickness
        flank_end = tooth.base_radius * hypot(1.0, max(tooth.form_roll_angle, 0.0))
        chord = 2.0 * tooth.half_thickness(flank_end) * cos(tooth.helix_angle)
        return FootRing(held, radius, width, teeth, chord, slope)

    @property
    def _virtual_radius(self) -> float:
        return 0.5 * self.tooth.normal_module * self.tooth.virtual_teeth

    def section_aside(self, radius: FloatArray) -> FloatArray:
        """Way along the axis from points of the flank to the middle of the tooth in the sections through them [mm].

        The sections are normal to the tooth: the thicker it is, the farther along the axis their middle.
        """
        tooth = self.tooth
        half = radius * tooth.half_angle(_roll(radius, tooth.base_radius))
        return np.asarray(-half * cos(tooth.helix_angle) * sin(self.slant))

    def prism_aside(self, radius: FloatArray) -> FloatArray:
        """The same relative to a point on the reference cylinder, whose place on the prism is its own [mm]."""
        return self.section_aside(radius) - self.section_aside(np.array(self.tooth.reference_radius))

    def on_wheel(self, radius: FloatArray) -> FloatArray:
        """Radial, tangential and axial force on the foot and the couple that bends the tooth, per unit load.

        Parameters
        ----------
        radius : (...) array [mm]
            Radius of the loaded point of the flank.

        Returns
        -------
        (..., 4) array [1, 1, 1, mm]
            The couple about the tooth's direction is that of radial forces which rise in the direction of the load.
        """
        tooth = self.tooth
        force, arm = _load(
            radius, tooth.base_radius, tooth.pressure_angle, tooth.half_thickness_angle, tooth.side, tooth.root_radius
        )
        beta_b = tooth.base_helix_angle
        beta = atan(self.wheel.slope)
        axial = np.full(np.shape(radius), -self.sense * sin(beta_b))
        force = force * cos(beta_b)
        about_axis = arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]
        about_tangent = -arm[..., 0] * axial
        couple = -(about_axis * cos(beta) + about_tangent * sin(beta))
        return np.stack([force[..., 0], force[..., 1], axial, couple], axis=-1)

    def on_virtual(self, radius: FloatArray) -> FloatArray:
        """The same on the ring of the virtual spur gear, for loads at the same heights: (..., 4) array."""
        tooth = self.tooth
        alpha, reference = tooth.normal_pressure_angle, self._virtual_radius
        half = (0.5 * pi + 2.0 * tooth.profile_shift * tan(alpha)) / tooth.virtual_teeth
        force, arm = _load(
            reference + np.asarray(radius) - tooth.reference_radius,
            reference * cos(alpha),
            alpha,
            half,
            tooth.side,
            self.virtual.foot_radius,
        )
        couple = arm[..., 1] * force[..., 0] - arm[..., 0] * force[..., 1]
        return np.stack([force[..., 0], force[..., 1], np.zeros(np.shape(radius)), couple], axis=-1)


def _roll(radius: FloatArray, base: float) -> FloatArray:
    """Roll angles of an involute [rad]."""
    return np.sqrt(np.maximum((radius / base) ** 2 - 1.0, 0.0))


def _load(
    radius: FloatArray, base: float, pressure_angle: float, half_angle: float, side: int, foot: float
) -> tuple[FloatArray, FloatArray]:
    """Unit load of an involute in its plane, and its place from the foot, both radial and tangential: (..., 2)."""
    radius = np.asarray(radius, float)
    roll = _roll(radius, base)
    half = half_tooth_angle(roll, pressure_angle, half_angle, side)
    # the load is tangent to the base circle; the loaded flank lies at -half from the middle of the tooth
    angle = side * np.arctan(roll) - half
    force = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    arm = np.stack([radius * np.cos(half) - foot, -radius * np.sin(half)], axis=-1)
    return force, arm

r"""Flank and fillet of a spur or helical involute tooth, external or internal, in the body's own frame.

The axis is z; tooth 0 is centred on -y at z = 0. Polar angles count from -y, positive towards +x. A tooth that points
outwards bears its load on the -x side, one that points inwards on the +x side, so that both mesh with a pinion. The
sections of a helical body are all equal and turned by a constant angle per mm of z. The profile coordinate is
the length of the transverse involute from the working pitch circle, positive towards the tip.

The fillet of an external tooth is the envelope of the rounding of the rack's crest, a circle normal to the teeth and
an ellipse in the transverse section; that of an internal tooth an arc.

Source: Litvin and Fuentes 2004, *Gear Geometry and Applied Theory*, chapters 6 and 16; ISO 21771:2007.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, pi, sqrt, tan

import numpy as np

from fem_reference.arrays import FloatArray
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.geometry.involute import involute_function


@dataclass(frozen=True)
class InvoluteFlank:
    """Loaded flank of tooth 0 (a `GearFlank`).

    Attributes
    ----------
    tooth : CylindricalTooth
    working_radius : float [mm]
        Of the working pitch cylinder.
    twist : float [rad/mm]
        Turn of the sections about z for each mm of it.
    """

    tooth: CylindricalTooth
    working_radius: float
    twist: float

    @property
    def facing(self) -> int:
        """Sign of the polar angle of the loaded flank on tooth 0."""
        return -self.tooth.side

    @property
    def working_roll(self) -> float:
        """Roll angle of the involute on the working pitch circle [rad]."""
        return self.tooth.roll_at(self.working_radius)

    @property
    def root_profile(self) -> float:
        """Profile coordinate where the fillet begins [mm]."""
        return float(self.profile_from_roll(np.array(max(self.tooth.form_roll_angle, 0.0))))

    def tip_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate of the tip, wherever on the face [mm]."""
        return np.full(np.shape(face), float(self.profile_from_roll(np.array(self.tooth.tip_roll_angle))))

    def profile_from_roll(self, roll: FloatArray) -> FloatArray:
        """Profile coordinate at roll angles [mm]."""
        tooth = self.tooth
        return 0.5 * tooth.side * tooth.base_radius * (np.asarray(roll) ** 2 - self.working_roll**2)

    def roll_from_profile(self, profile: FloatArray) -> FloatArray:
        """Roll angle at profile coordinates [rad]; zero beyond the base circle."""
        tooth = self.tooth
        square = 2.0 * tooth.side * np.asarray(profile) / tooth.base_radius + self.working_roll**2
        return np.sqrt(np.maximum(square, 0.0))

    def half_angle(self, roll: FloatArray) -> FloatArray:
        """Half the angle of the tooth where the involute has a roll angle [rad]."""
        tooth = self.tooth
        return tooth.half_thickness_angle + tooth.side * (
            involute_function(tooth.pressure_angle) - roll + np.arctan(roll)
        )

    def polar_angle(self, roll: FloatArray, z: FloatArray) -> FloatArray:
        """Polar angle of flank points at roll angles and places along the axis [rad]."""
        return self.facing * self.half_angle(roll) + self.twist * z

    def section_normal(self, roll: FloatArray) -> FloatArray:
        """Outward unit normals (..., 3): along the arc to the loaded side, towards the tip, along the axis."""
        inverse = 1.0 / np.sqrt(1.0 + roll**2)
        lean = np.full_like(inverse, -self.facing * self.twist * self.tooth.base_radius)
        return np.stack([inverse, roll * inverse, lean], axis=-1) / np.sqrt(1.0 + lean**2)[..., None]

    def directions(self, polar: FloatArray) -> FloatArray:
        """Unit vectors (..., 3, 3) along the arc to the loaded side, towards the tip and along the axis."""
        c, s, o = np.cos(polar), np.sin(polar), np.zeros_like(polar)
        side, facing = self.tooth.side, self.facing
        rows = [
            np.stack([facing * c, facing * s, o], axis=-1),
            np.stack([side * s, -side * c, o], axis=-1),
            np.stack([o, o, o + 1.0], axis=-1),
        ]
        return np.stack(rows, axis=-2)

    def points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and outward unit normals (..., 3) at places along the axis and profile coordinates [mm], [1]."""
        face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        roll = self.roll_from_profile(profile)
        polar = self.polar_angle(roll, face)
        radius = self.tooth.base_radius * np.sqrt(1.0 + roll**2)
        points = np.stack([radius * np.sin(polar), -radius * np.cos(polar), face], axis=-1)
        return points, np.einsum("...a,...ai->...i", self.section_normal(roll), self.directions(polar))

    def fillet(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Angles from the middle of the tooth [rad] and radii [mm], (count,) each, from the flank to the root."""
        return self._arc(count) if self.tooth.internal else self._trochoid(count)

    def _trochoid(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Envelope of the rack's rounded crest: its normal passes through the pitch point (Willis)."""
        tooth, beta, alpha = self.tooth, self.tooth.helix_angle, self.tooth.normal_pressure_angle
        rounding = tooth.rack_tip_radius
        # centre of the rounding below the pitch line, and from the middle of the rack tooth in the normal section
        below = tooth.rack_addendum - rounding
        offset = 0.25 * pi * tooth.normal_module - below * tan(alpha) - rounding / cos(alpha)
        below -= tooth.profile_shift * tooth.normal_module
        angle = np.linspace(alpha, 0.5 * pi, count)
        depth = below + rounding * np.sin(angle)
        # the transverse section is the normal one stretched along the pitch line by 1/cos(beta)
        lateral = depth * cos(beta) / np.tan(angle)
        rolled = (lateral - (rounding * np.cos(angle) + offset) / cos(beta)) / tooth.reference_radius
        radial = tooth.reference_radius - depth
        return pi / tooth.teeth - np.arctan2(lateral, radial) + rolled, np.hypot(radial, lateral)

    def _arc(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The arc that touches the involute and the root circle of an internal tooth."""
        tooth = self.tooth
        rounding = tooth.rack_tip_radius
        centre = tooth.root_radius - rounding
        # its normal turns from the flank's direction to the radial one
        turn = np.linspace(0.5 * pi - atan(sqrt(max((centre / tooth.base_radius) ** 2 - 1.0, 0.0))), 0.0, count)
        out, across = centre + rounding * np.cos(turn), -rounding * np.sin(turn)
        middle = pi / tooth.teeth - tooth.root_land_half_angle
        return middle + np.arctan2(across, out), np.hypot(out, across)

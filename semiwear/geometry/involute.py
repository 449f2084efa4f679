"""Involute spur tooth with the trochoidal fillet of a rack-shaped cutter.

Angles are measured about the tooth's axis from the -y direction, positive towards +x, as in the drawing of
the fixed frame (docs/frame.svg). The flank described here is the one on the -x side of a tooth centred on -y.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin, sqrt, tan

import numpy as np

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray
from semiwear.geometry.section import RingRim, ToothSection

_DEGREES = "numpy.radians converts degrees"


def involute_function(angle: float) -> float:
    """Involute function inv(angle) = tan(angle) - angle [rad], of an angle in rad (ISO 21771, 4.2.3).

    Raises
    ------
    ValueError
        The angle is not between -pi/2 and pi/2.

    Examples
    --------
    >>> from math import radians
    >>> from semiwear.geometry import involute_function
    >>> print(f"{involute_function(radians(20.0)):.6f}")
    0.014904
    """
    require_range("the angle", angle, "rad", above=-0.5 * pi, below=0.5 * pi, hint=_DEGREES)
    return tan(angle) - angle


def half_tooth_angle(roll: FloatArray, pressure_angle: float, on_reference: float, side: int = 1) -> FloatArray:
    """Angles about the axis from the middle of a tooth to its involute flank (ISO 21771, 4.4).

    Parameters
    ----------
    roll : (...) array [rad]
        Roll angles of the places, 0 or more.
    pressure_angle : float [rad]
        At the reference circle.
    on_reference : float [rad]
        The angle there.
    side : int
        +1 for external teeth, which grow thinner outwards, -1 for internal ones.

    Returns
    -------
    (...) array [rad]
    """
    return np.asarray(on_reference + side * (involute_function(pressure_angle) - roll + np.arctan(roll)))


def involute(base_radius: float, roll_angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of an involute of a circle, in polar coordinates about its centre (ISO 21771, 4.2).

    With xi = tan(alpha), the roll angle: r = r_b sqrt(1 + xi^2), inv(alpha) = xi - atan(xi). The arc from its origin
    on the base circle is r_b xi^2 / 2 long.

    Parameters
    ----------
    base_radius : float
        Radius r_b of the base circle, above 0 [mm].
    roll_angle : array
        Roll angle xi, 0 at the base circle [rad].

    Returns
    -------
    radius, polar_angle : arrays [mm], [rad]
        Like `roll_angle`; the polar angle is 0 at the involute's origin on the base circle.

    Raises
    ------
    ValueError
        The base radius is not positive.
    """
    require_range("the base radius", base_radius, "mm", above=0.0)
    return base_radius * np.sqrt(1.0 + np.square(roll_angle)), roll_angle - np.arctan(roll_angle)


def require_rack(module: float, pressure_angle: float) -> None:
    """Refuse a module [mm] or a pressure angle [rad] that no rack of involute teeth has."""
    require_range("the module", module, "mm", above=0.0)
    require_range("the pressure angle", pressure_angle, "rad", above=0.0, below=0.5 * pi, hint=_DEGREES)


@dataclass(frozen=True)
class InvoluteTooth:
    """One tooth of an external spur gear.

    Attributes
    ----------
    teeth : float
        Number of teeth; that of a virtual spur gear need not be whole.
    module : float
        Module [mm].
    pressure_angle : float
        Pressure angle of the rack [rad].
    addendum : float
        Pitch circle to tip circle [mm].
    rack_addendum : float
        Reference line to crest of the generating rack [mm]: the dedendum of the tooth without profile shift.
    rack_tip_radius : float
        Radius that rounds the crest of the rack [mm].
    bore_radius : float
        Radius of the bore of the ring that carries the teeth [mm].
    profile_shift : float
        Distance of the rack's reference line from the pitch circle, positive away from the axis [mm]. Default 0.

    Raises
    ------
    ValueError
        A number cannot be.
    """

    teeth: float
    module: float
    pressure_angle: float
    addendum: float
    rack_addendum: float
    rack_tip_radius: float
    bore_radius: float
    profile_shift: float = 0.0

    def __post_init__(self) -> None:
        require_range("the number of teeth", self.teeth, above=0.0)
        require_rack(self.module, self.pressure_angle)
        require_range("the addendum of the rack", self.rack_addendum, "mm", least=0.0)
        require_range("the tip radius of the rack", self.rack_tip_radius, "mm", least=0.0)
        require_range("the radius of the bore", self.bore_radius, "mm", least=0.0)

    @property
    def pitch_radius(self) -> float:
        """Radius of the pitch circle [mm]."""
        return 0.5 * self.module * self.teeth

    @property
    def base_radius(self) -> float:
        """Radius of the base circle [mm]."""
        return self.pitch_radius * cos(self.pressure_angle)

    @property
    def tip_radius(self) -> float:
        """Radius of the tip circle [mm]."""
        return self.pitch_radius + self.addendum

    @property
    def root_radius(self) -> float:
        """Radius of the root circle [mm]."""
        return self.pitch_radius - self.rack_addendum + self.profile_shift

    @property
    def base_pitch(self) -> float:
        """Distance between neighbouring flanks along the line of action [mm]."""
        return 2.0 * pi * self.base_radius / self.teeth

    @property
    def flank_phase(self) -> float:
        """Polar angle c of the flank's origin on the base circle: polar angle = roll - atan(roll) + c [rad]."""
        thicker = self.profile_shift * tan(self.pressure_angle) / self.pitch_radius
        return -pi / (2.0 * self.teeth) - involute_function(self.pressure_angle) - thicker

    @property
    def form_roll_angle(self) -> float:
        """Roll angle where the involute ends and the fillet begins; negative when the rack undercuts [rad].

        The deepest point that the rack's straight flank generates lies on the line of action at the height of its end
        (ISO 21771, form diameter generated by the tool).
        """
        # along the line of action the rack's end point is met at depth / sin(alpha) before the pitch point
        return tan(self.pressure_angle) - self.straight_depth / sin(self.pressure_angle) / self.base_radius

    @property
    def straight_depth(self) -> float:
        """Pitch circle to the end of the rack's straight flank, where its tip rounding begins [mm]."""
        rounded = self.rack_tip_radius * (1.0 - sin(self.pressure_angle))
        return self.rack_addendum - self.profile_shift - rounded

    @property
    def undercut_depth(self) -> float:
        """Pitch circle to where the line of action touches the base circle: a deeper rack undercuts [mm]."""
        return self.pitch_radius * sin(self.pressure_angle) ** 2

    @property
    def tip_roll_angle(self) -> float:
        """Roll angle of the involute at the tip circle [rad]."""
        return sqrt((self.tip_radius / self.base_radius) ** 2 - 1.0)

    def profile_from_roll(self, roll_angle: FloatArray) -> FloatArray:
        """Profile coordinate: arc length of the involute from the pitch circle, positive to the tip [mm]."""
        return 0.5 * self.base_radius * (np.asarray(roll_angle) ** 2 - tan(self.pressure_angle) ** 2)

    def roll_from_profile(self, profile: FloatArray) -> FloatArray:
        """Roll angle of the involute at a profile coordinate [rad]; NaN for one below the base circle."""
        return np.sqrt(2.0 * np.asarray(profile) / self.base_radius + tan(self.pressure_angle) ** 2)

    def polar_angle(self, roll_angle: FloatArray) -> FloatArray:
        """Polar angle of the flank point with a given roll angle, tooth centred on -y [rad]."""
        return involute(self.base_radius, roll_angle)[1] + self.flank_phase

    def fillet(self, points: int = 41) -> FloatArray:
        """Trochoidal fillet in the frame of `ToothSection`: tooth centre line on +y, ring centre at 0.

        Parameters
        ----------
        points : int
            Number of points from the end of the involute to the root circle.

        Returns
        -------
        (points, 2) array [mm]

        Notes
        -----
        Envelope of the circle that rounds the rack's crest: the contact normal passes through the pitch point
        (Willis), so each normal angle fixes the rolled distance in closed form (Litvin and Fuentes 2004, ch. 6).
        """
        alpha, rounding = self.pressure_angle, self.rack_tip_radius
        # centre of the rounding: depth below the rack's reference line, distance from the middle of the rack tooth
        depth = self.rack_addendum - rounding
        offset = 0.25 * pi * self.module - depth * tan(alpha) - rounding / cos(alpha)
        depth -= self.profile_shift  # below the pitch line
        normal_angle = np.linspace(alpha, 0.5 * pi, points)
        # the normal meets the pitch line this far from the centre of the rounding; the rack has rolled as far
        along = depth / np.tan(normal_angle)
        rolled = (along - offset) / self.pitch_radius
        radial = self.pitch_radius - depth - rounding * np.sin(normal_angle)
        lateral = along + rounding * np.cos(normal_angle)
        angle = pi / self.teeth - np.arctan2(lateral, radial) + rolled
        radius = np.hypot(radial, lateral)
        return np.column_stack([radius * np.sin(angle), radius * np.cos(angle)])

    def section(self, flank_points: int = 81) -> ToothSection:
        """Transverse section of the tooth with its fillet, on the whole ring.

        `flank_points` is the number of points of the flank, from tip to root.
        """
        profile = np.linspace(
            self.profile_from_roll(np.array(self.tip_roll_angle)),
            self.profile_from_roll(np.array(max(self.form_roll_angle, 0.0))),
            flank_points,
        )
        roll = self.roll_from_profile(profile)
        radius, angle = involute(self.base_radius, roll)[0], -self.polar_angle(roll)
        flank = np.column_stack([radius * np.sin(angle), radius * np.cos(angle)])
        fillet = self.fillet()
        fillet[0] = flank[-1]
        return ToothSection(flank, profile, fillet, RingRim(self.teeth, self.bore_radius))

    @property
    def tip_half_thickness(self) -> float:
        """Half the tooth thickness at the tip circle, as an arc [mm]; negative beyond the pointed tip."""
        return -float(self.polar_angle(np.array(self.tip_roll_angle))) * self.tip_radius

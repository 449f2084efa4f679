"""Interface of geometry to loaded contact and wear: a pair of flanks in mesh.

Conventions, shared by every kind of pair (docs/frame.svg):

* The *driven* body carries the stations: `face` [mm] along its tooth, `profile` [mm] across it, rising from
  root to tip and close to arc length. Contact lines run roughly along `face`.
* `roll` counts base pitches of one tooth pair's engagement: 0 when contact passes the pitch point, rising with
  time. Neighbouring pairs differ by one.
* `separation` is the distance along the common normal at the nominal (conjugate) rotation; where it is least,
  an unloaded pair touches. Its sign: positive is a gap.
* Time runs so that the driving body turns by one radian in one unit.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Protocol

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.inclined_foot import InclinedFoot
from semiwear.geometry.section import ToothSection
from semiwear.scene import Placement

BODIES = ("pinion", "gear")
DRIVING, DRIVEN = 0, 1

ARCSEC = 180.0 * 3600.0 / pi
"""Of a radian."""

EXACT_STEPS = 1.5e-3, 2e-3
"""`FlankPair.difference_steps` of flanks given by formulas: rounding leaves 1e-9 of the curvatures."""


@dataclass(frozen=True)
class Meeting:
    """A driven flank point and the driving flank point that it would touch at a roll position.

    All arrays have the broadcast shape of the arguments; vectors add a last axis of length 3 in the fixed frame.

    Attributes
    ----------
    separation : array [mm]
        Normal distance at the nominal rotation.
    position : (..., 3) array [mm]
    normal : (..., 3) array
        Unit normal out of the driven body.
    driving_profile, driving_face : arrays [mm]
        Coordinates of the mating point on the driving flank.
    """

    separation: FloatArray
    position: FloatArray
    normal: FloatArray
    driving_profile: FloatArray
    driving_face: FloatArray


@dataclass(frozen=True)
class Borders:
    """Limits of both flanks, and the radii that round their edges.

    A flank ends where the rounding of its edge begins (`sharp=False`) or at the nominal edge (`sharp=True`).

    Attributes
    ----------
    root, tip : arrays [mm]
        Profile coordinate of the driven flank's ends at each face station, of the shape of the stations.
    driving_root, driving_tip : float [mm]
        Profile coordinate of the driving flank's ends.
    face : (float, float) [mm]
        Ends of the driven flank.
    driving_face : (float, float) [mm]
        Ends of the driving flank.
    tip_turn : array [rad], like `root`
    driving_tip_turn : float [rad]
        Angles by which the outlines of both bodies turn at their tip edges.
    tip_edge_radius, end_edge_radius, driving_tip_edge_radius, driving_end_edge_radius : float [mm]
    """

    root: FloatArray
    tip: FloatArray
    driving_root: float
    driving_tip: float
    face: tuple[float, float]
    driving_face: tuple[float, float]
    tip_turn: FloatArray
    driving_tip_turn: float
    tip_edge_radius: float
    end_edge_radius: float
    driving_tip_edge_radius: float
    driving_end_edge_radius: float


@dataclass(frozen=True)
class PrismBody:
    """Sections of a toothed body along its width, from which its compliance is computed.

    Attributes
    ----------
    width : float
        Extent of the tooth in the face coordinate [mm].
    start : float
        Face coordinate of its lower end [mm].
    faces : tuple of float
        Face coordinates of the sections [mm], rising.
    sections : tuple of ToothSection
        Normal to the tooth.
    length : float or None
        Length of the tooth along itself, where it is inclined to the face coordinate [mm]. Default: the width.
    foot : InclinedFoot or None
        Foot of a helical tooth on its wheel.
    """

    width: float
    start: float
    faces: tuple[float, ...]
    sections: tuple[ToothSection, ...]
    length: float | None = None
    foot: InclinedFoot | None = None

    @property
    def tooth_length(self) -> float:
        """Length of the tooth along itself [mm]."""
        return self.width if self.length is None else self.length


class FlankPair(Protocol):
    """Two flanks in mesh."""

    def __hash__(self) -> int:
        """Hash of the pair's data, so that contact lines of equal pairs are traced once."""

    @property
    def placement(self) -> Placement:
        """Rigid displacement of the pinion from its nominal place."""

    @property
    def difference_steps(self) -> tuple[float, float]:
        """Steps of differences for curvatures, as fractions of the face width and of the flank's height."""

    @property
    def face_limits(self) -> tuple[float, float]:
        """Ends of the driven flank [mm]."""

    @property
    def base_pitch(self) -> float:
        """Travel of the contact along the line of action in one roll unit [mm]."""

    @property
    def base_profiles(self) -> tuple[float, float]:
        """Profile coordinates where both involutes begin, the driving and the driven one [mm].

        Their curvature is infinite there. For a generated flank: of its generating involute; infinite without one.
        """

    @property
    def roll_per_time(self) -> float:
        """Roll positions passed while the driving body turns by one radian."""

    @property
    def arcsec_per_mm(self) -> float:
        """Driven-side transmission error per approach along the line of action [arcsec/mm], positive."""

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the pinion's reference circle."""

    @property
    def driving_meshes(self) -> float:
        """Meshes of a driving tooth in one mesh of a driven tooth: the ratio of tooth numbers."""

    @property
    def pitch_point(self) -> FloatArray:
        """Pitch point in the fixed frame: (3,) array [mm]."""

    def borders(self, face: FloatArray, *, sharp: bool = False) -> Borders:
        """Limits of both flanks at face stations."""

    def meeting(self, face: FloatArray, profile: FloatArray, roll: FloatArray) -> Meeting:
        """Mating point on the driving flank of a driven point (face, profile) at a roll; arguments broadcast."""

    def driving_points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals of the driving flank in that body's own frame, from its own coordinates [mm]."""

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the driving minus that of the driven body at fixed-frame positions [mm per unit time]."""

    def driven_velocity(self, position: FloatArray) -> FloatArray:
        """Velocity of the driven body at fixed-frame positions [mm per unit time]."""

    def lever_arm(self, position: FloatArray) -> FloatArray:
        """Approach along the normal per unit rotation of the driving body at positions [mm]."""

    def flank_place(self, body: int, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Height above the pitch surface, and radius about the body's own axis, of flank points [mm]."""

    def profile_at(self, face: FloatArray, height: FloatArray) -> FloatArray:
        """Profile coordinate of the driven flank at a height above the pitch surface [mm]."""

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate where the driven flank crosses its pitch surface [mm]; may lie outside the flank."""

    def prism_body(self, body: int) -> PrismBody:
        """Sections of a body with fillets and rim."""


def displacement(placement: Placement) -> tuple[FloatArray, FloatArray]:
    """Rotation about the pitch point, (3, 3) array, and shift, (3,) array [mm], of a displaced pinion."""
    about_x, about_y = 1e-3 * placement.shaft_angle_error_mrad, 1e-3 * placement.pinion_slope_mrad
    turn_x = np.array([[1.0, 0.0, 0.0], [0.0, cos(about_x), -sin(about_x)], [0.0, sin(about_x), cos(about_x)]])
    turn_y = np.array([[cos(about_y), 0.0, sin(about_y)], [0.0, 1.0, 0.0], [-sin(about_y), 0.0, cos(about_y)]])
    return turn_x @ turn_y, np.array([placement.offset_mm, placement.axial_gear_mm, placement.axial_pinion_mm])


def reference_lever(pair: FlankPair) -> float:
    """Lever arm with which `arcsec_per_mm` converts an approach into a rotation [mm].

    On flanks that are no involutes the lever arm varies: an approach at another lever arm counts for
    ``reference_lever / lever_arm`` of itself.
    """
    return ARCSEC / (pair.driving_meshes * pair.arcsec_per_mm)

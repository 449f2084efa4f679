"""The interface of a gear pair in motion for the finite elements, and the part that all kinds have in common.

Pair j is pinion tooth j on gear tooth -j and stands at roll position r as pair 0 does at r + j. Pinion and gear have
frames of their own, in which their meshes lie, and poses in the fixed frame (docs/frame.svg).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fem_reference.arrays import FloatArray
from semiwear.scene import Placement, Scene

ARCSEC = 180.0 * 3600.0 / pi
"""Of a radian."""


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
    """Gear flank points and the corresponding points of the pinion's involute.

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


class GearFlank(Protocol):
    """The gear's loaded flank by face and profile coordinate."""

    @property
    def root_profile(self) -> float:
        """Profile coordinate where the fillet begins [mm]."""

    def tip_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate of the tip at face coordinates [mm]."""

    def points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and outward unit normals (..., 3) of tooth 0 in the gear's own frame [mm], [1]."""


class PairMotion(Protocol):
    """A gear pair in motion."""

    def __hash__(self) -> int:
        """Of scene and placement."""

    @property
    def scene(self) -> Scene:
        """The scene with the pair."""

    @property
    def placement(self) -> Placement:
        """Rigid displacement of the pinion."""

    @property
    def gear(self) -> GearFlank:
        """The gear's loaded flank."""

    @property
    def pinion_teeth(self) -> int:
        """Number of the pinion's teeth."""

    @property
    def lever(self) -> float:
        """How much a rotation of the pinion closes the gap, wherever the contact is [mm per radian]."""

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the normal [arcsec/mm]."""

    @property
    def gear_face(self) -> tuple[float, float]:
        """Ends of the gear's teeth [mm]."""

    @property
    def pinion_face(self) -> tuple[float, float]:
        """Ends of the pinion's teeth along its axis [mm]."""

    @property
    def pitch_face(self) -> float:
        """Face coordinate of the pitch point, whose profile coordinate is zero [mm]."""

    @property
    def pinion_profile_limits(self) -> tuple[float, float]:
        """Profile coordinates at which the pinion's involute begins and at which its tip circle cuts it [mm]."""

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate of the gear's pitch surface at face coordinates [mm]."""

    def flank_grid(self, face: FloatArray, radius: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Face (F,) and profile (P, F) coordinates of the points of a `/flank` group [mm]."""

    def gear_pose(self, roll: float) -> Pose:
        """The gear at a roll position."""

    def pinion_pose(self, roll: float) -> Pose:
        """The pinion at a roll position, displaced by the placement."""

    def turned_to_zero(self, body: str, pair: int) -> FloatArray:
        """Rotation (3, 3) of a body in its own frame that brings the tooth of a pair to tooth 0."""

    def meeting(self, face: ArrayLike, profile: ArrayLike, roll: float) -> FlankMeeting:
        """Meeting points of flank points of gear tooth 0 at a roll position."""

    def met_by(self, points: FloatArray, normals: FloatArray, roll: float) -> FlankMeeting:
        """Meeting points of points (..., 3) of gear tooth 0, given in the gear's own frame."""

    def edge_insets(self, face: ArrayLike) -> EdgeInsets:
        """How far before the nominal tips their roundings begin [mm]."""

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion less that of the gear at fixed-frame points [mm per radian of the pinion]."""


def displacement(placement: Placement, pitch_point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Turn and shift by a placement: x -> turn x + shift; about y first, both axes through the pitch point."""
    about_y = Rotation.from_rotvec([0.0, 1e-3 * placement.pinion_slope_mrad, 0.0])
    about_x = Rotation.from_rotvec([1e-3 * placement.shaft_angle_error_mrad, 0.0, 0.0])
    turn = (about_x * about_y).as_matrix()
    moved = np.array([placement.offset_mm, placement.axial_gear_mm, placement.axial_pinion_mm])
    return turn, pitch_point - turn @ pitch_point + moved


def rounded(pair: PairMotion, face: ArrayLike, profile: ArrayLike, met: FlankMeeting) -> FloatArray:
    """Gap that the rounded edges of both bodies add [mm]; infinite beyond the nominal edges.

    An edge of radius rho that turns by t begins rho tan(t/2) before the nominal edge and falls off as its arc.
    """
    table = pair.scene.gear_pair
    face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
    inset = pair.edge_insets(face)
    gear_end, pinion_end = float(table.gear_end_edge_radius_mm), float(table.pinion_end_edge_radius_mm)
    gear_tip, pinion_tip = float(table.gear_tip_edge_radius_mm), float(table.pinion_tip_edge_radius_mm)
    edges = (
        (pair.gear.tip_profile(face) - profile, gear_tip, inset.gear_tip),
        (
            pair.pinion_profile_limits[1] - met.pinion_profile,
            pinion_tip,
            inset.pinion_tip,
        ),
        (face - pair.gear_face[0], gear_end, gear_end),
        (pair.gear_face[1] - face, gear_end, gear_end),
        (met.pinion_face - pair.pinion_face[0], pinion_end, pinion_end),
        (pair.pinion_face[1] - met.pinion_face, pinion_end, pinion_end),
    )
    added = np.zeros(face.shape)
    for distance, radius, begins in edges:
        into = begins - distance
        arc = radius - np.sqrt(np.maximum(radius**2 - np.clip(into, 0.0, radius) ** 2, 0.0))
        added += np.where(distance < -1e-9, np.inf, arc)
    return added


def line_speed(pair: PairMotion, before: FloatArray, after: FloatArray, rolls: float) -> FloatArray:
    """Speed of a contact line over a flank, normal to the line [mm per radian of the pinion].

    Parameters
    ----------
    pair : PairMotion
    before, after : (face, 3) arrays [mm]
        The line in the body's own frame at two roll positions, by the same stations.
    rolls : float
        Roll positions between them.
    """
    moved = (after - before) / rolls * pair.pinion_teeth / (2.0 * pi)
    along = np.gradient(0.5 * (before + after), axis=0)
    along /= np.linalg.norm(along, axis=-1)[:, None]
    return np.asarray(np.linalg.norm(moved - np.sum(moved * along, -1)[:, None] * along, axis=-1))

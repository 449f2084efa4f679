"""A pair's flanks in the bodies' own frames, their axes and ends, as files of points hold them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.flank_pair import DRIVEN, DRIVING, FlankPair
from semiwear.meshing.point_flank_body import frame_about


@dataclass(frozen=True)
class Axis:
    """The axis of a body in the fixed frame.

    Attributes
    ----------
    point : (3,) array [mm]
        The origin of the body's own frame.
    direction : (3,) array
        Unit vector; the body's own z axis.
    rotation : str
        ``"positive"`` where the body turns right-handed about it, else ``"negative"``.
    """

    point: FloatArray
    direction: FloatArray
    rotation: str


def axis_of(pair: FlankPair, body: int) -> Axis:
    """The axis of a body, from the velocities of its points.

    Its direction is positive along the nearest fixed axis; its origin is the point nearest to the fixed origin.
    """
    places = np.vstack([np.zeros(3), np.eye(3)])
    velocity = pair.driven_velocity(places)
    if body == DRIVING:
        velocity = velocity + pair.sliding(places)
    by_place = velocity[1:] - velocity[0]  # row k: turn x e_k
    turn = np.array([by_place[1, 2], by_place[2, 0], by_place[0, 1]])
    point = np.cross(turn, velocity[0]) / (turn @ turn)
    direction = turn / np.linalg.norm(turn)
    forwards = direction[np.argmax(np.abs(direction))] > 0.0
    # sums of cosines and sines leave rounding in the last digits
    point, direction = np.round(point, 12) + 0.0, np.round(direction, 15) + 0.0
    return Axis(point, direction if forwards else -direction + 0.0, "positive" if forwards else "negative")


def flank_ends(pair: FlankPair, body: int, face: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Profile coordinates of the nominal root and tip ends of a flank at face coordinates [mm]."""
    borders = pair.borders(face, sharp=True)
    if body == DRIVEN:
        return borders.root, borders.tip
    return np.full(face.shape, borders.driving_root), np.full(face.shape, borders.driving_tip)


def own_flank(pair: FlankPair, body: int, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points and unit normals out of the material in the body's own frame, its axis as z.

    Parameters
    ----------
    pair : FlankPair
        In its nominal place.
    body : int
    face, profile : arrays that broadcast [mm]

    Returns
    -------
    points, normals : (..., 3) arrays [mm], [1]
    """
    if body == DRIVING:
        return pair.driving_points(face, profile)
    met = pair.meeting(face, profile, np.zeros(1))
    return _in_own_frame(pair, body, met.position, met.normal)


def driving_involute(
    pair: FlankPair, face: FloatArray, roll: FloatArray, base: float, phase: float, lead: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Points and unit normals of an involute driving flank in that body's own frame.

    Parameters
    ----------
    pair : FlankPair
        In its nominal place.
    face, roll : arrays that broadcast [mm], [rad]
        Coordinate along the axis and roll angle (ISO 21771).
    base : float
        Base radius [mm].
    phase : float
        Polar angle of the involute's origin in the transverse section at face 0, at roll position 0 [rad].
    lead : float
        Tangent of the base helix angle; its sign is that of the rotation along the axis.

    Returns
    -------
    points, normals : (..., 3) arrays [mm], [1]
    """
    face, roll = np.broadcast_arrays(np.asarray(face, float), roll)
    centre = axis_of(pair, DRIVING).point
    tangent = roll + phase + lead / base * face  # angle of the base circle's tangent
    polar, radius = tangent - np.arctan(roll), base * np.sqrt(1.0 + roll**2)
    points = np.stack([radius * np.sin(polar), -radius * np.cos(polar), face], axis=-1) + centre
    normals = np.stack([-np.cos(tangent), -np.sin(tangent), np.full(face.shape, lead)], axis=-1)
    return _in_own_frame(pair, DRIVING, points, normals / np.sqrt(1.0 + lead**2))


def _in_own_frame(
    pair: FlankPair, body: int, points: FloatArray, normals: FloatArray
) -> tuple[FloatArray, FloatArray]:
    axis = axis_of(pair, body)
    frame = frame_about(axis.direction)
    return (points - axis.point) @ frame, normals @ frame

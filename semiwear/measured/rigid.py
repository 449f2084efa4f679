"""Rigid displacements of a measured tooth: from the body's nominal frame to that of the measuring machine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import SceneError
from semiwear.measured.nominal import NominalFlank
from semiwear.plain_text import one_of
from semiwear.scene.closest import advised_name

MOTIONS = ("rotation", "axial", "radial", "tangential", "tilt_radial", "tilt_tangential")
"""Small motions of a body: about and along its axis; shifts towards the flank and across; tilts about these two."""

TURNS = ("rotation", "tilt_radial", "tilt_tangential")
"""Motions that are rotations; the others are shifts."""

DATUM = MOTIONS[:2]
"""Position of the tooth that a measuring machine leaves open: rotation about the axis and shift along it."""

# row of the frame: direction of a shift or axis of a rotation
_DIRECTION = {"rotation": 0, "axial": 0, "radial": 1, "tilt_radial": 1, "tangential": 2, "tilt_tangential": 2}
_INDEPENDENT = 1e-5  # least part of a motion that is no linear combination of the previous motions
_LEAST_MODE = 1e-9  # mm/mm or mm/rad: least displacement along the normals


@dataclass(frozen=True)
class Displacement:
    """Rigid displacement: measured = turn @ nominal + shift.

    Attributes
    ----------
    turn : (3, 3) array
        Rotation matrix.
    shift : (3,) array [mm]
    """

    turn: FloatArray
    shift: FloatArray

    @classmethod
    def none(cls) -> Displacement:
        """No displacement."""
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def about_axis(cls, angle: float, along: float = 0.0) -> Displacement:
        """Rotation about the body's axis, z [rad], and shift along it [mm]."""
        return cls(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix(), np.array([0.0, 0.0, along]))

    def apply(self, points: FloatArray) -> FloatArray:
        """Displaced points, (..., 3) [mm]."""
        return points @ self.turn.T + self.shift

    def undo(self, points: FloatArray) -> FloatArray:
        """Points before the displacement, (..., 3) [mm]."""
        return (points - self.shift) @ self.turn

    def after(self, first: Displacement) -> Displacement:
        """`first` followed by this displacement."""
        return Displacement(self.turn @ first.turn, self.turn @ first.shift + self.shift)


@dataclass(frozen=True)
class Motions:
    """Small motions of a body about its axis and a reference point on it.

    Attributes
    ----------
    names : tuple of str
        Some of `MOTIONS`.
    centre : (3,) array [mm]
        Point of the axis at the height of the middle of the flank.
    frame : (3, 3) array
        Rows: axis, radial direction (from the axis to the middle of the flank), tangential direction.
    """

    names: tuple[str, ...]
    centre: FloatArray
    frame: FloatArray

    def modes(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Displacement of flank points along their normals per unit of each motion, (..., motions) [mm/rad or 1]."""
        columns = []
        for name in self.names:
            direction = self.frame[_DIRECTION[name]]
            if name in TURNS:
                moved = np.cross(direction, points - self.centre)
            else:
                moved = np.broadcast_to(direction, points.shape)
            columns.append(np.sum(moved * normals, axis=-1))
        return np.stack(columns, axis=-1) if columns else np.zeros((*points.shape[:-1], 0))

    def displacement(self, amounts: FloatArray) -> Displacement:
        """The displacement by amounts [rad, mm] of each motion."""
        turning, shift = np.zeros(3), np.zeros(3)
        for name, amount in zip(self.names, amounts, strict=True):
            direction = self.frame[_DIRECTION[name]]
            if name in TURNS:
                turning = turning + amount * direction
            else:
                shift = shift + amount * direction
        turn = Rotation.from_rotvec(turning).as_matrix()
        return Displacement(turn, self.centre - turn @ self.centre + shift)

    def amounts(self, displacement: Displacement) -> dict[str, float]:
        """A displacement as motions [rad, mm]: a rotation about the axis, then a tilt, then a shift of the centre."""
        axis = self.frame[0]
        x, y, z, w = Rotation.from_matrix(displacement.turn).as_quat()
        angle = 2.0 * float(np.arctan2(np.dot((x, y, z), axis), w))
        angle = float((angle + np.pi) % (2.0 * np.pi) - np.pi)
        tilt = Rotation.from_matrix(displacement.turn) * Rotation.from_rotvec(angle * axis).inv()
        turning = self.frame @ tilt.as_rotvec()
        shift = self.frame @ (displacement.apply(self.centre) - self.centre)
        values = (angle, shift[0], shift[1], shift[2], turning[1], turning[2])
        return {name: float(value) for name, value in zip(MOTIONS, values, strict=True)}


def require_motions(names: object, field: str) -> tuple[str, ...]:
    """Names of motions, in the order given.

    Raises
    ------
    SceneError
        For a name that is not in a list, and for names that are not in `MOTIONS`.
    """
    fix = '() for none, ("rotation",) for one'
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise SceneError.of(field, names, f"a list of {', '.join(MOTIONS)}", fix)
    listed = list(names)
    for name in listed:
        if name not in MOTIONS:
            raise SceneError.of(field, name, one_of(MOTIONS), advised_name(str(name), MOTIONS, fix))
    return tuple(map(str, listed))


def motions_of(flank: NominalFlank, names: Sequence[str]) -> Motions:
    """Motions of a body, by name, in the order of `MOTIONS`."""
    axis = np.array([0.0, 0.0, 1.0])
    middle, _ = flank.points(*flank.places(0.5, 0.5))
    centre = middle[2] * axis
    radial = (middle - centre) / np.linalg.norm(middle - centre)
    frame = np.stack([axis, radial, np.cross(axis, radial)])
    return Motions(tuple(name for name in MOTIONS if name in names), centre, frame)


def determined(modes: FloatArray) -> BoolArray:
    """Motions that a flank determines: (motions,) bool from modes (points, motions).

    A shift along the axis moves no point of a spur flank along its normal, and those of a helical flank as a rotation
    does. A motion whose displacements are zero, or a linear combination of those of the previous motions, is not
    determined.
    """
    size = np.linalg.norm(modes, axis=0)
    least = _LEAST_MODE * np.sqrt(modes.shape[0])
    basis: list[FloatArray] = []
    independent = np.zeros(modes.shape[1], dtype=bool)
    for k in range(modes.shape[1]):
        rest = modes[:, k].copy()
        for _ in range(2):  # the second pass removes rounding errors
            for direction in basis:
                rest -= (direction @ rest) * direction
        length = float(np.linalg.norm(rest))
        if length > _INDEPENDENT * size[k] and size[k] > least:
            basis.append(rest / length)
            independent[k] = True
    return independent

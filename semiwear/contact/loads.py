"""Loads on the contact lines of all tooth pairs over a mesh cycle, and the pressures that they cause."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from semiwear.arrays import FloatArray, IntArray


@dataclass
class TeethLoads:
    """Loads on the contact lines; a solver changes its own copy in place while it goes through mesh positions.

    Attributes
    ----------
    force : (roll, face) array [N]
        Normal force on each slice.
    half_width : (roll, face) array [mm]
        Hertz half-width; on patches, of the Hertz contact with the same load and greatest pressure.
    rotation : (mesh_position,) array [rad]
        Rotation of the driving body beyond its nominal place.
    iterations : (mesh_position,) int array
    balance : (mesh_position,) array
        Relative error of the torque.
    complementarity : (mesh_position,) array
        On lines, greatest product of pressure over its peak and gap over approach, a negative gap counting in full;
        on patches, greatest gap where cells press, or penetration elsewhere, over the approach.
    cells : (roll, face, columns) array [N]
        Normal force on each cell of a patch, the fresh line in the middle of the columns; no columns on lines.
    """

    force: FloatArray
    half_width: FloatArray
    rotation: FloatArray
    iterations: IntArray
    balance: FloatArray
    complementarity: FloatArray
    cells: FloatArray

    @classmethod
    def none(cls, rolls: int, faces: int, positions: int) -> TeethLoads:
        """No loads yet."""
        return cls(
            np.zeros((rolls, faces)),
            np.zeros((rolls, faces)),
            np.zeros(positions),
            np.zeros(positions, dtype=np.int64),
            np.zeros(positions),
            np.zeros(positions),
            np.zeros((rolls, faces, 0)),
        )

    def copy(self) -> TeethLoads:
        """An independent copy."""
        return TeethLoads(*(getattr(self, entry.name).copy() for entry in fields(self)))


@dataclass(frozen=True)
class SlicePressures:
    """Greatest pressures of every slice; arrays are (roll, face).

    Attributes
    ----------
    inner : array [MPa]
        Away from the borders of both flanks; zero where there is none.
    place : array [mm]
        Profile coordinate where it is found.
    border : array [MPa]
        At the borders: the raw value, which depends on the mesh.
    """

    inner: FloatArray
    place: FloatArray
    border: FloatArray

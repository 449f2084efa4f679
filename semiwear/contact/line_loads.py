"""Loads on the contact lines of all tooth pairs, as fidelity `line` finds them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

__all__ = ["LineLoads"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass
class LineLoads:
    """Loads on the contact lines; changed in place while positions are solved.

    Attributes
    ----------
    force : (roll, face) array [N]
        Normal force on each slice.
    half_width : (roll, face) array [mm]
        Hertz half-width.
    rotation : (mesh_position,) array [rad]
        Rotation of the driving body beyond its nominal place.
    iterations : (mesh_position,) int array
    balance, complementarity : (mesh_position,) arrays
        Relative error of the torque; greatest product of pressure over its peak and gap over approach, a negative
        gap counting in full.
    """

    force: FloatArray
    half_width: FloatArray
    rotation: FloatArray
    iterations: IntArray
    balance: FloatArray
    complementarity: FloatArray

    @classmethod
    def none(cls, rolls: int, faces: int, positions: int) -> LineLoads:
        """No loads yet."""
        return cls(
            np.zeros((rolls, faces)),
            np.zeros((rolls, faces)),
            np.zeros(positions),
            np.zeros(positions, dtype=np.int64),
            np.zeros(positions),
            np.zeros(positions),
        )

    def copy(self) -> LineLoads:
        """An independent copy."""
        return LineLoads(*(getattr(self, entry.name).copy() for entry in fields(self)))

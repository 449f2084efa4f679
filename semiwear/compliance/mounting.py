"""Elastic mounting: the driving body as a rigid body on linear springs.

A force F along the common normal n (out of the driven body) at the point x pushes the driving body out of mesh. In
its five freedoms (the sixth, its rotation, is the drive) it moves by

    u = S G^T F,   G_i = (n_x, n_z, n_y, [(x_i - P) x n_i]_x, [(x_i - P) x n_i]_y)

S the flexibility of the springs, P the pitch point where they act, and the separation of slice i grows by G_i u. So

    C_ij = G_i S G_j^T

of rank five at most, positive semidefinite, and the same for all tooth pairs: they share one mounting.
Signs and axes are those of `semiwear.scene.Placement`; a displacement that the springs allow is one more placement.
Valid while displacements are small against the radii: the change of the separation is taken as linear.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from semiwear.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class MountingSprings:
    """Flexibility of the mounting of the driving body relative to the driven one, at the pitch point.

    The freedoms are uncoupled; zero is rigid.

    Attributes
    ----------
    offset : float
        Along x [mm/N].
    axial_pinion : float
        Along z, the driving body's axis [mm/N].
    axial_gear : float
        Along y, the driven body's axis [mm/N].
    shaft_angle : float
        About the axis through the pitch point along x [rad/(N mm)].
    pinion_slope : float
        About the axis through the pitch point along y [rad/(N mm)].

    Raises
    ------
    ValueError
        For a flexibility that is negative or not finite.
    """

    offset: float = 0.0
    axial_pinion: float = 0.0
    axial_gear: float = 0.0
    shaft_angle: float = 0.0
    pinion_slope: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: a flexibility is a finite number >= 0, not {value!r}")

    @property
    def flexibility(self) -> FloatArray:
        """The five values, in the order of the attributes: (5,) array."""
        return np.array([self.offset, self.axial_pinion, self.axial_gear, self.shaft_angle, self.pinion_slope])


def separation_by_freedom(position: FloatArray, normal: FloatArray, pitch_point: FloatArray) -> FloatArray:
    """Change of the separation by each freedom of the driving body.

    Parameters
    ----------
    position, normal : (..., 3) arrays [mm], [1]
        Contact points in the fixed frame, and unit normals out of the driven body.
    pitch_point : (3,) array [mm]

    Returns
    -------
    (..., 5) array
        Along x, z and y [mm/mm], about x and y [mm/rad].
    """
    moment = np.cross(position - pitch_point, normal)
    return np.concatenate([normal[..., [0, 2, 1]], moment[..., :2]], axis=-1)


class Mounting:
    """Compliance of the mounting between slices (a `SliceCompliance`).

    Parameters
    ----------
    springs : MountingSprings
    position, normal : (roll, face, 3) arrays [mm], [1]
        Points of the contact lines in the fixed frame, and unit normals out of the driven body.
    pitch_point : (3,) array [mm]
    """

    def __init__(
        self, springs: MountingSprings, position: FloatArray, normal: FloatArray, pitch_point: FloatArray
    ) -> None:
        self.springs = springs
        self.by_freedom = separation_by_freedom(position, normal, np.asarray(pitch_point, float))

    def matrix(self, at: tuple[IntArray, IntArray], starts: IntArray) -> FloatArray:
        """Compliance between slices of all lines, see `SliceCompliance` [mm/N]."""
        rooted = self.by_freedom[at] * np.sqrt(self.springs.flexibility)
        return rooted @ rooted.T

    def displacement(self, force: FloatArray, at: tuple[IntArray, IntArray]) -> FloatArray:
        """Displacement of the driving body under forces on slices: (5,) array [mm, mm, mm, rad, rad].

        Order and signs as in `MountingSprings`; `force` is an (n,) array [N].
        """
        return self.springs.flexibility * (force @ self.by_freedom[at])

"""Nominal flank of a body, to which measured flanks are registered.

All points are in the body's own frame, in which flanks are exported and measured (`semiwear.meshing.own_flanks`): z
is its axis, in the sense of the closest axis of the fixed frame, and the origin is the point of the axis closest to
the origin of the fixed frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING, FlankPair
from semiwear.meshing.own_flanks import Axis, axis_of, own_flank
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.meshing.point_flank_body import frame_about
from semiwear.plain_text import one_of
from semiwear.scene import Placement, Scene

_SLACK = 1e-6  # of half a slice


@dataclass(frozen=True)
class NominalFlank:
    """Points, normals and limits of a nominal flank.

    Attributes
    ----------
    pair : FlankPair
        Without placement errors.
    body : int
    mirrored : bool
        Whether the flank is the mirror image at x = 0 of that of the pair.
    """

    pair: FlankPair
    body: int
    mirrored: bool = False

    def points(self, face: ArrayLike, profile: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals out of the material.

        Parameters
        ----------
        face, profile : arrays that broadcast [mm]
            Flank coordinates; somewhat beyond the ends the surface is continued.

        Returns
        -------
        points, normals : (..., 3) arrays [mm], [1]
        """
        u, v = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        if self.body == DRIVING and isinstance(self.pair, FaceGearMesh):
            base_circle = float(self.pair.pinion.profile_from_roll(np.zeros(())))
            v = np.maximum(v, base_circle)  # there is no flank below it
        points, normals = own_flank(self.pair, self.body, u, v)
        shape = (*u.shape, 3)
        return (points @ self._mirror).reshape(shape), (normals @ self._mirror).reshape(shape)

    def limits(self, face: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Profile coordinate of the root and tip ends at face coordinates [mm], without the edge roundings."""
        face = np.asarray(face, float)
        # far beyond its ends a face-gear tooth may not exist
        inside = np.clip(face, *self.face_ends)
        if self.body == DRIVEN:
            borders = self.pair.borders(inside.ravel())
            return borders.root.reshape(face.shape), borders.tip.reshape(face.shape)
        borders = self.pair.borders(np.atleast_1d(self.pair.face_limits[0]))
        return np.full(face.shape, borders.driving_root), np.full(face.shape, borders.driving_tip)

    @cached_property
    def face_ends(self) -> tuple[float, float]:
        """Face coordinates of the lower and the upper end [mm]."""
        borders = self.pair.borders(np.atleast_1d(self.pair.face_limits[0]))
        return borders.face if self.body == DRIVEN else borders.driving_face

    def places(self, face_fraction: ArrayLike, profile_fraction: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Face and profile coordinates [mm] from fractions of the flank, from the lower end and from the root."""
        u, v = np.broadcast_arrays(np.asarray(face_fraction, float), np.asarray(profile_fraction, float))
        low, high = self.face_ends
        face = low + u * (high - low)
        root, tip = self.limits(face)
        return face, root + v * (tip - root)

    def place(self, face: ArrayLike, profile: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Height above the pitch surface and radius about the axis [mm]."""
        return self.pair.flank_place(self.body, np.asarray(face, float), np.asarray(profile, float))

    @cached_property
    def axis(self) -> Axis:
        """The body's axis; a mirrored body rotates in the opposite sense."""
        axis = axis_of(self.pair, self.body)
        if not self.mirrored:
            return axis
        turned = "negative" if axis.rotation == "positive" else "positive"
        across = np.array([-1.0, 1.0, 1.0])
        return Axis(across * axis.point + 0.0, across * axis.direction + 0.0, turned)

    @cached_property
    def _mirror(self) -> FloatArray:
        """The mirror at x = 0 of the fixed frame, in the body's own frame."""
        frame = frame_about(axis_of(self.pair, self.body).direction)
        return frame.T @ np.diag([-1.0 if self.mirrored else 1.0, 1.0, 1.0]) @ frame


def nominal_flank(scene: Scene, body: str = "gear") -> NominalFlank:
    """The nominal loaded flank of a body of a scene.

    Parameters
    ----------
    scene : Scene
    body : str
        ``"pinion"`` or ``"gear"``.

    Raises
    ------
    SceneError
        For an unknown body.
    """
    if body not in BODIES:
        raise SceneError.of("body", body, one_of(BODIES))
    coast = scene.operation.loaded_flank == "coast"
    table, placement = on_loaded_flank(scene.gear_pair, Placement(), scene.operation.loaded_flank)
    return NominalFlank(flank_pair(table, placement), BODIES.index(body), coast)


def unreached(pair: FlankPair, body: int, stations: FloatArray) -> tuple[float, float]:
    """Face coordinates below and above which a flank has no contact with its mate [mm].

    These are the ends of the outermost slices, whose middles are the stations. Infinite at an end where the slices
    reach the rounding of the flank's own edge; only a body that is wider than its mate has parts without contact.
    """
    borders = pair.borders(stations)
    driving = body == DRIVING
    low, high = borders.driving_face if driving else borders.face
    radius = borders.driving_end_edge_radius if driving else borders.end_edge_radius
    half = 0.5 * (stations[1] - stations[0])
    first, last, slack = stations[0] - half, stations[-1] + half, _SLACK * half
    below = float(first) if first - slack > low + radius else -np.inf
    above = float(last) if last + slack < high - radius else np.inf
    return below, above

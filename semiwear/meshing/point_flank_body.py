"""One body whose flank is given as points: its surface, its axis, and the coordinates on its flank.

`face` runs along the tooth: the file's coordinate, or the length from the tooth's middle. `profile` runs across it,
from 0 at the root end to the length of the flank at the tip edge: of the driven body the length at that face
coordinate, of the driving body the mean length, so that its flank is a rectangle in both. A file may state that it
rises otherwise: uniformly from row to row, with lengths of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from scipy.interpolate import CubicSpline

from semiwear.arrays import FloatArray
from semiwear.geometry.point_surface import PointSurface, spline_cells
from semiwear.meshing.point_flank_kernels import surface_points, touch

_GUESSES = 12  # points each way for the fit of the affine guess
_INVOLUTE = 1e-3  # of the change of a flank's squared radius, which for an involute is linear in the arc within this


def frame_about(direction: FloatArray) -> FloatArray:
    """Right-handed unit axes as columns, the third along a direction: (3, 3) array."""
    z = direction / np.linalg.norm(direction)
    aside = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(aside, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _straight_beyond(spline: CubicSpline, at: FloatArray) -> FloatArray:
    """A spline over 0 to 1, continued linearly."""
    inside = np.clip(at, 0.0, 1.0)
    value = spline(inside)
    beyond = at != inside
    if np.any(beyond):
        value = np.where(beyond, value + (at - inside) * np.where(at < 0.0, spline(0.0, 1), spline(1.0, 1)), value)
    return np.asarray(value)


@dataclass(frozen=True)
class Touch:
    """Points of a flank on given circles about its axis.

    Attributes
    ----------
    u, v : arrays
        Parameters of the surface.
    polar : array [rad]
        Polar angle of the flank there, in the body's own frame.
    lever : array [mm]
        Approach along the flank's normal per angle about its axis.
    """

    u: FloatArray
    v: FloatArray
    polar: FloatArray
    lever: FloatArray


@dataclass(frozen=True, eq=False)
class FlankBody:
    """A body with one flank.

    Attributes
    ----------
    surface : PointSurface
        In the body's own frame.
    centre : (3,) array [mm]
        Origin of its own frame, in the fixed one.
    frame : (3, 3) array
        Columns: its own axes in the fixed frame; the third is its axis.
    sense : int
        +1 if it turns right-handed about its axis, -1 if left-handed.
    teeth : int
    pushes : bool
        Whether the body drives: its flank moves out of the material, not into it.
    face_ends : (float, float) [mm]
        Face coordinate of the first and the last column; the first may be the greater.
    own_lengths : (F,) array [mm] or None
        Lengths of the columns in a profile coordinate that rises uniformly from row to row. None: it is arc length.
    """

    surface: PointSurface
    centre: FloatArray
    frame: FloatArray
    sense: int
    teeth: int
    pushes: bool
    face_ends: tuple[float, float]
    own_lengths: FloatArray | None = None

    # ---- coordinates

    @property
    def face_limits(self) -> tuple[float, float]:
        """Ends of the flank in its face coordinate, rising [mm]."""
        return min(self.face_ends), max(self.face_ends)

    def v_at(self, face: FloatArray) -> FloatArray:
        """Parameter v at face coordinates [mm]."""
        first, last = self.face_ends
        return (np.asarray(face, float) - first) / (last - first)

    def face_at(self, v: FloatArray) -> FloatArray:
        """Face coordinate [mm] at parameters v."""
        first, last = self.face_ends
        return first + (last - first) * v

    @cached_property
    def _length_spline(self) -> CubicSpline:
        lengths = self.surface.profile_lengths if self.own_lengths is None else self.own_lengths
        return CubicSpline(self.surface.v, lengths)

    @cached_property
    def _rows(self) -> tuple[CubicSpline, CubicSpline]:
        """Parameter u over the fraction of the profile coordinate, and its inverse."""
        even = np.linspace(0.0, 1.0, self.surface.u.size)
        return CubicSpline(even, self.surface.u), CubicSpline(self.surface.u, even)

    def u_at(self, profile: FloatArray, length: FloatArray | float) -> FloatArray:
        """Parameter u at profile coordinates, on flanks of some length [mm]."""
        fraction = np.asarray(profile, float) / length
        return fraction if self.own_lengths is None else _straight_beyond(self._rows[0], fraction)

    def profile_at(self, u: FloatArray, length: FloatArray | float) -> FloatArray:
        """Profile coordinate at parameters u, on flanks of some length [mm]."""
        return (u if self.own_lengths is None else _straight_beyond(self._rows[1], u)) * length

    def profile_length(self, v: FloatArray) -> FloatArray:
        """Length of the flank from root to tip [mm]; beyond the ends as at them."""
        return np.asarray(self._length_spline(np.clip(v, 0.0, 1.0)))

    @cached_property
    def mean_length(self) -> float:
        """Mean length of the flank from root to tip [mm]."""
        return float(self._length_spline.integrate(0.0, 1.0))

    # ---- the surface

    def evaluate(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and both slopes at parameters that broadcast: three (..., 3) arrays, own frame [mm]."""
        u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
        out = np.empty((u.size, 3, 3))
        surface = self.surface
        surface_points(surface.cells, surface.u, surface.v, u.ravel(), v.ravel(), out)
        shape = (*u.shape, 3)
        return out[..., 0].reshape(shape), out[..., 1].reshape(shape), out[..., 2].reshape(shape)

    @cached_property
    def _outwards(self) -> float:
        """Sign that turns the cross product of the slopes out of the material."""
        grid = np.linspace(0.1, 0.9, 5)
        points, across, along = self.evaluate(grid[:, None], grid)
        normal = np.cross(across, along)
        lever = float(np.sum(normal[..., 1] * points[..., 0] - normal[..., 0] * points[..., 1]))
        return float(np.copysign(1.0, lever) * self.sense * (1.0 if self.pushes else -1.0))

    def points(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points [mm] and unit normals out of the material, own frame: two (..., 3) arrays."""
        points, across, along = self.evaluate(u, v)
        normal = self._outwards * np.cross(across, along)
        return points, normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def radius_and_axial(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radius about the axis and place along it [mm]."""
        points = self.evaluate(u, v)[0]
        return np.hypot(points[..., 0], points[..., 1]), points[..., 2]

    @cached_property
    def base_profile(self) -> float:
        """Profile coordinate of the base circle if the flank is an involute in its middle [mm]; -inf otherwise.

        With the arc s from there, r^2 = r_b^2 + 2 r_b s on an involute.
        """
        u, middle = np.linspace(0.0, 1.0, _GUESSES), np.array(0.5)
        arc = self.profile_at(u, self.profile_length(middle))
        square = self.radius_and_axial(u, middle)[0] ** 2
        slope, start = np.polyfit(arc, square, 1)
        is_involute = np.abs(start + slope * arc - square).max() <= _INVOLUTE * np.ptp(square)
        return float((0.25 * slope**2 - start) / slope) if is_involute else -np.inf

    # ---- turned about its axis

    @cached_property
    def _revolved(self) -> FloatArray:
        """Splines of radius, axial place and polar angle."""
        x, y, z = np.moveaxis(self.surface.points, -1, 0)
        middle = np.arctan2(np.mean(y), np.mean(x))
        angle = middle + np.angle(np.exp(1j * (np.arctan2(y, x) - middle)))
        # a worm's thread runs over more than one turn
        angle = np.unwrap(np.unwrap(angle, axis=0), axis=1)
        return spline_cells(self.surface.u, self.surface.v, np.stack([np.hypot(x, y), z, angle], axis=-1))

    @cached_property
    def _start(self) -> FloatArray:
        """Affine guess of u and v from radius and axial place, (2, 3)."""
        grid = np.linspace(0.0, 1.0, _GUESSES)
        u, v = (entry.ravel() for entry in np.meshgrid(grid, grid, indexing="ij"))
        radius, axial = self.radius_and_axial(u, v)
        table = np.column_stack([np.ones(u.size), radius, axial])
        return np.ascontiguousarray(np.linalg.lstsq(table, np.column_stack([u, v]), rcond=None)[0].T)

    @cached_property
    def size(self) -> float:
        """Order of the flank's extent [mm]."""
        return sqrt(self.mean_length * self.surface.face_length)

    def touch(self, radius: FloatArray, axial: FloatArray) -> Touch:
        """Points of the flank at a radius and an axial coordinate; (n,) arrays [mm]."""
        out = np.empty((radius.size, 4))
        surface = self.surface
        touch(self._revolved, surface.u, surface.v, self._start, radius, axial, self.size, out)
        return Touch(out[:, 0], out[:, 1], out[:, 2], out[:, 3])

    # ---- its edges

    def tip_turn(self, v: FloatArray) -> FloatArray:
        """Angle by which the outline turns at the tip edge, from the flank to a surface of revolution [rad]."""
        v = np.asarray(v, float)
        points, across, along = self.evaluate(np.ones(v.shape), v)
        normal = self.points(np.ones(v.shape), v)[1]
        radius = np.hypot(points[..., 0], points[..., 1])
        radial = np.stack([points[..., 0] / radius, points[..., 1] / radius], axis=-1)

        def meridian(vector: FloatArray) -> FloatArray:
            return np.stack([np.sum(vector[..., :2] * radial, axis=-1), vector[..., 2]], axis=-1)

        edge, upwards = meridian(along), meridian(across)
        land = np.stack([edge[..., 1], -edge[..., 0]], axis=-1)
        land *= np.sign(np.sum(land * upwards, axis=-1, keepdims=True))
        cosine = np.sum(land * meridian(normal), axis=-1) / np.linalg.norm(land, axis=-1)
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))

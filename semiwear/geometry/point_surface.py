"""A smooth surface through a grid of points, with an estimate of its own error.

Each coordinate is a bicubic spline over (u, v), 0 to 1: u from the first row of the grid to the last, v from the
first column to the last, both by the chord length of the grid, mean over the lines across (de Boor 2001, ch. 17;
not-a-knot ends). The spline passes through all points; or, where they are noisy, it is a smoothing spline whose
distance from them is their noise (Dierckx 1993, Curve and Surface Fitting with Splines, ch. 5).

Noise is estimated from differences of points along the normal: that of order k, over the root of the binomial
coefficient (2k over k), has the variance of the noise; smooth parts fall with the order, noise does not.

Errors are along the normal, for 95 % of the flank. Interpolated: a spline of every second point each way misses the
others by 2^4 times the error of the whole one, apart from the noise. Smoothed: half the difference of two smoothing
splines, each through every second point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb, sqrt

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline, RectBivariateSpline

from semiwear.arrays import FloatArray
from semiwear.untyped import Reals

LEAST_POINTS = 9
"""Points each way of a grid, so that every second one still gives a cubic."""
NOISY = 5e-5
"""Noise [mm] above which a surface 10 mm high is smoothed, unless a scene states otherwise: less hardly matters."""

_ORDERS = (4, 5, 6, 7, 8)
_ORDER = 4  # of a cubic spline
_WITHIN = 0.95
_REFERENCE_HEIGHT = 10.0  # mm, of the flank that `NOISY` is for
_BASE_DEGREE = 9
_TARGET = 1.05  # of the noise, whose estimate scatters: with less the spline would follow the noise


def cell_normals(points: FloatArray) -> FloatArray:
    """Vector areas of the cells of a grid, (P - 1, F - 1, 3): across rows times along columns [mm^2]."""
    first, second = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    return 0.5 * np.cross(second, first)


def spline_cells(u: FloatArray, v: FloatArray, values: FloatArray) -> FloatArray:
    """Bicubic interpolating spline as polynomials of its cells.

    Parameters
    ----------
    u, v : (P,), (F,) arrays
        Rising parameters.
    values : (P, F, c) array

    Returns
    -------
    (P - 1, F - 1, c, 4, 4) array
        Coefficient of ``(u - u_i)^(3 - a) (v - v_j)^(3 - b)`` at ``[i, j, :, a, b]``.
    """
    across = CubicSpline(u, values, axis=0).c  # (4, P - 1, F, c)
    both = CubicSpline(v, across, axis=2).c  # (4, F - 1, 4, P - 1, c)
    return np.ascontiguousarray(both.transpose(3, 1, 4, 2, 0))


def _chords(points: FloatArray, axis: int) -> tuple[FloatArray, FloatArray]:
    """Parameters 0 to 1 by the mean chord length along an axis, and the length of every line [mm]."""
    steps = np.linalg.norm(np.diff(points, axis=axis), axis=-1)
    lengths = steps.sum(axis=axis)
    mean = np.mean(steps / np.expand_dims(lengths, axis), axis=1 - axis)
    parameter = np.concatenate([[0.0], np.cumsum(mean)])
    return parameter / parameter[-1], lengths


def noise_of(points: FloatArray) -> float:
    """Root mean square of the noise of a grid along its normal [mm]."""
    normal = cell_normals(points)
    padded = np.pad(normal, ((1, 1), (1, 1), (0, 0)), mode="edge")
    normal = padded[1:, 1:] + padded[:-1, 1:] + padded[1:, :-1] + padded[:-1, :-1]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    least = np.inf
    for axis in (0, 1):
        for order in _ORDERS:
            if points.shape[axis] < order + 3:
                continue
            difference = np.diff(points, n=order, axis=axis)
            middle = np.take(normal, np.arange(difference.shape[axis]) + order // 2, axis=axis)
            along = np.sum(difference * middle, axis=-1)
            least = min(least, float(np.sqrt(np.mean(along**2) / comb(2 * order, order))))
    return least


@dataclass(frozen=True)
class PointSurface:
    """A smooth surface through points.

    Attributes
    ----------
    u, v : (P,), (F,) arrays
        Parameters of rows and columns, 0 to 1.
    points : (P, F, 3) array [mm]
        Points on the surface: the given or the smoothed ones.
    noise : float [mm]
        Estimated noise of the points given.
    smoothing : float [mm]
        Root mean square distance of the surface from the given points; 0 if it passes through all.
    error : float [mm]
        Estimated error along the normal, for 95 % of the flank.
    """

    u: FloatArray
    v: FloatArray
    points: FloatArray
    noise: float
    smoothing: float
    error: float

    @classmethod
    def through(
        cls, points: FloatArray, face: FloatArray | None = None, smoothing: float | None = None
    ) -> PointSurface:
        """Surface through a grid of points.

        Parameters
        ----------
        points : (P, F, 3) array [mm]
            At least `LEAST_POINTS` each way, distinct neighbours.
        face : (F,) array, optional
            Rising coordinate of the columns, which is then the parameter v.
        smoothing : float [mm], optional
            Root mean square distance that the surface keeps from the points along its normal. Default: none, or their
            noise where they are noisy.
        """
        u, heights = _chords(points, 0)
        v = _chords(points, 1)[0] if face is None else (face - face[0]) / (face[-1] - face[0])
        noise, limit = noise_of(points), _noisy(float(heights.mean()))
        target = (noise if noise > limit else 0.0) if smoothing is None else smoothing
        if target > 0.0:
            smooth = _smoothed(u, v, points, target)
            return cls(u, v, smooth, noise, target, _split_half_error(u, v, points, smooth, target))
        return cls(u, v, points, noise, 0.0, _left_out_error(u, v, points, noise if noise > 1e-3 * limit else 0.0))

    @property
    def noisy(self) -> bool:
        """Whether the points are so noisy that the surface is smoothed unless a scene states otherwise."""
        return self.noise > _noisy(float(self.profile_lengths.mean()))

    @cached_property
    def cells(self) -> FloatArray:
        """The splines of x, y and z, see `spline_cells`."""
        return spline_cells(self.u, self.v, self.points)

    @cached_property
    def profile_lengths(self) -> FloatArray:
        """Length of each column from root to tip [mm], (F,) array."""
        return _arc_lengths(self.u, self.points, 0)

    @cached_property
    def face_length(self) -> float:
        """Length of the tooth along the middle of its flank [mm]."""
        lengths = _arc_lengths(self.v, self.points, 1)
        return float(lengths[lengths.size // 2])


def _noisy(height: float) -> float:
    """Noise above which a flank of this height is smoothed [mm]."""
    return NOISY * height / _REFERENCE_HEIGHT


def _arc_lengths(parameter: FloatArray, points: FloatArray, axis: int) -> FloatArray:
    """Lengths of the lines of a grid along an axis [mm], by Simpson's rule on the spline's speed."""
    spline = CubicSpline(parameter, points, axis=axis)
    middle = 0.5 * (parameter[1:] + parameter[:-1])
    speeds = [np.linalg.norm(spline(at, 1), axis=-1) for at in (parameter, middle)]
    ends, centre = np.moveaxis(speeds[0], axis, 0), np.moveaxis(speeds[1], axis, 0)
    step = np.diff(parameter)[:, None]
    return np.asarray(np.sum(step * (ends[1:] + ends[:-1] + 4.0 * centre) / 6.0, axis=0))


def _smoothed(u: FloatArray, v: FloatArray, points: FloatArray, target: float) -> FloatArray:
    """Smoothed points, at their smoothed distance from a base surface along its normal.

    Noise within the surface has no effect and is left out.
    """
    base, normal = _base(u, v, points)
    distance = np.sum((points - base) * normal, axis=-1)
    rest = (_TARGET * target) ** 2 * distance.size
    smooth = RectBivariateSpline(u, v, distance, kx=3, ky=3, s=rest)(u, v)
    return np.asarray(base + smooth[..., None] * normal)


def _base(u: FloatArray, v: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A polynomial surface near the points, and its unit normals there."""
    degrees = [min(_BASE_DEGREE, parameter.size // 3) for parameter in (u, v)]
    x, y = 2.0 * u - 1.0, 2.0 * v - 1.0
    across, along = legendre.legvander(x, degrees[0]), legendre.legvander(y, degrees[1])
    weights = np.einsum("ap,pfc,bf->abc", np.linalg.pinv(across), points, np.linalg.pinv(along))
    slopes = [
        legendre.legvander(at, degree - 1) @ legendre.legder(np.eye(degree + 1), axis=0)
        for at, degree in ((x, degrees[0]), (y, degrees[1]))
    ]

    def surface(rows: Reals, columns: Reals) -> FloatArray:
        return np.asarray(np.einsum("pa,abc,fb->pfc", rows, weights, columns))

    normal = np.cross(surface(slopes[0], along), surface(across, slopes[1]))
    return surface(across, along), normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def _normals(u: FloatArray, v: FloatArray, points: FloatArray) -> FloatArray:
    """Unit normals at the points of a grid, (P, F, 3)."""
    normal = np.cross(CubicSpline(u, points, axis=0)(u, 1), CubicSpline(v, points, axis=1)(v, 1))
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


def _spline_at(u: FloatArray, v: FloatArray, values: FloatArray, at_u: FloatArray, at_v: FloatArray) -> FloatArray:
    return np.asarray(CubicSpline(v, CubicSpline(u, values, axis=0)(at_u), axis=1)(at_v))


def _left_out_error(u: FloatArray, v: FloatArray, points: FloatArray, noise: float) -> float:
    """Error of the spline through all points [mm]."""
    # with the last point, so that no point lies beyond the ends
    rows, columns = (np.unique(np.append(np.arange(0, size, 2), size - 1)) for size in points.shape[:2])
    coarse = _spline_at(u[rows], v[columns], points[np.ix_(rows, columns)], u, v)
    missed = np.abs(np.sum((coarse - points) * _normals(u, v, points), axis=-1))
    left_out = np.ones(missed.shape, dtype=bool)
    left_out[np.ix_(rows, columns)] = False
    typical = float(np.quantile(missed[left_out], _WITHIN))
    smooth = sqrt(max(typical**2 - (2.0 * sqrt(2.0) * noise) ** 2, 0.0)) / 2.0**_ORDER
    return float(np.hypot(smooth, 2.0 * noise))


def _split_half_error(u: FloatArray, v: FloatArray, points: FloatArray, smooth: FloatArray, target: float) -> float:
    """Error of a smoothing spline [mm]."""
    halves = []
    for first in (0, 1):
        rows = np.unique(np.concatenate([[0], np.arange(first, u.size, 2), [u.size - 1]]))
        part = _smoothed(u[rows], v, points[rows], target)
        halves.append(_spline_at(u[rows], v, part, u, v))
    apart = np.abs(np.sum((halves[1] - halves[0]) * _normals(u, v, smooth), axis=-1))
    return 0.5 * float(np.quantile(apart, _WITHIN))

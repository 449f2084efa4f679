"""Nearest nominal points of measured points: along the normal, by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from semiwear.arrays import BoolArray, FloatArray
from semiwear.measured.nominal import NominalFlank

_START = (81, 81)  # nominal points among which the search starts, along the face and the profile
_BEYOND = 0.15  # of the flank's extent, by which feet may lie beyond its ends
_DIFFERENCE = 1e-3  # mm, of the flank coordinates
_STEP = 0.1  # of the flank's extent: the longest step
_PASSES = 60
_TOLERANCE = 1e-11  # mm, times the size of the body over a metre at least
_TOGETHER = 0.1  # mm about the axis, in which the points of a flank are sought among others
_NEAR, _SETTLING = 5.0, 3  # times that: points that then tell the angle, in so many passes
_BORDER = 1e-3  # mm beyond an end that still count as on the flank


@dataclass(frozen=True)
class Feet:
    """Nominal points on whose normals measured points lie; arrays have the shape of the points.

    Attributes
    ----------
    face, profile : array [mm]
        Flank coordinates.
    deviation : array [mm]
        Along the normal, positive for material in excess (ISO 1328-1).
    inside : bool array
        Whether the foot lies on the nominal flank. Elsewhere the other entries mean nothing.
    points, normals : (..., 3) arrays [mm], [1]
    """

    face: FloatArray
    profile: FloatArray
    deviation: FloatArray
    inside: BoolArray
    points: FloatArray
    normals: FloatArray


def _nominal_net(flank: NominalFlank) -> tuple[FloatArray, FloatArray, FloatArray]:
    face, profile = flank.places(np.linspace(0.0, 1.0, _START[0])[:, None], np.linspace(0.0, 1.0, _START[1]))
    points, _ = flank.points(face, profile)
    return face.ravel(), profile.ravel(), points.reshape(-1, 3)


def around_axis(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Height along the body's axis [mm], radius [mm] and polar angle [rad] of points."""
    x, y, z = np.moveaxis(points, -1, 0)
    return z, np.hypot(x, y), np.arctan2(y, x)


def turned_by(flank: NominalFlank, points: FloatArray) -> float:
    """About how far points are turned about the axis from the nominal flank [rad].

    The median difference in polar angle from the nominal points of the same height and radius.
    """
    apart, _ = _angles_apart(flank, points)
    # the median of angles, about their mean direction
    mean = float(np.angle(np.mean(np.exp(1j * apart))))
    return mean + float(np.median((apart - mean + np.pi) % (2.0 * np.pi) - np.pi))


def turned_by_most(flank: NominalFlank, points: FloatArray) -> float:
    """The same of points of which many lie elsewhere, such as those of a whole tooth [rad].

    Where most differences in polar angle lie together: those of the tooth's other flank change from root to tip, as
    the tooth's thickness does, and those of its tip and ends are spread over that thickness.
    """
    apart, blur = _angles_apart(flank, points)
    _, radius, _ = around_axis(points.reshape(-1, 3))
    window = max(_TOGETHER / float(np.median(radius)), blur)
    once = np.sort(apart % (2.0 * np.pi))
    around = np.append(once, once + 2.0 * np.pi)
    count = np.searchsorted(around, once + window) - np.arange(once.size)
    first = int(count.argmax())
    found = float(np.median(around[first : first + count[first]]))
    for _ in range(_SETTLING):
        away = (apart - found + np.pi) % (2.0 * np.pi) - np.pi
        found += float(np.median(away[np.abs(away) < _NEAR * window]))
    return float((found + np.pi) % (2.0 * np.pi) - np.pi)


def _angles_apart(flank: NominalFlank, points: FloatArray) -> tuple[FloatArray, float]:
    """Polar angles of points less those of nominal ones beside them [rad], and how far the nominal net blurs them."""
    _, _, net = _nominal_net(flank)
    height, radius, angle = around_axis(net)
    own_height, own_radius, own_angle = around_axis(points.reshape(-1, 3))
    _, nearest = cKDTree(np.column_stack([height, radius])).query(np.column_stack([own_height, own_radius]))
    steps = [np.median(np.abs(np.diff(np.unwrap(angle.reshape(_START), axis=k), axis=k))) for k in (0, 1)]
    return own_angle - angle[nearest], float(max(steps))


def feet(flank: NominalFlank, points: FloatArray, start: Feet | None = None) -> Feet:
    """Nearest nominal points of points in the body's nominal frame.

    Parameters
    ----------
    flank : NominalFlank
    points : (..., 3) array [mm]
    start : Feet, optional
        Where the search starts; the nearest of a net of nominal points unless given.

    Notes
    -----
    Solved is X(u, v) + d n(u, v) = P for u, v and d, exact to rounding; the derivatives of X and n are central
    differences, which bend the path and not the end.
    """
    shape = points.shape[:-1]
    wanted = points.reshape(-1, 3)
    if start is None:
        face, profile, net = _nominal_net(flank)
        _, nearest = cKDTree(net).query(wanted)
        u, v = face[nearest], profile[nearest]
    else:
        u, v = start.face.ravel().copy(), start.profile.ravel().copy()
    low, high = flank.face_ends
    extent = high - low
    # the deviation is a result of the first step, which is linear in it
    deviation = np.zeros(u.size)
    last = np.full(u.size, np.inf)
    tolerance = _TOLERANCE * max(1.0, 1e-3 * float(np.abs(wanted).max()))
    for _ in range(_PASSES):
        root, tip = flank.limits(u)
        length = tip - root
        here, normal = flank.points(u, v)
        forward, backward = (flank.points(u + h, v) for h in (_DIFFERENCE, -_DIFFERENCE))
        up, down = (flank.points(u, v + h) for h in (_DIFFERENCE, -_DIFFERENCE))
        columns = [
            (a[0] - b[0] + deviation[:, None] * (a[1] - b[1])) / (2.0 * _DIFFERENCE)
            for a, b in ((forward, backward), (up, down))
        ]
        missing = wanted - here - deviation[:, None] * normal
        du, dv, dd = _solved(columns[0], columns[1], normal, missing)
        du, dv = np.clip(du, -_STEP * extent, _STEP * extent), np.clip(dv, -_STEP * length, _STEP * length)
        u_next = np.clip(u + du, low - _BEYOND * extent, high + _BEYOND * extent)
        v_next = np.clip(v + dv, root - _BEYOND * length, tip + _BEYOND * length)
        last = np.maximum(np.maximum(np.abs(u_next - u), np.abs(v_next - v)), np.abs(dd))
        u, v, deviation = u_next, v_next, deviation + dd
        if last.max(initial=0.0) <= tolerance:
            break
    root, tip = flank.limits(u)
    here, normal = flank.points(u, v)
    deviation = np.sum((wanted - here) * normal, axis=-1)
    aside = np.linalg.norm(wanted - here - deviation[:, None] * normal, axis=-1)
    on = (u >= low - _BORDER) & (u <= high + _BORDER) & (v >= root - _BORDER) & (v <= tip + _BORDER)
    inside = on & (aside <= 1e-6)
    return Feet(
        u.reshape(shape),
        v.reshape(shape),
        deviation.reshape(shape),
        inside.reshape(shape),
        here.reshape((*shape, 3)),
        normal.reshape((*shape, 3)),
    )


def _solved(
    first: FloatArray, second: FloatArray, third: FloatArray, right: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coefficients of three vectors that make a fourth (Cramer); zero where they lie in a plane. All (points, 3)."""
    volume = np.sum(np.cross(first, second) * third, axis=-1)
    flat = np.abs(volume) < 1e-9
    volume = np.where(flat, 1.0, volume)
    parts = [
        np.sum(np.cross(a, b) * c, axis=-1) / volume
        for a, b, c in ((right, second, third), (first, right, third), (first, second, right))
    ]
    return tuple(np.where(flat, 0.0, part) for part in parts)  # type: ignore[return-value]

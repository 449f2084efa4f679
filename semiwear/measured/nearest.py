"""Nearest nominal points of measured points: along the normal, by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from semiwear.arrays import BoolArray, FloatArray
from semiwear.measured.nominal import NominalFlank

_START = (81, 81)  # nominal points for the start of the search, along the face and the profile
_BEYOND = 0.15  # of the flank's extent: feet may lie this far beyond its ends
_DIFFERENCE = 1e-3  # mm, of the flank coordinates
_STEP = 0.1  # of the flank's extent: the longest step
_PASSES = 60
_TOLERANCE = 1e-11  # mm for bodies up to a metre, in proportion to their size beyond
_WINDOW = 0.1  # mm around the axis: window that holds the points of one flank
_NEAR, _MEDIAN_PASSES = 5.0, 3  # windows about the angle whose points give its median, and number of passes
_BORDER = 1e-3  # mm beyond an end that still count as on the flank


@dataclass(frozen=True)
class Feet:
    """Feet of the normals through measured points on the nominal flank; arrays have the shape of the points.

    Attributes
    ----------
    face, profile : array [mm]
        Flank coordinates.
    deviation : array [mm]
        Along the normal, positive for material in excess (ISO 1328-1).
    inside : bool array
        Whether the foot lies on the nominal flank. Elsewhere the other entries have no meaning.
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
    """Approximate rotation of points about the axis against the nominal flank [rad].

    Median difference in polar angle from the nominal points of the same height and radius.
    """
    difference, _ = _angle_differences(flank, points)
    # the median of angles, about their mean direction
    mean = float(np.angle(np.mean(np.exp(1j * difference))))
    return mean + float(np.median((difference - mean + np.pi) % (2.0 * np.pi) - np.pi))


def turned_by_most(flank: NominalFlank, points: FloatArray) -> float:
    """The same for points of which many are not on the flank, such as those of a whole tooth [rad].

    The angle at which the differences in polar angle are densest: those of the other flank vary from root to tip with
    the tooth thickness, and those of tip and ends are spread over that thickness.
    """
    difference, blur = _angle_differences(flank, points)
    _, radius, _ = around_axis(points.reshape(-1, 3))
    window = max(_WINDOW / float(np.median(radius)), blur)
    once = np.sort(difference % (2.0 * np.pi))
    twice = np.append(once, once + 2.0 * np.pi)
    count = np.searchsorted(twice, once + window) - np.arange(once.size)
    first = int(count.argmax())
    found = float(np.median(twice[first : first + count[first]]))
    for _ in range(_MEDIAN_PASSES):
        offset = (difference - found + np.pi) % (2.0 * np.pi) - np.pi
        found += float(np.median(offset[np.abs(offset) < _NEAR * window]))
    return float((found + np.pi) % (2.0 * np.pi) - np.pi)


def _angle_differences(flank: NominalFlank, points: FloatArray) -> tuple[FloatArray, float]:
    """Polar angles of points less those of the nearest nominal points, and the net's resolution of them [rad]."""
    _, _, net = _nominal_net(flank)
    net_height, net_radius, net_angle = around_axis(net)
    height, radius, angle = around_axis(points.reshape(-1, 3))
    _, nearest = cKDTree(np.column_stack([net_height, net_radius])).query(np.column_stack([height, radius]))
    steps = [np.median(np.abs(np.diff(np.unwrap(net_angle.reshape(_START), axis=k), axis=k))) for k in (0, 1)]
    return angle - net_angle[nearest], float(max(steps))


def feet(flank: NominalFlank, points: FloatArray, start: Feet | None = None) -> Feet:
    """Feet on the nominal flank of points in the body's nominal frame.

    Parameters
    ----------
    flank : NominalFlank
    points : (..., 3) array [mm]
    start : Feet, optional
        Start of the search; default the nearest of a net of nominal points.

    Notes
    -----
    X(u, v) + d n(u, v) = P is solved for u, v and d, exact to rounding; the derivatives of X and n are central
    differences, whose error slows the iteration but does not change the solution.
    """
    shape = points.shape[:-1]
    measured = points.reshape(-1, 3)
    if start is None:
        face, profile, net = _nominal_net(flank)
        _, nearest = cKDTree(net).query(measured)
        u, v = face[nearest], profile[nearest]
    else:
        u, v = start.face.ravel(), start.profile.ravel()
    low, high = flank.face_ends
    extent = high - low
    # the first step, linear in the deviation, finds it
    deviation = np.zeros(u.size)
    tolerance = _TOLERANCE * max(1.0, 1e-3 * float(np.abs(measured).max()))
    for _ in range(_PASSES):
        root, tip = flank.limits(u)
        length = tip - root
        foot, normal = flank.points(u, v)
        forward, backward = (flank.points(u + h, v) for h in (_DIFFERENCE, -_DIFFERENCE))
        up, down = (flank.points(u, v + h) for h in (_DIFFERENCE, -_DIFFERENCE))
        columns = [
            (a[0] - b[0] + deviation[:, None] * (a[1] - b[1])) / (2.0 * _DIFFERENCE)
            for a, b in ((forward, backward), (up, down))
        ]
        residual = measured - foot - deviation[:, None] * normal
        du, dv, dd = _solved(columns[0], columns[1], normal, residual)
        du, dv = np.clip(du, -_STEP * extent, _STEP * extent), np.clip(dv, -_STEP * length, _STEP * length)
        u_next = np.clip(u + du, low - _BEYOND * extent, high + _BEYOND * extent)
        v_next = np.clip(v + dv, root - _BEYOND * length, tip + _BEYOND * length)
        last = np.abs([u_next - u, v_next - v, dd]).max(initial=0.0)
        u, v, deviation = u_next, v_next, deviation + dd
        if last <= tolerance:
            break
    root, tip = flank.limits(u)
    foot, normal = flank.points(u, v)
    deviation = np.sum((measured - foot) * normal, axis=-1)
    aside = np.linalg.norm(measured - foot - deviation[:, None] * normal, axis=-1)
    on = (u >= low - _BORDER) & (u <= high + _BORDER) & (v >= root - _BORDER) & (v <= tip + _BORDER)
    inside = on & (aside <= 1e-6)
    return Feet(
        u.reshape(shape),
        v.reshape(shape),
        deviation.reshape(shape),
        inside.reshape(shape),
        foot.reshape((*shape, 3)),
        normal.reshape((*shape, 3)),
    )


def _solved(
    first: FloatArray, second: FloatArray, third: FloatArray, right: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coefficients of the linear combination of three vectors that equals `right` (Cramer's rule), (points, 3) each.

    Zero where the three vectors are coplanar.
    """
    volume = np.sum(np.cross(first, second) * third, axis=-1)
    flat = np.abs(volume) < 1e-9
    volume = np.where(flat, 1.0, volume)
    parts = [
        np.sum(np.cross(a, b) * c, axis=-1) / volume
        for a, b, c in ((right, second, third), (first, right, third), (first, second, right))
    ]
    return tuple(np.where(flat, 0.0, part) for part in parts)  # type: ignore[return-value]

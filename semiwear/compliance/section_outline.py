"""The outline of a tooth section as stations: element corners along flank, fillet and root land.

`section_mesh` builds its blocks from them, in a frame in which the rim is a rectangle. Outlines that cannot be meshed
are refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from semiwear.arrays import FloatArray
from semiwear.errors import SemiwearError
from semiwear.geometry.section import RackRim, RingRim, ToothSection

TOWARDS_FILLET = 1.6
"""Exponent of the spacing of load heights from the fillet to the tip."""


_LEAST_FILLET = 1e-5  # of the flank's length: a shorter fillet is a corner
_LEAST_TURNING = 0.1  # least turning of a fillet for which its middle is defined [rad]
_SHORTEST_LAND = 0.02  # of an element of the fillet, where the number of land elements is given


class SectionMeshError(SemiwearError, ValueError):
    """A tooth section cannot be meshed; the message names the section and the location."""


class Plane:
    """Coordinates in which the rim is a rectangle: (x, y) of a rack."""

    def from_xy(self, xy: FloatArray) -> FloatArray:
        """Coordinates of points (..., 2) [mm]."""
        return xy

    def to_xy(self, coordinates: FloatArray) -> FloatArray:
        """Points (..., 2) of coordinates [mm]."""
        return coordinates


class Polar(Plane):
    """Coordinates in which the rim is a rectangle: (angle from the y axis, radius) of a ring."""

    def from_xy(self, xy: FloatArray) -> FloatArray:
        """Coordinates of points (..., 2) [mm]."""
        return np.stack([np.arctan2(xy[..., 0], xy[..., 1]), np.hypot(xy[..., 0], xy[..., 1])], axis=-1)

    def to_xy(self, coordinates: FloatArray) -> FloatArray:
        """Points (..., 2) [mm] at coordinates."""
        angle, radius = coordinates[..., 0], coordinates[..., 1]
        return np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=-1)


def frame_of(section: ToothSection) -> Plane:
    """The frame of a section's rim."""
    return Polar() if isinstance(section.rim, RingRim) else Plane()


def load_heights(count: int) -> FloatArray:
    """Load heights as shares of the flank's profile, from its lower end to its tip, (count,) array.

    They are denser towards the fillet, whose stress changes fastest with the height of a load beside it.
    """
    return (np.arange(count) / (count - 1)) ** TOWARDS_FILLET


@dataclass(frozen=True)
class _Curve:
    """Smooth curve through points, by chord length."""

    length: FloatArray
    spline: CubicSpline

    @classmethod
    def through(cls, points: FloatArray) -> _Curve:
        steps = np.hypot(*np.diff(points, axis=0).T)
        keep = np.concatenate([[True], steps > 1e-9 * steps.sum()])
        length = np.concatenate([[0.0], np.cumsum(steps)])[keep]
        return cls(length, CubicSpline(length, points[keep]))

    def tangent(self, at: FloatArray) -> FloatArray:
        derivative = self.spline(at, 1)
        return np.asarray(derivative / np.linalg.norm(derivative, axis=-1, keepdims=True))


def midpoints(corners: FloatArray) -> FloatArray:
    """Corner stations of elements -> corner and middle stations."""
    stations = np.empty(2 * len(corners) - 1)
    stations[::2] = corners
    stations[1::2] = (corners[1:] + corners[:-1]) / 2
    return stations


def flank_stations(section: ToothSection, heights: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Profile coordinates (upwards), points with middles (downwards) and inward normals (upwards)."""
    curve = _Curve.through(section.flank)
    chords = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(section.flank, axis=0).T))])
    low, tip = section.flank_profile[[-1, 0]]
    profile = low + (tip - low) * load_heights(heights)
    sign = np.sign(section.flank_profile[-1] - section.flank_profile[0])
    order = CubicSpline(sign * section.flank_profile, chords)
    corners = order(sign * profile[::-1])
    corners[[0, -1]] = curve.length[[0, -1]]
    tangent = curve.tangent(corners)[::-1]  # pointing down
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    return profile, curve.spline(midpoints(corners)), normal


def fillet_stations(section: ToothSection, elements: int) -> FloatArray:
    """Points along the fillet, as many elements before as after the middle of its turning."""
    curve = _Curve.through(section.fillet)
    fine, turning = _turning(curve)
    turned = turning / turning[-1] if turning[-1] > _LEAST_TURNING else fine / fine[-1]
    middle = np.interp(0.5, turned, fine)
    middle = np.clip(middle, 0.15 * fine[-1], 0.85 * fine[-1])
    stations = []
    for start, end in ((0.0, middle), (middle, fine[-1])):
        part = np.linspace(start, end, 201)
        bend = np.interp(part, fine, turned)
        even = (part - start) / (end - start) + (bend - bend[0]) / max(bend[-1] - bend[0], 1e-12)
        corners = np.interp(np.linspace(0.0, even[-1], elements // 2 + 1), even, part)
        stations.append(midpoints(corners))
    return np.asarray(curve.spline(np.concatenate([stations[0], stations[1][1:]])))


def _turning(curve: _Curve) -> tuple[FloatArray, FloatArray]:
    """Positions along a curve [mm] and the turning of its tangent up to there [rad]."""
    fine = np.linspace(0.0, curve.length[-1], 401)
    tangent = curve.tangent(fine)
    angle = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    return fine, np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])


def least_radius(section: ToothSection) -> float:
    """Least radius [mm] of a fillet, from the shortest piece with a quarter of its turning."""
    place, turning = _turning(_Curve.through(section.fillet))
    if turning[-1] < _LEAST_TURNING:
        return np.inf
    quarter = 0.25 * turning[-1]
    start = np.linspace(0.0, turning[-1] - quarter, 201)
    piece = np.interp(start + quarter, turning, place) - np.interp(start, turning, place)
    return float(piece.min() / quarter)


def root_land(
    section: ToothSection, fillet: FloatArray, frame: Plane, fillet_elements: int, elements: int | None = None
) -> FloatArray:
    """Points from the end of the fillet (left out) to mid-space, on a number of elements.

    Without a number it follows from the length of the land, and a fillet that ends very near mid-space is moved to
    it.
    """
    end = frame.from_xy(fillet[-1])
    middle = np.array([_half_pitch(section), end[1]])
    length = np.linalg.norm(frame.to_xy(middle) - fillet[-1])
    size = np.linalg.norm(np.diff(fillet, axis=0), axis=1).sum() / fillet_elements
    if elements is None and length < 0.1 * size:
        fillet[-1] = frame.to_xy(middle)
        return np.empty((0, 2))
    if length < _SHORTEST_LAND * size:  # the land is required: the fillet, flat there, ends that much earlier
        fillet[-1] = frame.to_xy(middle - np.array([_SHORTEST_LAND * size, 0.0]) / _per_mm(section, middle))
        end = frame.from_xy(fillet[-1])
    count = elements or int(np.clip(round(0.7 * length / size), 1, 4))
    along = np.linspace(0.0, 1.0, 2 * count + 1)[1:, None]
    return frame.to_xy(end + along * (middle - end))


def _per_mm(section: ToothSection, point: FloatArray) -> float:
    """Millimetres across for a unit of the frame's first coordinate: 1 for a rack, the radius for a ring."""
    return float(point[1]) if isinstance(section.rim, RingRim) else 1.0


def _half_pitch(section: ToothSection) -> float:
    """Half a pitch in the coordinates of the frame: length for a rack, angle for a ring."""
    rim = section.rim
    return np.pi / rim.teeth if isinstance(rim, RingRim) else rim.pitch / 2


def foot_height(section: ToothSection) -> float:
    """Height (radius) of the held face."""
    rim = section.rim
    return rim.bore_radius if isinstance(rim, RingRim) else rim.back_height


def point_below_tooth(section: ToothSection, fillet: FloatArray, middle: int) -> float:
    """Height of C, where the normal of the outline at M meets the centre line, but well inside the rim.

    On a deep rim it stays near the tooth, since the few elements from M to C set the size of those at the fillet.
    """
    x, y = fillet[middle]
    tangent = fillet[middle + 1] - fillet[middle - 1]
    normal_foot = y + x * tangent[0] / tangent[1] if tangent[1] < -1e-3 * tangent[0] else -np.inf
    foot = foot_height(section)
    # on a ring the root bends down from the centre line, by more than a thin rim's thickness
    root = max(min(y, fillet[-1, 1]), 0.5 * (foot + frame_of(section).from_xy(fillet[-1])[1]))
    rim = root - foot
    return float(np.clip(normal_foot, root - 0.5 * rim, root - min(0.2 * rim, 0.5 * x)))


def check_outline(section: ToothSection, name: str) -> None:
    """Raise a `SectionMeshError` if the outline or rim is impossible."""
    outline = np.vstack([section.flank, section.fillet])
    if not np.isfinite(outline).all():
        raise SectionMeshError(f"{name}: the outline holds values that are not finite")
    steps = np.diff(section.flank_profile)
    if len(section.flank_profile) != len(section.flank) or not (np.all(steps > 0) or np.all(steps < 0)):
        raise SectionMeshError(f"{name}: flank_profile must be monotonic, one value a flank point")
    if (outline[:, 0] <= 0).any():
        x, y = outline[np.argmin(outline[:, 0])]
        raise SectionMeshError(
            f"{name}: the tooth is pointed or the outline crosses the centre line (x = {x:.4g} mm at "
            f"y = {y:.4g} mm); lower the tip or cut the section elsewhere"
        )
    flank, fillet = (np.hypot(*np.diff(part, axis=0).T).sum() for part in (section.flank, section.fillet))
    if fillet < _LEAST_FILLET * flank:
        raise SectionMeshError(
            f"{name}: flank and root meet in a sharp corner, in which stress has no limit; round the fillet"
        )
    frame = frame_of(section)
    across, height = frame.from_xy(section.fillet[-1])
    if across > _half_pitch(section) * (1 + 1e-6):
        raise SectionMeshError(f"{name}: the fillet passes the middle of the tooth space")
    if isinstance(section.rim, RackRim) or section.rim.bore_radius > 0:
        if height - foot_height(section) > 0:
            return
        raise SectionMeshError(
            f"{name}: the held face at {foot_height(section):.4g} mm lies above the root at {height:.4g} mm; "
            "make the rim thicker"
        )
    raise SectionMeshError(f"{name}: the bore radius must be above zero")

"""Unloaded tooth contact analysis: a minimum of the separation, never a root (design, section 4).

For a roll position the flanks first touch where the separation is least. Over a grid of slices that place cannot be
missed; Newton then polishes it, and its step is only taken where it lowers the separation. Inside the borders of
both flanks it is a point of the path of contact; where the least separation lies on a border an edge touches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.meshing.flank_pair import Borders, FlankPair

__all__ = ["ContactPoints", "UnloadedContact", "contact_points", "nearest_separation", "unloaded_contact"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_SLICES = 41  # of the grid that starts the search
_SEARCH = (-3, 3, 16)  # first and last roll position between which a path is looked for, steps to a roll
_NEWTON_PASSES = 8
_FACE_STEP = 3e-4  # of the face width, for differences
_PROFILE_STEP = 5e-4  # of the tooth height
_ON_BORDER = 1e-6  # of the flank's height


@dataclass(frozen=True)
class ContactPoints:
    """Points of least separation, one for each roll position.

    Attributes
    ----------
    face, profile : (K,) arrays [mm]
    separation : (K,) array [mm]
    position : (K, 3) array [mm]
        In the fixed frame.
    inside : (K,) bool array
        Not on a border of either flank.
    margin : (K,) array [mm]
        Distance of the unbounded minimum to the nearest border, in face or profile coordinate; negative outside.
    curvature : (K, 2) array [1/mm]
        Relative principal curvatures, along and across the contact ellipse.
    along : (K, 3) array
        Unit vector of the long axis of the contact ellipse.
    """

    face: FloatArray
    profile: FloatArray
    separation: FloatArray
    position: FloatArray
    inside: BoolArray
    margin: FloatArray
    curvature: FloatArray
    along: FloatArray


@dataclass(frozen=True)
class UnloadedContact:
    """Path of contact of one tooth pair.

    Attributes
    ----------
    roll : (K,) array
        Roll positions from the first to the last contact.
    points : ContactPoints
    transmission_error : (K,) array [arcsec]
        Driven side, positive when the driven body leads; its mean over the path is the zero.
    contact_ratio : float
    """

    roll: FloatArray
    points: ContactPoints
    transmission_error: FloatArray
    contact_ratio: float


def _margin(pair: FlankPair, face: FloatArray, profile: FloatArray, roll: FloatArray, borders: Borders) -> FloatArray:
    """Distance to the nearest border of either flank [mm], negative outside."""
    met = pair.meeting(face, profile, roll)
    distances = (
        profile - borders.root,
        borders.tip - profile,
        face - borders.face[0],
        borders.face[1] - face,
        met.partner_face - borders.partner_face[0],
        borders.partner_face[1] - met.partner_face,
        borders.partner_tip - met.partner_profile,
    )
    return np.min(np.stack(np.broadcast_arrays(*distances)), axis=0)


def contact_points(pair: FlankPair, roll: FloatArray) -> ContactPoints:
    """Where a pair first touches at roll positions, within the nominal (sharp) borders of both flanks."""
    roll = np.asarray(roll, float)
    low, high = pair.face_limits
    stations = np.linspace(low, high, _SLICES)
    lines = trace_contact_lines(pair, roll, stations, sharp=True)
    best = np.argmin(lines.separation[0], axis=1)
    rows = np.arange(roll.size)
    held_face, held_profile = stations[best], lines.profile[rows, best]
    held = lines.separation[0][rows, best]

    height = float(np.mean(lines.high - lines.low))
    step = np.array([_FACE_STEP * (high - low), _PROFILE_STEP * height])
    face, profile = held_face.copy(), held_profile.copy()
    for _ in range(_NEWTON_PASSES):
        gradient, hessian, _ = _derivatives(pair, face, profile, roll, step)
        move = _newton(gradient, hessian)
        # no farther than a tenth of the flank in one pass, nor off the surface's domain
        move = np.clip(move, -0.1 * np.array([high - low, height]), 0.1 * np.array([high - low, height]))
        face = np.clip(face + move[:, 0], low - 0.02 * (high - low), high + 0.02 * (high - low))
        profile = profile + move[:, 1]
        borders = pair.borders(face, sharp=True)
        profile = np.clip(profile, borders.root - 0.3 * height, borders.tip + 0.3 * height)
    margin = _margin(pair, face, profile, roll, pair.borders(face, sharp=True))
    separation = pair.meeting(face, profile, roll).separation
    inside = (margin >= -_ON_BORDER * height) & (separation <= held + _ON_BORDER * 1e-2 * height)
    face, profile = np.where(inside, face, held_face), np.where(inside, profile, held_profile)
    _, hessian, tangents = _derivatives(pair, face, profile, roll, step)
    curvature, along = _principal(hessian, tangents)
    met = pair.meeting(face, profile, roll)
    return ContactPoints(
        face=face,
        profile=profile,
        separation=met.separation,
        position=met.position,
        inside=inside,
        margin=margin,
        curvature=curvature,
        along=along,
    )


def _derivatives(
    pair: FlankPair, face: FloatArray, profile: FloatArray, roll: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gradient (K, 2) and Hessian (K, 2, 2) of the separation by face and profile, and tangents (K, 2, 3)."""
    offset = np.array([-1.0, 0.0, 1.0])
    f = face[:, None, None] + step[0] * offset[:, None]
    p = profile[:, None, None] + step[1] * offset
    met = pair.meeting(f, p, roll[:, None, None])
    s, x = met.separation, met.position
    gradient = np.stack([(s[:, 2, 1] - s[:, 0, 1]) / (2 * step[0]), (s[:, 1, 2] - s[:, 1, 0]) / (2 * step[1])], -1)
    ff = (s[:, 2, 1] - 2 * s[:, 1, 1] + s[:, 0, 1]) / step[0] ** 2
    pp = (s[:, 1, 2] - 2 * s[:, 1, 1] + s[:, 1, 0]) / step[1] ** 2
    fp = (s[:, 2, 2] - s[:, 2, 0] - s[:, 0, 2] + s[:, 0, 0]) / (4 * step[0] * step[1])
    hessian = np.stack([np.stack([ff, fp], -1), np.stack([fp, pp], -1)], -2)
    tangents = np.stack(
        [(x[:, 2, 1] - x[:, 0, 1]) / (2 * step[0]), (x[:, 1, 2] - x[:, 1, 0]) / (2 * step[1])], axis=1
    )
    return gradient, hessian, tangents


def _newton(gradient: FloatArray, hessian: FloatArray) -> FloatArray:
    """Newton step where the separation is convex, steepest descent by profile elsewhere."""
    determinant = hessian[:, 0, 0] * hessian[:, 1, 1] - hessian[:, 0, 1] ** 2
    convex = (determinant > 0.0) & (hessian[:, 0, 0] > 0.0)
    safe = np.where(convex, determinant, 1.0)
    newton = -np.stack(
        [
            (hessian[:, 1, 1] * gradient[:, 0] - hessian[:, 0, 1] * gradient[:, 1]) / safe,
            (hessian[:, 0, 0] * gradient[:, 1] - hessian[:, 0, 1] * gradient[:, 0]) / safe,
        ],
        axis=-1,
    )
    return np.where(convex[:, None], newton, -np.sign(gradient) * np.array([1.0, 0.1]))


def _principal(hessian: FloatArray, tangents: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal relative curvatures (smaller first) and the direction of the first, from both fundamental forms."""
    first_form = tangents @ tangents.transpose(0, 2, 1)
    root = np.linalg.cholesky(first_form)
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ hessian @ inverse.transpose(0, 2, 1))
    coordinates = inverse.transpose(0, 2, 1) @ vectors[:, :, :1]
    along = (coordinates[:, :, 0][:, :, None] * tangents).sum(axis=1)
    return values, along / np.linalg.norm(along, axis=1)[:, None]


def _ends(pair: FlankPair) -> tuple[float, float]:
    """First and last roll position at which the pair touches inside its borders; or, if never, at which it leads."""
    start, stop, per_roll = _SEARCH
    count = (stop - start) * per_roll + 1
    roll = np.linspace(start, stop, count)
    points = contact_points(pair, roll)
    if points.inside.any():
        middle = int(np.argmax(np.where(points.inside, points.margin, -np.inf)))

        def margin(at: float) -> float:
            return float(contact_points(pair, np.array([at])).margin[0])

        first = last = middle
        while first > 0 and points.inside[first - 1]:
            first -= 1
        while last < count - 1 and points.inside[last + 1]:
            last += 1
        low = roll[first] if first == 0 else _cross(margin, roll[first - 1], roll[first])
        high = roll[last] if last == count - 1 else _cross(margin, roll[last], roll[last + 1])
        return low, high
    # an edge touches throughout: the pair counts from where it takes over from its neighbour to where it hands on
    padded = np.pad(points.separation, per_roll, constant_values=np.inf)
    neighbours = np.minimum(padded[: -2 * per_roll], padded[2 * per_roll :])
    leading = np.flatnonzero(points.separation <= neighbours)
    return float(roll[leading[0]]), float(roll[leading[-1]])


def _cross(function, low: float, high: float) -> float:  # type: ignore[no-untyped-def]
    """Zero of a function between two places, or the better of them where it has no change of sign."""
    a, b = function(low), function(high)
    if a * b > 0.0:
        return low if abs(a) < abs(b) else high
    return float(brentq(function, low, high, xtol=1e-9))


def unloaded_contact(pair: FlankPair, count: int = 41) -> UnloadedContact:
    """Path of contact from first to last touch at `count` roll positions."""
    low, high = _ends(pair)
    roll = np.linspace(low, high, count)
    points = contact_points(pair, roll)
    error = -points.separation * pair.arcsec_per_mm
    return UnloadedContact(roll, points, error - error.mean(), high - low)


def nearest_separation(pair: FlankPair, roll: FloatArray, slices: int = 15) -> FloatArray:
    """Least separation over the flank at roll positions [mm], roughly: between few slices only."""
    return trace_contact_lines(pair, roll, face_stations(pair, slices)).separation[0].min(axis=1)

"""Unloaded tooth contact analysis: a minimum of the separation, never a root (design, section 4).

For a roll position the flanks first touch where the separation is least. A grid of slices gives a first guess, which
Newton's method refines; its step is only taken where it lowers the separation. Inside the borders of
both flanks it is a point of the path of contact; where the least separation lies on a border an edge touches. Flanks
that touch along a whole line have no such point: the middle of its part within all borders is taken instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import SceneError
from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.meshing.flank_pair import Borders, FlankPair, reference_lever
from semiwear.meshing.least_separation import short_steps

_SLICES = 41  # of the first grid of the search
_SEARCH = (-3, 3, 16)  # first and last roll position of the search for a path, steps per roll
_VALLEY_PASSES = 2  # across the flank alone, before those along it
_NEWTON_PASSES = 8
_STEPS = (3e-4, 5e-4)  # of face width and height, for gradients, whose error is the square of the step
_ON_BORDER = 1e-6  # of the flank's height
_FLAT = 1e-5  # ratio of curvatures along and across below which flanks touch along a line
_EVEN = 1e-7  # of the flank's height: change of the separation along such a line, from one slice to the next
_HALVINGS = 20
_THIRDS = 24  # cuts by a third, from two station distances to 1e-4 of one
_SETTLED = 1e-10  # of face width and height: shorter steps end the search
_CLOSE = 1e-7  # of a step along the profile: likewise
_BACK_TRACKS = 8  # halvings of a step that raises the separation
_EQUAL = 1e-9  # of the flank's height: separations this close count as equal, within the error of gradients
_SHORTEST = 0.03  # of the steps for gradients: rounding leaves 1e-7/mm of curvatures
_NO_MARGIN = 1e-9  # mm: on a border


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
        met.driving_face - borders.driving_face[0],
        borders.driving_face[1] - met.driving_face,
        borders.driving_tip - met.driving_profile,
    )
    return np.asarray(np.min(np.stack(np.broadcast_arrays(*distances)), axis=0))


def contact_points(pair: FlankPair, roll: FloatArray) -> ContactPoints:
    """Points of first touch of a pair at roll positions, within the nominal (sharp) borders of both flanks."""
    roll = np.asarray(roll, float)
    low, high = pair.face_limits
    stations = np.linspace(low, high, _SLICES)
    lines = trace_contact_lines(pair, roll, stations, sharp=True)
    best = np.argmin(lines.separation[0], axis=1)
    rows = np.arange(roll.size)
    held_face, held_profile = stations[best], lines.profile[rows, best]
    held = lines.separation[0][rows, best]

    height = float(np.mean(lines.high - lines.low))
    size = np.array([high - low, height])
    face, profile = held_face.copy(), held_profile.copy()
    for done in range(_NEWTON_PASSES):
        gradient, hessian, _ = _derivatives(pair, face, profile, roll, np.array(_STEPS) * size)
        # line contact can be recognised in the valley only, not beside it on a border
        newton = _into_valley(gradient, hessian) if done < _VALLEY_PASSES else _newton(gradient, hessian)
        # no farther than a tenth of the flank in one pass
        move = np.clip(newton, -0.1 * size, 0.1 * size)
        if done >= _VALLEY_PASSES and np.all(np.abs(move) <= _SETTLED * size):
            break
        face, profile = _lowered(pair, face, profile, roll, move, height)
    straight = np.flatnonzero(_is_flat(hessian))
    if straight.size:
        face[straight], profile[straight] = _middle_of_line(
            pair, roll[straight], stations, lines.profile[straight], _STEPS[1] * height, _EVEN * height
        )
    margin = _margin(pair, face, profile, roll, pair.borders(face, sharp=True))
    separation = pair.meeting(face, profile, roll).separation
    gradient, hessian, _ = _derivatives(pair, face, profile, roll, np.array(_STEPS) * size)
    above = np.full(roll.size, _ON_BORDER * 1e-2 * height)
    # misaligned flanks: an edge is nearer up to the station beside the end of the line
    above[straight] = _EVEN * height + np.abs(gradient[straight, 0]) * (stations[1] - stations[0])
    # where a search ended on a border without a minimum there, an edge touches
    least = np.all(np.abs(_newton(gradient, hessian)) <= _ON_BORDER * size, axis=1)
    inside = (margin >= -_ON_BORDER * height) & (separation <= held + above)
    inside &= (margin > _ON_BORDER * height) | least
    face, profile = np.where(inside, face, held_face), np.where(inside, profile, held_profile)
    for_curvature = np.array(pair.difference_steps) * size
    (_, once, short), (_, twice, long) = (
        _derivatives(pair, face, profile, roll, factor * for_curvature) for factor in (1.0, 2.0)
    )
    # Richardson extrapolation: errors of the second order in the step cancel
    curvature, along = _principal((4.0 * once - twice) / 3.0, (4.0 * short - long) / 3.0)
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
    """Gradient (K, 2) and Hessian (K, 2, 2) of the separation by face and profile, and tangents (K, 2, 3).

    Steps (2,) [mm] are shorter near a base circle, both in the same proportion.
    """
    longest = float(step.max())
    shorter = short_steps(pair, face, profile, roll, longest) / longest
    step = step[:, None] * np.maximum(shorter, _SHORTEST)
    offset = np.array([-1.0, 0.0, 1.0])
    f = face[:, None, None] + step[0][:, None, None] * offset[:, None]
    p = profile[:, None, None] + step[1][:, None, None] * offset
    met = pair.meeting(f, p, roll[:, None, None])
    s, x = met.separation, met.position
    gradient = np.stack([(s[:, 2, 1] - s[:, 0, 1]) / (2 * step[0]), (s[:, 1, 2] - s[:, 1, 0]) / (2 * step[1])], -1)
    ff = (s[:, 2, 1] - 2 * s[:, 1, 1] + s[:, 0, 1]) / step[0] ** 2
    pp = (s[:, 1, 2] - 2 * s[:, 1, 1] + s[:, 1, 0]) / step[1] ** 2
    fp = (s[:, 2, 2] - s[:, 2, 0] - s[:, 0, 2] + s[:, 0, 0]) / (4 * step[0] * step[1])
    hessian = np.stack([np.stack([ff, fp], -1), np.stack([fp, pp], -1)], -2)
    along, across = step[:, :, None]
    tangents = np.stack([(x[:, 2, 1] - x[:, 0, 1]) / (2 * along), (x[:, 1, 2] - x[:, 1, 0]) / (2 * across)], axis=1)
    return gradient, hessian, tangents


def _lowered(
    pair: FlankPair, face: FloatArray, profile: FloatArray, roll: FloatArray, move: FloatArray, height: float
) -> tuple[FloatArray, FloatArray]:
    """Places (face, profile) moved by (K, 2) [mm], or by a fraction of it with which the separation does not grow."""
    low, high = pair.face_limits
    margin = 0.02 * (high - low)
    most = pair.meeting(face, profile, roll).separation + _EQUAL * height
    pending = np.ones(roll.size, dtype=bool)
    for fraction in 0.5 ** np.arange(_BACK_TRACKS):
        # within the surface's domain
        there = np.clip(face + fraction * move[:, 0], low - margin, high + margin)
        borders = pair.borders(there, sharp=True)
        up = np.clip(profile + fraction * move[:, 1], borders.root - 0.3 * height, borders.tip + 0.3 * height)
        lower = pending & (pair.meeting(there, up, roll).separation <= most)
        face, profile = np.where(lower, there, face), np.where(lower, up, profile)
        pending &= ~lower
        if not pending.any():
            break
    return face, profile


def _middle_of_line(
    pair: FlankPair, roll: FloatArray, stations: FloatArray, profile: FloatArray, step: float, even: float
) -> tuple[FloatArray, FloatArray]:
    """Face and profile of the middle of the part of a straight contact line that lies within all borders.

    Parameters
    ----------
    pair : FlankPair
    roll : (K,) array
    stations : (S,) array [mm]
        Face stations between which no contact is missed.
    profile : (K, S) array [mm]
        About the least separation in each slice.
    step : float [mm]
        For differences by the profile coordinate; shorter near a base circle.
    even : float [mm]
        Most that the separation may vary along a line.

    Returns
    -------
    face, profile : (K,) arrays [mm]
        Those of the station that is least outside, if no part lies within the borders.
    """

    def valley(
        face: FloatArray, at: FloatArray, rolls: FloatArray, passes: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Least place near `at`, its separation and its distance to the nearest border; -inf without a minimum."""
        for _ in range(passes):
            short = short_steps(pair, face, at, rolls, step)
            places = at[..., None] + short[..., None] * np.array([-1.0, 0.0, 1.0])
            near = pair.meeting(face[..., None], places, rolls[..., None])
            low, middle, high = np.moveaxis(near.separation, -1, 0)
            bend = low - 2.0 * middle + high
            move = np.where(bend > 0.0, 0.5 * short * (high - low) / np.where(bend > 0.0, bend, 1.0), np.inf)
            at = at - np.where(bend > 0.0, move, 0.0)
            if np.all((bend <= 0.0) | (np.abs(move) <= _CLOSE * step)):
                break
        borders = pair.borders(face.ravel(), sharp=True)
        shaped = replace(borders, root=borders.root.reshape(face.shape), tip=borders.tip.reshape(face.shape))
        margin = np.where(np.abs(move) < short, _margin(pair, face, at, rolls, shaped), -np.inf)
        return at, pair.meeting(face, at, rolls).separation, margin

    rows = np.arange(roll.size)
    face = np.broadcast_to(stations, profile.shape)
    rolls = np.broadcast_to(roll[:, None], profile.shape)
    profile, separation, margin = valley(face, profile, rolls, _NEWTON_PASSES)
    last = stations.size - 1
    # a line shorter than the distance of stations is found where it lies deepest within the borders
    lone = np.flatnonzero(np.all(margin < 0.0, axis=1))
    if lone.size:
        face, at = face.copy(), np.argmax(margin[lone], axis=1)
        low, high = stations[np.maximum(at - 1, 0)], stations[np.minimum(at + 1, last)]
        start = profile[lone, at]
        for _ in range(_THIRDS):
            thirds = low + (high - low) / 3.0, high - (high - low) / 3.0
            lower, upper = (valley(third, start, roll[lone], _NEWTON_PASSES // 2)[2] for third in thirds)
            low, high = np.where(upper > lower, thirds[0], low), np.where(upper > lower, high, thirds[1])
        face[lone, at] = 0.5 * (low + high)
        found = valley(face[lone, at], start, roll[lone], _NEWTON_PASSES)
        profile[lone, at], separation[lone, at], margin[lone, at] = found
    least = np.min(np.where(margin >= 0.0, separation, np.inf), axis=1)
    counts = (margin >= 0.0) & (separation <= least[:, None] + even)
    first = np.argmax(counts, axis=1), last - np.argmax(counts[:, ::-1], axis=1)
    ends, gaps = [], []
    for index, towards in zip(first, (-1, 1), strict=True):
        good, bad = face[rows, index], face[rows, np.clip(index + towards, 0, last)]
        start, gap_there = profile[rows, index], separation[rows, index]
        for _ in range(_HALVINGS):
            half = 0.5 * (good + bad)
            start, gap, left = valley(half, start, roll, _NEWTON_PASSES // 2)
            touches = (left >= 0.0) & (gap <= least + even)
            good, bad = np.where(touches, half, good), np.where(touches, bad, half)
            gap_there = np.where(touches, gap, gap_there)
        ends.append(good)
        gaps.append(gap_there)
    found = counts.any(axis=1)
    index = np.where(found, (first[0] + first[1]) // 2, np.argmax(margin, axis=1))
    # misaligned flanks touch at one end of the line
    lean = gaps[1] - gaps[0]
    part = np.where(np.abs(lean) <= 2.0 * even, 0.5, np.where(lean < 0.0, 1.0, 0.0))
    middle = np.where(found, ends[0] + part * (ends[1] - ends[0]), face[rows, index])
    return middle, valley(middle, profile[rows, index], roll, _NEWTON_PASSES)[0]


def _is_flat(hessian: FloatArray) -> BoolArray:
    """Whether the separation is curved across the flanks only."""
    across = hessian[:, 1, 1]
    determinant = hessian[:, 0, 0] * across - hessian[:, 0, 1] ** 2
    return (across > 0.0) & (np.abs(determinant) <= _FLAT * across**2)


def _into_valley(gradient: FloatArray, hessian: FloatArray) -> FloatArray:
    """Newton step in the profile alone where the separation is convex across the flank, zero elsewhere."""
    across = hessian[:, 1, 1]
    convex = across > 0.0
    move = np.where(convex, -gradient[:, 1] / np.where(convex, across, 1.0), 0.0)
    return np.stack([np.zeros_like(move), move], axis=-1)


def _newton(gradient: FloatArray, hessian: FloatArray) -> FloatArray:
    """Newton step where the separation is convex, in the profile alone where it is flat, else steepest descent."""
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
    flat = _is_flat(hessian)
    across = np.where(flat, hessian[:, 1, 1], 1.0)
    newton = np.where(flat[:, None], np.stack([0.0 * across, -gradient[:, 1] / across], axis=-1), newton)
    return np.where((convex | flat)[:, None], newton, -np.sign(gradient) * np.array([1.0, 0.1]))


def _principal(hessian: FloatArray, tangents: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal relative curvatures (smaller first) and the direction of the first, from both fundamental forms."""
    first_form = tangents @ tangents.transpose(0, 2, 1)
    root = np.linalg.cholesky(first_form)
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ hessian @ inverse.transpose(0, 2, 1))
    coordinates = inverse.transpose(0, 2, 1) @ vectors[:, :, :1]
    along = (coordinates[:, :, 0][:, :, None] * tangents).sum(axis=1)
    return values, along / np.linalg.norm(along, axis=1)[:, None]


@lru_cache(maxsize=8)
def _ends(pair: FlankPair) -> tuple[float, float]:
    """First and last roll position at which the pair touches inside its borders, or else is the nearest pair."""
    start, stop, per_roll = _SEARCH
    count = (stop - start) * per_roll + 1
    roll = np.linspace(start, stop, count)
    points = contact_points(pair, roll)
    if points.inside.any():
        middle = int(np.argmax(np.where(points.inside, points.margin, -np.inf)))

        def margin(at: float) -> float:
            point = contact_points(pair, np.array([at]))
            found = float(point.margin[0])
            # on a border the end of a line touches, a failed search does not: the margin cannot distinguish them
            if abs(found) <= _NO_MARGIN:
                found = _NO_MARGIN
            return found if point.inside[0] else min(found, -_NO_MARGIN)

        first = last = middle
        while first > 0 and points.inside[first - 1]:
            first -= 1
        while last < count - 1 and points.inside[last + 1]:
            last += 1
        low = roll[first] if first == 0 else _cross(margin, roll[first - 1], roll[first])
        high = roll[last] if last == count - 1 else _cross(margin, roll[last], roll[last + 1])
        return low, high
    # an edge touches throughout: the pair counts while it is nearer than its neighbours
    padded = np.pad(points.separation, per_roll, constant_values=np.inf)
    neighbours = np.minimum(padded[: -2 * per_roll], padded[2 * per_roll :])
    leading = np.flatnonzero(points.separation <= neighbours)
    return float(roll[leading[0]]), float(roll[leading[-1]])


def _cross(function, low: float, high: float) -> float:  # type: ignore[no-untyped-def]
    """Zero of a function between two arguments, or the better of them if the sign does not change."""
    a, b = function(low), function(high)
    if a * b > 0.0:
        return low if abs(a) < abs(b) else high
    return float(brentq(function, low, high, xtol=1e-9))


def unloaded_contact(pair: FlankPair, count: int = 41) -> UnloadedContact:
    """Path of contact from first to last touch at `count` roll positions.

    Raises
    ------
    SceneError
        If the flanks do not meet.
    """
    separation_of_neighbours(pair, _SEARCH[1], _SEARCH[2])
    low, high = _ends(pair)
    roll = np.linspace(low, high, count)
    points = contact_points(pair, roll)
    error = -points.separation * (reference_lever(pair) / pair.lever_arm(points.position)) * pair.arcsec_per_mm
    return UnloadedContact(roll, points, error - error.mean(), high - low)


def misplaced(pair: FlankPair, found: str, allowed: str, *, placed: str, aligned: str) -> SceneError:
    """The error of flanks that do not mesh.

    Parameters
    ----------
    pair : FlankPair
    found, allowed : str
    placed : str
        Remedy if the pinion is displaced.
    aligned : str
        Remedy if the pinion is in its nominal place.
    """
    if pair.placement.is_aligned:
        return SceneError.of("gear_pair", found, allowed, aligned)
    return SceneError.of("placement", found, allowed, placed)


@lru_cache(maxsize=8)
def separation_of_neighbours(
    pair: FlankPair, farthest: int, steps: int, slices: int = 15
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Least separation of the flanks at roll positions, and that of the nearest pair.

    Cached for runs of the same flanks; do not change the arrays.

    Parameters
    ----------
    pair : FlankPair
    farthest : int
        Roll positions from the pitch point within which pairs are searched.
    steps : int
        Positions per mesh cycle.
    slices : int
        Slices of the flank: few, for an estimate.

    Returns
    -------
    roll, separation, least : (2 farthest steps,) arrays [1], [mm], [mm]
        `least` is the separation of the nearest of all pairs at the same mesh position.

    Raises
    ------
    SceneError
        If no flanks meet at some mesh position, or only inside the driving body's base circle.
    """
    roll = np.arange(-farthest * steps, farthest * steps) / steps
    lines = trace_contact_lines(pair, roll, face_stations(pair, slices))
    nearest = lines.separation[0].argmin(axis=1)
    rows = np.arange(roll.size)
    separation = lines.separation[0][rows, nearest]
    by_position = separation.reshape(-1, steps)
    least = by_position.min(axis=0)
    if not np.all(np.isfinite(least)):
        raise misplaced(
            pair,
            "flanks that do not meet at every mesh position",
            "a pinion whose flanks reach those of the gear",
            placed="bring the pinion closer to its nominal place, or check the distance of the axes",
            aligned="check the tips of both bodies, the distance of the axes and where the faces lie",
        )
    leading = by_position.argmin(axis=0) * steps + np.arange(steps)
    if np.any(lines.driving_slope[rows, nearest][leading] == 0.0):
        raise misplaced(
            pair,
            "a gear that reaches inside the pinion's base circle",
            "a pinion whose involute meets the gear",
            placed="move the pinion away from the gear: give more axial_gear_mm",
            aligned="lower the gear's tips, or give the pinion more teeth",
        )
    return roll, separation, np.tile(least, 2 * farthest)

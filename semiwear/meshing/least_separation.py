"""The least separation of each slice by Newton's method, and its derivatives there.

Towards its base circle the curvature of an involute grows without limit, as 1/sqrt(2 r_b s) with the arc s from
there. Differences are taken within a fraction of that arc, and Newton's method works on its root, the roll angle. A
Taylor series holds within that arc, while contact and wear reach farther: near a base circle the third and
fourth derivatives are replaced by those of a quartic that meets the separation farther out.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.meshing.flank_pair import FlankPair, Meeting

_OF_ROOM = 0.125  # of the arc to the nearer base circle: longest step of differences
_LEAST_STEP = 1e-3  # of the normal step: rounding leaves 1e-6 of the curvature
_SLOWEST = 1e-6  # of driving arc per driven arc: avoids division by zero within the base circle
_NORMAL_PASSES = 2
_SHORT_PASSES = 10  # two or three are enough, except for first guesses within the base circle
_CLOSE = 0.01  # of a step: within it of the least place no further pass is made
_LEAST_LEFT = 1 / 16  # of that arc, left after a pass: at most three quarters of the roll angle per pass
_OUTWARDS = (2.0, 4.0)  # normal steps away from a base circle: as far as contact and some wear reach


@dataclass(frozen=True)
class LeastPlaces:
    """Least separation in slices: of all, (roll, face), or of some of them in a row.

    Attributes
    ----------
    at, step : arrays [mm]
        Middle of the five places of the differences, and their distance.
    met : Meeting
        At the five places, in front of the slices.
    derivatives : array
        Value of the separation at `at`, and its first four derivatives by the profile coordinate, likewise in front.
    profile : array [mm]
        The least place, near `at`.
    """

    at: FloatArray
    step: FloatArray
    met: Meeting
    derivatives: FloatArray
    profile: FloatArray

    def writable(self) -> LeastPlaces:
        """The same with arrays that can be changed."""
        shape = self.met.separation.shape
        met = {}
        for entry in dataclasses.fields(self.met):
            values = getattr(self.met, entry.name)
            met[entry.name] = np.array(np.broadcast_to(values, shape + values.shape[len(shape) :]))
        return LeastPlaces(
            np.array(self.at),
            np.array(self.step),
            Meeting(**met),
            np.array(self.derivatives),
            np.array(self.profile),
        )

    def put(self, where: tuple[IntArray, IntArray], other: LeastPlaces) -> None:
        """Replace the values at (roll, face) indices by (n,) others."""
        for name in ("at", "step", "profile", "derivatives"):
            getattr(self, name)[..., *where] = getattr(other, name)
        for entry in dataclasses.fields(self.met):
            getattr(self.met, entry.name)[:, *where] = getattr(other.met, entry.name)


def _five_points(f: FloatArray, step: FloatArray) -> FloatArray:
    """Value and first four derivatives in the middle of five values that are a step [mm] apart, (5, ...) both."""
    return np.stack(
        [
            f[2],
            (f[0] - 8.0 * f[1] + 8.0 * f[3] - f[4]) / (12.0 * step),
            (-f[0] + 16.0 * f[1] - 30.0 * f[2] + 16.0 * f[3] - f[4]) / (12.0 * step**2),
            (-f[0] + 2.0 * f[1] - 2.0 * f[3] + f[4]) / (2.0 * step**3),
            (f[0] - 4.0 * f[1] + 6.0 * f[2] - 4.0 * f[3] + f[4]) / step**4,
        ]
    )


def _places(at: FloatArray, step: FloatArray) -> FloatArray:
    return at + step * np.arange(-2.0, 3.0).reshape(-1, *[1] * at.ndim)


def _room(pair: FlankPair, profile: FloatArray, driving_profile: FloatArray, slope: FloatArray) -> FloatArray:
    """Distance along the driven flank to the nearer of both base circles [mm], from the slope of the driving profile.

    0 within the base circle of the driving body, where its flank has ended.
    """
    driving, driven = pair.base_profiles
    distance = np.abs(driving_profile - driving) / np.maximum(np.abs(slope), _SLOWEST)
    return np.asarray(np.minimum(distance, np.abs(profile - driven)))


def short_steps(
    pair: FlankPair, face: FloatArray, profile: FloatArray, roll: FloatArray, longest: float
) -> FloatArray:
    """Steps of differences [mm]: the longest one far from base circles.

    Parameters
    ----------
    pair : FlankPair
    face, profile, roll : arrays that broadcast [mm], [mm], [1]
        Points of the driven flank, and their roll positions.
    longest : float [mm]
    """
    short = _LEAST_STEP * longest
    # towards the driven root, away from the driving base circle
    below, here = pair.meeting(face, np.stack([profile - short, profile]), roll).driving_profile
    return np.clip(_OF_ROOM * _room(pair, profile, here, (here - below) / short), short, longest)


def _newton_move(derivatives: FloatArray) -> FloatArray:
    """Newton's step [mm] to the minimum; infinite, to a border, where the separation is not convex."""
    first, second = derivatives[1:3]
    convex = second > 0.0
    return np.where(convex, -first / np.where(convex, second, 1.0), np.where(first > 0.0, -np.inf, np.inf))


def _move_by_angle(
    derivatives: FloatArray, room: FloatArray, low: FloatArray, high: FloatArray, outside: BoolArray
) -> FloatArray:
    """Newton's step for the roll angle of the body whose base circle is near, as one of the profile coordinate [mm].

    Parameters
    ----------
    derivatives : (5, n) array
    room : (5, n) array [mm]
        Distance to the base circle at the five places.
    low, high : (n,) arrays [mm]
        Rest of the slice below and above, between which the minimum lies.
    outside : (n,) bool array
        Whether it is known to lie outside the base circle.
    """
    first = derivatives[1]
    newton = _newton_move(derivatives)
    outwards = np.sign(room[3] - room[1])
    here = np.where(room[2] > 0.0, room[2], 1.0)
    change = outwards * np.where(np.isfinite(newton), newton, 0.0)
    by_angle = change * (1.0 + 0.25 * change / here)
    # roll angles are not negative: contact may be on the border beyond the base circle
    by_angle = np.where(change > -2.0 * here, by_angle, -np.inf)
    by_angle = np.where(outside, np.maximum(by_angle, (_LEAST_LEFT - 1.0) * here), by_angle)
    known = np.isfinite(newton) & (outwards != 0.0)
    move = np.where(known, np.where(outwards < 0.0, -by_angle, by_angle), newton)
    # the driving base circle lies towards the driven tip; within it only the side of the minimum is known
    within = np.where(first < 0.0, high, 0.5 * (low + high))
    return np.where(room[2] > 0.0, move, within)


@dataclass
class _Bracket:
    """Ends between which the minimum lies, (n,) arrays [mm], and whether they were found by a sign of the slope."""

    low: FloatArray
    high: FloatArray
    low_seen: BoolArray
    high_seen: BoolArray

    def narrow(self, at: FloatArray, falls: BoolArray) -> None:
        """Move the lower end to places where the separation falls upwards, the upper end to the others."""
        self.low, self.high = np.where(falls, at, self.low), np.where(falls, self.high, at)
        self.low_seen, self.high_seen = self.low_seen | falls, self.high_seen | ~falls

    def within(self, place: FloatArray) -> FloatArray:
        """Places limited to the ends, or the middle where they lie beyond an end that was found."""
        beyond = (self.low_seen & (place < self.low)) | (self.high_seen & (place > self.high))
        return np.where(beyond, 0.5 * (self.low + self.high), np.clip(place, self.low, self.high))

    def of(self, kept: IntArray) -> _Bracket:
        """The brackets of some slices."""
        return _Bracket(self.low[kept], self.high[kept], self.low_seen[kept], self.high_seen[kept])


def _refine(
    pair: FlankPair, roll: FloatArray, face: FloatArray, found: LeastPlaces, ends: tuple[FloatArray, FloatArray]
) -> None:
    """Find least places near base circles with short steps, in place."""
    normal_step = float(found.step.max())
    at = found.profile
    steps = short_steps(pair, face, at, roll[:, None], normal_step)
    rows, columns = np.nonzero(steps < normal_step)
    where = rows, columns
    at, step, roll, face = at[where], steps[where], roll[rows], face[columns]
    unseen = np.zeros(at.size, dtype=bool)
    bracket, outside = _Bracket(ends[0][where], ends[1][where], unseen, unseen), unseen
    for _ in range(_SHORT_PASSES):
        places = _places(at, step)
        met = pair.meeting(face, places, roll)
        derivatives = _five_points(met.separation, step)
        room = _room(pair, places, met.driving_profile, (met.driving_profile[2] - met.driving_profile[1]) / step)
        falls = derivatives[1] <= 0.0
        bracket.narrow(at, falls)
        outside = outside | (~falls & (room[2] == 0.0))
        move = _move_by_angle(derivatives, room, bracket.low - at, bracket.high - at, outside)
        profile = bracket.within(at + move)
        moved = np.abs(profile - at)
        # a series holds only within its step
        found.put(where, LeastPlaces(at, step, met, derivatives, np.where(moved <= step, profile, at)))
        open_ = np.flatnonzero(moved > _CLOSE * step)
        if not open_.size:
            return
        rows, columns = rows[open_], columns[open_]
        where = rows, columns
        at, roll, face, bracket, outside = profile[open_], roll[open_], face[open_], bracket.of(open_), outside[open_]
        step = short_steps(pair, face, at, roll, normal_step)


def least_places(
    pair: FlankPair,
    roll: FloatArray,
    face: FloatArray,
    guess: FloatArray,
    normal_step: float,
    ends: tuple[FloatArray, FloatArray],
) -> LeastPlaces:
    """The least separation of each slice.

    Parameters
    ----------
    pair : FlankPair
    roll, face : (K,), (S,) arrays [1], [mm]
    guess : (K, S) array [mm]
        First guess of the least place, between both ends.
    normal_step : float [mm]
        Step of differences far from base circles.
    ends : two (K, S) arrays [mm]
        Lower and upper end of each slice.
    """
    at, step = guess, np.full(guess.shape, normal_step)
    for _ in range(_NORMAL_PASSES):
        met = pair.meeting(face[None, None], _places(at, step), roll[None, :, None])
        derivatives = _five_points(met.separation, step)
        profile = np.clip(at + _newton_move(derivatives), *ends)
        found = LeastPlaces(at, step, met, derivatives, profile)
        at = profile
    if np.isfinite(pair.base_profiles).any():
        found = found.writable()
        _refine(pair, roll, face, found, ends)
    return found


def with_far_terms(
    pair: FlankPair, roll: FloatArray, face: FloatArray, found: LeastPlaces, normal_step: float, series: FloatArray
) -> FloatArray:
    """A series about the least places whose last two terms, near a base circle, fit the separation farther out.

    Parameters
    ----------
    pair : FlankPair
    roll, face : (K,), (S,) arrays [1], [mm]
    found : LeastPlaces
    normal_step : float [mm]
        Step of differences far from base circles.
    series : (5, K, S) array
        Value and derivatives of the separation at ``found.profile``.
    """
    rows, columns = np.nonzero(found.step < normal_step)
    if not rows.size:
        return series
    profile, roll, face = found.profile[rows, columns], roll[rows], face[columns]
    both = profile + np.array([[-normal_step], [normal_step]])
    driving = pair.meeting(face, both, roll).driving_profile
    room = _room(pair, both, driving, (driving[1] - driving[0]) / (2.0 * normal_step))
    offset = np.where(room[1] > room[0], normal_step, -normal_step) * np.array(_OUTWARDS)[:, None]
    gap = pair.meeting(face, profile + offset, roll).separation
    value, first, second = series[:3, rows, columns]
    # third/6 + offset fourth/24 at both places
    cubic = (gap - value - offset * (first + 0.5 * offset * second)) / offset**3
    fourth = 24.0 * (cubic[1] - cubic[0]) / (offset[1] - offset[0])
    series = series.copy()
    series[3, rows, columns] = 6.0 * cubic[0] - 0.25 * offset[0] * fourth
    series[4, rows, columns] = fourth
    return series

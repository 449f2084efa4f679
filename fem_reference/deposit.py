r"""Archard's wear summed where it happens: pressures of a few roll positions, carried on between them.

.. math:: h = k \int p \, |v_s| \, dt

at every point of the flank (Archard 1953). Pressures are known at the roll positions that were solved. Between two of
them they change slowly *in coordinates that go with the contact line* (distance from the fresh line along the
profile, and gear radius), so there they are interpolated linearly; the line's own motion, and the sliding velocity
with its zero at the pitch line, are exact at every instant of a fine time grid. Where a line stands on an edge it
stands in these coordinates as well, where it sweeps the sum tends to k q |v_s|/v_n, and at the pitch line to what
the finite width of the contact gives: no case is treated apart.

The whole is linear in the pressures. `Deposit` is that operator, built once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, pi

import numpy as np
from scipy.sparse import csr_matrix

from fem_reference.arrays import BoolArray, FloatArray, IntArray
from fem_reference.edge_rule import reference_half_width
from fem_reference.fem_results import line_load
from fem_reference.mesh_position import PairResult, PositionResult
from fem_reference.pair_motion import PairMotion
from fem_reference.pairs import module_of
from fem_reference.rigid_lines import RigidFlank
from fem_reference.wear import face_stations, flank_profile

_FARTHEST = 0.315  # modules from the fresh line up to which pressures are held: 2 mm in the shipped scene
_SPACING = 0.1  # reference half-widths between places where they are, at most

_STEPS = 8
"""Instants of the time grid between two roll positions that were solved; 1/18 apart, lines move by 0.4 mm."""


@lru_cache(maxsize=8)  # asked for at every contact
def line_offsets(pair: PairMotion) -> FloatArray:
    """Distances from the fresh line along the profile at which pressures are held, evenly apart [mm]."""
    farthest = _FARTHEST * module_of(pair.scene)
    count = ceil(farthest / (_SPACING * reference_half_width(pair)))
    return np.linspace(-farthest, farthest, 2 * count + 1)


def line_pressures(found: PairResult, pair: PairMotion, fresh: RigidFlank) -> FloatArray:
    """Pressures on (face station of `/flank`, offset from the fresh line) [MPa].

    Every station carries the line load that the nodal forces have there.
    """
    line, offsets = fresh.line(found.line.roll), line_offsets(pair)
    columns = np.unique(found.face)
    at_columns = np.zeros((len(columns), len(offsets)))
    for row, face in enumerate(columns):
        here = np.flatnonzero(found.face == face)
        here = here[np.argsort(found.profile[here])]
        offset = found.profile[here] - np.interp(face, line.face, line.profile)
        at_columns[row] = np.interp(offsets, offset, found.contact.pressure[here], left=0.0, right=0.0)
    stations = face_stations(pair)
    result = np.stack([np.interp(stations, columns, values, left=0.0, right=0.0) for values in at_columns.T], axis=1)
    held = result.sum(axis=1) * (offsets[1] - offsets[0]) * np.interp(stations, line.face, line.spacing)
    exact = line_load(found, pair)
    return result * np.where(held > 0.0, exact / np.where(held > 0.0, held, 1.0), 0.0)[:, None]


def by_roll(
    positions: FloatArray, solved: Sequence[PositionResult], fresh: RigidFlank
) -> tuple[FloatArray, FloatArray]:
    """Roll positions of all pairs of a mesh cycle, growing, and their (roll, face, offset) pressures [MPa].

    Pairs without a solution carry no load; one such position is added before the first and after the last.
    """
    pair = fresh.pair
    numbers = sorted({j for result in solved for j in result.pairs})
    shape = (len(face_stations(pair)), len(line_offsets(pair)))
    entries = [
        (
            float(position) + j,
            line_pressures(result.pairs[j], pair, fresh) if j in result.pairs else np.zeros(shape),
        )
        for j in range(numbers[0] - 1, numbers[-1] + 2)
        for position, result in zip(positions, solved, strict=True)
    ]
    return np.array([roll for roll, _ in entries]), np.stack([pressure for _, pressure in entries])


@dataclass(frozen=True)
class _Track:
    """Flank points beside the moving line."""

    fresh: RigidFlank
    face: FloatArray
    profile: FloatArray
    own: FloatArray
    normal: FloatArray

    @classmethod
    def of(cls, fresh: RigidFlank) -> _Track:
        face = face_stations(fresh.pair)
        profile = flank_profile(fresh.pair, face)
        return cls(fresh, face, profile, *fresh.pair.gear.points(np.broadcast_to(face, profile.shape), profile))

    def radians(self, rolls: float) -> float:
        """Rotation of the pinion over some roll positions."""
        return 2.0 * pi / self.fresh.pair.pinion_teeth * rolls

    def at(self, roll: float) -> tuple[tuple[IntArray, IntArray], IntArray, FloatArray, FloatArray]:
        """Points (profile, face) beside the line, offset below each, fraction to the next, sliding per radian."""
        pair, line = self.fresh.pair, self.fresh.line(roll)
        offset = self.profile - np.interp(self.face, line.face, line.profile)
        held = line_offsets(pair)
        place = (offset - held[0]) / (held[1] - held[0])
        at = np.nonzero((place >= 0.0) & (place < len(held) - 1))
        pose = pair.gear_pose(roll)
        velocity, normal = pair.sliding(pose.points(self.own[at])), pose.vectors(self.normal[at])
        slid = np.linalg.norm(velocity - np.sum(velocity * normal, axis=1)[:, None] * normal, axis=1)
        low = place[at].astype(int)
        return (at[0], at[1]), low, place[at] - low, slid


@dataclass(frozen=True)
class Deposit:
    """Wear of a passage as a linear map of the pressures.

    Attributes
    ----------
    face : (F,) array [mm]
    profile : (P, F) array [mm]
        Grid of `/flank`.
    operator : (P F, rolls F offsets) sparse array [mm]
        Sliding distance that multiplies each pressure at each point.
    """

    face: FloatArray
    profile: FloatArray
    operator: csr_matrix

    @classmethod
    def of(
        cls, fresh: RigidFlank, rolls: FloatArray, loaded: BoolArray | None = None, *, steps: int = _STEPS
    ) -> Deposit:
        """For pressures at these growing roll positions, which are zero except at the `loaded` ones."""
        track = _Track.of(fresh)
        (points, stations), offsets = track.profile.shape, len(line_offsets(fresh.pair))
        rows, columns, values = [], [], []
        on = np.ones(len(rolls), dtype=bool) if loaded is None else loaded
        for k in np.flatnonzero(on[1:] | on[:-1]):
            step = track.radians(float(rolls[k + 1] - rolls[k]) / steps)
            for share in (np.arange(steps) + 0.5) / steps:
                (p, f), low, part, slid = track.at(float((1.0 - share) * rolls[k] + share * rolls[k + 1]))
                for roll_row, weight in ((k, 1.0 - share), (k + 1, share)):
                    base = (roll_row * stations + f) * offsets + low
                    for offset, amount in ((0, 1.0 - part), (1, part)):
                        rows.append(p * stations + f)
                        columns.append(base + offset)
                        values.append(slid * step * weight * amount)
        size = (points * stations, len(rolls) * stations * offsets)
        at = np.concatenate(rows), np.concatenate(columns)
        return cls(track.face, track.profile, csr_matrix((np.concatenate(values), at), shape=size))

    def __call__(self, pressures: FloatArray) -> FloatArray:
        """Sum of p |v_s| dt, (profile, face), of (roll, face, offset) pressures [N/mm]."""
        return np.asarray((self.operator @ pressures.ravel()).reshape(self.profile.shape))


def marched(fresh: RigidFlank, rolls: FloatArray, pressures: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The same sum over a short range, roll position by roll position, without interpolation between them.

    A check of `Deposit`, after Park, Kolivand, Kahraman 2012 (Mech. Mach. Theory): with steps of a fifth of the
    contact's half-width or less it equals the integral.

    Parameters
    ----------
    fresh : RigidFlank
    rolls : (K,) array
        Even steps.
    pressures : (K, face, offset) array [MPa]
        From `line_pressures`.

    Returns
    -------
    depth : (profile, face) array [N/mm]
        Sum of p |v_s| dt.
    whole : (profile, face) bool array
        Points that the contact reaches after the first position and has left before the last.
    """
    track = _Track.of(fresh)
    shape = track.profile.shape
    depth, first, last = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for k, roll in enumerate(rolls):
        at, low, part, slid = track.at(float(roll))
        held = pressures[k][at[1], low] * (1.0 - part) + pressures[k][at[1], low + 1] * part
        depth[at] += held * slid * track.radians(float(rolls[1] - rolls[0]))
        if k == 0:
            first[at] = held
        last = np.zeros(shape)
        last[at] = held
    return depth, (depth > 0.0) & (first == 0.0) & (last == 0.0)

"""Passage of the unworn contact line over each point of the gear's flank, and the sliding there, for `/flank`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from fem_reference.arrays import FloatArray
from fem_reference.edge_rule import reference_half_width
from fem_reference.fem_results import line_motion
from fem_reference.kinematics import PairKinematics, face_gear_motion
from fem_reference.pairs import module_of
from fem_reference.rigid_lines import RigidFlank
from fem_reference.wear import face_stations, flank_profile
from semiwear.results import Zone

_UM = 1e3
_TRACED = 24  # rigid lines a mesh cycle, from which the passage of flank points is read
_NEAR = 0.03  # modules: gap up to which a line is one of contact
_STILL = 1e-7  # modules: a line that has moved less between two roll positions stands


@dataclass(frozen=True)
class Passage:
    """Passage of the unworn contact line over each point of the `/flank` grid; arrays are (profile, face).

    Attributes
    ----------
    face : (F,) array [mm]
    profile : array [mm]
    roll : array
        Roll position; not a number where the line never passes.
    specific_sliding : array
        |v_s| / v_n of the gear there.
    pair : PairKinematics
    """

    face: FloatArray
    profile: FloatArray
    roll: FloatArray
    specific_sliding: FloatArray
    pair: PairKinematics

    @classmethod
    def of(cls, fresh: RigidFlank, first: float = -2.0, last: float = 2.0) -> Passage:
        """Traced between two roll positions."""
        pair = face_gear_motion(fresh.pair)
        face = face_stations(pair)
        profile = flank_profile(pair, face)
        near, still = _NEAR * module_of(pair.scene), _STILL * module_of(pair.scene)
        rolls = np.linspace(first, last, round((last - first) * _TRACED) + 1)
        traced = [line_motion(fresh, float(roll)) for roll in rolls]
        place = np.stack([np.interp(face, line.face, line.profile) for line, _ in traced])
        gap = np.stack([np.interp(face, line.face, line.gap) for line, _ in traced])
        speed = np.stack([np.interp(face, line.face, motion.speed["gear"]) for line, motion in traced])
        roll, sliding = np.full(profile.shape, np.nan), np.zeros(profile.shape)
        for i in range(len(face)):
            # a line that stops at a border has no speed of its own there: its last free steps are carried on
            inside = np.isfinite(gap[:, i]) & (gap[:, i] < near)
            step = np.abs(np.diff(place[:, i], prepend=np.nan, append=np.nan))
            free = step[1:-1][inside[1:] & inside[:-1]]
            usual = float(np.median(free[free > still])) if np.any(free > still) else np.inf
            moving = inside & (step[:-1] > 0.6 * usual) & (step[1:] > 0.6 * usual)
            rows = np.flatnonzero(moving)
            if len(rows) < 3:
                continue
            order = rows[np.argsort(place[rows, i])]
            kept = np.diff(place[order, i], prepend=-np.inf) > still
            order = order[kept]
            nodes = place[order, i]
            within = (profile[:, i] >= nodes[0] - usual) & (profile[:, i] <= nodes[-1] + usual)
            points = profile[within, i]
            held = np.clip(points, nodes[0], nodes[-1])
            # towards the tip the line was earlier
            roll[within, i] = PchipInterpolator(nodes, rolls[order])(held) - (points - held) / (usual * _TRACED)
            met_speed = PchipInterpolator(nodes, speed[order, i])(held)
            for k, at, v in zip(np.flatnonzero(within), roll[within, i], met_speed, strict=True):
                point = pair.meeting(face[i], profile[k, i], float(at)).position
                sliding[k, i] = np.linalg.norm(pair.sliding(point)) / v
        return cls(face, profile, roll, sliding, pair)


def flank_group(passage: Passage, depths: list[FloatArray]) -> dict[str, FloatArray]:
    """Both flanks in the layout of `/flank`; the pinion's specific sliding follows from the gear's."""
    pair, profile = passage.pair, passage.profile
    gear, pinion = pair.gear, pair.pinion
    low, high = pair.pinion_profile_limits
    own = np.broadcast_to(np.linspace(low, high, len(profile))[:, None], profile.shape)
    radius = pinion.base_radius * np.sqrt(1.0 + pinion.roll_from_profile(own) ** 2)
    face = np.broadcast_to(passage.face, profile.shape)
    pitch = gear.profile_from_height(passage.face, pair.pitch_height(passage.face))
    side = np.where(profile < pitch, -1.0, 1.0)
    known = np.isfinite(passage.roll)
    met = [np.full(profile.shape, np.nan), np.zeros(profile.shape)]
    for k, i in np.argwhere(known):
        met[0][k, i] = pair.meeting(face[k, i], profile[k, i], float(passage.roll[k, i])).pinion_profile
    # both lines move towards the same end of the teeth; their speeds differ by the sliding: 1/s_1 + 1/s_2 = 1
    signed = side * passage.specific_sliding
    with np.errstate(divide="ignore", invalid="ignore"):
        partner = np.where(signed == 1.0, 0.0, signed / (signed - 1.0))
    pinion_sliding, pinion_known = np.zeros(profile.shape), np.zeros(profile.shape, dtype=bool)
    for i in range(profile.shape[1]):
        rows = np.flatnonzero(known[:, i])
        if len(rows) > 1:
            order = rows[np.argsort(met[0][rows, i])]
            pinion_sliding[:, i] = np.interp(own[:, i], met[0][order, i], partner[order, i], left=0.0, right=0.0)
            pinion_known[:, i] = (own[:, i] >= met[0][order[0], i]) & (own[:, i] <= met[0][order[-1], i])

    band = reference_half_width(pair)

    def zones(height: FloatArray) -> FloatArray:
        return np.where(height < -band, int(Zone.ROOT), np.where(height > band, int(Zone.ADDENDUM), int(Zone.PITCH)))

    worn = _UM * np.stack(depths)
    return {
        "flank_height": np.stack([radius - pinion.pitch_radius, gear.height(face, profile)]),
        "flank_radius": np.stack([radius, face]),
        "zone": np.stack([zones(radius - pinion.pitch_radius), zones(profile - pitch)]),
        "active": np.stack([pinion_known, known]).astype(int),
        "specific_sliding": np.stack([pinion_sliding, signed]),
        "wear_depth": np.stack([np.zeros_like(worn), worn], axis=1),
    }

r"""Wear of the gear's flank in finite elements: contact at a few mesh positions, wear by the swept line.

A contact line that passes a point of the flank with line load q, sliding speed v_s and its own speed over the flank
v_n wears off

    h = k q |v_s| / v_n    a mesh,

whatever the width of the contact (Archard 1953 integrated over the passage). Line loads are interpolated between the
roll positions that were solved, v_s and v_n are exact at every point. Each wear cycle is one implicit step: the wear
that a load is about to cause is a gap in the very solution that gives the load, so that steps may be long.

Not in here: the finite width of the contact (it matters only within a half-width of vanishing sliding) and the wear
of the pinion. Within some 2 mm of the flank's borders, where lines enter, leave and stand, the identity does not
hold and depths are rough: there they are no reference yet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from fem_reference.fem_results import line_load, line_motion, result_groups, tree_of
from fem_reference.kinematics import PairKinematics
from fem_reference.loaded import POSITIONS, on_loaded_flank, solve_positions
from fem_reference.mesh_position import MeshSettings, PositionResult
from fem_reference.rigid_lines import RigidFlank, RigidLine
from fem_reference.root_load import RootStress
from fem_reference.wear import FlankWear, face_stations, flank_profile
from semiwear.errors import SceneError
from semiwear.results import Zone
from semiwear.scene import Placement, Scene

__all__ = ["deposit", "simulate"]

FloatArray = NDArray[np.float64]

_UM = 1e3
_TRACED = 24  # rigid lines a mesh cycle, from which the passage of flank points is read


def simulate(
    scene: Scene,
    *,
    cycles: int = 3,
    meshes: float | None = None,
    positions: int = POSITIONS,
    placement: Placement | None = None,
    elements_per_half_width: float = 3.0,
    element_length: float = 2.0,
    teeth: int = 5,
    pinion_teeth: int = 9,
    root_stress: bool = True,
) -> xr.DataTree:
    """Wear the gear's flank.

    Parameters
    ----------
    scene : Scene
        With a table [wear].
    cycles : int
        Wear steps. Each costs `positions` contact solutions, and so does the final state.
    meshes : float, optional
        Engagements of one gear tooth in all; default ``wear.until.meshes``.
    positions : int
        Mesh positions.
    placement, elements_per_half_width, element_length, teeth, pinion_teeth, root_stress
        As for `loaded_contact`.

    Returns
    -------
    DataTree
        `/flank` with `wear_depth` after every cycle, `/engagement`, `/mesh_cycle` and `/diagnostics`, with the names
        of `semiwear.simulate`; no `/history`.

    Raises
    ------
    SceneError
        Without a table [wear], without a number of meshes, or for fewer than one cycle.
    """
    if scene.wear is None:
        raise SceneError.of("wear", None, "a table [wear]", "use loaded_contact for a scene without wear")
    total = scene.wear.until.meshes if meshes is None else meshes
    if total is None or not (np.isfinite(total) and total > 0.0):
        raise SceneError.of("meshes", total, "> 0", "the scene wears to control depths: say how many meshes")
    if cycles < 1:
        raise SceneError.of("cycles", cycles, ">= 1")
    pair = PairKinematics(scene, on_loaded_flank(scene, placement))
    fresh = RigidFlank(pair)
    passage = Passage.of(fresh)
    settings = MeshSettings(elements_per_half_width, element_length, teeth, pinion_teeth)
    roots = RootStress(scene, teeth, pinion_teeth) if root_stress else None
    places = np.arange(positions) / positions
    coefficient, step = scene.wear.coefficient_mm2_per_N, total / cycles

    def wear_to_come(line: RigidLine) -> FloatArray:
        _, motion = line_motion(fresh, line.roll)
        return coefficient * step * motion.sliding / motion.speed["gear"]

    depth = np.zeros(passage.profile.shape)
    depths, states = [depth], []
    for _ in range(cycles):
        flank = RigidFlank(pair, FlankWear(passage.face, passage.profile, depth))
        states.append((flank, solve_positions(flank, places, settings, roots, strict=False)))
        implicit = solve_positions(flank, places, settings, None, strict=False, wear_to_come=wear_to_come)
        depth = depth + coefficient * step * deposit(passage, implicit, places)
        depths.append(depth)
    flank = RigidFlank(pair, FlankWear(passage.face, passage.profile, depth))
    states.append((flank, solve_positions(flank, places, settings, roots, strict=False)))
    groups, coords = result_groups(states, places)
    groups["flank"] = _flank(passage, depths)
    coords["meshes"] = step * np.arange(cycles + 1.0)
    return tree_of(scene, groups, coords, "simulate", f"{cycles} implicit wear steps on {positions} mesh positions")


@dataclass(frozen=True)
class Passage:
    """When the fresh contact line passes each point of the `/flank` grid, and how; arrays are (profile, face).

    Attributes
    ----------
    face : (F,) array [mm]
    profile : array [mm]
    roll : array
        Roll position; not a number where the line never comes.
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
        pair = fresh.pair
        face, profile = face_stations(pair), flank_profile(pair)
        rolls = np.linspace(first, last, round((last - first) * _TRACED) + 1)
        traced = [line_motion(fresh, float(roll)) for roll in rolls]
        place = np.stack([np.interp(face, line.face, line.profile) for line, _ in traced])
        gap = np.stack([np.interp(face, line.face, line.gap) for line, _ in traced])
        speed = np.stack([np.interp(face, line.face, motion.speed["gear"]) for line, motion in traced])
        roll, sliding = np.full(profile.shape, np.nan), np.zeros(profile.shape)
        for i in range(len(face)):
            # a line that stops at a border has no speed of its own there: its last free steps are carried on
            inside = np.isfinite(gap[:, i]) & (gap[:, i] < 0.2)
            step = np.abs(np.diff(place[:, i], prepend=np.nan, append=np.nan))
            free = step[1:-1][inside[1:] & inside[:-1]]
            usual = float(np.median(free[free > 1e-6])) if np.any(free > 1e-6) else np.inf
            moving = inside & (step[:-1] > 0.6 * usual) & (step[1:] > 0.6 * usual)
            rows = np.flatnonzero(moving)
            if len(rows) < 3:
                continue
            order = rows[np.argsort(place[rows, i])]
            nodes, kept = np.unique(np.round(place[order, i], 9), return_index=True)
            order = order[kept]
            within = (profile[:, i] >= nodes[0] - usual) & (profile[:, i] <= nodes[-1] + usual)
            wanted = profile[within, i]
            held = np.clip(wanted, nodes[0], nodes[-1])
            # towards the tip the line was earlier
            roll[within, i] = PchipInterpolator(nodes, rolls[order])(held) - (wanted - held) / (usual * _TRACED)
            met_speed = PchipInterpolator(nodes, speed[order, i])(held)
            for k, at, v in zip(np.flatnonzero(within), roll[within, i], met_speed, strict=True):
                point = pair.meeting(face[i], profile[k, i], float(at)).position
                sliding[k, i] = np.linalg.norm(pair.sliding(point)) / v
        return cls(face, profile, roll, sliding, pair)


def deposit(passage: Passage, solved: list[PositionResult], positions: FloatArray) -> FloatArray:
    """Line load times specific sliding at the passage of each flank point: wear of a mesh over k [N/mm]."""
    entries = sorted(
        (position + j, k, j)
        for k, (position, result) in enumerate(zip(positions, solved, strict=True))
        for j in range(-3, 4)
    )
    rolls = np.array([entry[0] for entry in entries])
    loads = np.stack(
        [
            line_load(solved[k].pairs[j], passage.pair) if j in solved[k].pairs else np.zeros(len(passage.face))
            for _, k, j in entries
        ]
    )
    result = np.zeros(passage.profile.shape)
    for i in range(len(passage.face)):
        known = np.isfinite(passage.roll[:, i])
        result[known, i] = PchipInterpolator(rolls, loads[:, i])(passage.roll[known, i])
    return np.maximum(result, 0.0) * passage.specific_sliding


def _flank(passage: Passage, depths: list[FloatArray]) -> dict[str, FloatArray]:
    """Both flanks as `/flank` has them; the pinion's specific sliding follows from the gear's."""
    pair, profile = passage.pair, passage.profile
    gear, pinion = pair.gear, pair.pinion
    low, high = pair.pinion_profile_limits
    own = np.broadcast_to(np.linspace(low, high, len(profile))[:, None], profile.shape)
    radius = pinion.base_radius * np.sqrt(1.0 + pinion.roll_from_profile(own) ** 2)
    face = np.broadcast_to(passage.face, profile.shape)
    pitch = gear.profile_from_height(passage.face, pinion.pitch_radius * (1.0 - passage.face / gear.pitch_radius))
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

    def zones(height: FloatArray) -> FloatArray:
        return np.where(height < -0.5, int(Zone.ROOT), np.where(height > 0.5, int(Zone.ADDENDUM), int(Zone.PITCH)))

    worn = _UM * np.stack(depths)
    return {
        "flank_height": np.stack([radius - pinion.pitch_radius, gear.height(face, profile)]),
        "flank_radius": np.stack([radius, face]),
        "zone": np.stack([zones(radius - pinion.pitch_radius), zones(profile - pitch)]),
        "active": np.stack([pinion_known, known]).astype(int),
        "specific_sliding": np.stack([pinion_sliding, signed]),
        "wear_depth": np.stack([np.zeros_like(worn), worn], axis=1),
    }

"""From solved mesh positions to the arrays and the tree of a result, in the names of `semiwear.results.schema`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
import xarray as xr
from scipy.interpolate import make_interp_spline

from fem_reference.arrays import FloatArray
from fem_reference.edge_rule import beside_edges, reference_half_width
from fem_reference.mesh_position import PairResult, PositionResult
from fem_reference.pair_motion import PairMotion, line_speed
from fem_reference.rigid_lines import RigidFlank, RigidLine
from fem_reference.root_load import BODIES
from fem_reference.wear import face_stations
from semiwear.results import build_tree, provenance
from semiwear.scene import Scene

_ZERO_POSITIONS = 24  # of the mesh cycle over which the unloaded, unworn lead is averaged
_SHIFT = 0.02  # roll positions before and after, between which a line's speed is taken

_REFERENCES = (
    "Wohlmuth 2000, SIAM J. Numer. Anal. 38, 989-1012 (dual mortar)",
    "Hueber and Wohlmuth 2005, Comput. Meth. Appl. Mech. Eng. 194, 3147-3166 (active set)",
    "Taylor, Beresford, Wilson 1976, Int. J. Numer. Meth. Eng. 10, 1211-1219 (incompatible modes)",
    "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, chapter 18",
)

_ON_ROLL = ("elements_across", "reaches_border", "edge_contact")  # of `/diagnostics`


def line_load(found: PairResult, pair: PairMotion) -> FloatArray:
    """Nodal forces summed across the contact, per length of the line, on the face stations of `/flank` [N/mm]."""
    columns, where = np.unique(found.face, return_inverse=True)
    force = np.bincount(where, weights=found.contact.force)
    # a column of nodes represents the elements' halves beside it
    middles = 0.5 * (columns[1:] + columns[:-1])
    borders = np.concatenate([[columns[0]], middles, [columns[-1]]])
    total = np.concatenate([[0.0], np.cumsum(force)])
    stations = face_stations(pair)
    half = 0.5 * (stations[1] - stations[0])
    ends = np.append(stations - half, stations[-1] + half)
    below = np.interp(ends, borders, total)
    below[[0, -1]] = 0.0, total[-1]  # load on the roundings beyond the outermost slices
    share = np.diff(below)
    # the line is known up to the ends' roundings; slices may lie beyond
    line = make_interp_spline(found.line.face, found.line.position, k=1)
    return np.asarray(share / np.linalg.norm(np.diff(line(ends), axis=0), axis=1))


@dataclass(frozen=True)
class LineMotion:
    """How a contact line moves; arrays are over the stations of its `RigidLine`.

    Attributes
    ----------
    sliding : array [mm per radian of the pinion]
        Sliding speed.
    speed : dict from body to array [mm per radian of the pinion]
        Of the line over the body's flank, normal to the line.
    """

    sliding: FloatArray
    speed: Mapping[str, FloatArray]


def line_motion(fresh: RigidFlank, roll: float) -> tuple[RigidLine, LineMotion]:
    """Fresh contact line at a roll position and its motion.

    Source: Litvin and Fuentes 2004, chapter 8 (sliding velocity); Flodin and Andersson 1997, Wear 207, 16-23.
    """
    pair = fresh.pair
    before, now, after = (fresh.line(roll + shift) for shift in (-_SHIFT, 0.0, _SHIFT))
    speed = {}
    for name, pose in (("gear", pair.gear_pose), ("pinion", pair.pinion_pose)):
        own = [pose(line.roll).back(line.position) for line in (before, after)]
        speed[name] = np.maximum(line_speed(pair, own[0], own[1], 2.0 * _SHIFT), 1e-9)
    return now, LineMotion(np.linalg.norm(pair.sliding(now.position), axis=1), speed)


def _pressures(found: PairResult, pair: PairMotion, half_width: float) -> tuple[float, float, int]:
    """Greatest pressure away from edges and near them [MPa], and the node of the first."""
    pressure = found.contact.pressure
    border = found.contact.on_edge | beside_edges(
        pair, half_width, found.line, found.face, found.profile, found.pinion_face, found.pinion_profile, pressure
    )
    inner = np.where(border, 0.0, pressure)
    best = int(np.argmax(inner))
    return float(inner[best]), float(np.max(pressure, where=border, initial=0.0)), best


def _sliding_distance(
    fresh: RigidFlank, found: PairResult, best: int, pressure: float, load: FloatArray
) -> list[float]:
    """|v_s|/v_n times the contact width where the pressure is greatest, pinion and gear [mm]."""
    if pressure <= 0.0:
        return [0.0, 0.0]
    line, motion = line_motion(fresh, found.line.roll)
    face = found.face[best]
    # an elliptic pressure of that peak and load per length is so wide
    width = 4.0 * float(np.interp(face, face_stations(fresh.pair), load)) / (pi * pressure)
    sliding = np.interp(face, line.face, motion.sliding)
    return [float(width * sliding / np.interp(face, line.face, motion.speed[name])) for name in BODIES]


def result_groups(
    states: Sequence[tuple[RigidFlank, Sequence[PositionResult]]], positions: FloatArray
) -> tuple[dict[str, dict[str, FloatArray]], dict[str, FloatArray]]:
    """Arrays of `/engagement`, `/mesh_cycle` and `/diagnostics` by group and name, and coordinates.

    Parameters
    ----------
    states : sequence of (flank, solved positions)
        One for each wear step, all of the same pair and the same positions.
    positions : (M,) array
        Mesh positions, growing.
    """
    pair = states[0][0].pair
    fresh, lever, scale = RigidFlank(pair), pair.lever, -pair.arcsec_per_mm
    half_width = reference_half_width(pair)
    zero = float(np.mean([fresh.least_gap(k / _ZERO_POSITIONS) for k in range(_ZERO_POSITIONS)]))
    numbers = sorted({j for _, solved in states for result in solved for j in result.pairs})
    keys = sorted((position + j, k, j) for k, position in enumerate(positions) for j in numbers)
    groups: dict[str, dict[str, list[FloatArray]]] = {
        name: {} for name in ("engagement", "mesh_cycle", "diagnostics")
    }
    for flank, solved in states:
        cycle = {
            "transmission_error_loaded": [scale * (r.solution.rotation * lever - zero) for r in solved],
            "transmission_error_unloaded": [scale * (flank.least_gap(float(m)) - zero) for m in positions],
            "pairs_in_contact": [sum(p.contact.load > 0.0 for p in r.pairs.values()) for r in solved],
        }
        approach = max(r.solution.rotation * lever for r in solved)
        diagnostics = {
            "iterations": max(r.solution.iterations for r in solved),
            "load_balance_residual": max(r.solution.equilibrium_residual for r in solved),
            "complementarity_residual": max(0.0, *(-r.solution.smallest_gap / approach for r in solved)),
            "smallest_gap": [r.solution.smallest_gap for r in solved],
        }
        engagement, flags = _engagement(fresh, keys, solved, half_width)
        for name, arrays in (
            ("engagement", engagement), ("mesh_cycle", cycle), ("diagnostics", {**diagnostics, **flags}),
        ):  # fmt: skip
            for key, values in arrays.items():
                groups[name].setdefault(key, []).append(np.asarray(values))
    stages = list(states[0][1][0].seconds)
    seconds = [sum(r.seconds[stage] for _, solved in states for r in solved) for stage in stages]
    stacked = {name: {key: np.stack(values) for key, values in group.items()} for name, group in groups.items()}
    stacked["diagnostics"]["seconds"] = np.array(seconds)
    coords = {
        "roll_position": np.array([key[0] for key in keys]),
        "mesh_position": positions,
        "face": face_stations(pair),
        "stage": np.array(stages),
    }
    return stacked, coords


def _engagement(
    fresh: RigidFlank, keys: list[tuple[float, int, int]], solved: Sequence[PositionResult], half_width: float
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """`/engagement` of one wear state at (roll position, index of mesh position, pair), and flags of the mesh."""
    pair, count = fresh.pair, len(keys)
    values: dict[str, np.ndarray] = {
        "load_share": np.zeros(count),
        "contact_pressure_max": np.zeros(count),
        "contact_pressure_on_edge": np.zeros(count, dtype=np.int8),
        "contact_pressure_max_edge": np.zeros(count),
        "line_load": np.zeros((count, len(face_stations(pair)))),
        "sliding_distance": np.zeros((count, 2)),
    }
    if solved[0].root_stress:
        values["root_stress"] = np.zeros((count, 2))
    flags = {name: np.zeros(count) for name in _ON_ROLL}
    for row, (_, k, j) in enumerate(keys):
        result = solved[k]
        if j not in result.pairs:
            continue
        found = result.pairs[j]
        total = sum(other.contact.load for other in result.pairs.values())
        inner, border, best = _pressures(found, pair, half_width)
        load = line_load(found, pair)
        values["load_share"][row] = found.contact.load / total
        on_edge = inner <= 0.0 < border
        values["contact_pressure_max"][row] = border if on_edge else inner
        values["contact_pressure_on_edge"][row] = on_edge
        values["contact_pressure_max_edge"][row] = border
        values["line_load"][row] = load
        values["sliding_distance"][row] = np.nan if on_edge else _sliding_distance(fresh, found, best, inner, load)
        if result.root_stress:
            values["root_stress"][row] = [result.root_stress[name, j] for name in BODIES]
        flags["elements_across"][row] = max(found.contact.nodes_across - 1, 0)
        flags["reaches_border"][row] = bool(found.contact.borders)
        flags["edge_contact"][row] = bool(found.contact.edges) or border > inner
    return values, flags


def tree_of(
    scene: Scene,
    groups: dict[str, dict[str, FloatArray]],
    coords: dict[str, FloatArray],
    action: str,
    physics: str = "",
) -> xr.DataTree:
    """The result in the words of the schema."""
    return build_tree(groups, coords, _attributes(scene, action, physics))


def _attributes(scene: Scene, action: str, physics: str = "") -> dict[str, str]:
    """Root attributes of a result."""
    return provenance(
        title=scene.title or "fem_reference result",
        scene_toml=scene.to_toml(),
        physics="three-dimensional elasticity, frictionless dual-mortar contact of all tooth pairs\n" + physics,
        fidelity="finite elements",
        references="\n".join(_REFERENCES),
        action=f"fem_reference.{action}",
    )

"""Nodes of a result's wear depths on the flanks of its scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.measured.nominal import NominalFlank, nominal_flank
from semiwear.meshing.driving_flank import driving_grid
from semiwear.meshing.flank_grid import flank_grid
from semiwear.meshing.flank_pair import BODIES, DRIVEN, FlankPair
from semiwear.plain_text import one_of
from semiwear.results.missing import group_of
from semiwear.scene import Scene, parse_scene

_UM = 1e-3  # mm


@dataclass(frozen=True)
class FlankNodes:
    """Nodes of one body's flank and the wear on them; arrays are (face, profile).

    Attributes
    ----------
    flank : NominalFlank
    face : (S,) array [mm]
    profile : (S, P) array [mm]
    depth : (steps, S, P) array [mm]
        Wear along the normal.
    """

    flank: NominalFlank
    face: FloatArray
    profile: FloatArray
    depth: FloatArray


def scene_of(tree: xr.DataTree) -> Scene:
    """The scene of a result.

    Raises
    ------
    SceneError
        If the result has no scene, or one that this version cannot read.
    """
    text = tree.attrs.get("scene_toml")
    if not isinstance(text, str):
        raise SceneError.of("tree", "a result without its scene", "a result of simulate", "compute it anew")
    return parse_scene(text)


def chosen_step(steps: int, wear_step: int) -> int:
    """Index of a wear step; negative values count from the end.

    Raises
    ------
    SceneError
        For a wear step that the result does not have.
    """
    if not -steps <= wear_step < steps:
        raise SceneError.of("wear_step", wear_step, f"a wear step of the result, below {steps}", "-1 is the last")
    return wear_step % steps


def flank_nodes(tree: xr.DataTree, body: str) -> FlankNodes:
    """Nodes of a body's flank in a result, on the surface of its scene.

    Raises
    ------
    SceneError
        For an unknown body, or a result without wear depths.
    """
    if body not in BODIES:
        raise SceneError.of("body", body, one_of(BODIES))
    data = group_of(tree, "flank")
    if "wear_depth" not in data:
        raise SceneError.of("tree", "a tree without /flank/wear_depth", "a result of simulate", "simulate the scene")
    flank, face = nominal_flank(scene_of(tree), body), data["face"].values
    index = BODIES.index(body)
    height = data["flank_height"].isel(body=index).transpose("face", "profile").values
    depth = data["wear_depth"].isel(body=index).transpose("wear_step", "face", "profile").values
    return FlankNodes(flank, face, nodes_on(flank.pair, index, face, height), _UM * depth)


def nodes_on(pair: FlankPair, body: int, face: FloatArray, height: FloatArray) -> FloatArray:
    """Profile coordinates of a result's nodes from their heights above the pitch surface, (face, profile) [mm].

    Raises
    ------
    SceneError
        If the heights are those of another scene.
    """
    points = height.shape[1]
    borders = pair.borders(face)
    even = np.linspace(borders.driving_root, borders.driving_tip, points)
    if body == DRIVEN:
        candidates = [flank_grid(pair, face, points).profile]
    else:  # a pinion that does not wear has equidistant nodes
        candidates = [driving_grid(pair, face, points).profile, np.broadcast_to(even, height.shape)]
    for nodes in candidates:
        candidate_height = pair.flank_place(body, face[:, None], nodes)[0]
        if np.abs(candidate_height - height).max() <= 1e-6 * np.ptp(height):
            return np.asarray(nodes)
    fix = "give the scene that the result was computed with"
    raise SceneError.of("worn", "a result of another scene", "a result of this scene", fix)

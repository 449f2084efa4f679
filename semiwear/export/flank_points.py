"""Flanks of a scene as files of points: `export_flank`."""

from __future__ import annotations

import os

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.export.nodes import nodes_on
from semiwear.geometry.point_grid import PlacedSection, PointGrid, write_point_grid
from semiwear.geometry.point_surface import LEAST_POINTS
from semiwear.geometry.section import ToothSection
from semiwear.measured.nominal import nominal_flank, unreached
from semiwear.meshing.flank_pair import DRIVING, FlankPair
from semiwear.meshing.own_flanks import flank_ends
from semiwear.results.missing import group_of
from semiwear.scene import Scene


def export_flank(
    scene: Scene,
    body: str,
    path: str | os.PathLike[str],
    *,
    points: tuple[int, int] = (101, 101),
    worn: xr.DataTree | None = None,
    wear_step: int = -1,
) -> None:
    """Write the loaded flank of a scene's pinion or gear as a grid of points, with normals and tooth sections.

    The file is an input of ``gear_pair.type = "flank_points"`` (`semiwear.geometry.point_grid`). Its attributes hold
    the further input of such a scene: `axis_point_mm` and `axis_direction` in the fixed frame, `rotation`, `teeth`,
    and the edge radii. If `operation.loaded_flank` is ``"coast"``, the coast flanks are written with both rotations
    reversed, and a scene that reads them drives on them. Flank modifications and misalignment are effects of the
    scene, not part of its flanks: a scene that reads the points must state them again.

    Parameters
    ----------
    scene : Scene
    body : str
        ``"pinion"`` or ``"gear"``.
    path : path
        A .nc file; or a .csv file, which holds points and normals only. An existing file is replaced.
    points : (int, int)
        Rows from root to tip and columns along the tooth; at least 9 each.
    worn : DataTree, optional
        A result of `simulate` for this scene, whose wear is removed along the normal. Default: unworn.
    wear_step : int
        Index of its wear step. Default: the last.

    Raises
    ------
    SceneError
        For an unknown body, too few points, another kind of file, or a result that does not fit.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> path = pathlib.Path(tempfile.mkdtemp(), "gear.nc")
    >>> sw.export_flank(sw.load_scene("spur_fzg_c"), "gear", path, points=(21, 9))
    >>> path.is_file()
    True
    """
    loaded = nominal_flank(scene, body)
    if len(points) != 2 or min(points) < LEAST_POINTS:
        raise SceneError.of("points", points, f"two whole numbers, {LEAST_POINTS} or more", "101 x 101 is usual")
    index, pair = loaded.body, loaded.pair
    rows, columns = points
    borders = pair.borders(np.array([np.mean(pair.face_limits)]))
    low, high = borders.driving_face if index == DRIVING else borders.face
    face = np.linspace(low, high, columns)
    root, tip = flank_ends(pair, index, face)
    fraction = np.linspace(0.0, 1.0, rows)[:, None]
    profile = root + (tip - root) * fraction
    flank, normals = loaded.points(face[None], profile)
    if worn is not None:
        depth = _depth(pair, index, worn, wear_step, face, profile)
        flank, normals = _with_wear(flank, normals, depth)
    axis, prism = loaded.axis, pair.prism_body(index)
    edges = {
        "tip_edge_radius_mm": (borders.driving_tip_edge_radius, borders.tip_edge_radius)[index],
        "end_edge_radius_mm": (borders.driving_end_edge_radius, borders.end_edge_radius)[index],
    }
    write_point_grid(
        path,
        PointGrid(
            points=flank,
            normals=normals,
            face=face,
            profile_length=tip - root,
            sections=tuple(
                _placed(pair, index, at, section, rows)
                for at, section in zip(prism.faces, prism.sections, strict=True)
            ),
            attributes={
                "body": body,
                "teeth": abs(getattr(scene.gear_pair, f"{body}_teeth")),
                "axis_point_mm": axis.point,
                "axis_direction": axis.direction,
                "rotation": axis.rotation,
                "tooth_length_mm": prism.tooth_length,
                **edges,
            },
        ),
    )


def _placed(pair: FlankPair, body: int, face: float, section: ToothSection, rows: int) -> PlacedSection:
    root, tip = flank_ends(pair, body, np.array([face]))
    row = (section.flank_profile - root) / (tip - root) * (rows - 1)
    return PlacedSection(face, ToothSection(section.flank, row, section.fillet, section.rim))


def _with_wear(flank: FloatArray, normals: FloatArray, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points displaced by the wear along the normals, and the normals there: wear tilts a flank by some arc minutes.

    The tangents of the unworn flank are projected on its exact tangent plane, so that finite differences are used
    only for the slope of the wear.
    """
    worn = flank - depth[..., None] * normals
    tangents = []
    for axis in (0, 1):
        tangent = np.gradient(worn, axis=axis, edge_order=2)
        tangent = tangent - np.sum(tangent * normals, axis=-1, keepdims=True) * normals
        tangents.append(tangent - np.gradient(depth, axis=axis, edge_order=2)[..., None] * normals)
    tilted = np.cross(*tangents)
    tilted *= np.sign(np.sum(tilted * normals, axis=-1, keepdims=True))
    return worn, tilted / np.linalg.norm(tilted, axis=-1, keepdims=True)


def _depth(
    pair: FlankPair, body: int, worn: xr.DataTree, wear_step: int, face: FloatArray, profile: FloatArray
) -> FloatArray:
    """Wear depth at points of a flank, (rows, columns) [mm].

    Constant beyond the outermost nodes, but zero where the mate does not touch.
    """
    flank = group_of(worn, "flank")
    if "wear_depth" not in flank:
        raise SceneError.of("worn", "a tree without /flank/wear_depth", "a result of simulate", "simulate the scene")
    if not -flank.sizes["wear_step"] <= wear_step < flank.sizes["wear_step"]:
        raise SceneError.of("wear_step", wear_step, f"a wear step of the result, below {flank.sizes['wear_step']}")
    depth = 1e-3 * flank["wear_depth"].isel(wear_step=wear_step, body=body).transpose("face", "profile").values
    if not depth.any():  # a body that does not wear has other nodes
        return np.zeros(profile.shape)
    stations = flank["face"].values
    height = flank["flank_height"].isel(body=body).transpose("face", "profile").values
    nodes = nodes_on(pair, body, stations, height)
    root, tip = flank_ends(pair, body, stations)
    node_fraction = (nodes - root[:, None]) / (tip - root)[:, None]
    face_root, face_tip = flank_ends(pair, body, face)
    fraction = (profile - face_root) / (face_tip - face_root)  # (rows, columns)
    rows = profile.shape[0]
    on_slices = np.stack([np.interp(fraction[:, 0], node_fraction[k], depth[k]) for k in range(stations.size)])
    below, above = unreached(pair, body, stations)
    if np.isfinite(below):
        stations, on_slices = np.insert(stations, 0, below), np.insert(on_slices, 0, 0.0, axis=0)
    if np.isfinite(above):
        stations, on_slices = np.append(stations, above), np.append(on_slices, np.zeros((1, rows)), axis=0)
    return np.stack([np.interp(face, stations, on_slices[:, i]) for i in range(rows)])

"""Shape of a tooth in space on the flank grid of a result, for the picture of a worn flank."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SemiwearError
from semiwear.export.nodes import nodes_on
from semiwear.meshing.contact_lines import trace_contact_lines
from semiwear.meshing.driving_flank import PassedStations
from semiwear.meshing.flank_grid import between_stations
from semiwear.meshing.flank_pair import BODIES, DRIVEN, PrismBody
from semiwear.meshing.own_flanks import own_flank
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.plan import plan
from semiwear.plot.flank import on_flank
from semiwear.scene import Placement, Scene, parse_scene

_FILLET_POINTS = 8
_SLAB = 0.4  # of the flank's height: thickness drawn for a tooth of unknown shape


@dataclass(frozen=True)
class ToothShape:
    """A tooth in a frame of its own: x along it, y out of the flank, z from root to tip; the flank's middle is 0.

    Attributes
    ----------
    flank, normal : (profile, face, 3) arrays [mm], [1]
        The unworn flank, and its unit normals out of the material.
    back : (profile, face, 3) array [mm]
        The other flank.
    fillet, back_fillet : (k, face, 3) arrays [mm]
        From the ends of both flanks down to the root; empty if they are unknown.
    line : (roll, face) array or None
        Fractional row of the grid in which the unworn contact line crosses each station.
    hertz : (roll, face) array or None
        Pressure of the unworn line contact over the square root of its line load [MPa/(N/mm)^0.5]:
        sqrt(E*/(pi R)) (Johnson 1985, eq. 4.45). In slices of the driven flank, like the loads of a result.
    passed : PassedStations or None
        Stations of the driving flank among those slices; None for the driven flank, which has the same ones.
    """

    flank: FloatArray
    normal: FloatArray
    back: FloatArray
    fillet: FloatArray
    back_fillet: FloatArray
    line: FloatArray | None
    hertz: FloatArray | None = None
    passed: PassedStations | None = None

    def at_stations(self, values: FloatArray) -> FloatArray:
        """Values of slices of the driven flank, (..., roll, face), at this flank's stations; 0 outside contact."""
        if self.passed is None:
            return values
        rows = values.reshape(-1, *values.shape[-2:])
        read = [np.where(self.passed.within(row > 0.0), self.passed.read_within(row, row > 0.0), 0.0) for row in rows]
        return np.stack(read).reshape(values.shape)


def tooth_shape(tree: xr.DataTree, body: str) -> ToothShape:
    """The tooth of a body from the gear pair of the result's scene; a slab if the scene cannot be read."""
    try:
        scene = parse_scene(str(tree.attrs.get("scene_toml", "")))
        return _in_space(tree, scene, BODIES.index(body))
    except (SemiwearError, OSError):
        return _slab(tree, body)


def _slab(tree: xr.DataTree, body: str) -> ToothShape:
    """The flank as a plane on a slab."""
    along, height, _ = on_flank(tree, body, 0)
    flank = np.stack([along, np.zeros_like(along), height], axis=-1)
    flank -= flank.mean(axis=(0, 1))
    normal = np.broadcast_to([0.0, 1.0, 0.0], flank.shape)
    no_fillet = np.zeros((0, *flank.shape[1:]))
    return ToothShape(flank, normal, flank - _SLAB * float(np.ptp(height)) * normal, no_fillet, no_fillet, None)


def _in_space(tree: xr.DataTree, scene: Scene, index: int) -> ToothShape:
    table, _ = on_loaded_flank(scene.gear_pair, Placement(), scene.operation.loaded_flank)
    pair = flank_pair(table, Placement())
    grid = tree["flank"].to_dataset().isel(body=index)
    stations = np.asarray(grid["face"].values, float)
    nodes = nodes_on(pair, index, stations, grid["flank_height"].transpose("face", "profile").values)
    points, normals = (values.swapaxes(0, 1) for values in own_flank(pair, index, stations[:, None], nodes))
    prism = pair.prism_body(index)
    radius = np.hypot(points[..., 0], points[..., 1])
    tangent = np.stack([-points[..., 1], points[..., 0], np.zeros_like(radius)], axis=-1) / radius[..., None]
    outwards = tangent * np.sign(np.mean(np.sum(normals * tangent, axis=-1)))
    across = prism.tooth_length / prism.width  # a section is normal to the tooth, `outwards` is around the axis
    half = np.arcsin(across * _half_thickness(prism, stations, nodes).T / radius)  # angle about the axis
    half *= -np.sign(np.sum(outwards * tangent, axis=-1))  # to the tooth's middle
    back = _turned(points, 2.0 * half)
    up = points[-1] - points[0]
    up = up - np.sum(up * outwards[0], axis=-1, keepdims=True) * outwards[0]
    up = _turned(up / np.linalg.norm(up, axis=-1, keepdims=True), half[0])
    aside, down = _fillets(prism, stations)
    sideways = across * aside[..., None] * _turned(outwards[0], half[0])
    fillets = [points[0] + sideways + down[..., None] * up, back[0] - sideways + down[..., None] * up]
    frame, middle = _frame(points, normals, up), points.mean(axis=(0, 1))
    moved = ((values - middle) @ frame.T for values in (points, back, *fillets))
    flank, other, fillet, back_fillet = moved
    lines = _lines(tree, scene, index, stations, nodes)
    return ToothShape(flank, normals @ frame.T, other, fillet, back_fillet, *lines)


def _half_thickness(prism: PrismBody, stations: FloatArray, nodes: FloatArray) -> FloatArray:
    """Half the tooth's thickness at the nodes, (face, profile) [mm]."""
    halves = []
    for section in prism.sections:
        order = np.argsort(section.flank_profile)
        halves.append(np.interp(nodes, section.flank_profile[order], section.flank[order, 0]))
    low, weight = between_stations(np.array(prism.faces), stations)
    high = np.minimum(low + 1, len(halves) - 1)
    rows = np.arange(stations.size)
    stacked = np.stack(halves)
    return np.asarray((1.0 - weight)[:, None] * stacked[low, rows] + weight[:, None] * stacked[high, rows])


def _fillets(prism: PrismBody, stations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances of the fillet from the flank's end, sideways and downwards, (point, face) [mm]."""
    along = np.linspace(0.0, 1.0, _FILLET_POINTS)
    curves = []
    for section in prism.sections:
        own = np.linspace(0.0, 1.0, len(section.fillet))
        curves.append(np.stack([np.interp(along, own, section.fillet[:, k] - section.fillet[0, k]) for k in (0, 1)]))
    low, weight = between_stations(np.array(prism.faces), stations)
    high = np.minimum(low + 1, len(curves) - 1)
    stacked = np.stack(curves)
    aside, below = np.moveaxis((1.0 - weight) * stacked[low].T + weight * stacked[high].T, 1, 0)
    return aside, below


def _turned(points: FloatArray, angle: FloatArray) -> FloatArray:
    """Points turned about the z axis."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, z], axis=-1)


def _frame(points: FloatArray, normals: FloatArray, up: FloatArray) -> FloatArray:
    """Rotation matrix with rows along the tooth, out of the flank, and from root to tip."""
    height = up.mean(axis=0) / np.linalg.norm(up.mean(axis=0))
    along = np.mean(points[:, -1] - points[:, 0], axis=0)
    along -= (along @ height) * height
    along /= np.linalg.norm(along)
    out = np.cross(height, along)
    side = np.sign(normals.mean(axis=(0, 1)) @ out)
    return np.stack([side * along, side * out, height])


def _lines(
    tree: xr.DataTree, scene: Scene, index: int, stations: FloatArray, nodes: FloatArray
) -> tuple[FloatArray | None, FloatArray | None, PassedStations | None]:
    """`ToothShape.line`, `ToothShape.hertz` and `ToothShape.passed` of the scene's placement."""
    if "engagement" not in tree.children:
        return None, None, None
    roll = np.asarray(tree["engagement"]["roll_position"].values, float)
    physics = plan(scene)
    traced = trace_contact_lines(physics.flank_pair(), roll, stations)
    passed = None if index == DRIVEN else PassedStations.of(traced.driving_face, stations)
    places = traced.profile if passed is None else passed.read(traced.driving_profile)
    rows = np.arange(nodes.shape[1], dtype=float)
    line = np.stack([np.interp(places[:, i], nodes[i], rows) for i in range(stations.size)], axis=1)
    curvature = np.maximum(traced.curvature, 0.0)
    return line, np.sqrt(physics.modulus * curvature / pi), passed

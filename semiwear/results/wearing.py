"""Bodies that wear, control point and pitch surfaces of a result."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from semiwear.meshing.flank_pair import BODIES
from semiwear.scene.kinds import KINDS
from semiwear.untyped import Table, Value


class ControlPlace(NamedTuple):
    """Position of the control point of a result.

    Attributes
    ----------
    body : str
    along : float [mm]
        Face coordinate: the radius for a face gear.
    height : float [mm]
    """

    body: str
    along: float
    height: float


def scene_tables(tree: xr.DataTree) -> Table:
    """Tables of a result's scene; empty where its text is no TOML."""
    try:
        return tomllib.loads(str(tree.attrs.get("scene_toml", "")))
    except tomllib.TOMLDecodeError:
        return {}


def _table(scene: Mapping[str, Value], name: str) -> Mapping[str, Value]:
    found = scene.get(name)
    return found if isinstance(found, Mapping) else {}


def worn_bodies(tree: xr.DataTree) -> tuple[str, ...]:
    """Bodies that wear, by the scene of a result, else by its maps of wear; empty without wear."""
    if "flank" not in tree.children:
        return ()
    wear = tree["flank"].to_dataset()["wear_depth"]
    bodies = [str(body) for body in wear["body"].values]
    named = _table(scene_tables(tree), "wear").get("worn_bodies")
    if isinstance(named, list):
        return tuple(body for body in bodies if body in named)
    return tuple(body for body in bodies if np.any(wear.sel(body=body).values))


def life_bodies(tree: xr.DataTree) -> tuple[str, str]:
    """The body whose wear ends the life of a result, and the other one if that wears deeper; else empty texts.

    Both are empty if the result does not state its scene.
    """
    limited = _table(_table(scene_tables(tree), "effects"), "run_life").get("body")
    if not isinstance(limited, str) or "flank" not in tree.children:
        return "", ""
    depths = tree["flank"].to_dataset()["wear_depth"].isel(wear_step=-1).max(("profile", "face"))
    deepest = {body: float(depths.sel(body=body)) for body in worn_bodies(tree)}
    first = max(deepest, key=deepest.__getitem__, default=limited)
    return limited, first if first != limited else ""


def main_body(tree: xr.DataTree) -> str:
    """The gear, unless the pinion alone wears."""
    return "pinion" if worn_bodies(tree) == ("pinion",) else "gear"


def shown_bodies(tree: xr.DataTree) -> tuple[str, ...]:
    """Bodies whose flanks are shown: those that wear, or the gear where none does."""
    return worn_bodies(tree) or (main_body(tree),)


def control_place(tree: xr.DataTree) -> ControlPlace | None:
    """The control point of a result's scene, if it has one."""
    point = _table(_table(scene_tables(tree), "wear"), "control_point")
    along, height = point.get("radius_mm", point.get("face_mm")), point.get("height_mm")
    if not isinstance(along, int | float) or not isinstance(height, int | float):
        return None
    return ControlPlace(str(point.get("body", main_body(tree))), float(along), float(height))


def pitch_name(tree: xr.DataTree) -> str:
    """Name of a pair's pitch surfaces: cones of a face gear pair, cylinders of a cylindrical one."""
    return _pitch_surfaces(tree)[0]


def pitch_surface(tree: xr.DataTree, body: str) -> str:
    """Surface from which heights on a body's flank are measured; the plane, for a face gear."""
    return _pitch_surfaces(tree)[1 + BODIES.index(body)]


def _pitch_surfaces(tree: xr.DataTree) -> tuple[str, str, str]:
    """Names of the pitch surfaces of a pair, of its pinion and of its gear."""
    kind = str(_table(scene_tables(tree), "gear_pair").get("type"))
    return KINDS[kind][0].pitch_surfaces if kind in KINDS else ("pitch surface",) * 3

"""Life of a result in hours or kilometres of sliding instead of meshes: an option of all pictures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.plain_text import one_of
from semiwear.results.missing import group_of
from semiwear.results.wearing import main_body, scene_tables
from semiwear.scene.units import LIFE_UNITS

_KM = 1e-6  # of a mm


def life_in(tree: xr.DataTree, unit: str) -> xr.DataTree:
    """A result whose wear steps are counted in hours or in kilometres of sliding, for pictures and reports.

    Its coordinate `meshes` holds the other count under its own name and unit; everything else is unchanged.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`.
    unit : str
        ``"meshes"`` for the result as it is; ``"hours"`` of running at the scene's speed; ``"km"`` of sliding, the
        greatest `sliding_distance` of a mesh summed over meshes, of the gear, or of the pinion where it alone wears.

    Raises
    ------
    SceneError
        There is no such unit, or the scene gives no speed for hours.
    """
    return counted_in(tree, unit, "unit")


def counted_in(tree: xr.DataTree, unit: str, argument: str) -> xr.DataTree:
    """The result of `life_in` for a unit that the user gave as the named argument, which errors tell."""
    if unit not in LIFE_UNITS:
        raise SceneError.of(argument, unit, one_of(LIFE_UNITS), "choose one of them")
    if unit == "meshes" or "history" not in tree.children:
        return tree
    if unit == "hours":
        values, attrs = hours_of(tree), {"units": "h", "long_name": "running time"}
        if values is None:
            fix = "set operation.pinion_speed_rpm and run again, or choose meshes or km"
            raise SceneError.of(argument, unit, "a result of a scene with a speed", fix)
    else:
        body = main_body(tree)
        values, attrs = _slid(tree, body), {"units": "km", "long_name": f"sliding of the {body}'s flank"}
    converted = tree.copy()
    for name in tree.children:
        dataset = tree[name].to_dataset()
        if "meshes" in dataset.coords:
            converted[name] = xr.DataTree(dataset.assign_coords(meshes=("wear_step", values, attrs)))
    return converted


def hours_of(tree: xr.DataTree) -> FloatArray | None:
    """Running time at the end of every wear step [h]; None where the scene gives no speed."""
    scene = scene_tables(tree)
    operation = scene.get("operation")
    speed = operation.get("pinion_speed_rpm") if isinstance(operation, Mapping) else None
    ratio = _ratio(tree)
    if not isinstance(speed, int | float) or ratio is None:
        return None
    return np.asarray(_meshes(tree) * ratio / (60.0 * speed))


def _meshes(tree: xr.DataTree) -> FloatArray:
    return np.asarray(group_of(tree, "history")["meshes"].values, float)


def _ratio(tree: xr.DataTree) -> float | None:
    """Turns of the pinion in one of the gear: meshes of a pinion tooth in one of a gear tooth."""
    pair = scene_tables(tree).get("gear_pair")
    if not isinstance(pair, Mapping) or "pinion_teeth" not in pair or "gear_teeth" not in pair:
        return None
    return float(abs(pair["gear_teeth"]) / pair["pinion_teeth"])


def _slid(tree: xr.DataTree, body: str) -> FloatArray:
    """Sliding distance of a body's flank up to the end of every wear step, at its greatest in a mesh [km]."""
    sliding = group_of(tree, "engagement")["sliding_distance"].sel(body=body)
    each = np.nan_to_num(sliding.max("roll_position").values)
    meshes = _meshes(tree) * ((_ratio(tree) or 1.0) if body == "pinion" else 1.0)
    steps = 0.5 * (each[1:] + each[:-1]) * np.diff(meshes)
    return np.asarray(_KM * np.concatenate([[0.0], np.cumsum(steps)]))

"""Scenes of flanks given as points: exported from other scenes, or made by `tests.strategies.bevel`."""

from collections.abc import Callable
from math import atan, cos
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.geometry.point_grid import PointGrid, read_point_grid, write_point_grid
from semiwear.scene import scene_from_dict
from tests.strategies.bevel import BevelPair

COARSE = {
    "face_slices": 31,
    "roll_positions": 12,
    "harmonics": 9,
}


def exported(
    scene: sw.Scene,
    folder: Path,
    points: tuple[int, int] = (101, 101),
    change: Callable[[str, PointGrid], PointGrid] | None = None,
    suffix: str = ".nc",
    **export: Any,
) -> dict[str, Any]:
    """A scene's flanks as points: the scene of these, as nested mappings.

    `change` makes another grid of a body's.
    """
    table: dict[str, Any] = {"type": "flank_points"}
    for body in ("pinion", "gear"):
        file = folder / f"{body}.nc"
        sw.export_flank(scene, body, file, points=points, **export)
        with xr.open_dataset(file) as data:
            told = dict(data.attrs)
        path = file.with_suffix(suffix)
        if change is not None or suffix != ".nc":
            grid = read_point_grid(file)
            assert isinstance(grid, PointGrid)
            write_point_grid(path, grid if change is None else change(body, grid))
        table |= {
            f"{body}_file": str(path),
            f"{body}_teeth": int(told["teeth"]),
            f"{body}_axis_point_mm": told["axis_point_mm"].tolist(),
            f"{body}_axis_direction": told["axis_direction"].tolist(),
            f"{body}_rotation": told["rotation"],
            f"{body}_tip_edge_radius_mm": float(told["tip_edge_radius_mm"]),
            f"{body}_end_edge_radius_mm": float(told["end_edge_radius_mm"]),
        }
    data = {name: value for name, value in scene.to_dict().items() if name != "reference"} | {"gear_pair": table}
    point = data.get("wear", {}).get("control_point")
    if point and "radius_mm" in point:
        # heights are normal to the pitch cone, those of the face gear are above its pitch plane
        height = point["height_mm"] * cos(atan(table["pinion_teeth"] / table["gear_teeth"]))
        data["wear"]["control_point"] = {"face_mm": point["radius_mm"], "height_mm": height}
    return data


def scene_of(data: dict[str, Any]) -> sw.Scene:
    """A checked scene."""
    return scene_from_dict(data, check=geometric_problems)


def noisy(size: float, seed: int = 0) -> Callable[[str, PointGrid], PointGrid]:
    """Grids with noise of a root mean square [mm] in every coordinate, without the normals."""
    random = np.random.default_rng(seed)

    def change(body: str, grid: PointGrid) -> PointGrid:
        points = grid.points + size * random.standard_normal(grid.points.shape)
        return PointGrid(points, None, grid.face, grid.profile_length, grid.sections, grid.attributes)

    return change


def bevel_scene(pair: BevelPair, folder: Path, points: tuple[int, int] = (41, 61), **numerics: Any) -> dict[str, Any]:
    """A scene of a bevel or hypoid pair, as nested mappings."""
    for body, grid in (("pinion", pair.pinion_grid(points)), ("gear", pair.gear_grid(points))):
        write_point_grid(folder / f"{body}.nc", PointGrid(*grid))
    return {
        "gear_pair": {
            "type": "flank_points",
            "pinion_file": str(folder / "pinion.nc"),
            "gear_file": str(folder / "gear.nc"),
            "pinion_teeth": pair.pinion_teeth,
            "gear_teeth": pair.gear_teeth,
            "gear_axis_point_mm": pair.gear_centre.tolist(),
            "gear_axis_direction": pair.gear_axis.tolist(),
            "pinion_rotation": "positive",
            "gear_rotation": "negative",
        },
        "operation": {"pinion_torque_Nm": 150.0},
        "wear": {
            "coefficient_mm2_per_N": 1e-13,
            "worn_bodies": ["pinion", "gear"],
            "until": {"meshes": 1e8},
        },
        "numerics": {"face_slices": 21, "roll_positions": 8, "profile_points": 61, "wear_steps": 1} | numerics,
    }

"""Scenes at another size: lengths times s, forces times s^2, torques times s^3, of the same materials."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.geometry.point_grid import PointGrid, read_point_grid, write_point_grid

# of the size; everything else is dimensionless or a stress
_POWERS = {"mm": 1, "um": 1, "N/mm": 1, "N": 2, "mm^3": 3}
# Neither depends on the size alone: seconds, and counts and rests of iterations that stop below a tolerance.
_ASIDE = ("/diagnostics",)


def scaled(scene: sw.Scene, size: float, folder: Path | None = None) -> sw.Scene:
    """The scene `size` times as large; what was left to its default stays so, files of points go to `folder`."""
    changes: dict[str, Any] = {"operation.pinion_torque_Nm": size**3 * scene.operation.pinion_torque_Nm}
    tables = {"gear_pair": scene.gear_pair, "wear.control_point": scene.wear and scene.wear.control_point}
    for name, table in tables.items():
        for entry in fields(table) if table is not None else ():
            value = getattr(table, entry.name)
            derived = entry.name in getattr(table, "_derived", ()) or value == "auto"
            if entry.name.endswith("_mm") and not derived:
                large = [size * x for x in value] if isinstance(value, tuple) else size * value
                changes[f"{name}.{entry.name}"] = large
            elif entry.name.endswith("_file"):
                assert folder is not None
                grid = read_point_grid(value)
                assert isinstance(grid, PointGrid)
                changes[f"{name}.{entry.name}"] = str(folder / f"{size:g}_{Path(value).name}")
                write_point_grid(changes[f"{name}.{entry.name}"], scaled_grid(grid, size))
    assert scene.wear is not None
    depths = scene.wear.until.control_depths_um
    if depths is not None:
        changes["wear.until.control_depths_um"] = [size * depth for depth in depths]
    return scene.replace(changes)


def scaled_grid(grid: PointGrid, size: float) -> PointGrid:
    """A grid of points `size` times as large, without tooth sections of its own."""
    return replace(
        grid,
        points=size * grid.points,
        face=None if grid.face is None else size * grid.face,
        profile_length=None if grid.profile_length is None else size * grid.profile_length,
        sections=(),
        attributes={},
    )


def dimensionless_difference(one: xr.DataTree, other: xr.DataTree, size: float) -> dict[str, float]:
    """Of every variable the greatest difference over its greatest value; `other` is `size` times as large."""
    found = {}
    for group in set(one.groups) - set(_ASIDE):
        for name, first in one[group].to_dataset().data_vars.items():
            if first.dtype.kind != "f":
                assert np.array_equal(first.values, other[group][name].values), name
                continue
            second = other[group][name].values / size ** _POWERS.get(str(first.attrs.get("units")), 0)
            assert first.shape == second.shape and np.array_equal(np.isnan(first.values), np.isnan(second)), name
            top = np.nanmax(np.abs(first.values), initial=0.0)
            apart = np.nanmax(np.abs(first.values - second), initial=0.0)
            found[f"{group}/{name}"] = float(apart / top if top > 0.0 else apart)
    return found

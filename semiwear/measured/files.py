"""Measured flanks from files and arrays, checked for common mistakes."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.geometry.point_grid import PointGrid, read_point_grid
from semiwear.measured.nearest import around_axis
from semiwear.measured.nominal import NominalFlank
from semiwear.meshing.deviation_grid import DeviationGrid, read_deviation_grid
from semiwear.plain_text import lines_of
from semiwear.sources import oversized

Measurement = PointGrid | DeviationGrid
"""Data of a measuring machine: points of a flank, or deviations from it."""

_LEAST = 4  # points in each direction
_SCALES = {"metres": 1e-3, "micrometres": 1e3, "inches": 1.0 / 25.4, "centimetres": 0.1}
_SCALE_TOLERANCE = 0.2
_APART = 0.25  # of the body's radius: points farther off belong to another part
_WRONG_SIDE = np.radians(20.0)


def read_measured(measured: str | os.PathLike[str] | ArrayLike | Measurement, field: str = "measured") -> Measurement:
    """A measured flank from a file, an array of points, or a grid that was already read.

    Parameters
    ----------
    measured : path, (P, F, 3) array [mm], PointGrid or DeviationGrid
        A .nc or .csv file of points (`semiwear.geometry.point_grid`) or of deviations
        (`semiwear.meshing.deviation_grid`), recognised by its contents. Points are in the body's own frame: z is
        its axis, as `export_flank` writes them.
    field : str
        Name of the measurement in error messages.

    Raises
    ------
    SceneError
        With the file, its defect and a remedy.
    """
    if isinstance(measured, PointGrid | DeviationGrid):
        return measured
    if isinstance(measured, str | os.PathLike):
        return _from_file(Path(measured), field)
    points = np.asarray(measured, float)
    if points.ndim != 3 or points.shape[-1] != 3:
        raise SceneError.of(field, f"an array of shape {points.shape}", "points (profile, face, 3) in mm, or a file")
    return PointGrid(points)


def _from_file(file: Path, field: str) -> Measurement:
    if file.is_file() and _holds_deviations(file):
        return read_deviation_grid(file, field)
    found = read_point_grid(file, field)
    if isinstance(found, Problem):
        raise SceneError([found], "measured flank")
    return found


def _holds_deviations(file: Path) -> bool:
    if file.suffix.casefold() == ".csv":
        try:
            lines = lines_of(file.read_text(encoding="utf-8-sig"))
        except UnicodeDecodeError:
            return False
        return bool(lines) and lines[0].lstrip().startswith(("um", "µm", "μm"))
    if oversized(file):
        return False
    try:
        with xr.open_dataset(file, engine="netcdf4") as data:
            return "deviation" in data
    except (OSError, ValueError):
        return False


def check_points(flank: NominalFlank, grid: PointGrid, field: str) -> None:
    """Refuse points that cannot lie on the flank.

    Raises
    ------
    SceneError
        For gaps, too few points, other units, another part or position.
    """
    points = grid.points
    if points.ndim != 3 or points.shape[-1] != 3:
        raise SceneError.of(field, f"points of shape {points.shape}", "points (profile, face, 3) in mm")
    if min(points.shape[:2]) < _LEAST:
        found = f"{points.shape[0]} x {points.shape[1]} points"
        raise SceneError.of(field, found, f"{_LEAST} x {_LEAST} points or more", "measure a finer grid")
    bad = ~np.all(np.isfinite(points), axis=-1)
    if bad.any():
        where = tuple(int(k) for k in np.argwhere(bad)[0])
        found = f"{int(bad.sum())} points that are not finite, the first at (profile, face) = {where}"
        raise SceneError.of(field, found, "finite coordinates", "fill the gaps of the grid or cut them off")
    nominal, _ = flank.points(*flank.places(np.linspace(0.0, 1.0, 9)[:, None], np.linspace(0.0, 1.0, 9)))
    radius = around_axis(nominal)[1]
    own = np.hypot(points[..., 0], points[..., 1])
    ratio = float(np.median(own) / np.median(radius))
    for unit, scale in _SCALES.items():
        if abs(ratio / scale - 1.0) < _SCALE_TOLERANCE:
            found = f"points at a radius of {np.median(own):.4g}, the flank is at {np.median(radius):.4g} mm"
            raise SceneError.of(field, found, "points in mm", f"these look like {unit}: convert them")
    height, reach = float(np.ptp(radius)), _APART * float(radius.max())
    if own.min() > radius.max() + reach or own.max() < radius.min() - reach:
        found = f"points at radii from {own.min():.4g} to {own.max():.4g} mm"
        allowed = f"about those of the flank, {radius.min():.4g} to {radius.max():.4g} mm (z is the body's axis)"
        raise SceneError.of(field, found, allowed, "check the body, the frame of the points and their order x, y, z")
    size = np.linalg.norm(np.ptp(points.reshape(-1, 3), axis=0))
    if size < 0.05 * max(height, 1e-3):
        raise SceneError.of(field, f"points within {size:.3g} mm", "points over the flank", "check the units")


def check_side(normals: FloatArray, points: FloatArray, inside: BoolArray, field: str) -> None:
    """Refuse a grid whose surface is inclined to the nominal one: the other flank, or a mirror image.

    Parameters
    ----------
    normals : (P, F, 3) array
        Nominal normals at the nearest nominal points.
    points : (P, F, 3) array [mm]
        Measured, registered.
    inside : (P, F) bool array

    Raises
    ------
    SceneError
        If the median angle between the surfaces is more than 20 degrees.
    """
    own = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    length = np.linalg.norm(own, axis=-1)
    if np.median(length) == 0.0:
        raise SceneError.of(field, "points that coincide", "points over the flank", "give each point once")
    cosine = np.abs(np.sum(own * normals, axis=-1)) / np.where(length > 0.0, length, 1.0)
    angle = float(np.median(np.arccos(np.clip(cosine[inside], 0.0, 1.0))))
    if angle > _WRONG_SIDE:
        raise SceneError.of(
            field,
            f"a surface at {np.degrees(angle):.0f} degrees to the nominal flank",
            "points of the loaded flank (operation.loaded_flank)",
            "this looks like the tooth's other flank or a mirror image: take the other one, or change the sign of x",
        )

"""Checks of a grid of points before any surface is laid through it."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

import numpy as np

from semiwear.errors import Problem
from semiwear.geometry.point_grid import PointGrid
from semiwear.geometry.point_surface import LEAST_POINTS, cell_normals

_FACE_TO_LENGTH = 100.0  # face coordinate over length of the tooth, or the inverse: more means another unit
_UNIT = 1e-3  # error of the length of a unit normal
_SAME = 1e-9  # of the flank's size: points within it count as the same
_COARSE_TURN = 20.0  # degrees by which the normal may turn from cell to cell
_PITCHES = (0.2, 1000.0)  # mm: pitch, for modules of 0.06 to 300
_HEIGHTS = (0.05, 4.0)  # height of a flank over the pitch


def grid_problems(grid: PointGrid, key: str, path: str, teeth: int) -> list[Problem]:
    """Problems of a grid, from the first check that finds any, since later ones may follow from them.

    Parameters
    ----------
    grid : PointGrid
    key, path : str
        The scene's field, and its value.
    teeth : int
        Teeth of the body.
    """
    checks = (_size, _numbers, _distinct, _folds, _columns, _teeth)
    for check in checks:
        found = [Problem(key, f"{path}: {value}", allowed, fix) for value, allowed, fix in check(grid, teeth)]
        if found:
            return found
    return []


Finding = tuple[str, str, str]
"""A finding, the allowed values, and advice."""


def _size(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    rows, columns = grid.points.shape[:2]
    if min(rows, columns) < LEAST_POINTS:
        fix = "give a finer grid: 25 x 25 is coarse, 101 x 101 is fine"
        yield f"{rows} x {columns} points", f"{LEAST_POINTS} x {LEAST_POINTS} points or more", fix


def _numbers(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    for kind, values in (("point", grid.points), ("normal", grid.normals)):
        if values is None:
            continue
        bad = np.argwhere(~np.isfinite(values).all(axis=-1))
        if bad.size:
            i, j = bad[0]
            found = f"{len(bad)} {kind}(s) without a number, the first at (profile {i}, face {j})"
            yield found, "finite numbers", "fill the gaps of the grid, or cut its rows or columns off"
    if grid.face is not None and not np.all(np.isfinite(grid.face)):
        yield "a face coordinate without a number", "finite numbers", "complete the coordinate face, or leave it out"


def _distinct(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    size = float(np.linalg.norm(np.ptp(grid.points, axis=(0, 1))))
    for axis, kind in ((0, "rows"), (1, "columns")):
        steps = np.linalg.norm(np.diff(grid.points, axis=axis), axis=-1)
        if steps.min() <= _SAME * size:
            i, j = np.unravel_index(int(np.argmin(steps)), steps.shape)
            k = int((i, j)[axis])
            where = f"{kind} {k} and {k + 1} at (profile {i}, face {j})"
            yield f"the same point twice: {where}", "distinct neighbours", f"give each of the {kind} once"
            return


def _folds(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    points = grid.points
    for axis, kind in ((0, "rows"), (1, "columns")):
        steps = np.moveaxis(np.diff(points, axis=axis), axis, 0)
        lead = np.moveaxis(np.sum(steps[1:] * steps[:-1], axis=-1), 0, axis)
        if lead.min() <= 0.0:
            i, j = np.unravel_index(int(np.argmin(lead)), lead.shape)
            found = f"the grid folds back between {kind} near (profile {i}, face {j})"
            yield (
                found,
                f"{kind} in the order in which they lie on the flank",
                f"sort the {kind}, or correct the point",
            )
            return
    normals = cell_normals(points)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    for axis in (0, 1):
        turn = np.sum(np.diff(normals, axis=axis) ** 2, axis=-1)
        worst = float(2.0 * np.arcsin(np.clip(0.5 * np.sqrt(turn.max()), 0.0, 1.0)))
        i, j = np.unravel_index(int(np.argmax(turn)), turn.shape)
        if worst > 0.5 * np.pi:
            found = f"the grid is folded at (profile {i}, face {j}): neighbouring cells face opposite ways"
            yield found, "a grid whose lines do not cross", "sort its rows and columns, or correct the point"
            return
        if degrees(worst) > _COARSE_TURN:
            found = f"the flank turns by {degrees(worst):.0f} degrees from cell to cell at (profile {i}, face {j})"
            allowed = f"at most {_COARSE_TURN:.0f} degrees"
            yield found, allowed, "the grid is too coarse there, or a point is far off: give a finer one"
            return


def _columns(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    if grid.face is not None and np.any(np.diff(grid.face) <= 0.0):
        fix = "sort the columns, or leave the coordinate out"
        yield "a coordinate face that does not rise", "one rising face coordinate [mm] a column", fix
    elif grid.face is not None:
        along = np.linalg.norm(np.diff(grid.points[len(grid.points) // 2], axis=0), axis=-1).sum()
        with np.errstate(over="ignore"):
            span = grid.face[-1] - grid.face[0]
        if not along / _FACE_TO_LENGTH <= span <= along * _FACE_TO_LENGTH:
            found = f"a coordinate face over {span:.3g} mm along a tooth of {along:.3g} mm"
            yield found, "about the length of the tooth", "give it in mm, or leave the coordinate out"
    if grid.normals is not None:
        length = np.linalg.norm(grid.normals, axis=-1)
        if np.abs(length - 1.0).max() > _UNIT:
            worst = float(length.flat[int(np.argmax(np.abs(length - 1.0)))])
            yield f"a normal of length {worst:.4g}", "unit normals", "divide each by its length, or leave them out"
    stated = grid.attributes.get("teeth")
    if stated is not None and int(stated) != teeth:
        yield f"made for {int(stated)} teeth, not {teeth}", f"{int(stated)} teeth", "give the right file or teeth"


def _teeth(grid: PointGrid, teeth: int) -> Iterator[Finding]:
    """Problems of a flank's proportions for this number of teeth about the z axis."""
    points = grid.points
    radius = np.hypot(points[..., 0], points[..., 1])
    pitch = 2.0 * np.pi * float(radius.mean()) / teeth
    height = float(np.linalg.norm(points[-1] - points[0], axis=-1).mean())
    low, high = _HEIGHTS
    if radius.min() <= 0.0 or not low * pitch <= height <= high * pitch:
        found = f"a flank {height:.4g} mm high at a mean radius of {radius.mean():.4g} mm about its z axis"
        allowed = (
            f"a height of {low * pitch:.3g} to {high * pitch:.3g} mm, {low:g} to {high:g} pitches of {teeth} teeth"
        )
        fix = "give the points in the body's own frame, whose z axis is the body's axis; or correct the teeth"
        yield found, allowed, fix
        return
    least, most = _PITCHES
    if not least <= pitch <= most:
        for unit, factor in (("metres", 1e3), ("micrometres", 1e-3)):
            if least <= pitch * factor <= most:
                fix = f"these look like {unit}: multiply the points by {factor:g}"
                break
        else:
            fix = "give the points in millimetres"
        yield f"a pitch of {pitch:.3g} mm", f"{least:g} to {most:g} mm", fix

"""Checks of the surface of a flank given as points: the side it faces, and its unit of length."""

from __future__ import annotations

from math import degrees, pi

import numpy as np

from semiwear.errors import Problem
from semiwear.geometry.point_grid import PointGrid
from semiwear.meshing.flank_pair import BODIES
from semiwear.meshing.point_flank_body import FlankBody
from semiwear.scene import FlankPointsPair

_LEANING = 0.02  # least inclination of a flank towards its tip: teeth are thinner at the tip
_NORMALS_OFF = 5.0  # degrees by which given normals may deviate from the surface
_ALIKE = 2.5  # pitches of both bodies
_UNITS = (("metres", 1e3), ("inches", 25.4), ("micrometres", 1e-3))


def side_problems(table: FlankPointsPair, index: int, body: FlankBody, grid: PointGrid) -> list[Problem]:
    """Problems of a flank's side, of the direction of its rows, and of given normals."""
    name = BODIES[index]
    key, path = f"gear_pair.{name}_file", getattr(table, f"{name}_file")
    does = "pushes" if body.pushes else "is pushed"
    surface = body.surface
    points, normals = body.points(surface.u[:, None], surface.v)
    if grid.normals is not None:
        agree = np.sum(normals * grid.normals, axis=-1)
        if np.mean(agree) < 0.0:
            fix = (
                f"they point into the material of a flank that {does} while its body turns "
                f"{getattr(table, f'{name}_rotation')}: turn the normals around, correct {name}_rotation, "
                "or give the other flank"
            )
            return [Problem(key, f"{path}: normals inward", "normals out of the material", fix)]
        worst = degrees(float(np.arccos(np.clip(agree.min(), -1.0, 1.0))))
        if worst > _NORMALS_OFF:
            i, j = np.unravel_index(int(np.argmin(agree)), agree.shape)
            found = f"{path}: a normal {worst:.0f} degrees off the surface at (profile {i}, face {j})"
            fix = "correct the normals or the points, or leave the normals out"
            return [Problem(key, found, f"normals within {_NORMALS_OFF:g} degrees", fix)]
    radius = np.hypot(points[..., 0], points[..., 1])
    around = np.stack([-points[..., 1], points[..., 0], 0.0 * radius], axis=-1) / radius[..., None]
    lever = np.sum(around * normals, axis=-1)
    if lever.max() * lever.min() <= 0.0:
        fix = "give the points in the body's own frame, whose z axis is the body's axis"
        found = f"{path}: a flank that faces both ways round its axis"
        return [Problem(key, found, "a flank that can turn its body", fix)]
    across = body.evaluate(surface.u[:, None], surface.v)[1]
    across = across / np.linalg.norm(across, axis=-1, keepdims=True)
    depth = across - np.sum(across * around, axis=-1)[..., None] * around
    leaning = float(np.mean(np.sum(depth * normals, axis=-1) / np.linalg.norm(depth, axis=-1)))
    if leaning > -_LEANING:
        return []
    rows = "its first row is the root end, its last the tip edge"
    outwards = float(np.mean(radius[-1] - radius[0]))
    if abs(outwards) > 0.3 * body.mean_length and outwards < 0.0:
        found = f"{path}: rows that run from the tip to the root"
        fix = "reverse the rows; of an internal gear give the other flank, or correct the rotation"
    else:
        found = f"{path}: a flank on the wrong side of its tooth"
        fix = (
            f"it {does} while its body turns {getattr(table, f'{name}_rotation')}, and would get thicker to its tip: "
            f"give the other flank, correct {name}_rotation, or reverse the rows if they run from the tip to the root"
        )
    return [Problem(key, found, f"a flank that leans to its tip; {rows}", fix)]


def unit_problems(bodies: list[FlankBody]) -> list[Problem]:
    """Problems of units: bodies of different pitch, or parallel axes at a distance unlike the flanks' radii."""
    radii = [float(np.mean(np.hypot(*np.moveaxis(body.surface.points[..., :2], -1, 0)))) for body in bodies]
    pitches = [2.0 * pi * radius / body.teeth for radius, body in zip(radii, bodies, strict=True)]
    parallel = np.linalg.norm(np.cross(bodies[0].frame[:, 2], bodies[1].frame[:, 2])) < 1e-6
    if not 1.0 / _ALIKE / 2.0 <= pitches[0] / pitches[1] <= _ALIKE * 2.0:
        small = int(np.argmin(pitches))
        factor = pitches[1 - small] / pitches[small]
        name = BODIES[small]
        found = f"a pitch of {pitches[small]:.3g} mm, the other body's is {pitches[1 - small]:.3g} mm"
        for unit, size in _UNITS[:2]:
            if 0.5 < factor / size < 2.0:
                fix = f"these look like {unit}: multiply the points by {size:g}"
                return [Problem(f"gear_pair.{name}_file", found, "points of both bodies in mm", fix)]
        if parallel:
            return [
                Problem(f"gear_pair.{name}_teeth", found, "two bodies of about the same pitch", "check the teeth")
            ]
    if parallel:
        axis = bodies[0].frame[:, 2]
        apart = bodies[1].centre - bodies[0].centre
        distance = float(np.linalg.norm(apart - (apart @ axis) * axis))
        # external or internal: in nearly equal gears the difference of the radii is small, whatever the unit
        expected = [total for total in (radii[0] + radii[1], abs(radii[1] - radii[0])) if total > 0.0]
        if any(_fits(distance, total) for total in expected):
            return []
        for unit, size in _UNITS:
            if any(_fits(distance, size * total) for total in expected):
                found = f"radii of {radii[0]:.3g} and {radii[1]:.3g} mm on axes {distance:.4g} mm apart"
                fix = f"the points look like {unit}: multiply them by {size:g}"
                return [Problem("gear_pair.pinion_file", found, "points in mm", fix)]
    return []


def _fits(distance: float, expected: float) -> bool:
    """Whether a centre distance agrees with the flanks' mean radii."""
    return 0.85 < distance / expected < 1.18

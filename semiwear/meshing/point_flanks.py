"""From the files of a table to two flanks in mesh: surfaces through points, and their rotations at roll 0.

The relative position of the two grids is unknown: a measured flank has any angle about its axis. So an angle of the
gear is searched at which some point of its flank can touch the pinion's with opposite normals; from there the
unloaded path of contact is followed, and roll 0 is where the flanks slide on it along their teeth, not across.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from math import degrees, pi

import numpy as np
from scipy.optimize import brentq

from semiwear.arrays import FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.geometry.point_grid import PointGrid, read_point_grid
from semiwear.geometry.point_problems import grid_problems
from semiwear.geometry.point_surface import PointSurface
from semiwear.meshing.contact_lines import trace_contact_lines
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.meshing.point_flank_body import FlankBody, frame_about
from semiwear.meshing.point_flank_kernels import meet
from semiwear.meshing.point_flank_pair import PointFlankMesh, PointFlanks
from semiwear.meshing.point_flank_sides import side_problems, unit_problems
from semiwear.meshing.point_pitch import PitchSurface, instantaneous_axis, pitch_point, pitch_surface
from semiwear.meshing.tooth_contact import ContactPoints, contact_points
from semiwear.scene import FlankPointsPair, Placement
from semiwear.untyped import Options

_TURNS = 1440  # angles of the gear that are tried
_PLACES = np.linspace(0.05, 0.95, 9)  # points on its flank, each way
_OPPOSITE = 0.03  # 1 + cosine of the normals: 14 degrees between them at most
_ROLLS = 1.5  # base pitches to either side, within which the path is followed
_STEPS = (37, 17)  # points of the first search, and of later ones about its best
_NARROWER = 8.0
_NARROWINGS = 3
_FACES = 9
_LINE = 1e-6  # of the flank's height: variation of the separation along a line, besides the surfaces' errors
_FARTHEST_LINE, _LINE_STEPS = 3.0, 97  # base pitches to either side, within which it crosses the middle of the face
_BESIDE = 1e-3  # of the face width, between stations in the middle of the face
# Defaults of the fields of edges and sections, on which the flanks' surfaces do not depend.
_OF_TEETH: Options = {
    entry.name: entry.default
    for entry in fields(FlankPointsPair)
    if entry.name.endswith(("_thickness_mm", "_radius_mm", "_depth_mm"))
}


def point_flanks_or_problems(table: FlankPointsPair) -> PointFlanks | tuple[Problem, ...]:
    """Both flanks in mesh, or all their problems; kept between runs as long as the files stay the same."""
    found = _kept(replace(table, **_OF_TEETH))
    return found if isinstance(found, tuple) else replace(found, table=table)


@lru_cache(maxsize=8)
def _kept(table: FlankPointsPair) -> PointFlanks | tuple[Problem, ...]:
    paths = {f"gear_pair.{name}_file": str(getattr(table, f"{name}_file")) for name in BODIES}
    return _flanks_or_problems(table, [read_point_grid(path, key) for key, path in paths.items()])


def _flanks_or_problems(
    table: FlankPointsPair, read: Sequence[PointGrid | Problem]
) -> PointFlanks | tuple[Problem, ...]:
    """Flanks in mesh from the grids read for the pinion and for the gear."""
    problems: list[Problem] = []
    bodies: list[FlankBody] = []
    grids: list[PointGrid] = []
    for index, (name, grid) in enumerate(zip(BODIES, read, strict=True)):
        key, path = f"gear_pair.{name}_file", str(getattr(table, f"{name}_file"))
        if isinstance(grid, Problem):
            problems.append(grid)
            continue
        found = grid_problems(grid, key, path, getattr(table, f"{name}_teeth"))
        problems += found
        if not found:
            body = _body(table, index, grid)
            problems += side_problems(table, index, body, grid)
            bodies.append(body)
            grids.append(grid)
    if len(bodies) == len(BODIES) and not problems:
        problems += unit_problems(bodies)
    if problems:
        return tuple(problems)
    try:
        with np.errstate(all="ignore"):
            return _in_mesh(table, (bodies[DRIVING], bodies[DRIVEN]), (grids[DRIVING], grids[DRIVEN]))
    except SceneError as error:
        return error.problems
    except (ArithmeticError, ValueError) as error:
        value = f"flanks whose contact cannot be computed ({error})"
        fix = "compare with flanks that export_flank writes; check the axes, the rotations and the teeth"
        return (Problem("gear_pair.pinion_file", value, "two flanks that roll on each other", fix),)


def point_flanks(table: FlankPointsPair) -> PointFlanks:
    """Both flanks in mesh.

    Raises
    ------
    SceneError
        With every problem of the files and of their mesh.
    """
    return _without_problems(point_flanks_or_problems(table))


def flanks_in_mesh(table: FlankPointsPair, pinion: PointGrid, gear: PointGrid) -> PointFlanks:
    """Both flanks in mesh from given points, instead of the files of the table.

    Raises
    ------
    SceneError
        With every problem of the points and of their mesh.
    """
    return _without_problems(_flanks_or_problems(table, (pinion, gear)))


def _without_problems(found: PointFlanks | tuple[Problem, ...]) -> PointFlanks:
    if isinstance(found, tuple):
        raise SceneError(found, "gear_pair")
    return found


def surfaces_summary(table: FlankPointsPair) -> str:
    """Summary of the surfaces through the points: their noise, smoothing and error."""
    parts = []
    for name, body in zip(BODIES, point_flanks(table).bodies, strict=True):
        surface = body.surface
        rows, columns = surface.points.shape[:2]
        text = f"{name} {rows} x {columns} points"
        if surface.smoothing > 0.0:
            text += f" with a noise of {1e3 * surface.noise:.2g} um, smoothed by {1e3 * surface.smoothing:.2g} um"
        elif surface.noisy:
            text += f" with a noise of {1e3 * surface.noise:.2g} um, not smoothed"
        parts.append(f"{text}, surface error {1e3 * surface.error:.2g} um")
    return "; ".join(parts)


# ---- one body


def _body(table: FlankPointsPair, index: int, grid: PointGrid) -> FlankBody:
    name = BODIES[index]
    smoothing = None if table.smoothing_um == "auto" else 1e-3 * float(table.smoothing_um)
    surface = PointSurface.through(grid.points, grid.face, smoothing)
    half = 0.5 * surface.face_length
    ends = (-half, half) if grid.face is None else (float(grid.face[0]), float(grid.face[-1]))
    return FlankBody(
        surface=surface,
        centre=np.array(getattr(table, f"{name}_axis_point_mm")),
        frame=frame_about(np.array(getattr(table, f"{name}_axis_direction"))),
        sense=1 if getattr(table, f"{name}_rotation") == "positive" else -1,
        teeth=getattr(table, f"{name}_teeth"),
        pushes=index == DRIVING,
        face_ends=ends,
        own_lengths=grid.profile_length,
    )


# ---- both


def _in_mesh(
    table: FlankPointsPair, bodies: tuple[FlankBody, FlankBody], grids: tuple[PointGrid, PointGrid]
) -> PointFlanks:
    placeholder = PitchSurface(0.0, 0.0, (1.0, 0.0))
    flanks = PointFlanks(
        table, bodies, *_start(bodies), np.zeros(3), (placeholder, placeholder), 1.0,
        (grids[DRIVING].sections, grids[DRIVEN].sections),
        (_tooth_length(grids[DRIVING]), _tooth_length(grids[DRIVEN])),
    )  # fmt: skip
    flanks, position, directions = _at_no_sliding_across(flanks)
    (w_driving, w_driven), (driving, driven) = flanks.rotations, bodies
    motions = (w_driving, driving.centre), (w_driven, driven.centre)
    point = pitch_point(*motions, position)
    axis = instantaneous_axis(*motions)
    surfaces = [
        pitch_surface(body.frame, body.centre, point, along if axis is None else axis, _to_the_tips(body))
        for body, along in zip(bodies, directions, strict=True)
    ]
    flanks = replace(
        flanks,
        pitch_point=point,
        pitch_surfaces=(surfaces[DRIVING], surfaces[DRIVEN]),
        lever=float(PointFlankMesh(flanks, Placement()).lever_arm(position[None])[0]),
    )
    if grids[DRIVING].face is None or grids[DRIVEN].face is None:
        flanks = _with_shared_face(flanks)
    return flanks


def _tooth_length(grid: PointGrid) -> float | None:
    length = grid.attributes.get("tooth_length_mm")
    return None if length is None else float(length)


def _to_the_tips(body: FlankBody) -> FloatArray:
    """Radial and axial distance from root to tip [mm]."""
    radius, axial = body.radius_and_axial(np.array([[0.0], [1.0]]), np.linspace(0.0, 1.0, 5))
    return np.array([np.mean(radius[1] - radius[0]), np.mean(axial[1] - axial[0])])


def _start(bodies: tuple[FlankBody, FlankBody]) -> tuple[float, float]:
    """Rotations of the driven and the driving body at which the flanks touch with opposite normals."""
    driving, driven = bodies
    own, normals = (entry.reshape(-1, 3) for entry in driven.points(_PLACES[:, None], _PLACES))
    places = own.shape[0]
    turn = np.repeat(np.arange(_TURNS) * 2.0 * pi / _TURNS, places)
    position, normal, local = (np.empty((turn.size, 3)) for _ in range(3))
    meet(
        np.tile(own, (_TURNS, 1)), np.tile(normals, (_TURNS, 1)), turn, driven.frame, driven.centre, driving.frame,
        driving.centre, position, normal, local,
    )  # fmt: skip
    held = driving.touch(local[:, 0], local[:, 1])
    inside = (np.minimum(held.u, held.v) >= 0.0) & (np.maximum(held.u, held.v) <= 1.0)
    if not inside.any():
        reach = [_extent(body) for body in bodies]
        found = f"flanks that meet nowhere: about their axes the pinion's has {reach[0]}, the gear's {reach[1]}"
        fix = (
            "check the axes, the units of the points, and that they stand in the body's own frame, with the body's "
            "axis as z and its origin where the axis point lies"
        )
        raise SceneError.of("gear_pair.gear_axis_point_mm", found, "axes on which the flanks can touch", fix)
    index = np.flatnonzero(inside)
    theirs = driving.points(held.u[index], held.v[index])[1]
    rotation = local[index, 2] - held.polar[index]
    cosine = np.sum((_turned(theirs, rotation) @ driving.frame.T) * normal[index], axis=-1)
    best = int(np.argmin(cosine))
    if cosine[best] > _OPPOSITE - 1.0:
        found = f"flanks whose normals come no closer than {degrees(float(np.arccos(-cosine[best]))):.0f} degrees"
        fix = (
            "the driving flank lies on the other side of its tooth, a rotation is wrong, or the two flanks do not "
            "belong together (hand, pressure angle, axes)"
        )
        raise SceneError.of("gear_pair.pinion_file", found, "flanks that can touch", fix)
    return float(turn[index[best]]), float(rotation[best])


def _extent(body: FlankBody) -> str:
    grid = np.linspace(0.0, 1.0, 9)
    radius, axial = body.radius_and_axial(grid[:, None], grid)
    return (
        f"radii of {radius.min():.4g} to {radius.max():.4g} mm at {axial.min():.4g} to {axial.max():.4g} mm along it"
    )


def _at_no_sliding_across(flanks: PointFlanks) -> tuple[PointFlanks, FloatArray, FloatArray]:
    """The flanks turned to the point of their path of contact without sliding across their teeth.

    With the point (3,) and the directions (2, 3) of both bodies' teeth there.
    """
    driving, driven = flanks.bodies
    mesh = PointFlankMesh(flanks, Placement())

    def across(roll: FloatArray) -> tuple[ContactPoints, FloatArray]:
        """Contacts, and the square of the sliding across the driven body's teeth."""
        points = contact_points(mesh, roll)
        return points, _sliding_across(flanks, mesh, points.face, points.profile, roll) ** 2

    middle, width = 0.0, _ROLLS
    for narrowing in range(_NARROWINGS):
        roll = middle + np.linspace(-width, width, _STEPS[min(narrowing, 1)])
        points, sliding = across(roll)
        if not points.inside.any() and not narrowing:
            raise SceneError.of(
                "gear_pair.pinion_file",
                "flanks that touch nowhere within their borders",
                "a pair whose flanks roll on each other: convex enough against each other, with teeth that fit",
                "check the rotations, the teeth and the axes; a flank may lie on the wrong side of its tooth",
            )
        best = int(np.argmin(np.where(points.inside, sliding, np.inf)))
        middle, width = float(roll[best]), width / _NARROWER
    around = middle + np.array([-1.0, 0.0, 1.0]) * width
    points, (low, centre, high) = across(around)
    bend = low - 2.0 * centre + high
    if points.inside.all() and bend > 0.0:
        middle += width * float(np.clip(0.5 * (low - high) / bend, -1.0, 1.0))
    points, _ = across(np.array([middle]))
    place = _Place(points.face, points.profile, points.position, points.separation)
    at_middle = _in_the_middle_of_the_face(flanks, mesh, middle, float(points.separation[0]))
    if at_middle is not None:
        middle, place = at_middle
    position = place.position[0]
    lever = float(mesh.lever_arm(place.position)[0])
    moved = replace(
        flanks,
        driven_zero=flanks.driven_zero + driven.sense * 2.0 * pi / driven.teeth * middle,
        driving_zero=flanks.driving_zero
        + driving.sense * (2.0 * pi / driving.teeth * middle + float(place.separation[0]) / lever),
    )
    own = _along(flanks, place.face, place.profile, np.array([middle]))[0]
    return moved, position, np.stack([_along_driving(driving, position), own])


@dataclass(frozen=True)
class _Place:
    """Contact of the flanks at one roll position: arrays as of `ContactPoints`."""

    face: FloatArray
    profile: FloatArray
    position: FloatArray
    separation: FloatArray


def _in_the_middle_of_the_face(
    flanks: PointFlanks, mesh: PointFlankMesh, near: float, least: float
) -> tuple[float, _Place] | None:
    """Roll position and place without sliding across, in the middle of the driven face, if flanks touch along lines.

    None if the flanks are farther apart there than at the least separation, or do not reach there.
    """
    low, high = mesh.face_limits
    stations = 0.5 * (low + high) + _BESIDE * (high - low) * np.array([-1.0, 0.0, 1.0])

    def across(roll: FloatArray) -> tuple[FloatArray, FloatArray]:
        lines = trace_contact_lines(mesh, roll, stations, sharp=True)
        profile = lines.profile[:, 1]
        inside = (profile > lines.low[:, 1]) & (profile < lines.high[:, 1]) & np.isfinite(lines.separation[0][:, 1])
        face = np.full(roll.size, stations[1])
        return profile, np.where(inside, _sliding_across(flanks, mesh, face, profile, roll), np.nan)

    # the line may cross the middle of the face some pitches before or after its own middle is on the pitch surface
    roll = near + np.linspace(-_FARTHEST_LINE, _FARTHEST_LINE, _LINE_STEPS)
    _, sliding = across(roll)
    turns = np.flatnonzero(sliding[:-1] * sliding[1:] <= 0.0)
    if not turns.size:
        return None
    first = int(turns[np.argmin(np.abs(roll[turns] - near))])
    found = brentq(lambda at: float(across(np.array([at]))[1][0]), roll[first], roll[first + 1], xtol=1e-12)
    profile, _ = across(np.array([found]))
    met = mesh.meeting(stations[1:2], profile, np.array([found]))
    apart = abs(float(met.separation[0]) - least)
    if apart > _LINE * flanks.driven.mean_length + 3.0 * sum(mesh.surface_errors):
        return None
    return found, _Place(stations[1:2], profile, met.position, met.separation)


def _sliding_across(
    flanks: PointFlanks, mesh: PointFlankMesh, face: FloatArray, profile: FloatArray, roll: FloatArray
) -> FloatArray:
    """Sliding across the driven body's teeth at places of its flank [mm per radian of pinion rotation]."""
    met = mesh.meeting(face, profile, roll)
    along = _along(flanks, face, profile, roll)
    return np.asarray(np.sum(np.cross(met.normal, along) * mesh.sliding(met.position), axis=-1))


def _along(flanks: PointFlanks, face: FloatArray, profile: FloatArray, roll: FloatArray) -> FloatArray:
    """Unit directions of the driven body's teeth at places of its flank, in the fixed frame: (n, 3) array."""
    driven = flanks.driven
    v = driven.v_at(face)
    along = driven.evaluate(driven.u_at(profile, driven.profile_length(v)), v)[2]
    turn = flanks.driven_zero + driven.sense * 2.0 * pi / driven.teeth * roll
    return _turned(along / np.linalg.norm(along, axis=-1, keepdims=True), turn) @ driven.frame.T


def _along_driving(driving: FlankBody, position: FloatArray) -> FloatArray:
    """Unit direction of the driving body's tooth at a position on its flank, in the fixed frame."""
    local = (position - driving.centre) @ driving.frame
    held = driving.touch(np.array([np.hypot(local[0], local[1])]), local[2:3].copy())
    along = driving.evaluate(held.u, held.v)[2]
    turned = _turned(along / np.linalg.norm(along), np.arctan2(local[1], local[0]) - held.polar)
    return np.asarray((turned @ driving.frame.T)[0])


def _turned(vectors: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors turned about the z axis."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y, vectors[..., 2]], axis=-1)


def _with_shared_face(flanks: PointFlanks) -> PointFlanks:
    """Flanks whose driving stations have the face coordinates of their mating points at the pitch point."""
    driving = flanks.driving
    mesh = PointFlankMesh(flanks, Placement())
    low, high = flanks.driven.face_limits
    face = np.linspace(low, high, _FACES)
    met = mesh.meeting(face, mesh.pitch_profile(face), np.zeros(1))
    slope, offset = np.polyfit(face, driving.v_at(met.driving_face), 1)
    ends = (float(-offset / slope), float((1.0 - offset) / slope))
    return replace(flanks, bodies=(replace(driving, face_ends=ends), flanks.driven))

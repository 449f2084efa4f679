"""Limits of flanks given as points: readable files, grids that form flanks, and flanks that can mesh."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import cast

import numpy as np

from semiwear.check.limits import down, up, watched_point
from semiwear.errors import Problem, SceneError
from semiwear.meshing.flank_pair import BODIES, DRIVING
from semiwear.meshing.point_flank_pair import PointFlankMesh, PointFlanks
from semiwear.meshing.point_flank_sections import section_problems
from semiwear.meshing.point_flanks import point_flanks, point_flanks_or_problems
from semiwear.meshing.tooth_contact import separation_of_neighbours
from semiwear.scene import FlankPointsControlPoint, FlankPointsPair, Placement, Scene

_SEARCH = (3, 8)  # base pitches to either side of the pitch point, steps per base pitch


def flank_points_problems(scene: Scene) -> list[Problem]:
    """Problems of flanks given as points; see `semiwear.check.geometric_problems`."""
    flanks = point_flanks_or_problems(cast(FlankPointsPair, scene.gear_pair))
    if isinstance(flanks, tuple):
        return list(flanks)
    mesh = PointFlankMesh(flanks, Placement())
    found = [*_edges_fit(mesh), *_teeth_hand_over(mesh), *_sections(scene, flanks)]
    return found or list(_control_point_is_on_the_flank(scene, mesh))


def _edges_fit(mesh: PointFlankMesh) -> Iterator[Problem]:
    """The rounded edges leave a flank."""
    ends = np.array(mesh.face_limits)
    sharp, rounded = mesh.borders(ends, sharp=True), mesh.borders(ends)
    radii = sharp.driving_tip_edge_radius, sharp.tip_edge_radius
    insets = sharp.driving_tip - rounded.driving_tip, float((sharp.tip - rounded.tip).max())
    lengths = sharp.driving_tip, float(sharp.tip.min())
    end_radii = sharp.driving_end_edge_radius, sharp.end_edge_radius
    widths = sharp.driving_face[1] - sharp.driving_face[0], ends[1] - ends[0]
    fix = "an edge radius is small, usually 0.2 mm at a module of 5"
    for k, body in enumerate(BODIES):
        if insets[k] >= lengths[k]:
            allowed = f"below {down(radii[k] * lengths[k] / insets[k])} mm"
            yield Problem(f"gear_pair.{body}_tip_edge_radius_mm", radii[k], allowed, fix)
        if end_radii[k] >= 0.5 * widths[k]:
            allowed = f"less than half the face width ({down(0.5 * widths[k])} mm)"
            yield Problem(f"gear_pair.{body}_end_edge_radius_mm", end_radii[k], allowed, fix)


def _teeth_hand_over(mesh: PointFlankMesh) -> Iterator[Problem]:
    """Flanks meet at every mesh position."""
    if not _hands_over(mesh.flanks.table):
        fix = "check the teeth of both bodies, and that the rows reach to the tip edges"
        yield Problem("gear_pair.pinion_teeth", mesh.flanks.driving.teeth, "flanks that hand over", fix)


@lru_cache(maxsize=16)
def _hands_over(table: FlankPointsPair) -> bool:
    """Whether a tooth pair is in mesh when the next one enters; cached, since most changes keep the flanks."""
    try:
        separation_of_neighbours(PointFlankMesh(point_flanks(table), Placement()), *_SEARCH)
    except SceneError:
        return False
    return True


def _sections(scene: Scene, flanks: PointFlanks) -> Iterator[Problem]:
    """The section of a tooth can be derived if its file has none; rigid teeth need none."""
    if scene.numerics.tooth_compliance == "rigid":
        return
    for index in range(len(BODIES)):
        if not flanks.sections[index]:
            yield from section_problems(flanks.table, index, flanks.bodies[index], flanks.pitch_surfaces[index])


def _control_point_is_on_the_flank(scene: Scene, mesh: PointFlankMesh) -> Iterator[Problem]:
    """The control point lies on its body's flank, between root and tip edge."""
    watched = watched_point(scene, FlankPointsControlPoint)
    if watched is None:
        return
    point, body = watched
    low, high = mesh.face_limits
    if not low <= point.face_mm <= high:
        fix = "the face coordinate of the gear's points; without one, the length from the tooth's middle"
        yield Problem("wear.control_point.face_mm", point.face_mm, f"{up(low)} to {down(high)} mm", fix)
        return
    station = np.array([point.face_mm])
    borders = mesh.borders(station)
    ends = np.array([float(borders.root[0]), float(borders.tip[0])])
    if body == DRIVING:
        ends = np.array([borders.driving_root, borders.driving_tip])
    heights = mesh.flank_place(body, np.full(2, point.face_mm), ends)[0]
    if not heights[0] <= point.height_mm <= heights[1]:
        allowed = f"{up(float(heights[0]))} to {down(float(heights[1]))} mm, root end to tip edge there"
        fix = "the height above the pitch surface, normal to it"
        yield Problem("wear.control_point.height_mm", point.height_mm, allowed, fix)

"""Limits of flanks given as points, each with the value of the pair."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import cast

import numpy as np

from semiwear.check.margins import Margin, margin
from semiwear.meshing.flank_pair import BODIES
from semiwear.meshing.point_flank_pair import PointFlankMesh
from semiwear.meshing.point_flanks import point_flanks_or_problems
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.scene import FlankPointsPair, Placement, Scene


def flank_points_margins(scene: Scene) -> Iterator[Margin]:
    """Limits of flanks given as points; see `semiwear.check.margins.check_geometry`."""
    flanks = point_flanks_or_problems(cast(FlankPointsPair, scene.gear_pair))
    if isinstance(flanks, tuple):  # the files cannot be read
        return
    mesh = PointFlankMesh(flanks, Placement())
    ends = np.array(mesh.face_limits)
    sharp, rounded = mesh.borders(ends, sharp=True), mesh.borders(ends)
    lengths = rounded.driving_tip - rounded.driving_root, float((rounded.tip - rounded.root).min())
    radii = sharp.driving_end_edge_radius, sharp.end_edge_radius
    widths = sharp.driving_face[1] - sharp.driving_face[0], float(ends[1] - ends[0])
    for k, body in enumerate(BODIES):
        yield margin(
            f"flank of the {body} within its edges", partial(float, lengths[k]), f"{body}_tip_edge_radius_mm",
            low=0.0,
        )  # fmt: skip
        yield margin(
            f"end edge radius of the {body}", partial(float, radii[k]), f"{body}_end_edge_radius_mm",
            high=0.5 * widths[k],
        )  # fmt: skip
    yield margin(
        "contact ratio", lambda: unloaded_contact(mesh).contact_ratio, "pinion_teeth", low=0.0, unit="1",
        usual="1.2 or more; below 1 teeth hand over on their edges",
    )  # fmt: skip

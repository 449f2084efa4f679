"""Limits of a face gear pair, each with the value of the pair."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi, tan
from typing import cast

import numpy as np

from semiwear.check.face_gear import edge_limits
from semiwear.check.margins import Margin, margin
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import BODIES
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.scene import FaceGearPair, Placement, Scene


def face_gear_margins(scene: Scene) -> Iterator[Margin]:
    """Limits of a face gear pair's teeth; see `semiwear.check.margins.check_geometry`."""
    table = cast(FaceGearPair, scene.gear_pair)
    mesh = FaceGearMesh(table, Placement())
    yield from _gear(table, mesh.gear)
    yield from _pinion(table, mesh.pinion)
    clearance = f"{0.25 * table.module_mm:.3g} mm (0.25 m)"
    yield margin(
        "tip clearance of the pinion",
        lambda: table.shaper_addendum_mm - table.pinion_addendum_mm, "shaper_addendum_mm", low=0.0, usual=clearance,
    )  # fmt: skip
    yield margin(
        "tip clearance of the gear",
        lambda: table.rack_addendum_mm - table.gear_addendum_mm, "rack_addendum_mm", low=0.0, usual=clearance,
    )  # fmt: skip
    yield margin(
        "addendum of the pinion (interference)", lambda: table.pinion_addendum_mm,
        "pinion_addendum_mm", high=lambda: mesh.gear.shaper_flank_depth,
    )  # fmt: skip
    yield margin(
        "addendum of the gear (interference)", lambda: table.gear_addendum_mm, "gear_addendum_mm",
        high=lambda: min(mesh.pinion.straight_depth, mesh.pinion.undercut_depth),
    )  # fmt: skip
    for k, body in enumerate(BODIES):
        edge = f"{body}_tip_edge_radius_mm"
        radius = partial(getattr, table, edge)
        if radius() > 0.0:
            yield margin(f"tip edge radius of the {body}", radius, edge, high=partial(_edge, mesh, k))
    yield margin(
        "contact ratio", lambda: unloaded_contact(mesh).contact_ratio, "gear_addendum_mm", low=0.0, unit="1",
        usual="1.4 or more; below 1 teeth hand over on their edges",
    )  # fmt: skip


def _gear(table: FaceGearPair, tooth: FaceGearTooth) -> Iterator[Margin]:
    """Limits of the gear's tooth and of the shaper that cuts it."""
    inner, outer, pitch = table.gear_inner_radius_mm, table.gear_outer_radius_mm, tooth.pitch_radius
    yield margin(
        "inner radius of the gear (undercut)", lambda: inner, "gear_inner_radius_mm",
        low=tooth.undercut_radius, high=pitch,
    )  # fmt: skip
    yield margin(
        "outer radius of the gear (pointing)", lambda: outer, "gear_outer_radius_mm", low=pitch,
        high=tooth.pointing_radius,
    )  # fmt: skip
    for end, radius in (("inner", inner), ("outer", outer)):
        yield margin(
            f"tip thickness of the gear, {end} radius",
            partial(_tip_thickness, tooth, radius), f"gear_{end}_radius_mm", low=0.0,
            usual=f"{0.2 * table.module_mm:.3g} mm (0.2 m) or more" if end == "outer" else "",
        )  # fmt: skip
    yield margin(
        "flank above the fillet, inner radius",
        lambda: tooth.gear_addendum - float(tooth.height(np.array(inner), np.array(tooth.root_profile))),
        "gear_inner_radius_mm", low=0.0,
    )  # fmt: skip
    yield margin(
        "addendum of the gear (shaper's base circle)", lambda: table.gear_addendum_mm,
        "gear_addendum_mm", high=lambda: float(tooth.height(np.array(inner), tooth.profile_from_roll(0.0))),
    )  # fmt: skip
    yield margin("land on the shaper's crest", lambda: 2.0 * tooth.crest_half_width, "shaper_tip_radius_mm", low=0.0)


def _pinion(table: FaceGearPair, pinion: InvoluteTooth) -> Iterator[Margin]:
    """Limits of the pinion's tooth."""
    yield margin(
        "tip thickness of the pinion", lambda: 2.0 * pinion.tip_half_thickness, "pinion_addendum_mm", low=0.0,
        usual=f"{0.2 * table.module_mm:.3g} mm (0.2 m) or more, twice that if case-hardened",
    )  # fmt: skip
    yield margin(
        "straight flank of the rack (undercut)", lambda: pinion.straight_depth,
        "rack_tip_radius_mm", high=lambda: pinion.undercut_depth,
    )  # fmt: skip
    full = (0.25 * pi * table.module_mm - table.rack_addendum_mm * tan(pinion.pressure_angle)) * 2.0
    yield margin("land on the rack's crest, unrounded", lambda: full, "rack_addendum_mm", low=0.0)


def _edge(mesh: FaceGearMesh, body: int) -> float:
    """Tip edge radius at which a body's tooth has no top land left [mm]."""
    return edge_limits(mesh)[body]


def _tip_thickness(tooth: FaceGearTooth, radius: float) -> float:
    """Thickness of the gear's tooth in its tip plane at a radius, along the arc [mm]."""
    return 2.0 * tooth.half_thickness(radius, tooth.gear_addendum)

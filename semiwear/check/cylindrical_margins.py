"""Limits of a cylindrical pair, each with the value of the pair."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import degrees, isfinite
from typing import cast

from semiwear.check.cylindrical_limits import (
    edge_limits,
    jamming_distance,
    least_profile_shift,
    pointed_diameter,
    root_limits,
    teeth_of,
    tip_limits,
    tip_passage,
)
from semiwear.check.margins import Margin, margin
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.flank_pair import BODIES
from semiwear.scene import CylindricalPair, Placement, Scene


def cylindrical_margins(scene: Scene) -> Iterator[Margin]:
    """Limits of a cylindrical pair's teeth; see `semiwear.check.margins.check_geometry`."""
    table = cast(CylindricalPair, scene.gear_pair)
    limit = jamming_distance(table)
    ends = (None, limit) if table.internal else (limit, None)
    yield margin(
        "centre distance (jamming)", lambda: table.centre_distance_mm, "centre_distance_mm",
        low=ends[0], high=ends[1], usual=_without_backlash(scene, limit),
    )  # fmt: skip
    if not isfinite(table.working_pressure_angle):
        return
    mesh = CylindricalMesh(table, Placement())
    for body, tooth in teeth_of(mesh):
        yield from _tooth(table, body, tooth)
    yield from _pair(table, mesh)


def _without_backlash(scene: Scene, limit: float) -> str:
    """A remark if a misalignment brings the axes closer than the teeth allow; such a scene is computed."""
    moved, table = scene.effects.misalignment, cast(CylindricalPair, scene.gear_pair)
    distance = table.centre_distance_mm + (moved.axial_gear_mm if moved else 0.0)
    if not moved or (distance <= limit if table.internal else distance >= limit):
        return ""
    return f"misaligned {distance:.6g} mm: real teeth jam there, contact on both flanks is not modelled"


def _tooth(table: CylindricalPair, body: str, tooth: CylindricalTooth) -> Iterator[Margin]:
    """Limits of a tooth by itself."""
    module = table.normal_module_mm
    tip = f"{body}_tip_diameter_mm"
    if not tooth.internal:
        shift = f"{body}_profile_shift"
        yield margin(
            f"profile shift of the {body} (undercut)", lambda: tooth.profile_shift, shift,
            low=lambda: least_profile_shift(tooth), unit="1",
        )  # fmt: skip
    ends = (partial(pointed_diameter, tooth), None) if tooth.internal else (None, partial(pointed_diameter, tooth))
    limit = "end of involute" if tooth.internal else "pointing"
    yield margin(
        f"tip diameter of the {body} ({limit})", lambda: 2.0 * tooth.tip_radius, tip, low=ends[0], high=ends[1]
    )
    yield margin(
        f"tip thickness of the {body}", lambda: 2.0 * tooth.half_thickness(tooth.tip_radius), tip, low=0.0,
        usual=f"{0.2 * module:.3g} mm (0.2 m_n) or more, twice that if case-hardened",
    )  # fmt: skip
    if tooth.internal:
        yield margin(
            f"root land of the {body}, half its angle",
            lambda: degrees(tooth.root_land_half_angle), f"{body}_rack_tip_radius_mm", low=0.0, unit="deg",
        )  # fmt: skip
    yield margin(f"rim of the {body}", lambda: tooth.rim_thickness, _RIMS[body], low=0.0)


_RIMS = {"pinion": "pinion_bore_radius_mm", "gear": "gear_rim_thickness_mm"}


def _pair(table: CylindricalPair, mesh: CylindricalMesh) -> Iterator[Margin]:
    """Limits of both bodies together."""
    for k, body in enumerate(BODIES):
        edge = f"{body}_tip_edge_radius_mm"
        radius = partial(getattr, table, edge)
        yield margin(f"tip edge radius of the {body}", radius, edge, high=partial(_edge, mesh, k))
    pinion, gear = mesh.pinion, mesh.gear
    usual = f"{0.25 * table.normal_module_mm:.3g} mm (0.25 m_n)"
    yield margin(
        "tip clearance of the pinion", lambda: root_limits(mesh)[0] - pinion.tip_radius,
        "gear_rack_addendum_mm", low=0.0, usual=usual,
    )  # fmt: skip
    yield margin(
        "tip clearance of the gear",
        lambda: gear.side * (root_limits(mesh)[1] - gear.tip_radius), "pinion_rack_addendum_mm", low=0.0, usual=usual,
    )  # fmt: skip
    ends = partial(_interference, mesh, 1)
    yield margin(
        "tip diameter of the gear (interference)", lambda: 2.0 * gear.tip_radius, "gear_tip_diameter_mm",
        low=ends if gear.internal else None, high=None if gear.internal else ends,
    )  # fmt: skip
    yield margin(
        "tip diameter of the pinion (interference)", lambda: 2.0 * pinion.tip_radius,
        "pinion_tip_diameter_mm", high=partial(_interference, mesh, 0),
    )  # fmt: skip
    overlap = mesh.overlap_ratio
    yield margin(
        "transverse contact ratio", lambda: mesh.transverse_contact_ratio, "pinion_tip_diameter_mm",
        low=max(1.0 - overlap, 0.0), unit="1", usual="1.2 or more for spur gears",
    )  # fmt: skip
    if overlap:
        hint = table.helix_in_radians
        yield margin("overlap ratio", lambda: overlap, "helix_angle_deg", low=0.0, unit="1", usual=hint)
    if gear.internal:
        yield margin(
            "passage of the tips, angle of the gear", lambda: degrees(tip_passage(mesh)),
            "pinion_tip_diameter_mm", low=0.0, unit="deg",
        )  # fmt: skip


def _edge(mesh: CylindricalMesh, body: int) -> float:
    """Tip edge radius at which a body's tooth has no top land left [mm]."""
    return edge_limits(mesh)[body]


def _interference(mesh: CylindricalMesh, body: int) -> float:
    """Tip diameter at which a body's tip reaches the end of the other's involute [mm]."""
    return tip_limits(mesh)[body]

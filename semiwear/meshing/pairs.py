"""Flanks in mesh of a scene's gear pair, by its kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.point_flank_pair import PointFlankMesh
from semiwear.meshing.point_flanks import point_flanks
from semiwear.scene import GearPair, Placement
from semiwear.untyped import Value


def _point_flank_mesh(table: Value, placement: Placement) -> FlankPair:
    return PointFlankMesh.placed(point_flanks(table), placement)


MESHES: Mapping[str, Callable[[Value, Placement], FlankPair]] = {
    "face_gear": FaceGearMesh,
    "cylindrical": CylindricalMesh,
    "flank_points": _point_flank_mesh,
}
"""Functions from a table and a placement to the flanks in mesh, by ``gear_pair.type``."""


def flank_pair(table: GearPair, placement: Placement) -> FlankPair:
    """The two flanks in mesh."""
    return MESHES[table.type](table, placement)


def on_loaded_flank(table: GearPair, placement: Placement, loaded_flank: str) -> tuple[GearPair, Placement]:
    """The pair and placement whose drive flank is the loaded flank of these.

    The coast flank is the drive flank in a mirror at x = 0: offset and slope of the placement and the helix are
    mirrored instead.

    Raises
    ------
    SceneError
        If the coast flanks of the pair are not known.
    """
    if loaded_flank == "drive":
        return table, placement
    mirrored = replace(placement, offset_mm=-placement.offset_mm, pinion_slope_mrad=-placement.pinion_slope_mrad)
    return table.mirrored(), mirrored

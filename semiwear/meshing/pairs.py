"""From a scene's gear pair to its flanks in mesh: the one place that knows which kinds there are."""

from __future__ import annotations

from dataclasses import replace

from semiwear.errors import SceneError
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import DRIVING, FlankPair
from semiwear.meshing.point_flank_pair import PointFlankMesh
from semiwear.meshing.point_flanks import point_flanks
from semiwear.scene import CylindricalPair, FaceGearPair, FlankPointsPair, Placement

__all__ = ["GearPair", "flank_pair", "normal_per_arc", "on_loaded_flank"]

GearPair = FaceGearPair | CylindricalPair | FlankPointsPair


def flank_pair(table: GearPair, placement: Placement) -> FlankPair:
    """The two flanks in mesh."""
    if isinstance(table, CylindricalPair):
        return CylindricalMesh(table, placement)
    if isinstance(table, FlankPointsPair):
        return PointFlankMesh.placed(point_flanks(table), placement)
    return FaceGearMesh(table, placement)


def normal_per_arc(table: GearPair) -> float:
    """Normal distance between flanks per arc of the pinion's reference circle."""
    if isinstance(table, FlankPointsPair):
        flanks = point_flanks(table)
        return flanks.lever / flanks.pitch_surfaces[DRIVING].radius
    return table.normal_per_arc


def on_loaded_flank(table: GearPair, placement: Placement, loaded_flank: str) -> tuple[GearPair, Placement]:
    """The pair and placement whose drive flank is, in a mirror at x = 0, the loaded one of these.

    The coast flank is the drive flank in that mirror: what turns the placement is mirrored instead, and a helix.
    """
    if loaded_flank == "drive":
        return table, placement
    if isinstance(table, FlankPointsPair):
        fix = "give the points of the coast flanks, and turn both rotations"
        raise SceneError.of("operation.loaded_flank", loaded_flank, '"drive": only that flank is given', fix)
    if isinstance(table, CylindricalPair):
        table = replace(table, hand="left" if table.hand == "right" else "right")
    mirrored = replace(placement, offset_mm=-placement.offset_mm, pinion_slope_mrad=-placement.pinion_slope_mrad)
    return table, mirrored
